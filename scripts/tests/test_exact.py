"""Path logs of the program against their evaluation with 60 digits."""

import csv
import json
import os
import subprocess
import sys
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest
import stability_scenes as scenes

from pathspace.stability import fresnel
from pathspace.stability.compare import Comparison, compare
from pathspace.stability.exact import main
from pathspace.stability.geometry import PI, ZERO, Edge, Number, Uncertain, Vector, unit, vector
from pathspace.stability.scene import Camera, Emitter, Scene
from pathspace.stability.surface import Conductor, Dielectric, Surface
from pathspace.stability.weights import Competitor, weights

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/pathspace"
needs_program = pytest.mark.skipif(
    not PROGRAM.is_file(), reason="pathspace is not built: run cargo build --release"
)
Log = tuple[list[dict[str, Any]], Scene]


def log(folder: Path, xml: str, integrator: str, *options: str, lines: int) -> Log:
    """Let the program write the first lines of a log."""
    file, parameters = folder / "scene.xml", folder / "scene.json"
    file.write_text(xml)
    command = [PROGRAM, "paths", file, "-i", integrator, "--scene-json", parameters]
    command += ["--format", "jsonl", *options]
    found = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            found.append(json.loads(line))
            if len(found) == lines:
                process.kill()
                break
    assert len(found) == lines
    return found, Scene.of(json.loads(parameters.read_text()))


def check(lines: list[dict[str, Any]], scene: Scene) -> Comparison:
    """Evaluate a log, all of which has to hold."""
    comparison = compare(lines, scene)
    assert not comparison.skipped and comparison.paths == len(lines)
    wrong = {name: q for name, q in comparison.quantities.items() if not q.holds}
    assert not wrong
    return comparison


@needs_program
def test_paths_of_a_thousand_edges(tmp_path: Path) -> None:
    options = ("--max-length", "1000", "--where", "L.{999}E", "--pixel", "1,1")
    comparison = check(*log(tmp_path, scenes.enclosure(), "path:roulette=off", *options, lines=1))
    assert comparison.log10_p[0] < -900
    assert comparison.of("p").bound < 1e-10 and comparison.of("p").beyond == 0
    small = scenes.enclosure(scale=1e-6)
    comparison = check(*log(tmp_path, small, "path:roulette=off", *options, lines=1))
    assert comparison.log10_p[1] > 1e4


@needs_program
@pytest.mark.parametrize("alpha", [1e-1, 1e-4, 1e-8])
def test_near_specular_chains(tmp_path: Path, alpha: float) -> None:
    comparison = check(*log(tmp_path, scenes.chain(alpha), "bdpt", lines=10))
    # Half vectors of rounded directions leave about 2⁻⁵³ / α of a density, and nothing of weights.
    assert comparison.of("p").error < 100 * 2**-53 / alpha
    assert comparison.of("w f/(n p)").error < 1e-13


@needs_program
@pytest.mark.parametrize("distance", [1e-1, 1e-5, 1e-9])
def test_connections_across_a_corner(tmp_path: Path, distance: float) -> None:
    xml = scenes.corner(distance)
    comparison = check(*log(tmp_path, xml, "bdpt", "--max-length", "4", lines=30))
    # f has 1/d² for each edge across, and keeps its digits: positions are given.
    assert comparison.of("f").error < 1e-14
    assert comparison.log10_p[1] > -4 * mp.log10(distance)


@needs_program
@pytest.mark.parametrize(
    "heuristic",
    ["balance", "power:exponent=1", "power:exponent=100", "maximum", "cutoff:threshold=0.6"],
)
def test_heuristics_whose_ratios_leave_every_range(tmp_path: Path, heuristic: str) -> None:
    integrator = f"bdpt:heuristic={heuristic}"
    lines, scene = log(tmp_path, scenes.chain(1e-6), integrator, "--samples", "2", lines=6)
    spread = check(lines, scene).log10_p
    assert 100 * (spread[1] - spread[0]) > 600
    assert {line["heuristic"]["kind"] for line in lines} == {heuristic.split(":")[0]}


@needs_program
@pytest.mark.parametrize(
    ("integrator", "more"),
    [
        ("bdpt", ("--samples", "20", "--max-length", "5")),
        (
            "light",
            (
                "--samples",
                "60",
            ),
        ),
        ("path:roulette=fixed:survival=0.7:roulette_start=1", ("--samples", "9")),
        ("path:roulette=local:roulette_start=1", ("--light-selection", "uniform")),
        ("path:roulette=throughput:roulette_start=1", ("--samples", "9")),
    ],
)
def test_glass_mirror_sky_and_lens(tmp_path: Path, integrator: str, more: tuple[str, ...]) -> None:
    lines, scene = log(tmp_path, scenes.terrace(), integrator, *more, lines=20)
    check(lines, scene)
    uniform = "uniform" in more
    error, bound = scene.choice_error(uniform=uniform)
    assert error <= bound
    assert scene.choice_error(uniform=not uniform)[0] > 1e-3


@needs_program
@pytest.mark.parametrize("alpha", [None, 0.2])
def test_normals_that_are_not_the_geometric_ones(tmp_path: Path, alpha: float | None) -> None:
    (tmp_path / "floor.obj").write_text(scenes.LEANING)
    bsdf = scenes.rough(alpha) if alpha else scenes.diffuse("0.7, 0.6, 0.5")
    lines, scene = log(tmp_path, scenes.relief("floor.obj", bsdf), "bdpt", lines=60)
    lines = [line for line in lines if any(vertex["shading_normal"] for vertex in line["vertices"])]
    assert len(lines) > 10
    check(lines[:16], scene)


@needs_program
def test_logs_are_read_by_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines, _ = log(tmp_path, scenes.enclosure(), "bdpt", lines=5)
    file = tmp_path / "paths.jsonl"
    arguments = ["--scene-json", str(tmp_path / "scene.json"), str(file)]
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert main(arguments) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["holds"] is True and told["paths"] == 5 and told["log"] == str(file)
    assert set(told["quantities"]) >= {"f", "p", "ln p", "w", "Σ w", "w f/(n p)", "P(emitter)"}
    lines[0]["weight"] *= 1.0001
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert main(arguments) == 1
    assert json.loads(capsys.readouterr().out)["holds"] is False
    file.write_text('{"schema": 3}\n')
    assert main(arguments) == 2
    assert f"{file}: line 1: schema 3" in capsys.readouterr().err
    file.unlink()
    assert main(arguments) == 2


@needs_program
def test_the_suite_evaluates_its_logs(tmp_path: Path) -> None:
    command = [PROGRAM, "stability", "across a corner", "powers", "-o"]
    here = {**os.environ, "PATHSPACE_PYTHON": sys.executable}
    done = subprocess.run([*command, tmp_path], cwd=ROOT, env=here, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "stability.csv").open() as file:
        cells = list(csv.DictReader(file))
    assert [cell["case"] for cell in cells] == ["across a corner"] * 3 + ["powers"] * 3
    for cell in cells:
        assert (cell["method"], cell["verdict"]) == ("core", "holds")
        assert 0 < float(cell["difference"]) < float(cell["detectable"]) < 1e-4
        assert "edges" in cell["details"]
    absent = {**os.environ, "PATHSPACE_PYTHON": "/absent/python"}
    done = subprocess.run(
        [*command, tmp_path], cwd=ROOT, env=absent, capture_output=True, text=True
    )
    with (tmp_path / "stability.csv").open() as file:
        cells = list(csv.DictReader(file))
    assert {cell["verdict"] for cell in cells} == {"missing"}
    assert all("no Python" in cell["details"] for cell in cells)


def plant_cosine(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = Edge.to_area
    monkeypatch.setattr(
        Edge, "to_area", lambda self, normal: whole(self, normal) * self.cosine(normal)
    )


def plant_swap(monkeypatch: pytest.MonkeyPatch) -> None:
    right = Conductor.density
    monkeypatch.setattr(
        Conductor, "density", lambda self, came_from, to, n: right(self, to, came_from, n)
    )


def plant_no_scale(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fresnel.Interface, "radiance_scale", lambda self, a, b: mp.mpf(1))


def plant_rough_scale(monkeypatch: pytest.MonkeyPatch) -> None:
    right = Dielectric.value

    def value(self: Dielectric, a: Vector, b: Vector, n: Vector) -> list[Number]:
        dropped = self.interface.radiance_scale(mp.fdot(a, n), mp.fdot(b, n))
        return [channel / dropped for channel in right(self, a, b, n)]

    monkeypatch.setattr(Dielectric, "value", value)


def plant_sky(monkeypatch: pytest.MonkeyPatch) -> None:
    right = Emitter.first

    def first(self: Emitter, normal: Vector | None, edge: Edge) -> tuple[Uncertain, Uncertain]:
        position, direction = right(self, normal, edge)
        return (
            (position.over(edge.cosine(normal)), direction)
            if not self.is_local
            else (position, direction)
        )

    monkeypatch.setattr(Emitter, "first", first)


def plant_importance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        Camera,
        "importance",
        lambda self, edge: self.position_density * self.direction_density(edge),
    )


@needs_program
@pytest.mark.parametrize(
    ("plant", "xml", "quantity"),
    [
        (plant_cosine, scenes.enclosure(), "p"),
        (plant_swap, scenes.chain(0.3), "p"),
        (plant_no_scale, scenes.aquarium(), "f"),
        (plant_no_scale, scenes.aquarium(), "p"),
        (plant_rough_scale, scenes.aquarium(0.3), "f"),
        (plant_sky, scenes.terrace(), "w of all"),
        (plant_importance, scenes.terrace(), "f"),
    ],
)
def test_planted_errors_are_seen(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    plant: Callable[[pytest.MonkeyPatch], None],
    xml: str,
    quantity: str,
) -> None:
    lines, scene = log(tmp_path, xml, "bdpt", "--samples", "9", lines=24)
    lines = [line for line in lines if line["edges"] > 1][-12:]
    check(lines, scene)
    plant(monkeypatch)
    seen = compare(deepcopy(lines), scene)
    assert not seen.quantities[quantity].holds and seen.quantities[quantity].error > 1e-3


def test_models_integrate_as_they_should() -> None:
    """Fresnel's, a full circle of normals, and weights of numbers that no double holds."""
    at_normal = fresnel.dielectric(mp.mpf(1.5), mp.mpf(1))
    assert abs(at_normal - mp.mpf(4) / 100) < mp.mpf(10) ** -50
    same = fresnel.complex_index(mp.mpc(1.5), mp.mpf(0.3))
    assert abs(same - fresnel.dielectric(mp.mpf(1.5), mp.mpf(0.3))) < mp.mpf(10) ** -50
    ggx = fresnel.Ggx(0.3)
    normal = vector([0, 0, 1])

    def seen(z: Number) -> Number:
        return ggx.distribution(unit((mp.sqrt(1 - z * z), ZERO, z)), normal) * z

    assert abs(2 * PI * mp.quad(seen, [0, 0.5, 0.9, 1]) - 1) < 1e-12
    big = [Competitor(1, mp.mpf(10) ** e, 0.0, 0.0, 0.0) for e in (-500, 500)]
    for kind in ({"kind": "balance"}, {"kind": "power", "exponent": 3}, {"kind": "maximum"}):
        (small, _), (large, _) = weights(kind, big)
        assert abs(small + large - 1) < 1e-30 and small < mp.mpf(10) ** -900


def test_a_tie_may_go_either_way() -> None:
    even = [Competitor(1, mp.mpf(2), 1.0, 0.0, 0.0)] * 2
    assert weights({"kind": "maximum"}, even) == [(0, 1), (0, 1)]
    half = [Competitor(1, mp.mpf(1), 1.0, 0.0, 0.0), Competitor(1, mp.mpf(2), 1.0, 0.0, 0.0)]
    low, high = weights({"kind": "cutoff", "threshold": 0.5}, half)[0]
    assert low == 0 and abs(high - mp.mpf(1) / 3) < 1e-12


def test_unknown_materials_are_told() -> None:
    with pytest.raises(NotImplementedError, match="'velvet'"):
        Surface.of({"name": "velvet", "two_sided": False, "kind": "other"})
