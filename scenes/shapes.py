"""Shapes made of triangles, counter-clockwise seen from the front. They need no more than square
roots, which every platform rounds alike."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

from vectors import Vec3, along, cross, distance, dot, normalize, sub

_H = math.sqrt(3.0) / 2.0
# The corners of a regular 12-gon, counter-clockwise about the third axis.
_TWELVE = [(1.0, 0.0), (_H, 0.5), (0.5, _H)]
_TWELVE += [(-y, x) for x, y in _TWELVE]
_TWELVE += [(-x, -y) for x, y in _TWELVE]


@dataclass
class Shape:
    """Vertices and the triangles between them."""

    vertices: list[Vec3] = field(default_factory=list)
    triangles: list[tuple[int, int, int]] = field(default_factory=list)

    def polygon(self, *corners: Vec3) -> Shape:
        """Adds a convex polygon with vertices of its own."""
        first = len(self.vertices)
        self.vertices += corners
        self.triangles += [(first, first + i, first + i + 1) for i in range(1, len(corners) - 1)]
        return self

    def add(self, other: Shape) -> Shape:
        """Adds all of another shape."""
        first = len(self.vertices)
        self.vertices += other.vertices
        self.triangles += [(first + a, first + b, first + c) for a, b, c in other.triangles]
        return self


ALL_FACES = "xXyYzZ"


def box(low: Vec3, high: Vec3, *, faces: str = ALL_FACES, inside_out: bool = False) -> Shape:
    """A box along the axes, its faces outwards, or inwards for a room."""
    x, y, z = zip(low, high, strict=True)
    corners = [(i, j, k) for i in x for j in y for k in z]
    return hexahedron(corners, faces=faces, inside_out=inside_out)


def tilted_box(
    centre: Vec3, normal: Vec3, size: tuple[float, float, float], *, faces: str = ALL_FACES
) -> Shape:
    """A box of width, height and thickness `size` whose face Z looks along `normal` (not vertical)
    and whose width is level."""
    n = normalize(normal)
    u = normalize(cross((0.0, 1.0, 0.0), n))
    v = cross(n, u)
    corners = [
        along(along(along(centre, u, i * size[0]), v, j * size[1]), n, k * size[2])
        for i in (-0.5, 0.5)
        for j in (-0.5, 0.5)
        for k in (-0.5, 0.5)
    ]
    return hexahedron(corners, faces=faces)


def hexahedron(corners: list[Vec3], *, faces: str = ALL_FACES, inside_out: bool = False) -> Shape:
    """A box of any orientation: corner 4i + 2j + k is at the low (0) or high (1) end of each axis,
    the face `x` at the low end of the first axis, `X` at its high end, and so on."""
    shape = Shape()
    for face in faces:
        around = _FACES[face]
        shape.polygon(*(corners[i] for i in (reversed(around) if inside_out else around)))
    return shape


_FACES = {
    "x": (0, 1, 3, 2),
    "X": (4, 6, 7, 5),
    "y": (0, 4, 5, 1),
    "Y": (2, 3, 7, 6),
    "z": (0, 2, 6, 4),
    "Z": (1, 5, 7, 3),
}


@dataclass(frozen=True)
class Cup:
    """A round cup with a thick wall and a lamp in its bottom, open along `axis`."""

    bottom: Vec3
    """Centre of the inner bottom, where the lamp is."""
    axis: Vec3
    depth: float
    lamp_radius: float
    bottom_radius: float
    """Inner radius at the bottom, above that of the lamp."""
    rim_radius: float
    """Inner radius at the rim."""
    wall: float
    """Thickness of wall and bottom."""

    def lamp(self) -> Shape:
        """The disk (a regular 12-gon) that shines along the axis."""
        return Shape().polygon(*self._ring(self.lamp_radius, 0.0))

    def body(self) -> Shape:
        """All the rest: with the lamp it bounds a solid."""
        rings = [
            self._ring(self.lamp_radius, 0.0),
            self._ring(self.bottom_radius, 0.0),
            self._ring(self.rim_radius, self.depth),
            self._ring(self.rim_radius + self.wall, self.depth),
            self._ring(self.bottom_radius + self.wall, -self.wall),
        ]
        shape = Shape()
        for inner, outer in pairwise(rings):
            for i in range(12):
                j = (i + 1) % 12
                shape.polygon(inner[i], outer[i], outer[j], inner[j])
        return shape.polygon(*reversed(rings[-1]))

    def _ring(self, radius: float, height: float) -> list[Vec3]:
        axis = normalize(self.axis)
        aside = (0.0, 0.0, 1.0) if abs(axis[2]) < 0.9 else (1.0, 0.0, 0.0)
        s = normalize(cross(aside, axis))
        t = cross(axis, s)
        centre = along(self.bottom, axis, height)
        return [along(along(centre, s, radius * x), t, radius * y) for x, y in _TWELVE]


def icosphere(subdivisions: int) -> Shape:
    """The unit sphere as an icosahedron whose faces are cut in four, repeatedly."""
    g = (1.0 + math.sqrt(5.0)) / 2.0
    plane = [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)]
    vertices = (
        [(a, b, 0.0) for a, b in plane]
        + [(0.0, a, b) for a, b in plane]
        + [(b, 0.0, a) for a, b in plane]
    )
    sphere = Shape([normalize(v) for v in vertices])
    edge = min(distance(sphere.vertices[0], v) for v in sphere.vertices[1:])
    near = [[distance(a, b) < 1.1 * edge for b in sphere.vertices] for a in sphere.vertices]
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near[a][b] and near[b][c] and near[c][a]:
                    sphere.triangles.append(_outwards(sphere.vertices, a, b, c))
    for _ in range(subdivisions):
        sphere = _cut_in_four(sphere)
    return sphere


def _cut_in_four(sphere: Shape) -> Shape:
    finer = Shape(list(sphere.vertices))
    middles: dict[tuple[int, int], int] = {}

    def middle(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in middles:
            middles[key] = len(finer.vertices)
            p, q = sphere.vertices[key[0]], sphere.vertices[key[1]]
            finer.vertices.append(normalize((p[0] + q[0], p[1] + q[1], p[2] + q[2])))
        return middles[key]

    for a, b, c in sphere.triangles:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        finer.triangles += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return finer


def _outwards(vertices: list[Vec3], a: int, b: int, c: int) -> tuple[int, int, int]:
    normal = cross(sub(vertices[b], vertices[a]), sub(vertices[c], vertices[a]))
    return (a, b, c) if dot(normal, vertices[a]) > 0.0 else (a, c, b)
