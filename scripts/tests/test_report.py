"""The report says what the tables say, and what it embeds are the images."""

import base64
import html
import json
import re
import zlib
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from synthetic import write_experiment, write_rows

from pathspace import load
from pathspace.report import page
from pathspace.report.__main__ import main
from pathspace.report.images import LARGEST, pack
from pathspace.report.tables import shown

SCENES = ["box", "veach <mis> & </script>"]


class Cells(HTMLParser):
    """The cells of all tables, with scene, table and line."""

    def __init__(self) -> None:
        super().__init__()
        self.cells: list[tuple[int, str, int, str, str]] = []
        self.scene, self.table, self.line = -1, "", -1

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        if tag == "section" and "data-scene" in values:
            self.scene = int(values["data-scene"])
        elif tag == "table":
            self.table, self.line = values.get("data-table", ""), -2
        elif tag == "tr":
            self.line += 1
        elif tag == "td" and "data-column" in values:
            column, value = values["data-column"], values["data-value"]
            self.cells.append((self.scene, self.table, self.line, column, value))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("experiment")
    write_experiment(folder, SCENES)
    return folder


@pytest.fixture(scope="module")
def text(folder: Path) -> str:
    return page(load(folder))


def data_of(text: str) -> dict:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found
    return json.loads(found[1])


def test_every_number_of_the_plots_stands_in_curves_csv(folder: Path, text: str) -> None:
    curves = pd.read_csv(folder / "curves.csv")
    points = 0
    for scene in data_of(text)["scenes"]:
        for curve in scene["curves"]:
            where = curves["scene"] == scene["name"]
            for column in ("method", "hardware", "metric"):
                where &= curves[column] == curve[column]
            lines = curves[where].set_index("checkpoint")
            for i, checkpoint in enumerate(curve["checkpoint"]):
                line = lines.loc[checkpoint]
                for column in ("seeds", "seconds", "spp", "error", "low", "high"):
                    assert curve[column][i] == line[column]
                assert curve["noisy"][i] == line["below_reference_noise"]
                points += 1
    assert points == len(curves)


def test_every_cell_stands_in_its_table_with_all_digits(folder: Path, text: str) -> None:
    names = {"Methods": "summary", "Verdicts": "verdicts", "Same image?": "agreement"}
    parser = Cells()
    parser.feed(text)
    tables = {
        name: pd.read_csv(folder / f"{file}.csv", keep_default_na=False, dtype=str)
        for name, file in names.items()
    }
    for scene, table, line, column, value in parser.cells:
        frame = tables[table]
        found = frame[frame["scene"] == SCENES[scene]].iloc[line][column]
        assert value == found or float(value) == float(found), (table, column)
    lines = {(scene, table, line) for scene, table, line, _, _ in parser.cells}
    assert len(lines) == sum(len(frame) for frame in tables.values())


def test_images_are_those_of_the_files_in_half_precision(folder: Path, text: str) -> None:
    experiment = load(folder)
    scene = data_of(text)["scenes"][0]
    assert [image["name"] for image in scene["images"]] == ["reference", *experiment.methods]
    for image in scene["images"]:
        planes = np.frombuffer(zlib.decompress(base64.b64decode(image["data"])), np.uint8)
        values = np.ascontiguousarray(planes.reshape(2, -1).T).view("<f2").astype(np.float64)
        name = image["name"]
        true = experiment.reference("box") if name == "reference" else experiment.image("box", name)
        assert true is not None
        assert np.allclose(values.reshape(true.shape), true, rtol=2**-11, atol=0)


def test_values_beyond_half_precision_are_bounded() -> None:
    packed = zlib.decompress(base64.b64decode(pack(np.array([1e9, -1e9, np.nan], np.float32))))
    values = np.ascontiguousarray(np.frombuffer(packed, np.uint8).reshape(2, -1).T).view("<f2")
    assert values.ravel().tolist() == [LARGEST, -LARGEST, 0.0]


def test_names_are_text_whatever_they_hold(text: str) -> None:
    assert html.escape(SCENES[1]) in text
    without_data = re.sub(r'id="data">.*?</script>', "", text, flags=re.DOTALL)
    assert SCENES[1] not in without_data
    assert data_of(text)["scenes"][1]["name"] == SCENES[1]


def test_it_needs_nothing_else(text: str) -> None:
    body = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)
    assert not re.search(r'(src|href)="(?!#|data:)', body)
    assert "pathspace compare nothing -o nowhere" in text


def test_an_experiment_of_rows_alone_has_a_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_rows(tmp_path, ["box"])
    assert main([str(tmp_path)]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "There are no tables." in text
    assert main([str(tmp_path / "none")]) == 1
    assert "rows.csv: no such file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (8.0, "8"),
        (0.0103, "0.0103"),
        (2.154, "2.15"),
        (123.4, "123"),
        (1e-9, "1.00e-09"),
    ]
    + [(0.1234, "0.123"), (45.67, "45.7"), (float("inf"), "inf")],
)
def test_numbers_have_three_digits(value: float, text: str) -> None:
    assert shown(value) == text
