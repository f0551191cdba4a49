"""Mitsuba sees the same in an XML scene and in what pathspace reads of it and writes again."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

mi = pytest.importorskip("mitsuba")

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/pathspace"

pytestmark = pytest.mark.skipif(
    not PROGRAM.is_file(), reason="pathspace is not built: run cargo build --release"
)

SENSOR = '<sensor type="perspective"><film type="hdrfilm"><rfilter type="box"/></film></sensor>'
LIGHT = '<emitter type="point"><point name="position" value="0 0 9"/></emitter>'
PLACE = (
    '<transform name="to_world"><rotate x="0.6" y="0.8" angle="30"/><translate x="0.3" z="0.1"/>'
    "</transform>"
)
MIRROR = '<transform name="to_world"><scale x="-1.5" y="1" z="0.5"/></transform>'
FLIP = '<boolean name="flip_normals" value="true"/>'
TEXTURE = (
    '<texture type="checkerboard" name="{}"><rgb name="color0" value="0.1 0.2 0.3"/>'
    '<transform name="to_uv"><scale x="3" y="4"/><translate x="0.3"/></transform></texture>'
)
IMAGE = (
    '<texture type="bitmap" name="{}"><string name="filename" value="image.png"/>'
    '<string name="filter_type" value="{}"/><string name="wrap_mode" value="{}"/>'
    '<transform name="to_uv"><scale x="2" y="1.5"/><translate x="0.1"/></transform></texture>'
)

SHAPES = [
    ("rectangle", PLACE),
    ("rectangle", MIRROR),
    ("rectangle", FLIP),
    ("cube", PLACE),
    ("cube", MIRROR),
    ("cube", FLIP),
    ("sphere", PLACE + '<point name="center" value="0.1"/><float name="radius" value="0.7"/>'),
    ("sphere", FLIP),
    ("sphere", '<transform name="to_world"><scale x="-1"/></transform>'),
    ("disk", PLACE),
    ("disk", MIRROR),
    ("disk", FLIP),
    ("cylinder", PLACE + '<point name="p0" value="0 0 -1"/><float name="radius" value="0.4"/>'),
    ("cylinder", FLIP),
    ("cylinder", '<transform name="to_world"><scale x="-1"/></transform>'),
    ("obj", '<string name="filename" value="smooth.obj"/>' + PLACE),
    ("obj", '<string name="filename" value="smooth.obj"/>' + MIRROR),
    ("obj", '<string name="filename" value="smooth.obj"/>' + FLIP),
    ("obj", '<string name="filename" value="plain.obj"/>' + PLACE),
    ("obj", '<string name="filename" value="plain.obj"/>' + MIRROR),
    ("obj", '<string name="filename" value="plain.obj"/>' + FLIP + MIRROR),
    (
        "obj",
        '<string name="filename" value="smooth.obj"/><boolean name="face_normals" value="true"/>'
        + MIRROR,
    ),
]

BSDFS = [
    '<bsdf type="diffuse"/>',
    '<bsdf type="diffuse"><spectrum name="reflectance" value="400:0.2, 500:0.9, 700:0.1"/></bsdf>',
    '<bsdf type="diffuse">' + TEXTURE.format("reflectance") + "</bsdf>",
    '<bsdf type="diffuse">' + IMAGE.format("reflectance", "bilinear", "repeat") + "</bsdf>",
    '<bsdf type="diffuse">' + IMAGE.format("reflectance", "nearest", "mirror") + "</bsdf>",
    '<bsdf type="diffuse">' + IMAGE.format("reflectance", "bilinear", "clamp") + "</bsdf>",
    '<bsdf type="conductor"/>',
    '<bsdf type="conductor"><string name="material" value="Au"/></bsdf>',
    '<bsdf type="roughconductor"><string name="material" value="Al"/></bsdf>',
    '<bsdf type="roughconductor"><spectrum name="eta" value="400:1.5, 700:1.2"/>'
    '<spectrum name="k" value="3"/><float name="alpha_u" value="0.1"/>'
    '<float name="alpha_v" value="0.3"/><string name="distribution" value="ggx"/></bsdf>',
    '<bsdf type="dielectric"/>',
    '<bsdf type="dielectric"><string name="int_ior" value="diamond"/>'
    '<rgb name="specular_transmittance" value="0.5 0.6 0.7"/></bsdf>',
    '<bsdf type="thindielectric"/>',
    '<bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf>',
    '<bsdf type="plastic"><boolean name="nonlinear" value="true"/></bsdf>',
    '<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.1 0.2 0.3"/></bsdf>',
    '<bsdf type="principled"/>',
    '<bsdf type="principled"><float name="specular" value="0.8"/><float name="metallic" value="0.3"'
    '/><float name="anisotropic" value="0.5"/><float name="clearcoat" value="0.5"/></bsdf>',
    '<bsdf type="twosided"><bsdf type="diffuse"/><bsdf type="roughconductor"/></bsdf>',
    '<bsdf type="mask"><float name="opacity" value="0.3"/><bsdf type="diffuse"/></bsdf>',
    '<bsdf type="blendbsdf">' + TEXTURE.format("weight") + '<bsdf type="diffuse"/>'
    '<bsdf type="conductor"/></bsdf>',
    '<bsdf type="bumpmap">'
    + IMAGE.format("bump", "bilinear", "repeat")
    + '<float name="scale" value="0.1"/><bsdf type="roughconductor"/></bsdf>',
    '<bsdf type="null"/>',
]

LIGHTS = [
    '<emitter type="point"><transform name="to_world"><translate y="2"/></transform></emitter>',
    '<emitter type="point"><spectrum name="intensity" value="3"/></emitter>',
    '<emitter type="point"><spectrum name="intensity" value="400:1, 600:5"/></emitter>',
    '<emitter type="spot"><transform name="to_world"><lookat origin="0 0 4" target="0.3 0 0"/>'
    '</transform><float name="cutoff_angle" value="30"/></emitter>',
    '<emitter type="directional"><vector name="direction" value="1 2 -3"/></emitter>',
    '<emitter type="constant"><rgb name="radiance" value="1 2 3"/></emitter>',
    '<emitter type="envmap"><string name="filename" value="image.png"/><float name="scale" value='
    '"2"/><transform name="to_world"><rotate y="1" angle="40"/></transform></emitter>',
    '<emitter type="projector"><texture type="bitmap" name="irradiance">'
    '<string name="filename" value="image.png"/></texture><float name="fov" value="50"/>'
    '<transform name="to_world"><lookat origin="0 0 4" target="0 0 0" up="0 1 0"/></transform>'
    "</emitter>",
]

FILM = (
    '<film type="hdrfilm"><integer name="width" value="60"/><integer name="height" value="40"/>'
    '{}<rfilter type="box"/></film>'
)
LOOK = '<transform name="to_world"><lookat origin="1 2 6" target="0 0 0" up="0 1 0"/></transform>'
CROP = (
    '<integer name="crop_width" value="20"/><integer name="crop_height" value="10"/>'
    '<integer name="crop_offset_x" value="25"/><integer name="crop_offset_y" value="15"/>'
)
SENSORS = [
    '<sensor type="perspective">' + LOOK + FILM.format("") + "</sensor>",
    '<sensor type="perspective"><float name="fov" value="40"/><string name="fov_axis" value='
    '"smaller"/>' + LOOK + FILM.format(CROP) + "</sensor>",
    '<sensor type="perspective"><float name="fov" value="40"/><float name='
    '"principal_point_offset_x" value="0.2"/>' + LOOK + FILM.format("") + "</sensor>",
    '<sensor type="thinlens"><float name="aperture_radius" value="0.2"/><float name='
    '"focus_distance" value="5"/><float name="fov" value="30"/>' + LOOK + FILM.format("") +
    "</sensor>",
    '<sensor type="orthographic"><transform name="to_world"><scale x="2" y="2"/>'
    '<lookat origin="1 2 6" target="0 0 0" up="0 1 0"/></transform>' + FILM.format("") +
    "</sensor>",
]  # fmt: skip

SHARED = ROOT.parent / "shared" / "scenes" / "mitsuba"

RANDOM = np.random.default_rng(7)


@pytest.fixture(autouse=True)
def variant() -> Iterator[None]:
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    yield


def both(folder: Path, *elements: str) -> tuple:
    """The scene of the elements, and what becomes of it."""
    pixels = np.random.default_rng(3).integers(0, 256, (5, 8, 3), dtype=np.uint8)
    mi.Bitmap(pixels).write(str(folder / "image.png"))
    corners = "v -1 -1 0\nv 1 -1 0.2\nv -1 1 0.1\nv 1 1 -0.3\nv 0 0 -1\n"
    texcoords = "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
    (folder / "plain.obj").write_text(
        corners + texcoords + "f 1/1 2/2 3/3\nf 2/2 4/4 3/3\nf 1/1 3/3 5/4\nf 2/2 1/1 5/4\n"
    )
    normals = "vn 0.1 0 1\nvn -0.2 0.1 3\nvn 0 0 1\n"
    (folder / "smooth.obj").write_text(
        corners + texcoords + normals + "f 1/1/1 2/2/2 3/3/3\nf 2/2/2 4/4/1 3/3/3\n"
    )
    original = folder / "scene.xml"
    original.write_text(f'<scene version="3.0.0">{"".join(elements)}</scene>')
    command = [PROGRAM, "export", original, folder / "out"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return mi.load_file(str(original)), mi.load_file(str(folder / "out" / "scene.xml"))


def rays(count: int) -> list:
    """From outside towards the middle."""
    origins = RANDOM.normal(size=(count, 3))
    origins *= 4 / np.linalg.norm(origins, axis=1, keepdims=True)
    targets = RANDOM.uniform(-0.8, 0.8, size=(count, 3))
    return [mi.Ray3f(list(o), list((t - o) / np.linalg.norm(t - o))) for o, t in zip(origins, targets, strict=True)]  # fmt: skip  # noqa: E501


def near(a: object, b: object, tolerance: float = 2e-4) -> None:
    """Equal but for single precision."""
    np.testing.assert_allclose(np.array(a), np.array(b), rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize(("plugin", "inner"), SHAPES)
def test_shapes_are_where_they_were(tmp_path: Path, plugin: str, inner: str) -> None:
    shape = f'<shape type="{plugin}">{inner}</shape>'
    a, b = both(tmp_path, SENSOR, LIGHT, shape)
    hits = 0
    for ray in rays(200):
        x, y = a.ray_intersect(ray), b.ray_intersect(ray)
        assert x.is_valid() == y.is_valid()
        if x.is_valid():
            hits += 1
            near(x.t, y.t)
            near(x.sh_frame.n, y.sh_frame.n)
            near(np.array(x.uv) % 1, np.array(y.uv) % 1, 1e-3)
    assert hits > 20


@pytest.mark.parametrize("bsdf", BSDFS)
def test_models_scatter_as_they_did(tmp_path: Path, bsdf: str) -> None:
    a, b = both(tmp_path, SENSOR, LIGHT, f'<shape type="rectangle">{bsdf}</shape>')
    context = mi.BSDFContext()
    for u, v, s, t, w in RANDOM.uniform(0.05, 0.95, size=(60, 5)):
        side = 1 if s < 0.7 else -1
        ray = mi.Ray3f([1.6 * u - 0.8 + 0.4, 1.6 * v - 0.8 + 0.3, side], [-0.4, -0.3, -side])
        x, y = a.ray_intersect(ray), b.ray_intersect(ray)
        assert x.is_valid() and y.is_valid()
        (p, weight), (q, other) = (
            si.bsdf(ray).sample(context, si, float(t), mi.Point2f(float(w), float(u)))
            for si in (x, y)
        )
        near(p.wo, q.wo, 1e-3)
        near(weight, other, 1e-3)
        wo = mi.warp.square_to_uniform_sphere(mi.Point2f(float(v), float(w)))
        near(x.bsdf(ray).eval(context, x, wo), y.bsdf(ray).eval(context, y, wo), 1e-3)


@pytest.mark.parametrize("light", LIGHTS)
def test_lights_shine_as_they_did(tmp_path: Path, light: str) -> None:
    a, b = both(tmp_path, SENSOR, light, '<shape type="disk"/>')
    for point in RANDOM.uniform(-1, 1, size=(40, 3)):
        it = mi.SurfaceInteraction3f()
        it.p = list(point)
        if a.environment() is not None:
            direction = mi.Vector3f(list(point / np.linalg.norm(point)))
            it.wi = -direction
            near(a.environment().eval(it), b.environment().eval(it), 1e-3)
            continue
        sample = mi.Point2f(0.3, 0.6)
        (x, weight), (y, other) = (
            scene.emitters()[0].sample_direction(it, sample) for scene in (a, b)
        )
        near(x.d, y.d)
        near(weight, other, 1e-3)


@pytest.mark.parametrize("sensor", SENSORS)
def test_cameras_look_where_they_did(tmp_path: Path, sensor: str) -> None:
    a, b = both(tmp_path, sensor, LIGHT, '<shape type="disk"/>')
    films = [scene.sensors()[0].film() for scene in (a, b)]
    assert list(films[0].crop_size()) == list(films[1].crop_size())
    for u, v, s, t in RANDOM.uniform(size=(30, 4)):
        samples = (0.0, 0.5, mi.Point2f(float(u), float(v)), mi.Point2f(float(s), float(t)))
        (x, _), (y, _) = (scene.sensors()[0].sample_ray(*samples) for scene in (a, b))
        near(x.d, y.d)
        # Where a camera's rays begin depends on its clipping planes, but not their line.
        near(np.cross(np.array(x.o) - np.array(y.o), np.array(x.d)), np.zeros(3), 1e-3)


@pytest.mark.skipif(not SHARED.is_dir(), reason=f"there is no {SHARED}")
@pytest.mark.parametrize("name", ["cornell-box", "veach-mis", "veach-bidir"])
def test_scenes_of_others_look_as_in_mitsuba(name: str) -> None:
    size = {"resx": 32, "resy": 18 if name == "veach-mis" else 32}
    command = [sys.executable, "-m", "pathspace.compare_xml", "--export", "--block", "6"]
    command += [str(SHARED / f"bitterli-{name}" / "scene.xml"), f"--binary={PROGRAM}"]
    command += ["-Dintegrator=path", *(f"-D{key}={value}" for key, value in size.items())]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "scripts")}
    done = subprocess.run(
        [*command, "--spp=32", "--passes=17"],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
    )
    assert done.returncode == 0, done.stdout + done.stderr
