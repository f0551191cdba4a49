"""The tables of the report: a few columns of each file, every cell with all its digits beside."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

HEADINGS = {
    "spp_per_second": "spp/s",
    "cpu_per_second": "CPU/s",
    "equal_time": "at [s]",
    "rmse": "RMSE",
    "relmse": "relMSE",
    "relmse_low": "low",
    "relmse_high": "high",
    "mape": "MAPE",
    "flip": "FLIP",
    "time_to_target": "s to base's RMSE",
    "time_bound": "bound",
    "relative_efficiency": "gain",
    "relative_low": "low",
    "relative_high": "high",
    "slope": "slope",
    "slope_low": "low",
    "slope_high": "high",
    "mean_ratio": "mean ratio",
    "bias2": "bias²",
    "bias2_error": "±",
    "variance": "variance",
    "target_error": "for the error",
    "time_ratio": "times less time",
    "crossing_seconds": "order changes at [s]",
    "image_difference": "difference",
    "image_error": "±",
    "image_detectable": "would find",
    "invalid": "not finite",
}

SUMMARY = [
    *("method", "seeds", "spp_per_second", "cpu_per_second", "equal_time", "rmse"),
    *("relmse", "relmse_low", "relmse_high", "flip", "time_to_target", "time_bound"),
    *("relative_efficiency", "relative_low", "relative_high", "slope", "slope_low", "slope_high"),
    *("mean_ratio", "bias2", "bias2_error", "variance", "invalid"),
]
VERDICTS = [
    *("metric", "method", "other", "seeds", "target_error", "time_ratio", "low", "high"),
    *("crossing_seconds", "verdict"),
]
AGREEMENT = [
    *("method", "against", "verdict", "image_difference", "image_error", "image_detectable"),
    "details",
]


@dataclass(frozen=True)
class Cell:
    """A cell: what is shown, and what the file says."""

    text: str
    value: str
    number: bool
    column: str


@dataclass(frozen=True)
class Table:
    """A table of one scene."""

    name: str
    headings: list[tuple[str, bool]]
    """Their text, and whether numbers stand below."""
    rows: list[list[Cell]]


def table(frame: pd.DataFrame, name: str, columns: Sequence[str], scene: str) -> Table | None:
    """Choose the lines of a scene and those of the columns that are there and not empty."""
    if frame.empty or "scene" not in frame:
        return None
    lines = frame[frame["scene"] == scene]
    if lines.empty:
        return None
    several = "hardware" in lines and lines["hardware"].nunique() > 1
    chosen = (["hardware"] if several else []) + [
        column for column in columns if column in lines and lines[column].notna().any()
    ]
    rows = [[cell(line[column], column) for column in chosen] for _, line in lines.iterrows()]
    names = [HEADINGS.get(column, column.replace("_", " ")) for column in chosen]
    return Table(name, [(name, c.number) for name, c in zip(names, rows[0], strict=True)], rows)


def cell(value: str | float, column: str) -> Cell:
    """Show a value with three digits."""
    if isinstance(value, str):
        return Cell(value, value, number=False, column=column)
    if pd.isna(value):
        return Cell("–", "", number=True, column=column)
    return Cell(shown(float(value)), repr(float(value)), number=True, column=column)


def shown(value: float) -> str:
    """Write three digits, whole numbers as they are."""
    if not math.isfinite(value):
        return str(value)
    if value == int(value) and abs(value) < 1e6:
        return str(int(value))
    size = abs(value)
    if not 1e-3 <= size < 1e6:
        return f"{value:.2e}"
    decimals = next(d for d, least in enumerate((100, 10, 1, 0.1, 0.01, 0)) if size >= least)
    return f"{value:.{decimals}f}"
