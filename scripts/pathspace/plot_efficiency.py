"""Draws the efficiency of each method, 1 / (MSE · time), against its rendering time.

    python -m pathspace.plot_efficiency DIR
    python -m pathspace.plot_efficiency DIR --over bdpt -o efficiency.pdf

DIR is the folder of an experiment. There is a panel for each scene; in it, a line for each method.
It is level where the error falls as that of an unbiased estimator with finite variance; where it
sinks, the method meets rare paths or has a bias. Bands are those of the MSE. Efficiencies are
relative to a method's at its last checkpoint: with --over NAME that one's, else that of the base
method of summary.csv. Without -o, efficiency.png and efficiency.svg are written into DIR.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .experiment import Experiment
from .panels import (
    PlotError,
    draw_curve,
    dress,
    grid,
    legend_label,
    panel_titles,
    plot_parser,
    run,
    save,
    tidy_ticks,
)


def efficiency(curves: pd.DataFrame) -> pd.DataFrame:
    """Turn curves of the MSE into curves of 1 / (MSE · time), in 1/(radiance² s).

    Where there is no MSE, it is the square of the RMSE.
    """
    metric = "mse" if (curves["metric"] == "mse").any() else "rmse"
    chosen = curves[(curves["metric"] == metric) & (curves["error"] > 0) & (curves["seconds"] > 0)]
    power = 1 if metric == "mse" else 2
    seconds = chosen["seconds"]
    return chosen.assign(
        error=1 / (chosen["error"] ** power * seconds),
        low=1 / (chosen["high"] ** power * seconds),
        # A band that reaches to no error at all has no upper end.
        high=1 / (chosen["low"].where(chosen["low"] > 0) ** power * seconds),
    ).sort_values("seconds")


def base_of(experiment: Experiment, scene: str) -> str:
    """Return the method that others are compared with: that of summary.csv, else the first."""
    summary = experiment.summary
    if "base" in summary and not (found := summary.loc[summary["scene"] == scene, "base"]).empty:
        return found.iloc[0]
    return experiment.methods[0]


def plot_efficiency(experiment: Experiment, over: str | None = None) -> Figure:
    """Draw a panel for each scene."""
    if over is not None and over not in experiment.methods:
        raise PlotError(f"no method {over}; there are: {', '.join(experiment.methods)}")
    curves = efficiency(experiment.curves)
    if curves.empty:
        raise PlotError("there is no MSE to draw")
    titles = panel_titles(experiment, curves)

    def draw(axes: Axes, title: str, _: str) -> None:
        scene, hardware = titles[title]
        panel = curves[(curves["scene"] == scene) & (curves["hardware"] == hardware)]
        draw_panel(axes, experiment, panel, title, over or base_of(experiment, scene))

    return grid([(title, "efficiency") for title in titles], draw)


def draw_panel(
    axes: Axes, experiment: Experiment, panel: pd.DataFrame, title: str, base: str
) -> None:
    """Draw the curves of one scene, relative to the base method's last point."""
    dress(axes, title, f"efficiency over {base}")
    if panel.empty:
        axes.text(0.5, 0.5, "no reference image", transform=axes.transAxes, ha="center")
        return
    unit = panel.loc[panel["method"] == base, "error"]
    if unit.empty:
        axes.set_ylabel("efficiency 1/(MSE · time) [1/(radiance² s)]")
    scale = 1.0 if unit.empty else 1 / unit.iloc[-1]
    for method, style in experiment.styles.items():
        curve = panel[panel["method"] == method]
        if not curve.empty:
            scaled = curve.assign(
                **{name: curve[name] * scale for name in ("error", "low", "high")}
            )
            draw_curve(axes, scaled, style, legend_label(experiment, method))
    tidy_ticks(axes)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = plot_parser(__doc__, "plot_efficiency")
    parser.add_argument("--over", metavar="METHOD", help="method that others are divided by")
    return run(parser, make, arguments)


def make(experiment: Experiment, options: argparse.Namespace) -> Sequence[Path]:
    """Write the pictures that the command line asks for."""
    files = options.output or [experiment.folder / f"efficiency.{kind}" for kind in ("png", "svg")]
    save(plot_efficiency(experiment, options.over), files)
    return files


if __name__ == "__main__":
    sys.exit(main())
