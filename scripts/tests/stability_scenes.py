"""Small scenes in Mitsuba's format for the second evaluation of path logs."""

SIDE = 4
"""Of films [pixels]."""


def scene(body: str, camera: str, max_depth: int = 6) -> str:
    return (
        f'<scene version="3.0.0"><integrator type="path">'
        f'<integer name="max_depth" value="{max_depth}"/></integrator>{camera}{body}</scene>'
    )


def camera(origin: str, target: str, fov: float = 60.0, lens: str = "") -> str:
    kind = "thinlens" if lens else "perspective"
    return (
        f'<sensor type="{kind}"><float name="fov" value="{fov!r}"/>{lens}'
        f'<transform name="to_world"><lookat origin="{origin}" target="{target}" up="0, 1, 0"/>'
        f"</transform>"
        f'<film type="hdrfilm"><integer name="width" value="{SIDE}"/>'
        f'<integer name="height" value="{SIDE}"/><rfilter type="box"/></film></sensor>'
    )


LENS = '<float name="aperture_radius" value="0.2"/><float name="focus_distance" value="1.5"/>'


def diffuse(reflectance: str) -> str:
    return f'<bsdf type="diffuse"><rgb name="reflectance" value="{reflectance}"/></bsdf>'


def shape(kind: str, bsdf: str, transform: str = "", emission: str = "", rest: str = "") -> str:
    emitter = (
        f'<emitter type="area"><rgb name="radiance" value="{emission}"/></emitter>'
        if emission
        else ""
    )
    return (
        f'<shape type="{kind}">{rest}<transform name="to_world">{transform}</transform>'
        f"{bsdf}{emitter}</shape>"
    )


INWARDS = '<boolean name="flip_normals" value="true"/>'
LAMP = '<scale value="0.3"/><rotate x="1" angle="90"/><translate y="0.95"/>'
METAL = '<string name="material" value="Au"/>'


def enclosure(albedo: str = "0.9, 0.8, 0.95", scale: float = 1.0) -> str:
    """A closed diffuse box that emits everywhere."""
    walls = shape("cube", diffuse(albedo), f'<scale value="{scale!r}"/>', "0.3, 0.4, 0.5", INWARDS)
    corner = ", ".join(repr(x * scale) for x in (0.5, 0.4, -0.6))
    return scene(walls, camera("0, 0, 0", corner))


def rough(alpha: float, kind: str = "roughconductor", rest: str = METAL) -> str:
    return (
        f'<bsdf type="{kind}"><string name="distribution" value="ggx"/>'
        f'<float name="alpha" value="{alpha!r}"/>{rest}</bsdf>'
    )


def chain(alpha: float) -> str:
    """A box of rough metal with a lamp, a ball of rough glass and one of diffuse plaster."""
    body = (
        shape("cube", rough(alpha), rest=INWARDS)
        + shape("rectangle", diffuse("0.5"), LAMP, "5, 4, 3")
        + shape(
            "sphere",
            rough(alpha, "roughdielectric", '<float name="int_ior" value="1.5"/>'),
            '<scale value="0.35"/><translate x="0.4" y="-0.3" z="-0.2"/>',
        )
        + shape("sphere", diffuse("0.7, 0.5, 0.3"), '<scale value="0.3"/><translate x="-0.4"/>')
    )
    return scene(body, camera("0.1, 0.2, 0.9", "0, 0, -1"))


def terrace(ior: float = 1.5) -> str:
    """Under the sky and a point light: smooth glass, a mirror, a ball that shines, a lens."""
    glass = f'<bsdf type="dielectric"><float name="int_ior" value="{ior!r}"/></bsdf>'
    body = (
        shape(
            "rectangle",
            f'<bsdf type="twosided">{diffuse("0.6, 0.5, 0.4")}</bsdf>',
            '<scale value="3"/><rotate x="1" angle="-90"/><translate y="-0.6"/>',
        )
        + shape("sphere", glass, '<scale value="0.5"/><translate x="0.3"/>')
        + shape(
            "rectangle",
            f'<bsdf type="conductor">{METAL}</bsdf>',
            '<rotate y="1" angle="60"/><translate x="-1.2"/>',
        )
        + shape(
            "sphere",
            diffuse("0.2"),
            '<scale value="0.1"/><translate x="-0.4" z="0.6"/>',
            "20, 15, 9",
        )
        + '<emitter type="constant"><rgb name="radiance" value="0.3, 0.4, 0.5"/></emitter>'
        + '<emitter type="point"><point name="position" x="0.2" y="1.5" z="0.4"/>'
        '<rgb name="intensity" value="2, 2, 3"/></emitter>'
    )
    return scene(body, camera("0, 0.4, 2.4", "0, 0, 0", 40.0, LENS))


def aquarium(alpha: float = 0.0) -> str:
    """A room seen from within a ball of glass, so that refraction happens once."""
    ior = '<float name="int_ior" value="1.5"/>'
    glass = (
        rough(alpha, "roughdielectric", ior) if alpha else f'<bsdf type="dielectric">{ior}</bsdf>'
    )
    body = (
        shape("cube", diffuse("0.6, 0.5, 0.4"), rest=INWARDS)
        + shape("sphere", glass, '<scale value="0.5"/>')
        + shape("rectangle", diffuse("0.5"), LAMP, "5, 4, 3")
    )
    return scene(body, camera("0.1, 0, 0", "0.3, 1, 0.4", lens=LENS))


LEANING = """v -1 -0.5 1
v 1 -0.5 1
v 1 -0.5 -1
v -1 -0.5 -1
vn -0.5 1 0.5
vn 0.5 1 0.5
vn 0.5 1 -0.5
vn -0.5 1 -0.5
f 1//1 2//2 3//3
f 1//1 3//3 4//4
"""
"""A square whose normals lean outwards, as an OBJ file."""


def relief(mesh: str, bsdf: str) -> str:
    """A box whose floor, in a file, has normals that are not the geometric ones."""
    body = (
        shape("cube", diffuse("0.6, 0.5, 0.4"), rest=INWARDS)
        + shape("obj", bsdf, rest=f'<string name="filename" value="{mesh}"/>')
        + shape("rectangle", diffuse("0.5"), LAMP, "5, 4, 3")
    )
    return scene(body, camera("0.1, 0.3, 0.9", "0, -0.6, -0.3"))


def corner(distance: float) -> str:
    """Two emitting walls that meet at an edge, which the camera looks at from nearby."""
    wall = diffuse("0.8, 0.6, 0.4")
    body = shape(
        "rectangle", wall, '<rotate x="1" angle="-90"/><translate y="-1"/>', "1, 2, 3"
    ) + shape("rectangle", wall, '<translate z="-1"/>', "3, 2, 1")
    return scene(body, camera("0.1, 0, 0", "0.2, -1, -1", 60.0 * distance))
