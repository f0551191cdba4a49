"""Mitsuba on cells of the stability suite: a known answer, and cells that end badly."""

import json
import os
import signal
import subprocess
import sys
import time
from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import stability_scenes as scenes

from pathspace.stability import run
from pathspace.stability.passes import Passes

ROOT = Path(__file__).resolve().parents[2]
ALBEDO, EMISSION = 0.5, 0.3


def write_cells(folder: Path, *cells: dict[str, Any]) -> Path:
    """Write a list of cells beside an enclosure of known radiance."""
    body = scenes.enclosure(str(ALBEDO)).replace("0.3, 0.4, 0.5", str(EMISSION))
    (folder / "box.xml").write_text(body)
    common = {"integrator": "path", "max_depth": -1, "width": 4, "height": 4, "scene": "box.xml"}
    path = folder / "cells.json"
    path.write_text(json.dumps({"schema": 1, "cells": [{**common, **cell} for cell in cells]}))
    return path


def test_passes_have_the_known_mean(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("mitsuba", reason="mitsuba is not installed; run scripts/setup")
    cells = write_cells(
        tmp_path,
        {"id": "stiff/albedo/0.5"},
        {"id": "two", "max_depth": 2},
        {"id": "absent", "scene": "absent.xml"},
        {"id": "wide", "width": 5},
    )
    arguments = ["--cells", str(cells), "--variant", "scalar_rgb", "--seconds", "0.4"]
    assert run.main(arguments) == 0
    full, short, absent, wide = (json.loads(line) for line in capfd.readouterr().out.splitlines())
    assert [full["id"], full["variant"]] == ["stiff/albedo/0.5", "scalar_rgb"]
    for told, truth in (
        (full, EMISSION / (1 - ALBEDO)),
        (short, EMISSION * (1 + ALBEDO)),
    ):
        passes = np.array(told["passes"])
        assert len(passes) >= 16 and len(set(told["passes"])) > 1
        # |z| < 5 has a probability above 1 − 1e-3 with 15 degrees of freedom (Student's t).
        assert abs(passes.mean() - truth) < 5 * passes.std(ddof=1) / len(passes) ** 0.5
        assert told["nonfinite"] == told["negative"] == 0 and told["largest"] >= passes.max()
        assert told["spp"] >= 1 and 0 < told["seconds_per_sample"] < 0.1
    assert "absent.xml" in absent["failed"] and "4 × 4" in wide["failed"]


def renderer(script: str, seconds: float = 0.1) -> run.Renderer:
    """A child that only the protocol knows."""
    options = Namespace(variant="scalar_rgb", seconds=seconds, seed=0, threads=1)
    made = run.Renderer(options, dict(os.environ))
    made.command = [sys.executable, "-c", f"import json, os, sys, time\n{script}"]
    return made


def test_crashes_hangs_and_slow_cells_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "GRACE_SECONDS", 0.3)
    cell = {"id": "a"}
    pilot = "sys.stdin.readline()\nprint(json.dumps({'step': %r, 'seconds': 0.01}), flush=True)\n"
    assert renderer("sys.stdin.readline(); os.abort()").render(cell) == {
        "failed": "crashed: SIGABRT"
    }
    assert renderer("raise SystemExit(3)").render(cell) == {"failed": "crashed: exit status 3"}
    slow = renderer(pilot % "pilot" + "time.sleep(60)").render(cell)
    assert 1 <= slow["slow"] < 30
    hangs = renderer(pilot % "a pass" + "time.sleep(60)").render(cell)
    assert hangs["failed"].startswith("hangs: no answer from a pass")
    again = renderer("for line in sys.stdin: print('{\"slow\": 1}', flush=True)")
    assert again.render(cell) == again.render(cell) == {"slow": 1}
    again.end()


def test_interrupting_ends_at_once_without_a_traceback(tmp_path: Path) -> None:
    pytest.importorskip("mitsuba", reason="mitsuba is not installed; run scripts/setup")
    cells = write_cells(tmp_path, {"id": "absent", "scene": "absent.xml"}, {"id": "long"})
    command = [sys.executable, "-m", "pathspace.stability.run", "--cells", cells]
    command += ["--variant", "scalar_rgb", "--seconds", "600"]
    process = subprocess.Popen(command, stdout=-1, stderr=-1, text=True, cwd=ROOT / "scripts")
    assert process.stdout is not None and "failed" in process.stdout.readline()
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=10)
    assert (process.returncode, out, err) == (130, "", "")


def test_cells_that_make_no_sense_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "cells.json"
    arguments = ["--cells", str(path), "--variant", "scalar_rgb", "--seconds", "1"]
    for text, expected in (
        (None, "No such file"),
        ("{", "is no JSON"),
        ('{"schema": 2}', "schema 1"),
        ('{"schema": 1, "cells": [{"id": "x", "scene": "s"}]}', "cell x has no height"),
    ):
        if text is not None:
            path.write_text(text)
        assert run.main(arguments) == 2
        assert expected in capsys.readouterr().err


def test_values_that_cannot_be_are_counted_and_kept_out_of_json() -> None:
    passes = Passes()
    passes.add(np.full((2, 2, 3), 2.0))
    bad = np.ones((2, 2, 3))
    bad[0, 0], bad[1, 1, 2], bad[0, 1] = np.nan, np.inf, -1
    passes.add(bad)
    assert (passes.nonfinite, passes.negative, passes.largest) == (2, 1, 2.0)
    assert passes.means == [pytest.approx(2.0), None]
