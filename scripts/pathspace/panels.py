"""What plots of curves share: panels with one legend, axes in logarithms, and a command line."""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from .experiment import Experiment, LoadError, load, unique
from .styles import Style

COLUMNS = 3


class PlotError(Exception):
    """There is nothing to draw."""


def grid(panels: Sequence[Sequence[str]], draw: Callable[[Axes, str, str], None]) -> Figure:
    """Draw panels (scene, quantity): scenes side by side, their quantities below each other.

    The quantities of a single scene stand side by side.
    """
    scenes, kinds = unique(scene for scene, _ in panels), unique(kind for _, kind in panels)
    columns = len(kinds) if len(scenes) == 1 else min(COLUMNS, len(scenes))
    padding = 0 if len(scenes) == 1 else -len(scenes) % columns
    cells = [(scene, kind) for kind in kinds for scene in [*scenes, *[None] * padding]]
    count = -(-len(cells) // columns)
    size = (1.0 + 4.6 * columns, 0.9 + 3.9 * count)
    figure, axes_grid = plt.subplots(
        count, columns, figsize=size, squeeze=False, layout="constrained"
    )
    handles: dict[str, Artist] = {}
    for axes, (scene, kind) in zip(axes_grid.flat, cells, strict=True):
        if scene is None:
            axes.set_axis_off()
            continue
        draw(axes, scene, kind)
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
    return figure


def draw_curve(axes: Axes, curve: pd.DataFrame, style: Style, label: str) -> None:
    """Draw a band and a line; what is below the noise of the reference is pale, and no line."""
    noisy = curve["below_reference_noise"]
    for part, alpha in ((curve[~noisy], 1.0), (curve[noisy], 0.3)):
        if part.empty:
            continue
        seconds = part["seconds"]
        axes.fill_between(
            seconds, part["low"], part["high"], color=style.colour, alpha=0.15 * alpha, linewidth=0
        )
        look = style.line if alpha == 1.0 else {**style.line, "linestyle": "none", "marker": "x"}
        shown = label if alpha == 1.0 else "_below the noise of the reference"
        axes.plot(
            seconds, part["error"], label=shown, markersize=5, linewidth=1.6, alpha=alpha, **look
        )


def dress(axes: Axes, title: str, label: str) -> None:
    """Give a panel its axes."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_title(title)
    axes.set_xlabel("rendering time [s]")
    axes.set_ylabel(label)
    axes.grid(which="major", color="0.88", linewidth=0.8)
    axes.set_axisbelow(True)


def tidy_ticks(axes: Axes) -> None:
    """Write plain numbers, and three to a decade where an axis spans few decades."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        if high / low < 300:
            axis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def legend_label(experiment: Experiment, method: str) -> str:
    """Name the method; where it is another renderer's, with that one's version and variant."""
    rows = experiment.rows
    renderers = unique(rows.loc[rows["method"] == method, "renderer"]) if "renderer" in rows else []
    if len(renderers) != 1 or not experiment.styles[method].foreign:
        return method
    detail = renderers[0].removeprefix(method.split(":")[0]).strip()
    return f"{method} ({detail})" if detail else method


def panel_titles(experiment: Experiment, curves: pd.DataFrame) -> dict[str, tuple[str, str]]:
    """Name a panel for each scene and hardware; times of unequal hardware never share one."""
    pairs = unique(zip(curves["scene"], curves["hardware"], strict=True))
    several = {scene for scene, _ in pairs if sum(scene == other for other, _ in pairs) > 1}
    found = {f"{s}\n{h}" if s in several else s: (s, h) for s, h in pairs}
    return found | {s: (s, "") for s in experiment.scenes if s not in {scene for scene, _ in pairs}}


def save(figure: Figure, files: Sequence[Path]) -> None:
    """Write the figure to each of the files; the ending says the format."""
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            figure.savefig(file, dpi=150)
        except (OSError, ValueError) as error:
            raise PlotError(f"{file}: {error}") from None
    plt.close(figure)


def run(
    parser: argparse.ArgumentParser,
    make: Callable[..., Sequence[Path]],
    arguments: list[str] | None,
) -> int:
    """Read the folder, let `make` write files, and print their names; return the exit status."""
    options = parser.parse_args(arguments)
    try:
        files = make(load(options.folder), options)
    except (LoadError, PlotError) as error:
        print(error, file=sys.stderr)
        return 1
    for file in files:
        print(file)
    return 0


def plot_parser(doc: str, name: str) -> argparse.ArgumentParser:
    """Make a parser with what every plot takes; its help is the text of the module."""
    parser = argparse.ArgumentParser(
        prog=f"python -m pathspace.{name}",
        description=doc,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of an experiment")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        action="append",
        metavar="FILE",
        help="picture to write: .pdf, .svg or .png; may be repeated",
    )
    return parser
