"""Puts the page together."""

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd
import plotly

from pathspace.curves import METRICS
from pathspace.experiment import Experiment, unique
from pathspace.files import write_atomically

from .images import colours, images_of, pictures
from .tables import AGREEMENT, SUMMARY, VERDICTS, Table, table

SCRIPTS = ("pixels.js", "plots.js", "views.js", "viewer.js", "main.js")
NOISE = {"mse": "reference_mse", "rmse": "reference_mse", "relmse": "reference_relmse"}


def write_report(experiment: Experiment, output: Path, *, images: bool = True) -> None:
    """Write the report; the file is whole or not there."""
    text = page(experiment, images=images)
    write_atomically(output, lambda file: file.write(text.encode()))


def page(experiment: Experiment, *, images: bool = True) -> str:
    """Make the HTML text."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("pathspace.report", "assets"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    scenes = [scene_of(experiment, scene, images=images) for scene in experiment.scenes]
    record = experiment.experiment.get("record", {})
    return environment.get_template("page.html").render(
        title=", ".join(experiment.scenes),
        scenes=scenes,
        tables={name: tables_of(experiment, name) for name in experiment.scenes},
        pictures={name: list(pictures(experiment, name)) for name in experiment.scenes},
        data=embedded({"scenes": scenes, "styles": looks(experiment), "magma": colours()}),
        metrics=metrics_of(experiment),
        facts=facts(experiment, record),
        manifest=manifest_text(experiment),
        style=asset("style.css"),
        scripts=[asset(name) for name in SCRIPTS],
        plotly=plotly.offline.get_plotlyjs(),
        plotly_version=plotly.__version__,
    )


def asset(name: str) -> str:
    """Read a file of the page."""
    return (files("pathspace.report") / "assets" / name).read_text(encoding="utf-8")


def embedded(data: object) -> str:
    """Write JSON that ends no script element, whatever the names of scenes and methods."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def scene_of(experiment: Experiment, scene: str, *, images: bool) -> dict[str, Any]:
    """Collect what the scripts of the page draw for a scene."""
    curves = experiment.curves
    lines = curves[curves["scene"] == scene] if not curves.empty else curves
    return {
        "name": scene,
        "curves": [] if lines.empty else curves_of(lines),
        "noise": noise_of(experiment.rows, scene),
        "images": images_of(experiment, scene) if images else [],
    }


def curves_of(lines: pd.DataFrame) -> list[dict[str, Any]]:
    """List each curve of a scene, numbers with all their digits."""
    columns = ["checkpoint", "seeds", "seconds", "spp", "error", "low", "high"]
    curves = []
    for (metric, hardware, method), curve in lines.groupby(
        ["metric", "hardware", "method"], sort=False
    ):
        ordered = curve.sort_values("checkpoint")
        points = {column: numbers(ordered, column) for column in columns}
        noisy = ordered.get("below_reference_noise", pd.Series(False, index=ordered.index))
        points["noisy"] = [bool(value) for value in noisy]
        curves.append({"metric": metric, "hardware": hardware, "method": method, **points})
    return curves


def numbers(frame: pd.DataFrame, column: str) -> list[float | None]:
    """Give a column as plain numbers, what is missing as none."""
    if column not in frame:
        return [None] * len(frame)
    return [None if pd.isna(value) else float(value) for value in frame[column]]


def noise_of(rows: pd.DataFrame, scene: str) -> dict[str, float]:
    """Give the error that the noise of the reference alone would make, where it is known."""
    lines, found = rows[rows["scene"] == scene], {}
    for metric, column in NOISE.items():
        if column in lines and (known := lines[column].dropna()).size and known.iloc[-1] > 0:
            found[metric] = float(known.iloc[-1]) ** (0.5 if metric == "rmse" else 1.0)
    return found


def metrics_of(experiment: Experiment) -> dict[str, str]:
    """Name the metrics that there are curves of; the relative one comes first."""
    known = unique(experiment.curves["metric"]) if not experiment.curves.empty else []
    ordered = sorted(known, key=lambda metric: metric != "relmse")
    return {metric: METRICS.get(metric, (metric, None))[0] for metric in ordered}


def tables_of(experiment: Experiment, scene: str) -> list[Table]:
    """List the tables of a scene."""
    found = [
        table(experiment.summary, "Methods", SUMMARY, scene),
        table(experiment.verdicts, "Verdicts", VERDICTS, scene),
        table(experiment.agreement, "Same image?", AGREEMENT, scene),
    ]
    return [entry for entry in found if entry]


def looks(experiment: Experiment) -> dict[str, dict[str, Any]]:
    """Give the look of each method, the same as in all plots of these scripts."""
    return {
        method: {"colour": style.colour, "marker": style.marker, "foreign": style.foreign}
        for method, style in experiment.styles.items()
    }


def facts(experiment: Experiment, record: dict[str, Any]) -> dict[str, str]:
    """Name what the numbers came from."""
    rows = experiment.rows
    seen = {
        "command": record.get("command"),
        "pathspace": record.get("version"),
        "Mitsuba": record.get("mitsuba"),
        "seeds": experiment.experiment.get("seeds"),
        "renderers": ", ".join(unique(rows["renderer"])) if "renderer" in rows else None,
        "hardware": ", ".join(filter(None, unique(rows["hardware"]))),
        "runs": len(rows.groupby(["scene", "method", "seed"])),
    }
    return {name: str(value) for name, value in seen.items() if value not in (None, "")}


def manifest_text(experiment: Experiment) -> str:
    """Read the resolved manifest as it stands."""
    path = experiment.folder / "experiment.toml"
    return path.read_text(encoding="utf-8") if path.is_file() else ""
