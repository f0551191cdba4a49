"""The picture of a small table, and what it says of tables that are none."""

from pathlib import Path

import pytest

from pathspace.stability.figure import LOOKS, main, plot
from pathspace.stability.table import VERDICTS, read_table, short

HEADER = (
    "schema,group,case,parameter,value,method,verdict,estimate,truth,z,difference,interval,"
    "detectable,passes,samples,variance,variance_growth,tail_index,invalid,negative,firefly,weights,"
    "definition,seconds_per_sample,time_growth,rays_per_sample,details\n"
)


def write_table(folder: Path, *cells: tuple[str, ...]) -> Path:
    path = folder / "stability.csv"
    rows = (",".join(("1", *cell)) + "," * 20 + "\n" for cell in cells)
    path.write_text(HEADER + "".join(rows))
    return path


def small(folder: Path) -> Path:
    cells = [
        ("stiff", "albedo", "1 - rho", value, method, verdict)
        for method in ("mitsuba:path:scalar_rgb", "path", "bdpt:heuristic=power:exponent=2")
        for value, verdict in zip(("0.5", "0.01", "1e-6"), ("holds", "slow", "fails"), strict=True)
    ]
    cells += [("light", verdict, "size", "1e-9", "path", verdict) for verdict in VERDICTS]
    cells += [("random", "extremes", "u", "0", "core", "beyond")]
    cells += [("stiff", "mirrors", "bounces", "1000000", "path", "noise")]
    return write_table(folder, *cells)


def test_pictures_show_all_cells(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    small(tmp_path)
    assert main([str(tmp_path)]) == 0
    assert capsys.readouterr().out.split() == [
        str(tmp_path / "stability.png"),
        str(tmp_path / "stability.svg"),
    ]
    assert (tmp_path / "stability.png").read_bytes().startswith(b"\x89PNG")
    assert "</svg>" in (tmp_path / "stability.svg").read_text()
    figure = plot(read_table(tmp_path / "stability.csv"))
    words = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert words.count("1e-6") == 3 and words.count("F") == 3 + 1 + 1
    assert "3 of 11 hold, 2 fail" not in words and "2 of 11 hold, 2 fail" in words
    assert "without an integrator" in words and "mitsuba:\npath:scalar_rgb" in words
    assert all(look.meaning in words for look in LOOKS.values())


def test_groups_stay_together_and_other_renderers_come_last(tmp_path: Path) -> None:
    table = read_table(small(tmp_path))
    assert [row.group for row in table.rows[:2]] == ["stiff", "stiff"]
    assert table.methods[-1] == "mitsuba:path:scalar_rgb"
    integrators, alone = table.parts()
    assert alone.methods == ("core",) and "core" not in integrators.methods
    assert len(integrators.rows) + len(alone.rows) == len(table.rows)


def test_values_are_short() -> None:
    written = ["1e-06", "0.01", "179.9", "1000000000.0", "1.0", "0.0", "1234.5", "1.5e-300", "-90"]
    expected = ["1e-6", "0.01", "179.9", "1e9", "1", "0", "1234.5", "1.5e-300", "-90"]
    assert [short(value) for value in written] == expected


def test_tables_that_are_none_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path)]) == 1
    assert "No such file" in capsys.readouterr().err
    write_table(tmp_path, ("a", "b", "c", "1", "path", "perhaps"))
    assert main([str(tmp_path)]) == 1
    assert "line 2: no verdict is called 'perhaps'" in capsys.readouterr().err
    (tmp_path / "stability.csv").write_text(HEADER)
    assert main([str(tmp_path)]) == 1
    (tmp_path / "stability.csv").write_text("schema,group\n1,a\n")
    assert main([str(tmp_path)]) == 1
    assert "no column case" in capsys.readouterr().err
