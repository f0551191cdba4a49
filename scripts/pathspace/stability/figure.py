"""Draws the table of `pathspace stability`: where numbers hold, and where they stop holding.

    python -m pathspace.stability.figure DIR [-o FILE]...

A row is a case, a column of cells one value of its parameter, from tame to extreme, and there is a
panel for each method. The value stands in its cell. Colour and hatching say the verdict; all but
`holds` have a letter besides, so that nothing depends on colour. Cases that are tried without any
integrator have a part of their own at the bottom. DIR is the folder with stability.csv; without -o,
stability.png and stability.svg are written there.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from pathspace.panels import PlotError, plot_parser, save

from .table import ALONE, Row, Table, read_table

CELL_WIDTH, CELL_HEIGHT = 0.41, 0.2
"""Of a cell [inch]."""
GAP = 0.18
"""Between panels [inch]."""
TOP, BOTTOM = 0.95, 0.62
"""For titles and for the legend [inch]."""
LETTER_WIDTH = 0.062
"""Of the names' letters on the average [inch]."""
HEAD = 0.5
"""For the titles of a further part [inch]."""
GROUP = 0.85
"""Height of a group's title [cells]."""


@dataclass(frozen=True)
class Look:
    """How a verdict is drawn."""

    face: str
    letter: str
    meaning: str
    ink: str = "0.15"
    hatch: str = ""
    edge: str = "white"
    """Of hatching."""


# Okabe and Ito's colours (2008), of lightness as different as can be.
LOOKS = {
    "holds": Look("#5FC4A2", "", "holds"),
    "noise": Look("#D4D4D4", "N", "noise: too large to tell"),
    "blind": Look("white", "B", "blind: the method misses this light", hatch="////", edge="0.78"),
    "slow": Look("#8CC8EE", "S", "slow: would take too long", hatch="....", edge="#5AA6D6"),
    "beyond": Look("#F7EE9A", "D", "beyond double precision", hatch="\\\\\\\\", edge="#DDCF55"),
    "fails": Look("#B83D00", "F", "fails", ink="white", hatch="xxx", edge="#8C2C00"),
    "missing": Look("white", "M", "missing", edge="0.6"),
}


def plot(table: Table) -> Figure:
    """Draw all methods."""
    parts = table.parts()
    names = max(len(label(row)) for row in table.rows) * LETTER_WIDTH + 0.15
    panel = table.width * CELL_WIDTH
    count = max(len(part.methods) for part in parts)
    heights = [
        (len(part.rows) + GROUP * len({row.group for row in part.rows})) * CELL_HEIGHT
        for part in parts
    ]
    size = (
        max(names + count * (panel + GAP) + 0.1, 7.5),
        TOP + sum(heights) + HEAD * (len(parts) - 1) + BOTTOM,
    )
    figure = Figure(figsize=size)
    below = size[1] - TOP
    for part, height in zip(parts, heights, strict=True):
        for i, method in enumerate(part.methods):
            left = names + i * (panel + GAP)
            place = left / size[0], (below - height) / size[1], panel / size[0], height / size[1]
            draw_panel(figure.add_axes(place), part, method, table.width, labelled=i == 0)
        below -= height + HEAD
    figure.text(
        0.1 / size[0],
        1 - 0.12 / size[1],
        "Where numbers hold, from tame to extreme",
        fontsize=12,
        fontweight="bold",
        va="top",
    )
    draw_legend(figure, table, size)
    return figure


def label(row: Row) -> str:
    """Name a case with its parameter."""
    same = row.parameter in ("", row.case)
    return row.case if same else f"{row.case} · {row.parameter}"


def draw_panel(axes: Axes, table: Table, method: str, width: int, *, labelled: bool) -> None:
    """Draw the cells of a method."""
    axes.set_axis_off()
    y, group = 0.0, None
    for row in table.rows:
        if row.group != group:
            group = row.group
            y += GROUP
            axes.plot([0, width], [y - 0.06] * 2, color="0.55", linewidth=0.6, clip_on=False)
            if labelled:
                axes.text(-0.2, y - 0.12, group, fontsize=8.5, fontweight="bold", ha="right")
        for x, value in enumerate(row.values):
            verdict = table.verdicts.get((row.group, row.case, value, method))
            if verdict is not None:
                draw_cell(axes, x, y, value, LOOKS[verdict])
        if labelled:
            axes.text(-0.2, y + 0.5, label(row), fontsize=7.5, ha="right", va="center")
        y += 1
    axes.set_xlim(0, width)
    axes.set_ylim(y, 0)
    counts = table.counts(method)
    holds, fails = counts.get("holds", 0), counts.get("fails", 0)
    summary = f"{holds} of {sum(counts.values())} hold" + (f", {fails} fail" if fails else "")
    axes.text(0, -0.75, title(method), fontsize=8.5, fontweight="bold", va="bottom")
    axes.text(0, -0.7, summary, fontsize=7, color="0.3", va="top")


def title(method: str) -> str:
    """Break the name of a method that is longer than its panel."""
    if method == ALONE:
        return "without an integrator"
    return method.replace(":", ":\n", 1) if len(method) > 16 else method


def draw_cell(axes: Axes, x: float, y: float, value: str, look: Look) -> None:
    """Draw a cell with its value and the letter of its verdict."""
    inset = 0.04
    corner, width, height = (x + inset, y + inset), 1 - 2 * inset, 1 - 2 * inset
    axes.add_patch(
        Rectangle(
            corner, width, height, facecolor=look.face, edgecolor=look.edge, hatch=look.hatch, lw=0
        )
    )
    axes.add_patch(Rectangle(corner, width, height, fill=False, edgecolor="0.45", lw=0.4))
    middle = x + (0.43 if look.letter else 0.5)
    size = 6.0 if len(value) < 6 else 6.0 * 5.5 / len(value)
    box = {"facecolor": look.face, "edgecolor": "none", "pad": 0.6} if look.hatch else None
    axes.text(
        middle, y + 0.53, value, fontsize=size, color=look.ink, ha="center", va="center", bbox=box
    )
    if look.letter:
        axes.text(
            x + 0.93,
            y + 0.5,
            look.letter,
            fontsize=5.5,
            fontweight="bold",
            color=look.ink,
            ha="right",
            va="center",
            bbox=box,
        )


def draw_legend(figure: Figure, table: Table, size: tuple[float, float]) -> None:
    """Explain the verdicts that there are, in one or two lines below."""
    axes = figure.add_axes((0.0, 0.0, 1.0, BOTTOM / size[1]))
    axes.set_axis_off()
    axes.set_xlim(0, size[0] / CELL_WIDTH)
    axes.set_ylim(BOTTOM / CELL_HEIGHT, 0)
    x, y = 0.5, 0.5
    for name, look in LOOKS.items():
        if name not in table.verdicts.values():
            continue
        wide = 1.3 + len(look.meaning) * LETTER_WIDTH / CELL_WIDTH + 0.5
        if x + wide > size[0] / CELL_WIDTH:
            x, y = 0.5, y + 1.25
        draw_cell(axes, x, y, "", look)
        axes.text(x + 1.2, y + 0.53, look.meaning, fontsize=7.5, va="center")
        x += wide


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    options = plot_parser(__doc__, "stability.figure").parse_args(arguments)
    files: Sequence[Path] = options.output or [
        options.folder / f"stability.{kind}" for kind in ("png", "svg")
    ]
    try:
        with rc_context({"hatch.linewidth": 0.6, "svg.hashsalt": "pathspace"}):
            save(plot(read_table(options.folder / "stability.csv")), files)
    except PlotError as error:
        print(error, file=sys.stderr)
        return 1
    for file in files:
        print(file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
