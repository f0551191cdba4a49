import csv
from pathlib import Path

import numpy as np
import pytest
from synthetic import METHODS, SIZE, write_experiment, write_rows

import pathspace
from pathspace.styles import styles


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("experiment")
    write_experiment(folder, ["a room", "two"])
    return folder


def test_tables_and_manifest_are_read(folder: Path) -> None:
    experiment = pathspace.load(folder)
    assert experiment.scenes == ["a room", "two"]
    assert experiment.methods == list(METHODS)
    assert len(experiment.rows) == 2 * 5 * 4 * 8
    assert experiment.curves["below_reference_noise"].sum() == 3 * 2
    assert experiment.curves["below_reference_noise"].dtype == bool
    assert np.isnan(experiment.verdicts["time_ratio"]).sum() == 4 * 2
    assert experiment.experiment["record"]["version"] == "0.1.0"


def test_floats_are_read_to_the_last_bit(folder: Path) -> None:
    with (folder / "rows.csv").open(newline="") as file:
        expected = [float(row["mse"]) for row in csv.DictReader(file)]
    assert pathspace.load(folder).rows["mse"].to_list() == expected


def test_images_are_arrays_with_rows_from_the_top(folder: Path) -> None:
    experiment = pathspace.load(folder)
    reference = experiment.reference("a room")
    assert reference is not None and reference.shape == (SIZE, SIZE + 8, 3)
    assert np.allclose(reference[0, :, 1], 0.2) and np.allclose(reference[:, 0, 0], 0.1)
    error = experiment.reference_error("a room")
    assert error is not None and np.allclose(error, 0.001)
    runs = [experiment.image("two", "mitsuba:path", seed) for seed in range(4)]
    mean = experiment.image("two", "mitsuba:path")
    assert mean is not None and np.allclose(np.mean(runs, axis=0), mean, atol=1e-6)
    assert experiment.image("two", "mitsuba:path", 4) is None


def test_another_schema_is_refused_by_name(tmp_path: Path) -> None:
    write_rows(tmp_path, ["one"])
    path = tmp_path / "rows.csv"
    header, *lines = path.read_text().splitlines()
    path.write_text("\n".join([header, *(f"2{line[1:]}" for line in lines)]))
    with pytest.raises(pathspace.LoadError, match=r"rows.csv: schema 2.*reads schema 1"):
        pathspace.load(tmp_path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "no such file; is"),
        ("scene,method\n", "no column checkpoint, render_seconds"),
        ("", "rows.csv"),
        ("\0\xff", "rows.csv"),
    ],
)
def test_what_is_no_experiment_is_named(tmp_path: Path, text: str | None, message: str) -> None:
    if text is not None:
        (tmp_path / "rows.csv").write_text(text, "latin-1")
    with pytest.raises(pathspace.LoadError, match=message):
        pathspace.load(tmp_path)


def test_a_broken_image_is_named(tmp_path: Path) -> None:
    write_rows(tmp_path, ["one"])
    (tmp_path / "references").mkdir()
    (tmp_path / "references" / "one.exr").write_bytes(b"no image")
    with pytest.raises(pathspace.LoadError, match="one.exr"):
        pathspace.load(tmp_path).reference("one")


def test_methods_may_have_the_names_of_missing_values(tmp_path: Path) -> None:
    write_rows(tmp_path, ["NA"])
    assert pathspace.load(tmp_path).scenes == ["NA"]


def test_other_renderers_are_told_from_settings(tmp_path: Path) -> None:
    names = ["bdpt", "bdpt:heuristic=power", "mitsuba:path", "mitsuba:path:rr_depth=9"]
    found = styles(names)
    assert [found[name].foreign for name in names] == [False, False, True, True]
    assert len({style.colour for style in found.values()}) == 4
