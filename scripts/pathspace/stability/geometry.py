"""Vectors with many digits, and numbers that know how badly double precision may miss them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mpmath as mp

DIGITS = 60
"""Decimal digits of everything here."""
mp.mp.dps = DIGITS

Number = Any
"""A number of mpmath, whose types have no annotations."""
Vector = tuple[Number, Number, Number]

UNIT = mp.mpf(2) ** -53
"""u, the largest relative error of one rounding."""
ZERO, ONE, PI = mp.mpf(0), mp.mpf(1), +mp.pi

DIRECTION = 12.0
"""Error of a unit vector in a local frame [u].

Component by component, in first order: 1 for the difference of two positions, 2.5 for half of the
squared length with its three squares and two sums, 2 for the root and its reciprocal, 1 for the
product; then three products and two sums onto an axis of the frame, 3, whose own components have
about 2.5.
"""
POSITION = 8.0
"""Error of a vertex that a ray finds [u times the extent of the path].

A point of a triangle is a weighted sum of its corners, with weights from a few products each. It
matters only for what an integrator has computed along the ray, before the vertex was rounded.
"""
FACTOR = 8.0
"""Roundings of a factor besides those of its arguments [u]."""


def vector(numbers: Sequence[float]) -> Vector:
    """Take three doubles as they are."""
    x, y, z = numbers
    return mp.mpf(x), mp.mpf(y), mp.mpf(z)


def dot(a: Vector, b: Vector) -> Number:
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a × b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Vector, b: Vector) -> Vector:
    """Return a − b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(a: Vector, factor: Number) -> Vector:
    """Return the multiple of a."""
    return a[0] * factor, a[1] * factor, a[2] * factor


def length(a: Vector) -> Number:
    """Return ‖a‖."""
    return mp.sqrt(dot(a, a))


def unit(a: Vector) -> Vector:
    """Return a / ‖a‖."""
    return scale(a, 1 / length(a))


def tangents(a: Vector) -> tuple[Vector, Vector]:
    """Return two unit vectors at right angles to a unit vector and to each other."""
    smallest = min(range(3), key=lambda i: abs(a[i]))
    axis = tuple(ONE if i == smallest else ZERO for i in range(3))
    first = unit(cross(a, axis))
    return first, cross(a, first)


@dataclass(frozen=True)
class Uncertain:
    """A number with the relative errors [u] that double precision may add to it, in first order."""

    value: Number
    own: float = 0.0
    """Evaluated for given vertices."""
    moved: float = 0.0
    """Besides, where vertices have been rounded since: of one rounding of a position."""

    def __mul__(self, other: "Uncertain") -> "Uncertain":
        """Errors of factors add up, and the product has one of its own."""
        return Uncertain(
            self.value * other.value, self.own + other.own + 1, self.moved + other.moved
        )

    def over(self, other: "Uncertain") -> "Uncertain":
        """Divide."""
        return Uncertain(
            self.value / other.value, self.own + other.own + 1, self.moved + other.moved
        )

    @property
    def bound(self) -> float:
        """Largest relative error for given vertices."""
        return self.own * float(UNIT)

    @property
    def loose_bound(self) -> float:
        """Largest relative error where vertices have been rounded after their use."""
        return (self.own + POSITION * self.moved) * float(UNIT)


CERTAIN = Uncertain(ONE)


@dataclass(frozen=True)
class Edge:
    """Two vertices that follow each other."""

    direction: Vector
    """Unit vector from the first to the second."""
    length_squared: Number
    shift: float
    """Angle by which one rounding of a position turns the edge [u]: extent / length."""

    @classmethod
    def between(cls, a: Vector, b: Vector, extent: Number) -> "Edge":
        """From a to b, in a path of this extent."""
        offset = subtract(b, a)
        squared = dot(offset, offset)
        distance = mp.sqrt(squared)
        return cls(scale(offset, 1 / distance), squared, float(extent / distance))

    @cached_property
    def reversed(self) -> "Edge":
        """The same from its other end."""
        return Edge(scale(self.direction, -ONE), self.length_squared, self.shift)

    def cosine(self, normal: Vector | None) -> Uncertain:
        """Return |cos θ| against a normal, one where there is none.

        A turn by ε changes ln cos θ by ε tan θ.
        """
        if normal is None:
            return CERTAIN
        cos = abs(dot(normal, self.direction))
        if cos == 0:
            return Uncertain(ZERO, float("inf"), float("inf"))
        tangent = float(mp.sqrt(max(ZERO, 1 - cos * cos)) / cos)
        return Uncertain(cos, DIRECTION * tangent + FACTOR, tangent * self.shift)

    def inverse_square(self) -> Uncertain:
        """Return 1 / ‖x − y‖²."""
        return Uncertain(1 / self.length_squared, FACTOR, 2 * self.shift)

    def to_area(self, normal: Vector | None) -> Uncertain:
        """Return |cos θ| / ‖x − y‖², from solid angle at the start to area at the end."""
        return self.cosine(normal) * self.inverse_square()


def sensitivities(
    function: Callable[..., list[Number]], directions: Sequence[Vector]
) -> tuple[list[Number], list[float]]:
    """Return the function and its condition: |Δ ln f| / u as each direction is off by u.

    The function takes unit vectors and returns numbers; the worst of them counts. A direction turns
    towards both tangents. The first two, which are no normals, besides grow by u: the length of a
    rounded vector is no better than that, and neither is a cosine, so that what needs the sine of
    rays that are nearly upright, such as total reflection with a large index, has fewer digits. The
    effects are added.
    """
    values = function(*directions)
    conditions = []
    for i, direction in enumerate(directions):
        total = 0.0
        if i < 2:
            longer = list(directions)
            longer[i] = scale(direction, 1 + UNIT)
            total += change(values, function(*longer))
        for tangent in tangents(direction):
            turned = list(directions)
            turned[i] = unit(add(direction, scale(tangent, UNIT)))
            total += change(values, function(*turned))
        conditions.append(total)
    return values, conditions


def change(values: Sequence[Number], others: Sequence[Number]) -> float:
    """Return the largest |Δ ln| [u] between numbers."""
    worst = 0.0
    for value, other in zip(values, others, strict=True):
        if value == other:
            continue
        if value <= 0 or other <= 0:
            return float("inf")
        worst = max(worst, float(abs(mp.log(other / value)) / UNIT))
    return worst
