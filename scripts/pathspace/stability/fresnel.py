"""Fresnel's equations as textbooks have them: digits that cancel do no harm here."""

from typing import Any

import mpmath as mp

from .geometry import ONE, ZERO, Number, Vector, dot


def dielectric(n: Number, cos: Number) -> Number:
    """Return F for unpolarised light from a side with this cosine.

    n is the index beyond over that on the light's side; 1 for total reflection
    (Born and Wolf 1999, §1.5.2).
    """
    c = abs(cos)
    square = 1 - (1 - c * c) / (n * n)
    if square <= 0:
        return ONE
    t = mp.sqrt(square)
    s = (c - n * t) / (c + n * t)
    p = (n * c - t) / (n * c + t)
    return (s * s + p * p) / 2


def conductor(fresnel: dict[str, Any], cos: Number) -> list[Number]:
    """Return F by channel of a metal with the index η + ik, or of a tint."""
    if "specular_tint" in fresnel:
        return [mp.mpf(channel) for channel in fresnel["specular_tint"]]
    return [
        complex_index(mp.mpc(eta, k), abs(cos))
        for eta, k in zip(fresnel["eta"], fresnel["k"], strict=True)
    ]


def complex_index(n: Any, c: Number) -> Number:  # noqa: ANN401
    """Return F with a complex index (Born and Wolf 1999, §14.2)."""
    square = n * n
    w = mp.sqrt(square - (1 - c * c))
    if w.real < 0:
        w = -w

    def amplitude(x: Number) -> Number:
        total = abs(x + w)
        return ONE if total == 0 else (abs(x - w) / total) ** 2

    return (amplitude(mp.mpc(c)) + amplitude(square * c)) / 2


class Interface:
    """Between two dielectrics; the normal points to the outside, of index one."""

    def __init__(self, contrast: float) -> None:
        self.eta = 1 + mp.mpf(contrast)

    def index(self, cos: Number) -> Number:
        """Return the index on the side of a direction with this cosine."""
        return ONE if cos > 0 else self.eta

    def reflectance(self, cos: Number) -> Number:
        """Return F for light from the side of the cosine."""
        return dielectric(self.eta if cos > 0 else 1 / self.eta, cos)

    def transmittance(self, a: Number, b: Number) -> Number:
        """Return 1 − F for cosines on either side.

        On paths that were rounded, the two directions do not fit each other exactly; what counts by
        definition is the one in the thinner medium.
        """
        thin = a if (a > 0) == (self.eta >= 1) else b
        return 1 - self.reflectance(thin)

    def radiance_scale(self, to_emitter: Number, to_sensor: Number) -> Number:
        """Return (η_o/η_i)² (Veach 1997, §5.2)."""
        return (self.index(to_sensor) / self.index(to_emitter)) ** 2


class Ggx:
    """Isotropic microfacets of Trowbridge and Reitz with Smith's shadowing (Walter et al. 2007)."""

    def __init__(self, alpha: float) -> None:
        self.alpha = mp.mpf(alpha)

    def distribution(self, m: Vector, normal: Vector) -> Number:
        """Return D(m) = α² / (π (α² cos²θ + sin²θ)²)."""
        cos = dot(m, normal)
        if cos <= 0:
            return ZERO
        square = self.alpha * self.alpha
        cos2 = cos * cos
        denominator = square * cos2 + (1 - cos2)
        return square / (mp.pi * denominator * denominator)

    def shadowing_over_cos(self, cos: Number) -> Number:
        """Return G₁ / |cos θ| with G₁ = 2 / (1 + √(1 + α² tan²θ))."""
        c = abs(cos)
        return 2 / (c + mp.sqrt(c * c + self.alpha * self.alpha * (1 - c * c)))
