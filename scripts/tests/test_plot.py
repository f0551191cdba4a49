import csv
import math
from pathlib import Path

import numpy as np
import pytest
from synthetic import METHODS, write_rows

from pathspace.plot_convergence import PlotError, curve, main, read_rows


@pytest.mark.parametrize("scenes", [["one"], ["one", "two", "three", "four"]])
def test_both_pictures_are_written(tmp_path: Path, scenes: list[str]) -> None:
    write_rows(tmp_path, scenes)
    assert main([str(tmp_path)]) == 0
    assert (tmp_path / "convergence.png").read_bytes().startswith(b"\x89PNG")
    svg = (tmp_path / "convergence.svg").read_text()
    assert "</svg>" in svg


def test_curves_are_geometric_means_over_seeds(tmp_path: Path) -> None:
    write_rows(tmp_path, ["one"], seeds=3)
    rows = [row for row in read_rows(tmp_path / "rows.csv") if row.method == "bdpt"]
    found = curve(rows, "rmse")
    first = [row.errors["rmse"] for row in rows if row.checkpoint == 0]
    assert found is not None
    assert math.isclose(found.error[0], math.prod(first) ** (1 / 3))
    assert math.isclose(found.spread[0], math.exp(np.std(np.log(first), ddof=1)))
    assert len(found.seconds) == 8


def test_scenes_without_a_reference_are_drawn_empty(tmp_path: Path) -> None:
    write_rows(tmp_path, ["one"])
    with (tmp_path / "rows.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    with (tmp_path / "rows.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(row | {"rmse": "", "relmse": "NaN"} for row in rows)
    assert len(rows) == 40 * len(METHODS)
    assert main([str(tmp_path), "-o", str(tmp_path / "a.png")]) == 0


def test_what_cannot_be_read_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path)]) == 1
    assert "rows.csv" in capsys.readouterr().err
    (tmp_path / "rows.csv").write_text("scene,method\n")
    with pytest.raises(PlotError, match="render_seconds"):
        read_rows(tmp_path / "rows.csv")
