"""Runs on several workers, of which one is killed."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pathspace.distribute import main
from pathspace.exr import read_channels

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/pathspace"

pytestmark = pytest.mark.skipif(
    not PROGRAM.is_file(), reason="pathspace is not built: run cargo build --release"
)

SCENE = "{ file = '%s', film = '64x64' }"


def manifest(folder: Path, name: str, budget: str, seeds: int, methods: str) -> Path:
    scene = SCENE % (ROOT / "scenes/cornell_box")
    path = folder / f"{name}.toml"
    path.write_text(
        f"scenes = [{scene}]\nmethods = {methods}\nseeds = {seeds}\nbudget = {budget}\n"
        "reference = 'none'\n"
    )
    return path


def start(*arguments: str | Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "pathspace.distribute", "--pathspace", PROGRAM, *arguments]
    return subprocess.Popen(command, stdout=-1, stderr=-1, text=True, cwd=ROOT / "scripts")


def images(folder: Path) -> dict[str, np.ndarray]:
    return {
        str(path.relative_to(folder)): np.stack(list(read_channels(path).values()))
        for path in sorted((folder / "runs").glob("*/*/*/image.exr"))
    }


def workers(parent: int) -> list[int]:
    """Worker processes below one, whose command says so."""
    found = subprocess.run(["ps", "-wweo", "pid,ppid,args"], capture_output=True, text=True)
    lines = [line.split(None, 2) for line in found.stdout.splitlines()[1:]]
    return [int(p) for p, pp, args in lines if int(pp) == parent and "spawn_main" in args]


def test_a_worker_that_is_killed_loses_nothing(tmp_path: Path) -> None:
    toml = manifest(tmp_path, "exp", "{ spp = 60 }", 4, "['path', 'light', 'bdpt']")
    subprocess.run([PROGRAM, "compare", toml, "-o", tmp_path / "local"], check=True)
    process = start(toml, "--workers", "3")
    while not list((tmp_path / "exp/runs").glob("*/*/*/run.json")):
        assert process.poll() is None
        time.sleep(0.05)
    victims = workers(process.pid)
    assert len(victims) >= 3
    os.kill(victims[0], signal.SIGKILL)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert "12/12" in err
    local, spread = images(tmp_path / "local"), images(tmp_path / "exp")
    assert len(local) == 12
    assert local.keys() == spread.keys()
    assert all(np.array_equal(local[name], spread[name]) for name in local)
    assert (tmp_path / "exp/summary.csv").is_file()


def test_timed_runs_have_the_machine_for_themselves(tmp_path: Path) -> None:
    toml = manifest(tmp_path, "exp", "{ seconds = 0.6 }", 2, "['path', 'light']")
    process = start(toml, "--workers", "3")
    busy = 0
    while process.poll() is None:
        listed = subprocess.run(["ps", "-wweo", "args"], capture_output=True, text=True).stdout
        jobs = re.findall(rf"^{re.escape(str(PROGRAM))} compare.*--job", listed, re.MULTILINE)
        busy = max(busy, len(jobs))
        time.sleep(0.03)
    out, err = process.communicate()
    assert process.returncode == 0, err
    assert "never share a machine" in err
    assert busy == 1


def test_a_run_that_fails_is_named_and_the_others_are_made(tmp_path: Path) -> None:
    toml = manifest(tmp_path, "exp", "{ spp = 2 }", 2, "['path', 'light']")
    for seed in (2, 4):
        (tmp_path / f"exp/runs/cornell_box/light/.{seed}.lock").mkdir(parents=True)
    process = start(toml, "--workers", "2")
    _, err = process.communicate(timeout=120)
    assert process.returncode == 1, err
    assert "2 of 4 runs failed" in err
    assert "distribute: cornell_box/light/" in err
    assert len(images(tmp_path / "exp")) == 2


def test_an_interruption_keeps_what_is_finished(tmp_path: Path) -> None:
    toml = manifest(tmp_path, "exp", "{ spp = 200 }", 8, "['path', 'light']")
    process = start(toml, "--workers", "2")
    while not (found := list((tmp_path / "exp/runs").glob("*/*/*/run.json"))):
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert "the same command goes on" in err
    assert all(path.is_file() for path in found)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["none.toml"], "none.toml"),
        (["{toml}", "--pathspace", "/none"], "no such program"),
        (["{toml}", "--pathspace", str(PROGRAM), "--workers", "-1"], "--workers"),
        (["{bad}", "--pathspace", str(PROGRAM)], "did you mean"),
    ],
)
def test_wrong_arguments_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], text: str
) -> None:
    toml = manifest(tmp_path, "exp", "{ spp = 1 }", 1, "['path']")
    bad = manifest(tmp_path, "bad", "{ spp = 1 }", 1, "['pth']")
    assert main([argument.format(toml=toml, bad=bad) for argument in arguments]) == 2
    err = capsys.readouterr().err
    assert text in err
    assert len(err.splitlines()) == 1
