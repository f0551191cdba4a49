"""Vectors, and the turn of a camera."""

from __future__ import annotations

import math

Vec3 = tuple[float, float, float]


def along(a: Vec3, direction: Vec3, distance: float) -> Vec3:
    """a + distance · direction."""
    return (
        a[0] + distance * direction[0],
        a[1] + distance * direction[1],
        a[2] + distance * direction[2],
    )


def sub(a: Vec3, b: Vec3) -> Vec3:
    """a − b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a: Vec3, b: Vec3) -> float:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec3, b: Vec3) -> Vec3:
    """a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(a: Vec3) -> Vec3:
    """a / ‖a‖."""
    length = math.sqrt(dot(a, a))
    return (a[0] / length, a[1] / length, a[2] / length)


def distance(a: Vec3, b: Vec3) -> float:
    """‖a − b‖."""
    d = sub(a, b)
    return math.sqrt(dot(d, d))


def look_along(direction: Vec3) -> tuple[float, float, float, float]:
    """The unit quaternion (x, y, z, w) that turns −Z along `direction` and keeps X level."""
    back = normalize((-direction[0], -direction[1], -direction[2]))
    right = normalize(cross((0.0, 1.0, 0.0), back))
    up = cross(back, right)
    # Of the four classical formulas these two cover every camera here: w is largest, or y is.
    if (trace := right[0] + up[1] + back[2]) > -0.5:
        w = 0.5 * math.sqrt(1.0 + trace)
        s = 0.25 / w
        return s * (up[2] - back[1]), s * (back[0] - right[2]), s * (right[1] - up[0]), w
    y = 0.5 * math.sqrt(1.0 - right[0] + up[1] - back[2])
    s = 0.25 / y
    return s * (up[0] + right[1]), y, s * (up[2] + back[1]), s * (back[0] - right[2])
