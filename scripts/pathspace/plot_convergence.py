"""Draws the error of each method against its rendering time.

    python -m pathspace.plot_convergence DIR [-o FILE …] [--metric rmse|relmse|mse|smape …]

DIR holds the `rows.csv` of a comparison. There is a panel for each scene and metric; in it, a line
for each method: the geometric mean over seeds, in time and in error, of each checkpoint. The band
around it spans one geometric standard deviation of the error over the seeds. A grey line has the
slope of an unbiased estimator with finite variance: −1/2, and −1 for squared errors. Methods of
other renderers are dashed. Without `-o`, convergence.png and convergence.svg are written into DIR.
"""

import argparse
import csv
import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

METRICS = {
    "rmse": ("RMSE", -0.5),
    "relmse": ("relMSE", -1.0),
    "mse": ("MSE", -1.0),
    "smape": ("SMAPE", -0.5),
}
"""Label of the axis, and expected slope of the logarithms."""

# Okabe and Ito (2008), told apart with all common kinds of colour vision; yellow is too light.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")
COLUMNS = 3


class PlotError(Exception):
    """There is nothing to draw."""


@dataclass(frozen=True)
class Row:
    """A line of `rows.csv`."""

    scene: str
    method: str
    renderer: str
    seed: str
    checkpoint: int
    seconds: float
    errors: dict[str, float]


@dataclass(frozen=True)
class Curve:
    """Geometric means over seeds, one value a checkpoint."""

    seconds: np.ndarray
    error: np.ndarray
    spread: np.ndarray
    """Geometric standard deviation of the error, a factor of at least 1."""


def read_rows(path: Path) -> list[Row]:
    """Read a comparison's rows; a metric's missing or undefined value becomes NaN."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            needed = {"scene", "method", "seed", "checkpoint", "render_seconds"}
            if missing := needed - set(reader.fieldnames or ()):
                raise PlotError(f"{path}: no column {', '.join(sorted(missing))}")
            return [
                Row(
                    row["scene"],
                    row["method"],
                    row.get("renderer") or "",
                    row["seed"],
                    int(row["checkpoint"]),
                    number(row["render_seconds"]),
                    {metric: number(row.get(metric)) for metric in METRICS},
                )
                for row in reader
            ]
    except OSError as error:
        raise PlotError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise PlotError(f"{path}: {error}") from None


def number(text: str | None) -> float:
    """Read a number; NaN where there is none."""
    return float(text) if text else math.nan


def unique(values: Iterable[str]) -> list[str]:
    """Return the values in order of first appearance."""
    return list(dict.fromkeys(values))


def curve(rows: list[Row], metric: str) -> Curve | None:
    """Average one method's rows over seeds, in logarithms; `None` where nothing is positive."""
    points = []
    for checkpoint in sorted({row.checkpoint for row in rows}):
        values = [
            (row.seconds, row.errors[metric])
            for row in rows
            if row.checkpoint == checkpoint
            and row.seconds > 0
            and math.isfinite(row.errors[metric])
            and row.errors[metric] > 0
        ]
        if values:
            logs = np.log(np.array(values))
            deviation = logs[:, 1].std(ddof=1) if len(values) > 1 else 0.0
            points.append((*np.exp(logs.mean(axis=0)), np.exp(deviation)))
    if not points:
        return None
    seconds, error, spread = np.array(sorted(points)).T
    return Curve(seconds, error, spread)


def draw_panel(axes: Axes, rows: list[Row], scene: str, metric: str, methods: list[str]) -> None:
    """Draw one scene's curves for one metric."""
    label, slope = METRICS[metric]
    curves = {}
    for index, method in enumerate(methods):
        chosen = [row for row in rows if row.scene == scene and row.method == method]
        found = curve(chosen, metric)
        if found is None:
            continue
        curves[method] = found
        colour = COLOURS[index % len(COLOURS)]
        foreign = ":" in method
        axes.fill_between(
            found.seconds,
            found.error / found.spread,
            found.error * found.spread,
            color=colour,
            alpha=0.15,
            linewidth=0,
        )
        axes.plot(
            found.seconds,
            found.error,
            label=legend_label(method, chosen),
            color=colour,
            linestyle="--" if foreign else "-",
            marker=MARKERS[index % len(MARKERS)],
            markersize=5,
            markerfacecolor="white" if foreign else colour,
            linewidth=1.6,
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_title(scene)
    axes.set_xlabel("rendering time [s]")
    axes.set_ylabel(label)
    axes.grid(which="major", color="0.88", linewidth=0.8)
    axes.set_axisbelow(True)
    if curves:
        draw_reference(axes, list(curves.values()), slope)
        tidy_ticks(axes)
    else:
        axes.text(0.5, 0.5, "no reference image", transform=axes.transAxes, ha="center")


def legend_label(method: str, rows: list[Row]) -> str:
    """Name the method; where it is another renderer's, with that one's version and variant."""
    renderers = unique(row.renderer for row in rows)
    if len(renderers) != 1 or ":" not in method:
        return method
    detail = renderers[0].removeprefix(method.split(":")[0]).strip()
    return f"{method} ({detail})" if detail else method


def draw_reference(axes: Axes, curves: list[Curve], slope: float) -> None:
    """Draw the expected slope below all curves."""
    start = min(found.seconds[0] for found in curves)
    end = max(found.seconds[-1] for found in curves)
    if end <= start:
        return
    # Low enough to touch no curve, were each to fall exactly with the slope.
    level = 0.55 * min((found.error * found.seconds**-slope).min() for found in curves)
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


def tidy_ticks(axes: Axes) -> None:
    """Write plain numbers, and three to a decade where an axis spans few decades."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        if high / low < 300:
            axis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def draw(rows: list[Row], metrics: list[str], files: list[Path]) -> None:
    """Draw all panels and write them to each of the files."""
    scenes, methods = unique(row.scene for row in rows), unique(row.method for row in rows)
    if not scenes:
        raise PlotError("there are no rows to draw")
    columns = len(metrics) if len(scenes) == 1 else min(COLUMNS, len(scenes))
    padding = 0 if len(scenes) == 1 else -len(scenes) % columns
    padded: list[str | None] = [*scenes, *[None] * padding]
    panels = [(scene, metric) for metric in metrics for scene in padded]
    count = -(-len(panels) // columns)
    figure, grid = plt.subplots(
        count,
        columns,
        figsize=(1.0 + 4.6 * columns, 0.9 + 3.9 * count),
        squeeze=False,
        layout="constrained",
    )
    handles: dict[str, Artist] = {}
    for axes, (scene, metric) in zip(grid.flat, panels, strict=True):
        if scene is None:
            axes.set_axis_off()
            continue
        draw_panel(axes, rows, scene, metric, methods)
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    legend_rows = -(-len(handles) // (2 * columns))
    figure.legend(
        list(handles.values()),
        list(handles),
        loc="outside lower center",
        ncols=-(-len(handles) // max(legend_rows, 1)) or 1,
        frameon=False,
    )
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(file, dpi=150)
    plt.close(figure)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m pathspace.plot_convergence",
        description="Draw error against rendering time from the rows.csv of a comparison.",
    )
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument(
        "-o", "--output", type=Path, action="append", help="picture to write; may be repeated"
    )
    parser.add_argument(
        "--metric", choices=METRICS, action="append", help="default: rmse and relmse"
    )
    options = parser.parse_args(arguments)
    files = options.output or [options.folder / f"convergence.{kind}" for kind in ("png", "svg")]
    try:
        draw(read_rows(options.folder / "rows.csv"), options.metric or ["rmse", "relmse"], files)
    except PlotError as error:
        print(error, file=sys.stderr)
        return 1
    for file in files:
        print(file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
