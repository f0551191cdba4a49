"""A room whose lamps hide in their shades, in the manner of Veach 1997 (see README.md)."""

from __future__ import annotations

from gltf_writer import GltfScene
from shapes import Cup, Shape, box
from vectors import Vec3

ROOM = (5.6, 2.7, 4.4)
CAMERA = (2.8, 1.45, 4.2)
TARGET = (2.75, 1.0, 0.0)
VERTICAL_FOV = 0.92
# Where solids meet they overlap by this much: no two faces lie in one plane.
SINK = 0.01

FLOOR_LAMP = Cup(
    bottom=(0.95, 1.5, 0.95),
    axis=(0.0, 1.0, 0.0),
    depth=0.3,
    lamp_radius=0.07,
    bottom_radius=0.1,
    rim_radius=0.2,
    wall=0.015,
)
SPOT_LAMP = Cup(
    bottom=(4.55, 2.3, 1.5),
    axis=(0.9, -0.15, -0.4),
    depth=0.25,
    lamp_radius=0.06,
    bottom_radius=0.08,
    rim_radius=0.14,
    wall=0.02,
)
TABLE_LOW, TABLE_HIGH = (2.2, 0.7, 1.5), (3.7, 0.75, 2.4)
GLASS_RADIUS = 0.19


def build() -> GltfScene:
    """The scene."""
    scene = GltfScene(
        "hidden_lamps",
        {
            "film": {"width": 320, "height": 240},
            "reference": {"image": {"file": "reference.exr", "max_length": None}},
        },
    )
    wall = scene.diffuse("wall", (0.75, 0.73, 0.7))
    floor = scene.diffuse("floor", (0.45, 0.33, 0.22))
    wood = scene.diffuse("wood", (0.5, 0.3, 0.15))
    cloth = scene.diffuse("cloth", (0.2, 0.3, 0.5))
    dark = scene.diffuse("dark", (0.15, 0.15, 0.15))
    shade = scene.diffuse("shade", (0.7, 0.65, 0.55))
    picture = scene.diffuse("picture", (0.6, 0.2, 0.15))
    glass = scene.dielectric("glass", 1.5)
    warm = scene.diffuse("warm_light", (0.0, 0.0, 0.0), emission=(1100.0, 850.0, 580.0))
    cool = scene.diffuse("cool_light", (0.0, 0.0, 0.0), emission=(1200.0, 1350.0, 1600.0))

    x, y, _ = ROOM
    scene.mesh("floor", box((0.0, 0.0, 0.0), ROOM, faces="y", inside_out=True), floor)
    scene.mesh("walls", box((0.0, 0.0, 0.0), ROOM, faces="xXYzZ", inside_out=True), wall)

    scene.mesh("floor_lamp_light", FLOOR_LAMP.lamp(), warm)
    scene.mesh("floor_lamp_shade", FLOOR_LAMP.body(), shade)
    scene.mesh("floor_lamp_stand", _stand(FLOOR_LAMP.bottom), dark)
    scene.mesh("spot_lamp_light", SPOT_LAMP.lamp(), cool)
    scene.mesh("spot_lamp_shade", SPOT_LAMP.body(), shade)
    scene.mesh("spot_lamp_stem", box((4.53, 2.385, 1.49), (4.55, y + SINK, 1.51)), dark)

    scene.mesh("table", _table(), wood)
    centre = (2.75, TABLE_HIGH[1] + GLASS_RADIUS + 0.001, 1.95)
    scene.sphere("glass_sphere", centre, GLASS_RADIUS, glass)
    scene.mesh("book", box((3.2, 0.75 - SINK, 1.75), (3.5, 0.8, 2.0)), cloth)
    scene.mesh("cabinet", box((-SINK, -SINK, 1.7), (0.45, 0.95, 2.9)), wood)
    sofa = box((3.6, -SINK, -SINK), (5.3, 0.42, 0.8)).add(
        box((3.61, 0.41, -SINK), (5.29, 0.85, 0.25))
    )
    scene.mesh("sofa", sofa, cloth)
    scene.mesh("picture", box((1.9, 1.3, -SINK), (3.1, 2.1, 0.03)), picture)
    scene.mesh("door", box((x - 0.03, -SINK, 2.4), (x + SINK, 2.05, 3.3)), wood)
    scene.camera(CAMERA, TARGET, VERTICAL_FOV)
    return scene


def _stand(lamp: Vec3) -> Shape:
    x, y, z = lamp
    foot = box((x - 0.14, -SINK, z - 0.14), (x + 0.14, 0.03, z + 0.14))
    return foot.add(box((x - 0.012, 0.02, z - 0.012), (x + 0.012, y - SINK, z + 0.012)))


def _table() -> Shape:
    shape = box(TABLE_LOW, TABLE_HIGH)
    for x in (TABLE_LOW[0] + 0.05, TABLE_HIGH[0] - 0.11):
        for z in (TABLE_LOW[2] + 0.05, TABLE_HIGH[2] - 0.11):
            shape.add(box((x, -SINK, z), (x + 0.06, TABLE_LOW[1] + SINK, z + 0.06)))
    return shape
