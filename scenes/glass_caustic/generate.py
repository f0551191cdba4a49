"""Caustics of a glass sphere and of a mirror under a small lamp (see README.md)."""

from __future__ import annotations

from gltf_writer import GltfScene
from shapes import box, tilted_box
from vectors import along, normalize, sub

LOW, HIGH = (-1.6, 0.0, -1.5), (1.6, 2.6, 2.1)
CAMERA = (0.1, 1.45, 2.0)
TARGET = (0.15, 0.15, 0.1)
VERTICAL_FOV = 0.85
GLASS_CENTRE, GLASS_RADIUS = (-0.35, 0.301, -0.1), 0.3
LAMP_LOW, LAMP_HIGH = (-1.38, 1.7, -0.93), (-1.32, 1.78, -0.87)
MIRROR_CENTRE, MIRROR_SIZE = (0.75, 0.4, -0.35), (0.5, 0.6, 0.03)
# Where the mirror throws the light that it gets in its centre.
MIRROR_TARGET = (0.45, 0.0, 0.5)


def build() -> GltfScene:
    """The scene."""
    scene = GltfScene(
        "glass_caustic",
        {
            "film": {"width": 256, "height": 256},
            "reference": {"image": {"file": "reference.exr", "max_length": None}},
        },
    )
    floor = scene.diffuse("floor", (0.6, 0.58, 0.55))
    wall = scene.diffuse("wall", (0.4, 0.45, 0.5))
    dark = scene.diffuse("dark", (0.2, 0.2, 0.2))
    glass = scene.dielectric("glass", 1.5)
    mirror = scene.conductor("mirror", (0.95, 0.93, 0.88))
    light = scene.diffuse("light", (0.0, 0.0, 0.0), emission=(4000.0, 3700.0, 3200.0))

    scene.mesh("floor", box(LOW, HIGH, faces="y", inside_out=True), floor)
    scene.mesh("walls", box(LOW, HIGH, faces="xXYzZ", inside_out=True), wall)
    scene.mesh("light", box(LAMP_LOW, LAMP_HIGH, faces="y"), light)
    scene.mesh("light_housing", box(LAMP_LOW, LAMP_HIGH, faces="xXYzZ"), dark)
    scene.sphere("glass_sphere", GLASS_CENTRE, GLASS_RADIUS, glass)

    to_lamp = normalize(sub((-1.35, 1.7, -0.9), MIRROR_CENTRE))
    normal = along(to_lamp, normalize(sub(MIRROR_TARGET, MIRROR_CENTRE)), 1.0)
    panel = (MIRROR_CENTRE, normal, MIRROR_SIZE)
    scene.mesh("mirror", tilted_box(*panel, faces="Z"), mirror)
    scene.mesh("mirror_back", tilted_box(*panel, faces="xXyYz"), dark)
    scene.camera(CAMERA, TARGET, VERTICAL_FOV)
    return scene
