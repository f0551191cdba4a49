"""Every texture, emitter, sensor, shape and filter."""

from .case import BOX, CAMERA, FLOOR, LAMP, PANEL, SKY, VIEW, Case, film, on
from .materials import DIFFUSE, METAL

BITMAP = (
    '<texture type="bitmap" name="reflectance"><string name="filename" value="{}"/>{}</texture>'
)
WIDER = '<transform name="to_uv"><scale x="2.3" y="1.7"/><translate x="0.2" y="-0.3"/></transform>'


def textures() -> list[Case]:
    """List textures, each as a reflectance."""
    inside = {
        "bitmap-srgb": BITMAP.format("colours.png", ""),
        "bitmap-raw": BITMAP.format("colours.png", '<boolean name="raw" value="true"/>'),
        "bitmap-jpeg": BITMAP.format("colours.jpg", ""),
        "bitmap-exr": BITMAP.format("colours.exr", ""),
        "bitmap-exr-grey": BITMAP.format("grey.exr", ""),
        "bitmap-hdr": BITMAP.format("colours.hdr", ""),
        "bitmap-grey": BITMAP.format("greys.png", ""),
        "bitmap-nearest": BITMAP.format(
            "colours.png", '<string name="filter_type" value="nearest"/>'
        ),
        **{
            f"bitmap-{wrap}": BITMAP.format(
                "colours.png", f'<string name="wrap_mode" value="{wrap}"/>{WIDER}'
            )
            for wrap in ("repeat", "mirror", "clamp")
        },
        "bitmap-to-uv": BITMAP.format(
            "colours.png",
            '<transform name="to_uv"><rotate z="1" angle="30"/><scale value="1.5"/></transform>',
        ),
        "checkerboard": '<texture type="checkerboard" name="reflectance">'
        '<rgb name="color0" value="0.1, 0.2, 0.6"/><rgb name="color1" value="0.8, 0.7, 0.3"/>'
        '<transform name="to_uv"><scale x="4" y="3"/></transform></texture>',
    }
    flat = [
        Case(f"texture/{name}", on(PANEL, f'<bsdf type="diffuse">{text}</bsdf>'))
        for name, text in inside.items()
    ]
    mesh = PANEL.replace('type="rectangle"', 'type="ply"').replace(
        "%BSDF%", '<string name="filename" value="attributes.ply"/>%BSDF%'
    )
    attribute = '<bsdf type="diffuse"><texture type="mesh_attribute" name="reflectance"><string name="name" value="{}"/></texture></bsdf>'
    return flat + [
        Case(f"texture/mesh-attribute-{kind}", on(mesh, attribute.format(f"{kind}_color")))
        for kind in ("vertex", "face")
    ]


def emitters() -> list[Case]:
    """List emitters, each over a box on the floor."""
    image = '<texture type="bitmap" name="{}"><string name="filename" value="colours.exr"/><boolean name="raw" value="true"/></texture>'
    lamp = """
  <shape type="{}">{}<transform name="to_world">{}</transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.2"/></bsdf>
    <emitter type="area">{}</emitter>
  </shape>"""
    down = '<rotate x="1" angle="180"/><scale value="1.5"/><translate x="1" y="-1" z="3"/>'
    look = '<transform name="to_world"><lookat origin="2, -2, 4" target="0, 0, -0.5" up="0, 1, 0"/></transform>'
    radiance = '<rgb name="radiance" value="$radiance"/>'
    inside = {
        "area": lamp.format("rectangle", "", down, radiance),
        "area-seen": lamp.format(
            "rectangle", "", '<rotate x="1" angle="70"/><translate y="1" z="1"/>', radiance
        ),
        "area-textured": lamp.format("rectangle", "", down, image.format("radiance")),
        "area-sphere": lamp.format("sphere", "", '<translate x="1.5" y="-1" z="2"/>', radiance),
        "area-disk": lamp.format("disk", "", down, radiance),
        "area-cylinder": lamp.format(
            "cylinder", "", '<scale value="0.5"/><translate x="1.5" y="-1" z="1.5"/>', radiance
        ),
        "point": '<emitter type="point"><point name="position" x="2" y="-2" z="3"/>'
        '<rgb name="intensity" value="20, 25, 30"/></emitter>',
        "spot": f'<emitter type="spot">{look}<rgb name="intensity" value="40, 30, 20"/>'
        '<float name="cutoff_angle" value="25"/><float name="beam_width" value="12"/></emitter>',
        "spot-default": f'<emitter type="spot">{look}<rgb name="intensity" value="40"/></emitter>',
        "directional": '<emitter type="directional"><vector name="direction" x="-1" y="1" z="-2"/>'
        '<rgb name="irradiance" value="3, 2, 1"/></emitter>',
        "constant": SKY,
        "envmap": '<emitter type="envmap"><string name="filename" value="sky.exr"/>'
        '<float name="scale" value="1.5"/><transform name="to_world">'
        '<rotate x="1" angle="90"/><rotate z="1" angle="40"/></transform></emitter>',
        "projector": f'<emitter type="projector">{look}{image.format("irradiance")}'
        '<float name="fov" value="35"/><float name="scale" value="30"/></emitter>',
    }
    box = BOX.replace("%BSDF%", DIFFUSE)
    # A textured lamp is drawn by brightness here, by area in Mitsuba.
    own = {"area-textured": "by brightness", "envmap": "exactly by luminance"}
    return [
        Case(f"emitter/{name}", CAMERA + FLOOR + box + text, pdf=own.get(name, "same"))
        for name, text in inside.items()
    ]


def sensors() -> list[Case]:
    """List sensors, each before the same scene."""
    scene = FLOOR + LAMP + SKY + BOX.replace("%BSDF%", DIFFUSE)

    def case(name: str, sensor: str, shape: str = film(), **more: object) -> Case:
        return Case(f"sensor/{name}", sensor + scene, film=shape, **more)

    # Without a sky, from which few light paths come to the camera.
    lit = FLOOR + LAMP + BOX.replace("%BSDF%", DIFFUSE)
    thin = (
        '\n  <sensor type="thinlens"><float name="fov" value="30"/><float name="aperture_radius" value="0.2"/>'
        f'<float name="focus_distance" value="5"/>{VIEW}\n    %FILM%\n  </sensor>'
    )

    def perspective(inside: str) -> str:
        return f'\n  <sensor type="perspective">{inside}{VIEW}\n    %FILM%\n  </sensor>'

    wide = '<integer name="width" value="48"/><integer name="height" value="32"/>'
    wide = f'<film type="hdrfilm">{wide}<string name="pixel_format" value="rgb"/><rfilter type="box"/></film>'
    crop = "".join(
        f'<integer name="crop_{name}" value="{value}"/>'
        for name, value in (("offset_x", 12), ("offset_y", 20), ("width", 32), ("height", 24))
    )
    fov = '<float name="fov" value="30"/>'
    shifted = '<float name="principal_point_offset_x" value="0.2"/><float name="principal_point_offset_y" value="-0.1"/>'
    above = '<transform name="to_world"><lookat origin="0.5, -1.5, -0.99" target="0.5, -1.5, 3" up="0, 1, 0"/></transform>'
    ground = """
  <shape type="rectangle" id="meter">
    <transform name="to_world"><scale value="0.4"/><translate x="-0.5" y="-1.6" z="-0.9"/></transform>
    <bsdf type="diffuse"/>
    <sensor type="irradiancemeter">%FILM%</sensor>
  </shape>"""
    return [
        case("perspective", perspective(fov)),
        case("perspective-wide", perspective(fov), wide),
        Case("sensor/perspective-light", perspective(fov) + lit, particles=True),
        Case("sensor/thinlens-light", thin + lit, particles=True),
        *[
            case(
                f"perspective-fov-{axis}",
                perspective(fov + f'<string name="fov_axis" value="{axis}"/>'),
                wide,
            )
            for axis in ("y", "smaller", "diagonal")
        ],
        case("focal-length", perspective('<string name="focal_length" value="60mm"/>')),
        case("principal-point", perspective(fov + shifted)),
        case("crop", perspective(fov), film(64, crop)),
        case("thinlens", thin),
        case(
            "orthographic",
            '\n  <sensor type="orthographic"><transform name="to_world"><scale x="2" y="2"/>'
            '<lookat origin="1, -5, 2.5" target="0, 0, 0" up="0, 0, 1"/></transform>\n    %FILM%\n  </sensor>',
        ),
        case("irradiancemeter", ground, film(1), effort=1024),
        case(
            "radiancemeter",
            f'\n  <sensor type="radiancemeter">{VIEW}\n    %FILM%\n  </sensor>',
            film(1),
            effort=1024,
        ),
        case(
            "distant",
            '\n  <sensor type="distant"><vector name="direction" x="0.3" y="0.5" z="-1"/>'
            '<point name="target" x="0.2" y="-0.3" z="0"/>\n    %FILM%\n  </sensor>',
            film(1),
            effort=1024,
        ),
        case(
            "distant-meter",
            f'\n  <sensor type="radiancemeter">{above}\n    %FILM%\n  </sensor>',
            film(1),
            effort=1024,
        ),
    ]


def shapes() -> list[Case]:
    """List shapes, covered by rough metal, whose image shows the normals."""
    place = '<transform name="to_world"><scale x="1" y="0.8" z="0.9"/><rotate x="1" angle="20"/><rotate z="1" angle="35"/></transform>'
    even = place.replace('<scale x="1" y="0.8" z="0.9"/>', '<scale value="0.9"/>')
    texture = '<bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="colours.png"/></texture></bsdf>'
    both = f'<bsdf type="twosided">{texture}</bsdf>'

    def shape(kind: str, inside: str = "", bsdf: str = texture, to_world: str = place) -> str:
        return f'\n  <shape type="{kind}" id="object">{inside}{to_world}{bsdf}</shape>'

    def file(name: str) -> str:
        return f'<string name="filename" value="{name}"/>'

    flip = '<boolean name="flip_normals" value="true"/>'
    flat = '<boolean name="face_normals" value="true"/>'
    group = (
        f'\n  <shape type="shapegroup" id="group"><shape type="cube">{even}{texture}</shape>'
        f'<shape type="obj">{file("knob.obj")}<transform name="to_world"><scale value="0.5"/><translate z="1"/></transform>{METAL}</shape></shape>'
    )
    instances = "".join(
        f'\n  <shape type="instance"><ref id="group"/><transform name="to_world"><scale value="0.5"/>'
        f'<rotate z="1" angle="{angle}"/><translate x="{x}" z="-0.3"/></transform></shape>'
        for x, angle in ((-0.8, 10), (0.8, 70))
    )
    found = {
        "obj": shape("obj", file("knob.obj"), METAL),
        "obj-textured": shape("obj", file("knob.obj")),
        "obj-flip-tex-coords": shape(
            "obj", file("knob.obj") + '<boolean name="flip_tex_coords" value="false"/>'
        ),
        "ply-ascii": shape("ply", file("knob.ascii.ply")),
        "ply-binary": shape("ply", file("knob.ply")),
        "ply-without-normals": shape("ply", file("bare.ply"), METAL),
        "serialized": shape(
            "serialized", file("knobs.serialized") + '<integer name="shape_index" value="1"/>'
        ),
        "rectangle": shape("rectangle", bsdf=both),
        "cube": shape("cube"),
        "sphere": shape(
            "sphere",
            '<point name="center" x="0.1" y="0.2" z="0"/><float name="radius" value="0.9"/>',
            to_world=even,
        ),
        "disk": shape("disk", bsdf=both),
        "cylinder": shape(
            "cylinder",
            '<point name="p0" x="0" y="0" z="-0.8"/><point name="p1" x="0.2" y="0.1" z="0.9"/><float name="radius" value="0.6"/>',
            both,
            even,
        ),
        "instance": group + instances,
        "flip-normals-obj": shape("obj", file("knob.obj") + flip, '<bsdf type="dielectric"/>'),
        "flip-normals-sphere": shape("sphere", flip, '<bsdf type="dielectric"/>', even),
        "flip-normals-rectangle": shape("rectangle", flip, texture),
        "flip-normals-cube": shape(
            "cube", flip, '<bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>'
        ),
        "face-normals-obj": shape("obj", file("knob.obj") + flat, METAL),
        "face-normals-ply": shape("ply", file("knob.ply") + flat, METAL),
    }
    return [
        Case(f"shape/{name}", CAMERA + FLOOR + LAMP + SKY + text) for name, text in found.items()
    ]


def filters() -> list[Case]:
    """List pixel filters, with the border where that is defined alike."""
    scene = on(BOX, DIFFUSE)
    found = {
        "box": ('<rfilter type="box"/>', 0),
        "tent": ('<rfilter type="tent"/>', 1),
        "tent-wide": ('<rfilter type="tent"><float name="radius" value="2"/></rfilter>', 2),
        "gaussian": ('<rfilter type="gaussian"/>', 2),
        "gaussian-wide": (
            '<rfilter type="gaussian"><float name="stddev" value="0.8"/></rfilter>',
            4,
        ),
    }
    return [
        Case(f"filter/{name}", scene, film=film(rfilter=text), border=border)
        for name, (text, border) in found.items()
    ]


def cases() -> list[Case]:
    """List the cases of this module."""
    return textures() + emitters() + sensors() + shapes() + filters()
