"""A closed diffuse box that shines and reflects alike everywhere (see README.md)."""

from __future__ import annotations

from gltf_writer import GltfScene
from shapes import box

# Sums of few powers of two: single precision holds them, and the answer, without rounding.
EMISSION = (0.25, 0.5, 0.125)
REFLECTANCE = (0.5, 0.25, 0.75)


def build() -> GltfScene:
    """The scene."""
    answer = {"emission": list(EMISSION), "reflectance": list(REFLECTANCE)}
    scene = GltfScene(
        "enclosure",
        {
            "film": {"width": 64, "height": 64},
            "reference": {"enclosure": answer},
            "sensors": {
                "centre": "irradiance:0,0,0:0,1,0",
                "floor": "flux:-1,-0.749999,-1.5:0,0,3:2,0,0",
                "ray": "radiance:0.3,0.1,0.9:-0.8,-0.4,-1.9",
            },
        },
    )
    wall = scene.diffuse("wall", REFLECTANCE, emission=EMISSION)
    room = box((-1.0, -0.75, -1.5), (1.0, 0.75, 1.5), inside_out=True)
    scene.mesh("walls", room, wall)
    scene.camera((0.3, 0.1, 0.9), (-0.5, -0.3, -1.0), 1.0)
    return scene
