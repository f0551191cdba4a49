"""Draws the error of each method against its rendering time.

    python -m pathspace.plot_convergence DIR
    python -m pathspace.plot_convergence DIR --metric relmse --scene cornell_box -o relmse.pdf

DIR is the folder of an experiment. There is a panel for each scene and metric; in it, a line for
each method: the error over seeds at each checkpoint, and its 95 % band from curves.csv. Where there
is no such file, the geometric mean of rows.csv with one geometric standard deviation. Pale crosses
are below the noise of the reference: what they show is not the method's error. A grey line has the
slope of an unbiased estimator with finite variance: −1/2, and −1 for squared errors. Methods of
other renderers are dashed. Without -o, convergence.png and convergence.svg are written into DIR.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .curves import METRICS
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


def plot_convergence(
    experiment: Experiment,
    metrics: Sequence[str] = ("rmse", "relmse"),
    scenes: Sequence[str] | None = None,
) -> Figure:
    """Draw a panel for each scene and metric."""
    if experiment.rows.empty:
        raise PlotError("there are no rows to draw")
    curves = experiment.curves
    titles = panel_titles(experiment, curves)
    chosen = [title for title, (scene, _) in titles.items() if scenes is None or scene in scenes]
    if not chosen:
        raise PlotError(f"no such scene; there are: {', '.join(experiment.scenes)}")

    def draw(axes: Axes, title: str, metric: str) -> None:
        scene, hardware = titles[title]
        where = (curves["scene"] == scene) & (curves["hardware"] == hardware)
        panel = curves[where & (curves["metric"] == metric)]
        draw_panel(axes, experiment, panel, title, metric)

    return grid([(title, metric) for metric in metrics for title in chosen], draw)


def draw_panel(
    axes: Axes, experiment: Experiment, panel: pd.DataFrame, title: str, metric: str
) -> None:
    """Draw the curves of one scene for one metric."""
    label, slope = METRICS[metric]
    dress(axes, title, label)
    panel = panel[(panel["error"] > 0) & (panel["seconds"] > 0)].sort_values("seconds")
    if panel.empty:
        axes.text(0.5, 0.5, "no reference image", transform=axes.transAxes, ha="center")
        return
    for method, style in experiment.styles.items():
        curve = panel[panel["method"] == method]
        if not curve.empty:
            draw_curve(axes, curve, style, legend_label(experiment, method))
    draw_slope(axes, panel, slope)
    tidy_ticks(axes)


def draw_slope(axes: Axes, panel: pd.DataFrame, slope: float | None) -> None:
    """Draw the expected slope below all curves."""
    start, end = panel["seconds"].min(), panel["seconds"].max()
    if slope is None or end <= start:
        return
    # Low enough to touch no curve, were each to fall exactly with the slope.
    level = 0.55 * (panel["error"] * panel["seconds"] ** -slope).min()
    ends = np.array([start, end])
    axes.plot(ends, level * ends**slope, color="0.45", linewidth=1.2, linestyle=":")
    middle = math.sqrt(start * end)
    axes.annotate(
        f"slope {'−1/2' if slope == -0.5 else '−1'}",
        (middle, level * middle**slope),
        textcoords="offset points",
        xytext=(-4, -4),
        ha="right",
        va="top",
        color="0.35",
        fontsize=9,
    )


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = plot_parser(__doc__, "plot_convergence")
    parser.add_argument(
        "--metric",
        choices=METRICS,
        action="append",
        help="may be repeated; default: rmse and relmse",
    )
    parser.add_argument("--scene", action="append", help="only this scene; may be repeated")
    return run(parser, make, arguments)


def make(experiment: Experiment, options: argparse.Namespace) -> Sequence[Path]:
    """Write the pictures that the command line asks for."""
    files = options.output or [experiment.folder / f"convergence.{kind}" for kind in ("png", "svg")]
    save(plot_convergence(experiment, options.metric or ["rmse", "relmse"], options.scene), files)
    return files


if __name__ == "__main__":
    sys.exit(main())
