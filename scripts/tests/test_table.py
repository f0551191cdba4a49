from pathlib import Path

import pytest
from synthetic import write_experiment

import pathspace
from pathspace.table import main, table


def test_markdown_is_readable_as_it_stands(tmp_path: Path) -> None:
    write_experiment(tmp_path, ["one|two"])
    lines = table(pathspace.load(tmp_path), columns=["scene", "method", "rmse"]).splitlines()
    assert lines[:3] == [
        "| scene    | method          |   rmse |",
        "|----------|-----------------|-------:|",
        "| one\\|two | path            | 0.0949 |",
    ]
    assert len({len(line) for line in lines}) == 1


def test_latex_escapes_names_and_sets_numbers(tmp_path: Path) -> None:
    write_experiment(tmp_path, ["a_room", "b"])
    columns = ["scene", "method", "image_difference"]
    lines = table(pathspace.load(tmp_path), "agreement", columns, "latex").splitlines()
    assert lines[0] == "\\begin{tabular}{llr}"
    assert lines[4] == "a\\_room & path & $3.33 \\cdot 10^{-6}$ \\\\"
    assert lines.count("\\addlinespace") == 1 and lines[-1] == "\\end{tabular}"


def test_missing_values_are_empty_and_missing_columns_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_experiment(tmp_path, ["one"])
    columns = "--columns=other,time_ratio"
    assert main([str(tmp_path), "--table", "verdicts", "--format", "latex", columns]) == 0
    assert "mitsuba:ptracer &  \\\\" in capsys.readouterr().out
    assert main([str(tmp_path), "--columns", "speed"]) == 1
    assert "no column speed; it has: " in capsys.readouterr().err
