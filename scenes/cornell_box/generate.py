"""Cornell University's box, from its published measurements (see README.md)."""

from __future__ import annotations

import math

from cornell_box import spectra
from gltf_writer import GltfScene
from shapes import Shape
from vectors import Vec3

# Corners in millimetres, as published; x grows to the left of the image, z away from the camera.
FLOOR = ((552.8, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 559.2), (549.6, 0.0, 559.2))
CEILING = ((556.0, 548.8, 0.0), (556.0, 548.8, 559.2), (0.0, 548.8, 559.2), (0.0, 548.8, 0.0))
LIGHT = ((343.0, 548.8, 227.0), (343.0, 548.8, 332.0), (213.0, 548.8, 332.0), (213.0, 548.8, 227.0))
BACK = ((549.6, 0.0, 559.2), (0.0, 0.0, 559.2), (0.0, 548.8, 559.2), (556.0, 548.8, 559.2))
RIGHT = ((0.0, 0.0, 559.2), (0.0, 0.0, 0.0), (0.0, 548.8, 0.0), (0.0, 548.8, 559.2))
LEFT = ((552.8, 0.0, 0.0), (549.6, 0.0, 559.2), (556.0, 548.8, 559.2), (556.0, 548.8, 0.0))
# The tops of the blocks; their sides go straight down to the floor.
SHORT_BLOCK = (
    (130.0, 165.0, 65.0),
    (82.0, 165.0, 225.0),
    (240.0, 165.0, 272.0),
    (290.0, 165.0, 114.0),
)
TALL_BLOCK = (
    (423.0, 330.0, 247.0),
    (265.0, 330.0, 296.0),
    (314.0, 330.0, 456.0),
    (472.0, 330.0, 406.0),
)
CAMERA = (278.0, 273.0, -800.0)
FOCAL_LENGTH, FILM_SIZE = 0.035, 0.025
# The lamp's spectrum is published without an absolute unit; this scale exposes the picture well.
LIGHT_SCALE = 2.0


def build() -> GltfScene:
    """The scene."""
    scene = GltfScene(
        "cornell_box",
        {
            "film": {"width": 256, "height": 256},
            "reference": {"image": {"file": "reference.exr", "max_length": None}},
            # Where the whole lamp is in sight, and what leaves it.
            "sensors": {"floor": "irradiance:0.4,0.001,0.1:0,1,0", "lamp": "flux:light:leaving"},
        },
    )
    white = scene.diffuse("white", spectra.reflectance(spectra.WHITE))
    red = scene.diffuse("red", spectra.reflectance(spectra.RED))
    green = scene.diffuse("green", spectra.reflectance(spectra.GREEN))
    # What the lamp reflects was not measured for these spectra; nothing is taken for it.
    light = scene.diffuse("light", (0.0, 0.0, 0.0), emission=spectra.emission(LIGHT_SCALE))

    scene.mesh("floor", _polygon(FLOOR), white)
    scene.mesh("ceiling", _frame(CEILING, LIGHT), white)
    scene.mesh("light", _polygon(LIGHT), light)
    scene.mesh("back_wall", _polygon(BACK), white)
    scene.mesh("right_wall", _polygon(RIGHT), green)
    scene.mesh("left_wall", _polygon(LEFT), red)
    scene.mesh("short_block", _block(SHORT_BLOCK), white)
    scene.mesh("tall_block", _block(TALL_BLOCK), white)
    camera = _metres(CAMERA)
    scene.camera(
        camera, (camera[0], camera[1], 0.0), 2.0 * math.atan(0.5 * FILM_SIZE / FOCAL_LENGTH)
    )
    return scene


def _metres(corner: Vec3) -> Vec3:
    return (corner[0] / 1000.0, corner[1] / 1000.0, corner[2] / 1000.0)


def _polygon(corners: tuple[Vec3, ...]) -> Shape:
    return Shape().polygon(*map(_metres, corners))


def _frame(outer: tuple[Vec3, ...], inner: tuple[Vec3, ...]) -> Shape:
    """The quadrilateral `outer` with the hole `inner`, whose corners are in the same order."""
    shape = Shape()
    for i in range(4):
        j = (i + 1) % 4
        shape.polygon(*map(_metres, (outer[i], outer[j], inner[j], inner[i])))
    return shape


def _block(top: tuple[Vec3, ...]) -> Shape:
    """A block without its bottom, which stands on the floor."""
    shape = _polygon(top)
    for i in range(4):
        a, b = top[i], top[(i + 1) % 4]
        below = ((a[0], 0.0, a[2]), (b[0], 0.0, b[2]))
        shape.polygon(*map(_metres, (a, below[0], below[1], b)))
    return shape
