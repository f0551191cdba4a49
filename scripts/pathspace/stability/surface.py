"""f_s and its densities at a vertex, from the parameters of its material and nothing else."""

from dataclasses import dataclass
from typing import Any

import mpmath as mp

from .fresnel import Ggx, Interface, conductor
from .geometry import ONE, ZERO, Number, Vector, add, dot, length, scale

BLACK = [ZERO, ZERO, ZERO]


def colour(numbers: list[float]) -> list[Number]:
    """Take the three channels as they are."""
    return [mp.mpf(channel) for channel in numbers]


class Diffuse:
    """f_s = ρ / π in front, drawn by the cosine."""

    transmits = False

    def __init__(self, parameters: dict[str, Any]) -> None:
        self.reflectance = colour(parameters["reflectance"])

    def value(self, to_emitter: Vector, to_sensor: Vector, n: Vector) -> list[Number]:
        """Return f_s by channel."""
        if dot(to_emitter, n) <= 0 or dot(to_sensor, n) <= 0:
            return BLACK
        return [channel / mp.pi for channel in self.reflectance]

    def density(self, came_from: Vector, to: Vector, n: Vector) -> Number:
        """Return p_σ(to | came_from)."""
        if dot(came_from, n) <= 0:
            return ZERO
        return max(ZERO, dot(to, n)) / mp.pi


class Conductor:
    """A mirror of metal, or metal with GGX microfacets."""

    transmits = False

    def __init__(self, parameters: dict[str, Any]) -> None:
        self.reflectance = colour(parameters["reflectance"])
        self.fresnel = parameters["fresnel"]
        self.facets = facets(parameters["alpha"])

    def reflected(self, cos: Number) -> list[Number]:
        """Return r F."""
        pairs = zip(self.reflectance, conductor(self.fresnel, cos), strict=True)
        return [r * f for r, f in pairs]

    def value(self, to_emitter: Vector, to_sensor: Vector, n: Vector) -> list[Number]:
        """Return r F D G₁ G₁ / (4 cos cos) by channel."""
        i, o = dot(to_emitter, n), dot(to_sensor, n)
        if self.facets is None or i <= 0 or o <= 0:
            return BLACK
        h = half(to_emitter, to_sensor)
        d = self.facets.distribution(h, n) / 4
        g = self.facets.shadowing_over_cos(i) * self.facets.shadowing_over_cos(o)
        return [channel * d * g for channel in self.reflected(dot(to_emitter, h))]

    def density(self, came_from: Vector, to: Vector, n: Vector) -> Number:
        """Return D_v(h) / (4 i·h), with D_v = G₁ (i·h) D / cos θ the visible normals."""
        i, o = dot(came_from, n), dot(to, n)
        if self.facets is None or i <= 0 or o <= 0:
            return ZERO
        h = half(came_from, to)
        visible = self.facets.shadowing_over_cos(i) * dot(came_from, h)
        return visible * self.facets.distribution(h, n) / (4 * dot(to, h))

    def dirac(self, to_emitter: Vector, to_sensor: Vector, n: Vector) -> list[Number]:
        """Return the coefficient of δ_σ⊥ in f_s; the directions fit each other up to rounding."""
        i, o = dot(to_emitter, n), dot(to_sensor, n)
        return self.reflected((i + o) / 2) if i > 0 and o > 0 else BLACK

    def dirac_density(self, side: str, came_from: Vector, to: Vector, n: Vector) -> Number:
        """Return 1: a mirror has no choice."""
        return ONE if dot(came_from, n) > 0 and dot(to, n) > 0 else ZERO


class Dielectric:
    """Smooth glass, or glass with GGX microfacets; drawn by F of the normal met."""

    transmits = True

    def __init__(self, parameters: dict[str, Any]) -> None:
        self.interface = Interface(parameters["contrast"])
        self.tints = colour(parameters["reflectance"]), colour(parameters["transmittance"])
        self.facets = facets(parameters["alpha"])

    def tinted(self, share: Number, *, across: bool) -> list[Number]:
        """Return the share times the factor of what is reflected or refracted."""
        return [channel * share for channel in self.tints[across]]

    def share(self, a: Vector, b: Vector, n: Vector) -> tuple[Number, Number, bool]:
        """Return F or 1 − F, the density dσ_h/dσ_b of half vectors, and whether it is refracted."""
        i, o = dot(a, n), dot(b, n)
        across = i * o < 0
        # Scaled by the two indices; towards the outside, as n.
        weighed = [scale(v, self.interface.index(dot(v, n)) if across else ONE) for v in (a, b)]
        total = add(*weighed)
        size = length(total)
        if size == 0:
            return ZERO, ZERO, across
        h = scale(total, (1 if dot(total, n) > 0 else -1) / size)
        ah, bh = dot(a, h), dot(b, h)
        if ah * i <= 0 or bh * o <= 0:
            return ZERO, ZERO, across
        distribution = self.facets.distribution(h, n)
        if across:
            jacobian = self.interface.index(o) ** 2 * abs(bh) / (size * size)
            return self.interface.transmittance(ah, bh), distribution * abs(ah) * jacobian, True
        reflectance = self.interface.reflectance(ah)
        return reflectance, distribution * abs(ah) / (4 * abs(bh)), False

    def value(self, to_emitter: Vector, to_sensor: Vector, n: Vector) -> list[Number]:
        """Return f_s by channel (Walter et al. 2007, eqs. 20 and 21), refraction for radiance."""
        i, o = dot(to_emitter, n), dot(to_sensor, n)
        if self.facets is None or i * o == 0:
            return BLACK
        share, normals, across = self.share(to_emitter, to_sensor, n)
        g = self.facets.shadowing_over_cos(i) * self.facets.shadowing_over_cos(o)
        return self.tinted(share * normals * g, across=across)

    def density(self, came_from: Vector, to: Vector, n: Vector) -> Number:
        """Return F or 1 − F times the density of visible normals turned to directions."""
        i = dot(came_from, n)
        if self.facets is None or i * dot(to, n) == 0:
            return ZERO
        share, normals, _ = self.share(came_from, to, n)
        return share * normals * self.facets.shadowing_over_cos(i)

    def smooth(self, to_emitter: Vector, to_sensor: Vector, n: Vector) -> tuple[Number, Number]:
        """Return the share of a smooth interface and (η_o/η_i)²."""
        i, o = dot(to_emitter, n), dot(to_sensor, n)
        if i * o > 0:
            return self.interface.reflectance((i + o) / 2), ONE
        if i * o < 0:
            scaled = self.interface.radiance_scale(i, o)
            return self.interface.transmittance(i, o), scaled
        return ZERO, ONE

    def dirac(self, to_emitter: Vector, to_sensor: Vector, n: Vector) -> list[Number]:
        """Return the coefficient of δ_σ⊥ in f_s."""
        share, scaled = self.smooth(to_emitter, to_sensor, n)
        across = dot(to_emitter, n) * dot(to_sensor, n) < 0
        return self.tinted(share * scaled, across=across)

    def dirac_density(self, side: str, came_from: Vector, to: Vector, n: Vector) -> Number:
        """Return the probability of the lobe, times (η_o/η_i)² in walks from the emitter.

        The measure is δ_σ⊥ on the emitter's side, and dσ⊥ shrinks across the refraction.
        """
        roles = (came_from, to) if side == "emitter" else (to, came_from)
        share, scaled = self.smooth(*roles, n)
        return share * scaled if side == "emitter" else share

    def radiance_scale(self, to_emitter: Vector, to_sensor: Vector, n: Vector) -> Number:
        """Return (η_o/η_i)²."""
        return self.interface.radiance_scale(dot(to_emitter, n), dot(to_sensor, n))


def facets(alpha: list[float] | None) -> Ggx | None:
    """Make the microfacets, none where the surface is smooth."""
    if alpha is None:
        return None
    if alpha[0] != alpha[1]:
        raise NotImplementedError("anisotropic microfacets are not evaluated")
    return Ggx(alpha[0])


def half(a: Vector, b: Vector) -> Vector:
    """Return the half vector."""
    total = add(a, b)
    return scale(total, 1 / length(total))


MODELS = {"diffuse": Diffuse, "conductor": Conductor, "dielectric": Dielectric}


@dataclass(frozen=True)
class Surface:
    """A material with its sidedness and what shading normals do (Veach 1997, §5.3)."""

    model: Any
    two_sided: bool
    name: str

    @classmethod
    def of(cls, record: dict[str, Any]) -> "Surface":
        """From the scene's JSON."""
        if record["kind"] not in MODELS:
            raise NotImplementedError(f"material '{record['name']}' is none that is evaluated")
        model = MODELS[record["kind"]](record)
        return cls(model, record["two_sided"] and not model.transmits, record["name"])

    @property
    def cosine_only(self) -> bool:
        """Nothing but cosines depends on directions."""
        return isinstance(self.model, Diffuse)

    def sides(self, came_from: Vector, to: Vector, ng: Vector, ns: Vector) -> Vector | None:
        """Return the shading normal on the side of the light, `None` where all is black."""
        sign = -ONE if self.two_sided and dot(came_from, ng) < 0 else ONE
        ng, ns = scale(ng, sign), scale(ns, sign)
        if dot(came_from, ng) * dot(came_from, ns) <= 0 or dot(to, ng) * dot(to, ns) <= 0:
            return None
        if not self.model.transmits and dot(came_from, ng) <= 0:
            return None
        return ns

    def value(
        self, to_emitter: Vector, to_sensor: Vector, ng: Vector, ns: Vector, *, dirac: bool
    ) -> list[Number]:
        """Return f_s, or the coefficient of its Dirac lobe."""
        n = self.sides(to_sensor, to_emitter, ng, ns)
        if n is None:
            return BLACK
        if dirac:
            return self.model.dirac(to_emitter, to_sensor, n)
        ratio = abs(dot(to_emitter, ns) / dot(to_emitter, ng))
        return [channel * ratio for channel in self.model.value(to_emitter, to_sensor, n)]

    def density(
        self,
        side: str,
        came_from: Vector,
        to: Vector,
        ng: Vector,
        ns: Vector,
        *,
        dirac: bool,
    ) -> Number:
        """Return p_σ of a walk that started on this side, or the coefficient of δ_σ⊥."""
        n = self.sides(came_from, to, ng, ns)
        if n is None:
            return ZERO
        if not dirac:
            return self.model.density(came_from, to, n)
        density = self.model.dirac_density(side, came_from, to, n)
        if side == "emitter":
            density *= abs(dot(to, ns) / dot(to, ng)) / abs(dot(came_from, ns) / dot(came_from, ng))
        return density

    def radiance_scale(self, to_emitter: Vector, to_sensor: Vector, ns: Vector) -> Number:
        """Return (η_o/η_i)², one where nothing is refracted."""
        if not self.model.transmits:
            return ONE
        return self.model.radiance_scale(to_emitter, to_sensor, ns)
