"""The spectra that Cornell University measured, and what they are in linear sRGB."""

from __future__ import annotations

import math

Rgb = tuple[float, float, float]

# Reflectance of the paints at 400, 404, … 700 nm (Cornell Box Data, Cornell University).
WHITE = """
0.343 0.445 0.551 0.624 0.665 0.687 0.708 0.723 0.715 0.710 0.745 0.758 0.739 0.767 0.777 0.765
0.751 0.745 0.748 0.729 0.745 0.757 0.753 0.750 0.746 0.747 0.735 0.732 0.739 0.734 0.725 0.721
0.733 0.725 0.732 0.743 0.744 0.748 0.728 0.716 0.733 0.726 0.713 0.740 0.754 0.764 0.752 0.736
0.734 0.741 0.740 0.732 0.745 0.755 0.751 0.744 0.731 0.733 0.744 0.731 0.712 0.708 0.729 0.730
0.727 0.707 0.703 0.729 0.750 0.760 0.751 0.739 0.724 0.730 0.740 0.737
"""
GREEN = """
0.092 0.096 0.098 0.097 0.098 0.095 0.095 0.097 0.095 0.094 0.097 0.098 0.096 0.101 0.103 0.104
0.107 0.109 0.112 0.115 0.125 0.140 0.160 0.187 0.229 0.285 0.343 0.390 0.435 0.464 0.472 0.476
0.481 0.462 0.447 0.441 0.426 0.406 0.373 0.347 0.337 0.314 0.285 0.277 0.266 0.250 0.230 0.207
0.186 0.171 0.160 0.148 0.141 0.136 0.130 0.126 0.123 0.121 0.122 0.119 0.114 0.115 0.117 0.117
0.118 0.120 0.122 0.128 0.132 0.139 0.144 0.146 0.150 0.152 0.157 0.159
"""
RED = """
0.040 0.046 0.048 0.053 0.049 0.050 0.053 0.055 0.057 0.056 0.059 0.057 0.061 0.061 0.060 0.062
0.062 0.062 0.061 0.062 0.060 0.059 0.057 0.058 0.058 0.058 0.056 0.055 0.056 0.059 0.057 0.055
0.059 0.059 0.058 0.059 0.061 0.061 0.063 0.063 0.067 0.068 0.072 0.080 0.090 0.099 0.124 0.154
0.192 0.255 0.287 0.349 0.402 0.443 0.487 0.513 0.558 0.584 0.620 0.606 0.609 0.651 0.612 0.610
0.650 0.638 0.627 0.620 0.630 0.628 0.642 0.639 0.657 0.639 0.635 0.642
"""
# The lamp at 400, 500, 600 and 700 nm, in the unit of the publication, linear in between.
LIGHT = (0.0, 8.0, 15.6, 18.4)

# CIE 1931 colour matching, as the sums of lobes fitted by Wyman, Sloan and Shirley (2013, eq. 4):
# amplitude, centre [nm], inverse widths [1/nm] below and above the centre.
LOBES = (
    (
        (0.362, 442.0, 0.0624, 0.0374),
        (1.056, 599.8, 0.0264, 0.0323),
        (-0.065, 501.1, 0.0490, 0.0382),
    ),
    ((0.821, 568.8, 0.0213, 0.0247), (0.286, 530.9, 0.0613, 0.0322)),
    ((1.217, 437.0, 0.0845, 0.0278), (0.681, 459.0, 0.0385, 0.0725)),
)
# XYZ to linear sRGB (IEC 61966-2-1).
XYZ_TO_RGB = ((3.2406, -1.5372, -0.4986), (-0.9689, 1.8758, 0.0415), (0.0557, -0.2040, 1.0570))


def reflectance(spectrum: str) -> Rgb:
    """∫ ρ L s̄ dλ / ∫ L s̄ dλ for each sRGB sensitivity s̄: the colour under the box's own lamp
    divided by that of the lamp."""
    lit, lamp = _integral([float(r) for r in spectrum.split()]), _integral([1.0] * 76)
    return _rounded([a / b for a, b in zip(lit, lamp, strict=True)])


def emission(scale: float) -> Rgb:
    """scale · ∫ L s̄ dλ / ∫ ȳ dλ: a lamp of constant spectrum 1 would have luminance `scale`."""
    luminance = sum(_matching(400 + 4 * i)[1] for i in range(76))
    return _rounded([scale * c / luminance for c in _integral([1.0] * 76)])


def _integral(rho: list[float]) -> list[float]:
    xyz = [0.0, 0.0, 0.0]
    for i, value in enumerate(rho):
        nm = 400 + 4 * i
        for axis, weight in enumerate(_matching(nm)):
            xyz[axis] += value * _light(nm) * weight
    return [sum(m * v for m, v in zip(row, xyz, strict=True)) for row in XYZ_TO_RGB]


def _light(nm: int) -> float:
    interval, rest = divmod(nm - 400, 100)
    low, high = LIGHT[interval], LIGHT[min(interval + 1, 3)]
    return low + (high - low) * rest / 100.0


def _matching(nm: float) -> list[float]:
    return [
        sum(
            a * math.exp(-0.5 * ((nm - c) * (below if nm < c else above)) ** 2)
            for a, c, below, above in lobes
        )
        for lobes in LOBES
    ]


def _rounded(rgb: list[float]) -> Rgb:
    r, g, b = (round(c, 4) for c in rgb)
    return (r, g, b)
