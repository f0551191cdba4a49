import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex
from synthetic import METHODS, write_experiment, write_rows

import pathspace
from pathspace import figure, plot_convergence, plot_efficiency
from pathspace.panels import PlotError


@pytest.mark.parametrize("scenes", [["one"], ["one", "two", "three", "four"]])
def test_both_pictures_are_written(tmp_path: Path, scenes: list[str]) -> None:
    write_rows(tmp_path, scenes)
    for module in (plot_convergence, plot_efficiency):
        assert module.main([str(tmp_path)]) == 0
        name = module.__name__.rpartition("_")[2]
        assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert "</svg>" in (tmp_path / f"{name}.svg").read_text()


def test_without_curves_there_are_geometric_means_over_seeds(tmp_path: Path) -> None:
    write_rows(tmp_path, ["one"], seeds=3)
    experiment = pathspace.load(tmp_path)
    rows, curves = experiment.rows, experiment.curves
    first = rows.loc[(rows["method"] == "bdpt") & (rows["checkpoint"] == 0), "rmse"]
    found = curves[(curves["method"] == "bdpt") & (curves["metric"] == "rmse")]
    assert math.isclose(found["error"].iloc[0], math.prod(first) ** (1 / 3))
    spread = math.exp(np.std(np.log(first), ddof=1))
    assert math.isclose(found["high"].iloc[0], found["error"].iloc[0] * spread)
    assert len(found) == 8


def test_curves_are_drawn_and_what_is_below_noise_is_apart(tmp_path: Path) -> None:
    write_experiment(tmp_path, ["one"])
    experiment = pathspace.load(tmp_path)
    axes = plot_convergence.plot_convergence(experiment, ["rmse"]).axes[0]
    lines = {line.get_label(): line for line in axes.get_lines()}
    assert np.allclose(lines["path"].get_ydata(), 0.3 * lines["path"].get_xdata() ** -0.5)
    assert len(lines["path"].get_xdata()) == 8 and len(lines["bdpt"].get_xdata()) == 7
    apart = lines["_below the noise of the reference"]
    assert apart.get_linestyle() == "None" and len(apart.get_xdata()) == 1
    for method, style in experiment.styles.items():
        label = next(name for name in lines if name.split(" ")[0] == method)
        assert to_hex(lines[label].get_color()) == style.colour.lower()


def test_unequal_hardware_never_shares_a_panel(tmp_path: Path) -> None:
    write_rows(tmp_path, ["one"], hardware=("slow", "fast"))
    made = plot_convergence.plot_convergence(pathspace.load(tmp_path), ["rmse"])
    assert [axes.get_title() for axes in made.axes] == ["one\nslow", "one\nfast"]


def test_efficiency_is_level_and_relative_to_the_base(tmp_path: Path) -> None:
    write_experiment(tmp_path, ["one"])
    axes = plot_efficiency.plot_efficiency(pathspace.load(tmp_path)).axes[0]
    lines = {line.get_label().split(" ")[0]: line.get_ydata() for line in axes.get_lines()}
    assert np.allclose(lines["mitsuba:path"], 1) and np.allclose(lines["path"], (4 / 3) ** 2)
    with pytest.raises(PlotError, match="no method none"):
        plot_efficiency.plot_efficiency(pathspace.load(tmp_path), over="none")


def test_scenes_without_a_reference_are_drawn_empty(tmp_path: Path) -> None:
    write_rows(tmp_path, ["one"])
    rows = pd.read_csv(tmp_path / "rows.csv")
    rows.assign(rmse=np.nan, relmse="NaN").drop(columns="mse").to_csv(tmp_path / "rows.csv")
    assert len(rows) == 40 * len(METHODS)
    assert plot_convergence.main([str(tmp_path), "-o", str(tmp_path / "a.png")]) == 0


def test_what_cannot_be_drawn_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert plot_convergence.main([str(tmp_path)]) == 1
    assert "rows.csv" in capsys.readouterr().err
    write_rows(tmp_path, ["one"])
    assert plot_convergence.main([str(tmp_path), "-o", str(tmp_path / "a.nothing")]) == 1
    assert "a.nothing" in capsys.readouterr().err
    assert plot_convergence.main([str(tmp_path), "--scene", "two"]) == 1
    assert "no such scene" in capsys.readouterr().err


def test_figures_show_a_run_and_its_error(tmp_path: Path) -> None:
    write_experiment(tmp_path, ["a room"])
    crops = ["--crop", "2,3,6,4", "--crop", "12,10,6,4"]
    methods = ["--method", "bdpt", "--method", "light"]
    assert figure.main([str(tmp_path), "--run", "1", *methods, *crops]) == 0
    for kind, start in (("pdf", b"%PDF"), ("svg", b"<?xml"), ("png", b"\x89PNG")):
        assert (tmp_path / "figures" / f"a_room.{kind}").read_bytes().startswith(start)
    experiment = pathspace.load(tmp_path)
    chosen = [figure.Crop(2, 3, 6, 4)]
    made = figure.figure(experiment, "a room", ["bdpt", "light"], chosen, exposure=0.0, run=1)
    rows = experiment.rows
    row = rows[(rows["method"] == "bdpt") & (rows["seed"] == 1)].iloc[-1]
    assert made.axes[1].get_xlabel() == f"{row['relmse']:.3g}\n{row['render_seconds']:.3g} s"
    image = experiment.image("a room", "bdpt", 1)
    expected = figure.displayed(chosen[0].of(image))
    assert np.array_equal(made.axes[1].get_images()[0].get_array(), expected)


@pytest.mark.parametrize("crop", ["30,0,6,4", "1,2,3", "0,0,0,4"])
def test_crops_beyond_the_image_are_refused(tmp_path: Path, crop: str) -> None:
    write_experiment(tmp_path, ["one"], seeds=1)
    try:
        assert figure.main([str(tmp_path), "--crop", crop, "-o", str(tmp_path / "a.png")]) == 1
    except SystemExit as exit:
        assert exit.code == 2


def test_crops_are_chosen_where_methods_differ(tmp_path: Path) -> None:
    reference = np.ones((60, 60, 3), np.float32)
    good, bad = reference + 0.01, reference + 0.01
    bad[30:40, 10:20] += 1
    crop = figure.telling(reference, [good, bad], 1)[0]
    assert crop == figure.Crop(10, 30, 10, 10)
