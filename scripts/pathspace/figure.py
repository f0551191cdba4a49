"""Draws crops of one scene, method beside method, as papers do.

    python -m pathspace.figure DIR --scene cornell_box
    python -m pathspace.figure DIR --scene cornell_box --method path --method bdpt \\
        --crop 60,180,48,48 --crop 150,100,48,48 --exposure 1 --metric relmse -o crops.pdf

DIR is the folder of an experiment. On the left is the reference with the crops marked; on the right
a column for each method and the reference, a row for each crop, and below them the error of the
whole image. Images are those of one run, which is what a method yields in the time stated: --run 0
is the first seed. The error is that of this run in rows.csv, at its last checkpoint. Without
--crop, crops are chosen where methods differ most; without --exposure, it suits the reference.
Without -o, SCENE.pdf, .svg and .png are written into DIR/figures.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from .crops import Crop, automatic_exposure, displayed, telling
from .curves import METRICS
from .experiment import Experiment, file_name
from .exr import Image
from .panels import PlotError, plot_parser, run, save
from .styles import COLOURS

HEIGHT = 3.4
"""Height of the full image in inches."""


@dataclass(frozen=True)
class Column:
    """What stands in a column of insets."""

    title: str
    below: str
    image: Image


def figure(
    experiment: Experiment,
    scene: str,
    methods: Sequence[str] | None = None,
    crops: Sequence[Crop] | None = None,
    metric: str = "relmse",
    exposure: float | None = None,
    run: int = 0,
) -> Figure:
    """Draw the full reference and a grid of insets."""
    columns = [
        column(experiment, scene, name, metric, run) for name in methods or experiment.methods
    ]
    columns = [found for found in columns if found is not None]
    if not columns:
        raise PlotError(f"{scene}: there are no images of runs")
    reference = experiment.reference(scene)
    full = columns[0].image if reference is None else reference
    images = [found.image for found in columns]
    if crops is None:
        crops = telling(full, images)
    for crop in crops:
        if not crop.within(full):
            raise PlotError(
                f"a crop of {scene} reaches beyond its {full.shape[1]} × {full.shape[0]} pixels"
            )
    if reference is not None:
        columns.append(Column("reference", METRICS[metric][0], reference))
    stops = automatic_exposure(full) if exposure is None else exposure
    return layout(full, columns, crops, stops, scene)


def column(experiment: Experiment, scene: str, method: str, metric: str, run: int) -> Column | None:
    """Read a run's image, and its error and time from the rows."""
    rows = experiment.rows
    chosen = rows[(rows["scene"] == scene) & (rows["method"] == method)]
    seeds = experiment.seeds(scene, method)
    if run >= len(seeds) or (image := experiment.image(scene, method, seeds[run])) is None:
        return None
    last = chosen[chosen["seed"] == seeds[run]].sort_values("checkpoint").iloc[-1]
    error = last.get(metric)
    value = "–" if error is None or pd.isna(error) else f"{error:.3g}"
    return Column(method, f"{value}\n{last['render_seconds']:.3g} s", image)


def layout(
    full: Image, columns: Sequence[Column], crops: Sequence[Crop], exposure: float, title: str
) -> Figure:
    """Place the full image and the insets."""
    side = HEIGHT / max(len(crops), 1)
    aspect = full.shape[1] / full.shape[0]
    shape = max((crop.width / crop.height for crop in crops), default=1.0)
    widths = [HEIGHT * aspect, *[side * shape] * len(columns)]
    picture = plt.figure(figsize=(sum(widths) * 1.04, HEIGHT + 0.6), layout="constrained")
    picture.get_layout_engine().set(w_pad=0.02, h_pad=0.02, wspace=0.02, hspace=0.02)
    grid = picture.add_gridspec(max(len(crops), 1), len(widths), width_ratios=widths)
    left = picture.add_subplot(grid[:, 0])
    show(left, full, exposure, "0.2")
    left.set_title(title, fontsize=10)
    for index, crop in enumerate(crops):
        colour = COLOURS[1 + index % 5]
        box = Rectangle((crop.x - 0.5, crop.y - 0.5), crop.width, crop.height, fill=False)
        box.set(edgecolor=colour, linewidth=1.8)
        left.add_patch(box)
        for place, found in enumerate(columns, start=1):
            axes = picture.add_subplot(grid[index, place])
            show(axes, crop.of(found.image), exposure, colour)
            if index == 0:
                axes.set_title(found.title, fontsize=9)
            if index == len(crops) - 1:
                axes.set_xlabel(found.below, fontsize=9)
    return picture


def show(axes: Axes, image: Image, exposure: float, colour: str) -> None:
    """Show pixels as they are, in a frame."""
    axes.imshow(displayed(image, exposure), interpolation="nearest")
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(color=colour, linewidth=1.8)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = plot_parser(__doc__, "figure")
    parser.add_argument("--scene", help="default: the first")
    parser.add_argument("--method", action="append", help="may be repeated; default: all")
    parser.add_argument("--crop", action="append", type=Crop.parse, metavar="X,Y,W,H")
    parser.add_argument("--metric", choices=METRICS, default="relmse")
    parser.add_argument("--exposure", type=float, metavar="STOPS")
    parser.add_argument("--run", type=int, default=0, help="which seed, counted from 0")
    return run(parser, make, arguments)


def make(experiment: Experiment, options: argparse.Namespace) -> Sequence[Path]:
    """Write the pictures that the command line asks for."""
    scene = options.scene or next(iter(experiment.scenes), "")
    if scene not in experiment.scenes:
        raise PlotError(f"no scene {scene}; there are: {', '.join(experiment.scenes)}")
    if unknown := set(options.method or ()) - set(experiment.methods):
        raise PlotError(f"no method {unknown.pop()}; there are: {', '.join(experiment.methods)}")
    folder = experiment.folder / "figures"
    files = options.output or [
        folder / f"{file_name(scene)}.{kind}" for kind in ("pdf", "svg", "png")
    ]
    made = figure(
        experiment,
        scene,
        options.method,
        options.crop,
        options.metric,
        options.exposure,
        options.run,
    )
    save(made, files)
    return files


if __name__ == "__main__":
    sys.exit(main())
