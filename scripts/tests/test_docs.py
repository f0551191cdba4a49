"""The example of the documentation and the help of each command do what they say."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from synthetic import write_experiment

GUIDE = Path(__file__).parents[2] / "src/docs/scripting.md"


def test_the_example_of_the_guide_runs(tmp_path: Path) -> None:
    (tmp_path / "results").mkdir()
    folder = tmp_path / "results" / "cornell_box"
    folder.mkdir()
    write_experiment(folder, ["cornell_box"])
    [program] = re.findall(r"```python\n(.*?)```", GUIDE.read_text("utf-8"), re.DOTALL)
    assert len(program.split("import pathspace\n")[1].strip().splitlines()) <= 10
    run = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env={"MPLBACKEND": "Agg", "PYTHONPATH": str(Path(__file__).parents[1])},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "relmse_over_samples.pdf").stat().st_size > 1000


@pytest.mark.parametrize(
    "name", re.findall(r"python -m (pathspace\.\w+)", GUIDE.read_text("utf-8"))
)
def test_help_teaches(name: str) -> None:
    run = subprocess.run([sys.executable, "-m", name, "--help"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.count(f"python -m {name} DIR") >= 2, "examples"
