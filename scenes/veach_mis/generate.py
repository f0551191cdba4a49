"""Four metal plates under four spheres, in the manner of Veach and Guibas 1995 (see README.md)."""

from __future__ import annotations

from gltf_writer import GltfScene, Rgb
from shapes import Shape, box, tilted_box
from vectors import Vec3, along, normalize, sub

CAMERA = (0.0, 1.3, 5.2)
TARGET = (0.0, 0.25, 0.0)
VERTICAL_FOV = 0.5
# The middle of the row of lamps: what each plate's mirror image shows in its centre.
LAMPS = (0.0, 1.15, -0.9)
# Radius [m] and colour of each lamp, from left to right; each radius is twice the one before.
LAMP_SPACING = 0.8
LAMP_KINDS: tuple[tuple[float, Rgb], ...] = (
    (0.025, (1.2, 1.0, 0.8)),
    (0.05, (1.0, 1.1, 0.9)),
    (0.1, (0.9, 1.0, 1.1)),
    (0.2, (1.1, 0.9, 1.0)),
)
# Flux per channel [W], before the colour.
FLUX = 8.0
# GGX roughness α and centre of each plate, from the farthest to the nearest.
PLATES: tuple[tuple[float, Vec3], ...] = (
    (0.005, (0.0, 0.56, -0.45)),
    (0.02, (0.0, 0.26, 0.0)),
    (0.05, (0.0, 0.02, 0.55)),
    (0.1, (0.0, -0.15, 1.2)),
)
PLATE_SIZE = (3.0, 0.34, 0.02)
# Four times the square of pi, as the flux of a sphere of radius r is 4π²r² times its radiance.
FOUR_PI_SQUARED = 39.47841760435743


def build() -> GltfScene:
    """The scene."""
    scene = GltfScene(
        "veach_mis",
        {
            "environment": [0.02, 0.02, 0.02],
            "film": {"width": 384, "height": 256},
            "reference": {"image": {"file": "reference.exr", "max_length": None}},
        },
    )
    grey = scene.diffuse("grey", (0.4, 0.4, 0.4))
    for alpha, centre in PLATES:
        metal = scene.conductor(f"metal_{alpha}", (0.8, 0.8, 0.8), alpha)
        to_camera = normalize(sub(CAMERA, centre))
        normal = along(to_camera, normalize(sub(LAMPS, centre)), 1.0)
        scene.mesh(f"plate_{alpha}", tilted_box(centre, normal, PLATE_SIZE), metal)
    for i, (radius, colour) in enumerate(LAMP_KINDS):
        radiance = [round(FLUX * c / (FOUR_PI_SQUARED * radius**2), 6) for c in colour]
        name = f"lamp_{i + 1}"
        material = scene.diffuse(
            name, (0.0, 0.0, 0.0), emission=(radiance[0], radiance[1], radiance[2])
        )
        x = LAMP_SPACING * (i - 1.5)
        scene.sphere(name, (x, LAMPS[1], LAMPS[2]), radius, material)
    scene.mesh("stage", _stage(), grey)
    scene.camera(CAMERA, TARGET, VERTICAL_FOV)
    return scene


def _stage() -> Shape:
    """The floor and the back wall."""
    return box((-5.0, -0.5, -1.6), (5.0, 4.0, 6.0), faces="yz", inside_out=True)
