"""The page of `pathspace parity`: one HTML file that needs nothing else.

    python -m pathspace.parity.page DIR

DIR holds what `pathspace parity -o DIR` has written; the page goes into it as parity.html.
"""

import argparse
import base64
import io
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import matplotlib
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from PIL import Image as Pillow

from pathspace.exr import read_channels, rgb
from pathspace.files import write_atomically

Image = NDArray[np.floating]

RANGE = 4.0
"""Differences are shown from so many standard errors below to so many above."""
TOLERANCE = 1e-5
"""Relative difference that single precision makes, as the test of images has it."""
ORDER = ["differ", "missing", "undecided", "agree"]
"""Verdicts from the worst on."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m pathspace.parity.page")
    parser.add_argument("folder", type=Path, metavar="DIR")
    folder: Path = parser.parse_args(arguments).folder
    try:
        rows = pd.read_csv(folder / "parity.csv", keep_default_na=True)
    except (OSError, ValueError) as error:
        print(f"{folder / 'parity.csv'}: {error}; run pathspace parity", file=sys.stderr)
        return 1
    text = page(folder, rows)
    output = folder / "parity.html"
    write_atomically(output, lambda file: file.write(text.encode()))
    print(output)
    return 0


def page(folder: Path, rows: pd.DataFrame) -> str:
    """Make the HTML text."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("pathspace.parity", "assets"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    features = [
        feature_of(folder, name, part) for name, part in rows.groupby("feature", sort=False)
    ]
    groups = {name: [f for f in features if f["group"] == name] for name in groups_of(features)}
    count = {verdict: sum(f["verdict"] == verdict for f in features) for verdict in ORDER}
    return environment.get_template("page.html").render(
        groups=groups,
        count=count,
        range=f"{RANGE:g}",
        style=(files("pathspace.report") / "assets" / "style.css").read_text(encoding="utf-8"),
    )


def groups_of(features: list[dict[str, Any]]) -> list[str]:
    """Name the groups in their order."""
    return list(dict.fromkeys(feature["group"] for feature in features))


def feature_of(folder: Path, name: str, rows: pd.DataFrame) -> dict[str, Any]:
    """Collect what the page shows of a feature."""
    verdicts = set(rows["verdict"])
    scene = folder / name / "scene.xml"
    return {
        "name": name,
        "group": name.split("/", 1)[0],
        "verdict": next(verdict for verdict in ORDER if verdict in verdicts),
        "rows": [line(row) for row in rows.to_dict("records")],
        "pictures": pictures(folder / name),
        "scene": scene.read_text(encoding="utf-8") if scene.is_file() else "",
    }


def line(row: dict[str, Any]) -> dict[str, str]:
    """Write a comparison."""

    def text(key: str, form: str, factor: float = 1.0) -> str:
        return "" if pd.isna(row[key]) else form.format(factor * row[key])

    difference = text("difference", "{:+.3f} %", 100)
    interval = text("interval", " ± {:.3f} %", 100)
    return {
        "comparison": row["comparison"],
        "verdict": row["verdict"],
        "difference": difference + interval,
        "finds": text("detectable", "{:.2f} %", 100),
        "block": text("block_detectable", "{:.1f} %", 100),
        "error": text("largest_error", "{:.1e}"),
        "bound": text("bound", "{:.1e}"),
        "count": text("values", "{:.0f}"),
        "details": row["details"],
    }


def pictures(folder: Path) -> list[dict[str, str]]:
    """Show ours, Mitsuba's, and their difference, for each pair of integrators."""
    found = []
    for ours, theirs in (("path", "path"), ("light", "ptracer"), ("bdpt", "path")):
        exr, npy = folder / f"ours-{ours}.exr", folder / f"mitsuba-{theirs}.npy"
        if not (exr.is_file() and npy.is_file()):
            continue
        channels, passes = read_channels(exr), np.load(npy).astype(np.float64)
        image, error, mean = rgb(channels), rgb(channels, "standard_error"), passes.mean(axis=0)
        if image is None or image.shape != mean.shape:
            continue
        shown = [(f"ours, {ours}", tone(image)), (f"Mitsuba's, {theirs}", tone(mean))]
        if error is not None:
            noise = error.astype(np.float64) ** 2 + passes.var(axis=0, ddof=1) / len(passes)
            noise += (TOLERANCE * mean) ** 2
            shown.append(("difference", differences(image - mean, noise)))
        found += [{"title": title, "source": png(pixels)} for title, pixels in shown]
    return found


def tone(image: Image) -> NDArray[np.uint8]:
    """Encode linear colours for a screen."""
    x = np.clip(np.nan_to_num(image), 0, 1)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return (255 * encoded).round().astype(np.uint8)


def differences(difference: Image, variance: Image) -> NDArray[np.uint8]:
    """Colour differences by their standard errors: blue where ours is darker, else red."""
    scale = np.sqrt(variance.mean(axis=-1))
    z = np.divide(difference.mean(axis=-1), scale, out=np.zeros_like(scale), where=scale > 0)
    colours = matplotlib.colormaps["RdBu_r"](np.clip(0.5 + 0.5 * z / RANGE, 0, 1))
    return (255 * colours[..., :3]).round().astype(np.uint8)


def png(pixels: NDArray[np.uint8]) -> str:
    """Embed an image."""
    buffer = io.BytesIO()
    Pillow.fromarray(pixels).save(buffer, "png")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()


if __name__ == "__main__":
    sys.exit(main())
