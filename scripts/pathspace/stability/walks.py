"""f(x̄) and the densities with which walks from either end draw a path (Veach 1997, §8.3, §10.1)."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any

import mpmath as mp

from .geometry import (
    CERTAIN,
    DIRECTION,
    FACTOR,
    ONE,
    ZERO,
    Edge,
    Number,
    Uncertain,
    Vector,
    change,
    sensitivities,
    unit,
    vector,
)
from .scene import Emitter, Scene
from .surface import Surface

NEVER = Uncertain(ZERO)


@dataclass(frozen=True)
class Vertex:
    """A vertex of the log, without any number that was computed from others."""

    position: Vector
    normal: Vector | None
    shading: Vector | None
    dirac: bool
    surface: Surface | None
    emitter: Emitter | None

    @classmethod
    def of(cls, record: dict[str, Any], scene: Scene) -> "Vertex":
        """From the log."""
        normal = record["normal"] and unit(vector(record["normal"]))
        shading = record["shading_normal"] and unit(vector(record["shading_normal"]))
        material, emitter = record["material"], record["emitter"]
        return cls(
            vector(record["local"]),
            normal,
            shading or normal,
            record["dirac"],
            scene.surface(material["id"]) if material else None,
            scene.emitter(emitter["id"]) if emitter else None,
        )


class Path:
    """A path x_0 … x_k in a scene, with the rules by which walks end."""

    def __init__(self, record: dict[str, Any], scene: Scene) -> None:
        self.scene = scene
        self.vertices = [Vertex.of(vertex, scene) for vertex in record["vertices"]]
        self.roulette = record["roulette"]
        self.k = len(self.vertices) - 1
        extent = 2 * max(abs(x) for vertex in self.vertices for x in vertex.position)
        places = [vertex.position for vertex in self.vertices]
        self.edges = [Edge.between(a, b, extent) for a, b in zip(places, places[1:], strict=False)]
        self.scatterings = [None, *(Scattering(self, i) for i in range(1, self.k)), None]

    def contribution(self) -> list[Uncertain]:
        """Return f(x̄) by channel, without visibility (Veach 1997, eq. 8.7)."""
        x0, xk = self.vertices[0], self.vertices[-1]
        if xk.surface or x0.emitter is None or (self.k == 1 and not x0.emitter.can_be_hit):
            return [NEVER] * 3
        rest = self.scene.camera.importance(self.edges[-1].reversed)
        for i, edge in enumerate(self.edges):
            rest *= edge.cosine(self.vertices[i].normal) * edge.to_area(self.vertices[i + 1].normal)
        emitted = x0.emitter.emission(x0.normal, self.edges[0])
        channels = [Uncertain(channel) * rest for channel in emitted]
        for scattering in self.scatterings[1:-1]:
            pairs = zip(channels, scattering.value, strict=True)
            channels = [product * factor for product, factor in pairs]
        return channels

    def technique(self, s: int, t: int) -> Uncertain:
        """Return p_{s,t}(x̄), zero where the technique cannot draw the path."""
        if not self.can_draw(s, t):
            return NEVER
        if s == t == 1:
            return self.two
        return self.from_emitter[s] * self.from_sensor[t]

    def can_draw(self, s: int, t: int) -> bool:
        """No Dirac distribution is left undrawn."""
        emitter = self.vertices[0].emitter
        if emitter is None or (self.k == 1 and not emitter.can_be_hit):
            return False
        if s == 0:
            return emitter.can_be_hit
        if t == 0:
            return self.scene.camera.can_be_hit
        return not (self.vertices[s - 1].dirac or self.vertices[s].dirac)

    @property
    def two(self) -> Uncertain:
        """p_{1,1}: the end that has a position of its own is drawn first, the other for it."""
        x0, x1 = self.vertices
        lens = self.scene.camera.position_density
        if x0.emitter.is_local:
            return x0.emitter.first(x0.normal, self.edges[0])[0] * lens
        return x0.emitter.direct(x0.normal, self.edges[0].reversed, x1.position) * lens

    @cached_property
    def from_emitter(self) -> list[Uncertain]:
        """Densities of x_0 … x_{s−1} by a walk from the emitter, by s; drawn for x_1 at s = 1."""
        x0, edge = self.vertices[0], self.edges[0]
        if x0.emitter is None:
            return [CERTAIN] + [NEVER] * (self.k + 1)
        direct = x0.emitter.direct(x0.normal, edge.reversed, self.vertices[1].position)
        position, direction = x0.emitter.first(x0.normal, edge)
        start = position * direction * edge.to_area(self.vertices[1].normal)
        steps = self.steps("emitter")
        return [CERTAIN, direct, *accumulate(steps, Uncertain.__mul__, initial=start)]

    @cached_property
    def from_sensor(self) -> list[Uncertain]:
        """Densities of x_k … x_{k−t+1} by a walk from the sensor, by t; drawn for one at t = 1."""
        camera, edge = self.scene.camera, self.edges[-1].reversed
        direction = camera.direction_density(edge)
        to_area = edge.to_area(self.vertices[-2].normal)
        start = camera.position_density * direction * to_area
        steps = self.steps("sensor")
        return [
            CERTAIN,
            camera.position_density,
            *accumulate(steps, Uncertain.__mul__, initial=start),
        ]

    def steps(self, side: str) -> Iterator[Uncertain]:
        """Yield the densities of the third and later vertices of a walk, zero once it has ended."""
        order = range(1, self.k) if side == "emitter" else range(self.k - 1, 0, -1)
        rules = self.roulette[side]
        throughput = [CERTAIN] * 3
        ended = False
        for count, i in enumerate(order, 1):
            scattering = self.scatterings[i]
            density = scattering.density(side)
            ended = ended or density.value == 0
            if ended:
                yield NEVER
                continue
            if rules["kind"] == "throughput":
                pairs = zip(throughput, scattering.energy(side), strict=True)
                throughput = [product * factor for product, factor in pairs]
            survival = survives(rules, count, scattering, side, throughput)
            throughput = [product.over(survival) for product in throughput]
            yield density * survival


def survives(
    rules: dict[str, Any],
    edges: int,
    scattering: "Scattering",
    side: str,
    throughput: list[Uncertain],
) -> Uncertain:
    """Return the probability that roulette lets a walk go on after so many edges."""
    kind = rules["kind"]
    if kind == "off" or edges < rules["start"]:
        return CERTAIN
    if kind == "fixed":
        return Uncertain(mp.mpf(rules["survival"]))
    weights, most = scattering.energy(side) if kind == "local" else throughput, cap(rules, edges)
    largest = max(weights, key=lambda weight: weight.value)
    # At the limit either side of it may be meant.
    return largest if largest.value < most else Uncertain(most, largest.own, largest.moved)


def cap(rules: dict[str, Any], edges: int) -> Number:
    """Return the largest probability of going on, (n/(n+1))^(5/2) after n edges of long walks."""
    return ONE if edges < rules["long"] else (mp.mpf(edges) / (edges + 1)) ** mp.mpf(2.5)


class Scattering:
    """What happens at x_i, with its edges' errors."""

    def __init__(self, path: Path, i: int) -> None:
        self.vertex = path.vertices[i]
        self.before, self.after = path.vertices[i - 1], path.vertices[i + 1]
        self.to_emitter, self.to_sensor = path.edges[i - 1].reversed, path.edges[i]
        surface = self.vertex.surface
        if surface is None:
            raise NotImplementedError("a path scatters where no surface is")
        self.surface = surface
        self.normals_agree = self.vertex.shading == self.vertex.normal

    @property
    def directions(self) -> list[Vector]:
        """What models depend on: both directions and the normals."""
        here = [self.to_emitter.direction, self.to_sensor.direction, self.vertex.normal]
        return here if self.normals_agree else [*here, self.vertex.shading]

    def conditioned(self, function: Any) -> list[Uncertain]:  # noqa: ANN401
        """Evaluate a function of `directions` together with its condition."""

        def of(a: Vector, b: Vector, ng: Vector, ns: Vector | None = None) -> list[Number]:
            return function(a, b, ng, ng if ns is None else ns)

        values, conditions = sensitivities(of, self.directions)
        own = DIRECTION * sum(conditions) + FACTOR + self.index_condition(of, values)
        moved = conditions[0] * self.to_emitter.shift + conditions[1] * self.to_sensor.shift
        return [Uncertain(value, own, moved) for value in values]

    def index_condition(self, of: Any, values: list[Number]) -> float:  # noqa: ANN401
        """Return |Δ ln f| / u as the index of refraction is rounded."""
        interface = getattr(self.surface.model, "interface", None)
        if interface is None:
            return 0.0
        eta = interface.eta
        interface.eta = 1 + (eta - 1) * (1 + mp.mpf(2) ** -53)
        turned = of(*self.directions)
        interface.eta = eta
        return FACTOR * change(values, turned)

    @cached_property
    def value(self) -> list[Uncertain]:
        """f_s by channel."""
        dirac = self.vertex.dirac
        if self.surface.cosine_only and self.normals_agree:
            values = self.surface.value(*self.plain, dirac=dirac)
            return [Uncertain(value, FACTOR) for value in values]

        def value(a: Vector, b: Vector, ng: Vector, ns: Vector) -> list[Number]:
            return self.surface.value(a, b, ng, ns, dirac=dirac)

        return self.conditioned(value)

    @property
    def plain(self) -> tuple[Vector, Vector, Vector, Vector]:
        """All arguments of a model."""
        directions = self.to_emitter.direction, self.to_sensor.direction
        return *directions, self.vertex.normal, self.vertex.shading

    def walk(self, side: str) -> tuple[Edge, Edge, Vertex]:
        """Return the edges to where a walk comes from and goes to, and the vertex there."""
        if side == "emitter":
            return self.to_emitter, self.to_sensor, self.after
        return self.to_sensor, self.to_emitter, self.before

    def density(self, side: str) -> Uncertain:
        """Return the density of the walk's next vertex in area, without roulette."""
        came_from, to, after = self.walk(side)
        dirac = self.vertex.dirac
        to_area = to.to_area(after.normal)
        if self.surface.cosine_only and self.normals_agree:
            ends = came_from.direction, to.direction, self.vertex.normal, self.vertex.shading
            density = self.surface.density(side, *ends, dirac=dirac)
            cosine = to.cosine(self.vertex.normal)
            return Uncertain(density, cosine.own + FACTOR, cosine.moved) * to_area

        def density_of(a: Vector, b: Vector, ng: Vector, ns: Vector) -> list[Number]:
            ends = (a, b) if side == "emitter" else (b, a)
            return [self.surface.density(side, *ends, ng, ns, dirac=dirac)]

        (direction,) = self.conditioned(density_of)
        if dirac:
            to_area = to.cosine(self.vertex.normal) * to_area
        return direction * to_area

    def energy(self, side: str) -> list[Uncertain]:
        """Return f_s |cos θ| / p_σ by channel without the radiance's η²: what roulette asks for."""
        dirac = self.vertex.dirac

        def weight(a: Vector, b: Vector, ng: Vector, ns: Vector) -> list[Number]:
            ends = (a, b) if side == "emitter" else (b, a)
            density = self.surface.density(side, *ends, ng, ns, dirac=dirac)
            if density == 0:
                return [ZERO] * 3
            to = ends[1]
            if not dirac:
                density /= abs(sum(x * y for x, y in zip(to, ng, strict=True)))
            if side == "sensor":
                density *= self.surface.radiance_scale(a, b, ns)
            values = self.surface.value(a, b, ng, ns, dirac=dirac)
            return [value / density for value in values]

        if self.surface.cosine_only and self.normals_agree:
            return [Uncertain(value, FACTOR) for value in weight(*self.plain)]
        return self.conditioned(weight)
