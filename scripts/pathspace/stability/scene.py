"""The ends of paths, from the parameters of emitters and camera."""

from dataclasses import dataclass
from typing import Any

import mpmath as mp

from .geometry import (
    CERTAIN,
    FACTOR,
    ONE,
    PI,
    UNIT,
    ZERO,
    Edge,
    Number,
    Uncertain,
    Vector,
    cross,
    dot,
    length,
    subtract,
    vector,
)
from .surface import Surface, colour

SCHEMA = 1


class Emitter:
    """An emitter: radiance or intensity, and how walks start from it."""

    def __init__(self, record: dict[str, Any]) -> None:
        self.kind, self.name = record["kind"], record["name"]
        self.probability = mp.mpf(record["probability"])
        if self.kind not in ("mesh", "sphere", "point", "environment"):
            raise NotImplementedError(f"emitter '{self.name}' is none that is evaluated")
        self.power = colour(record["intensity" if self.kind == "point" else "radiance"])
        self.can_be_hit = self.kind != "point"
        self.is_local = self.kind != "environment"
        self.area, self.terms = ONE, 1
        if self.kind == "mesh":
            triangles = [
                [vector(corner) for corner in triangle] for triangle in record["triangles"]
            ]
            self.area = mp.fsum(area_of(*triangle) for triangle in triangles)
            self.terms = len(triangles)
        elif self.kind == "sphere":
            self.centre, self.inward = vector(record["centre"]), record["inward"]
            self.radius = mp.mpf(record["radius"])
            self.area = 4 * PI * self.radius**2
        elif self.kind == "environment":
            self.radius = mp.mpf(record["sphere_radius"])

    @property
    def flux(self) -> Number:
        """Mean over channels of the radiant flux."""
        mean = sum(self.power) / 3
        if self.kind == "point":
            return 4 * PI * mean
        if self.kind == "environment":
            return 4 * PI**2 * self.radius**2 * mean
        return PI * self.area * mean

    def emission(self, normal: Vector | None, edge: Edge) -> list[Number]:
        """Return L_e(x_0 → x_1) by channel, of a point its intensity."""
        behind = self.kind in ("mesh", "sphere") and dot(normal, edge.direction) <= 0
        return [ZERO] * 3 if behind else self.power

    def per_area(self) -> Uncertain:
        """Return the choice of the emitter and of a point on its surface, P / A."""
        return Uncertain(self.probability / self.area, FACTOR + self.terms)

    def first(self, normal: Vector | None, edge: Edge) -> tuple[Uncertain, Uncertain]:
        """Return the densities of x_0, in area, and of the direction to x_1, in solid angle."""
        sphere = Uncertain(1 / (4 * PI), 1)
        if self.kind == "point":
            return Uncertain(self.probability), sphere
        cosine = edge.cosine(normal)
        if self.kind == "environment":
            disk = Uncertain(self.probability / (PI * self.radius**2), FACTOR)
            return disk * cosine, sphere
        if dot(normal, edge.direction) <= 0:
            return self.per_area(), Uncertain(ZERO)
        return self.per_area(), cosine * Uncertain(1 / PI, 1)

    def direct(self, normal: Vector | None, edge: Edge, given: Vector) -> Uncertain:
        """Return the density of x_0 drawn for a vertex, the choice included; `edge` leads to it."""
        if self.kind == "point":
            return Uncertain(self.probability)
        if self.kind == "environment":
            return Uncertain(self.probability / (4 * PI), 2) * edge.to_area(normal)
        if self.kind == "mesh" or self.inward:
            return self.per_area()
        return self.cone(normal, edge, given)

    def cone(self, normal: Vector | None, edge: Edge, given: Vector) -> Uncertain:
        """Return the density of uniform directions in the cone that a sphere fills, as an area."""
        distance = length(subtract(self.centre, given))
        if distance <= self.radius or dot(normal, edge.direction) >= 0:
            return Uncertain(ZERO)
        sine = self.radius / distance
        cosine = mp.sqrt(1 - sine**2)
        # d − r, of which cos θ_max is made, has the roundings of the difference given − centre.
        near = float(distance / (distance - self.radius))
        own = FACTOR * (1 + near)
        solid_angle = 2 * PI * (1 - cosine)
        return Uncertain(self.probability / solid_angle, own, near) * edge.to_area(normal)


def area_of(a: Vector, b: Vector, c: Vector) -> Number:
    """Return the area of a triangle."""
    return length(cross(subtract(b, a), subtract(c, a))) / 2


class Camera:
    """A pinhole or a thin lens, with box pixels."""

    def __init__(self, record: dict[str, Any]) -> None:
        if record["kind"] != "camera":
            raise NotImplementedError("the sensor is none that is evaluated: a camera, box filter")
        self.forward = vector(record["forward"])
        x, y = (mp.mpf(extent) for extent in record["half_extent"])
        columns, rows = record["film"]
        self.pixels = columns * rows
        self.pixel_area = 4 * x * y / self.pixels
        lens = record["lens"]
        self.can_be_hit = lens is not None
        radius = mp.mpf(lens["aperture_radius"]) if lens else ONE
        self.position_density = Uncertain(1 / (PI * radius**2), FACTOR) if lens else CERTAIN

    def direction_density(self, edge: Edge) -> Uncertain:
        """Return p_σ = 1 / (A cos³θ) of a pixel's own rays; `edge` leads away from the camera."""
        cosine = edge.cosine(self.forward)
        return Uncertain(1 / self.pixel_area, FACTOR).over(cosine * cosine * cosine)

    def importance(self, edge: Edge) -> Uncertain:
        """Return W_e: p(x_k) p_σ / |cos θ|, with no cosine at a pinhole."""
        if dot(self.forward, edge.direction) <= 0:
            return Uncertain(ZERO)
        response = self.position_density * self.direction_density(edge)
        return response.over(edge.cosine(self.forward)) if self.can_be_hit else response


@dataclass(frozen=True)
class Scene:
    """What paths are evaluated in."""

    surfaces: list[Surface | NotImplementedError]
    emitters: list[Emitter | NotImplementedError]
    camera: Camera

    @classmethod
    def of(cls, record: dict[str, Any]) -> "Scene":
        """From the JSON that `pathspace paths --scene-json` writes."""
        if record["schema"] != SCHEMA:
            raise ValueError(f"schema {record['schema']} of the scene; this reads {SCHEMA}")
        return cls(
            [known(Surface.of, material) for material in record["materials"]],
            [known(Emitter, emitter) for emitter in record["emitters"]],
            Camera(record["sensor"]),
        )

    def surface(self, number: int) -> Surface:
        """Return a material; an error where it is none that is evaluated."""
        return given(self.surfaces[number])

    def emitter(self, number: int) -> Emitter:
        """Return an emitter; an error where it is none that is evaluated."""
        return given(self.emitters[number])

    def choice_error(self, *, uniform: bool) -> tuple[float, float]:
        """Return how far the probabilities of emitters are off, and by how much they may be [1].

        They are differences of cumulated sums, so the errors are absolute.
        """
        emitters = [given(emitter) for emitter in self.emitters]
        weights = [ONE if uniform else emitter.flux for emitter in emitters]
        total = sum(weights)
        off = (
            abs(emitter.probability - weight / total)
            for emitter, weight in zip(emitters, weights, strict=True)
        )
        terms = sum(emitter.terms for emitter in emitters)
        return float(max(off)), float((FACTOR + 2 * terms) * UNIT)


def known(make: Any, record: dict[str, Any]) -> Any:  # noqa: ANN401
    """Make it, or keep the reason why it cannot be made for the path that needs it."""
    try:
        return make(record)
    except NotImplementedError as reason:
        return reason


def given(thing: Any) -> Any:  # noqa: ANN401
    """Return it, or raise what it is."""
    if isinstance(thing, NotImplementedError):
        raise thing
    return thing
