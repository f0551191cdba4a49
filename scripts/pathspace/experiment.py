"""The folder of an experiment, read: tables as pandas, images as NumPy.

`src/docs/scripting.md` shows how to use it.
"""

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from .curves import curves_of_rows
from .exr import Image, read_channels, rgb
from .styles import Style, styles

SCHEMA = 1
"""Version of the tables that this package reads."""

TABLES = ("rows", "curves", "summary", "verdicts", "agreement")
FLAGS = ("below_reference_noise",)
TEXTS = ("scene", "method", "renderer", "hardware", "host", "other", "against", "verdict", "base")
NEEDED = {"scene", "method", "seed", "checkpoint", "spp", "render_seconds"}


class LoadError(Exception):
    """A folder is no experiment, or one that this version cannot read."""


@dataclass(frozen=True)
class Experiment:
    """What a comparison left behind.

    Columns are those of the files. A table that is not there is empty, save `curves`, which then
    comes from the rows: the geometric mean over seeds, and a band of one geometric standard
    deviation.
    """

    folder: Path
    rows: pd.DataFrame
    """A line for each scene, method, seed and checkpoint."""
    curves: pd.DataFrame
    """A line for each scene, method, hardware, metric and checkpoint: error, 95 % band."""
    summary: pd.DataFrame
    """A line for each scene, method and hardware."""
    verdicts: pd.DataFrame
    """A line for each pair of methods: how much less time the one needs for the same error."""
    agreement: pd.DataFrame
    """A line for each test whether two methods estimate the same image."""
    experiment: dict[str, Any]
    """The resolved manifest, `experiment.toml`."""

    @property
    def scenes(self) -> list[str]:
        """Names of the scenes, in the order of the rows."""
        return unique(self.rows["scene"])

    @property
    def methods(self) -> list[str]:
        """Names of the methods, in the order of the manifest and then of the rows."""
        entries = self.experiment.get("methods", [])
        named = [entry.get("name") for entry in entries if isinstance(entry, dict)]
        found = unique(self.rows["method"])
        return [name for name in unique(named) if name in found] + [
            name for name in found if name not in named
        ]

    @property
    def styles(self) -> dict[str, Style]:
        """Colour, marker and line of each method: the same in every plot."""
        return styles(self.methods)

    def image(self, scene: str, method: str, seed: int | None = None) -> Image | None:
        """Read the mean image over all seeds, or that of one run: rows from the top, R, G, B."""
        if seed is not None:
            return self._image(self._runs(scene, method) / str(seed) / "image.exr")
        return self._image(self.folder / "images" / file_name(scene) / f"{file_name(method)}.exr")

    def reference(self, scene: str) -> Image | None:
        """Read the reference image."""
        return self._image(self.folder / "references" / f"{file_name(scene)}.exr")

    def reference_error(self, scene: str) -> Image | None:
        """Read the standard error of the reference; `None` where it is exact or unknown."""
        path = self.folder / "references" / f"{file_name(scene)}.exr"
        return self._image(path, "standard_error")

    def seeds(self, scene: str, method: str) -> list[int]:
        """Return the seeds of a method's runs, in the order of the rows."""
        chosen = (self.rows["scene"] == scene) & (self.rows["method"] == method)
        return [int(seed) for seed in self.rows.loc[chosen, "seed"].drop_duplicates()]

    def _runs(self, scene: str, method: str) -> Path:
        return self.folder / "runs" / file_name(scene) / file_name(method)

    @staticmethod
    def _image(path: Path, layer: str = "") -> Image | None:
        if not path.is_file():
            return None
        try:
            return rgb(read_channels(path), layer)
        except RuntimeError as error:
            raise LoadError(f"{path}: {error}") from None


def load(folder: str | Path) -> Experiment:
    """Read the tables and the manifest of an experiment; images are read when asked for."""
    folder = Path(folder)
    tables = {name: read_table(folder / f"{name}.csv") for name in TABLES}
    rows = tables["rows"]
    if rows is None:
        raise LoadError(
            f"{folder / 'rows.csv'}: no such file; is {folder} the folder of an experiment?"
        )
    if missing := NEEDED - set(rows.columns):
        raise LoadError(f"{folder / 'rows.csv'}: no column {', '.join(sorted(missing))}")
    if "hardware" not in rows:
        rows = tables["rows"] = rows.assign(hardware="")
    if tables["curves"] is None:
        tables["curves"] = curves_of_rows(rows)
    found = {name: pd.DataFrame() if table is None else table for name, table in tables.items()}
    return Experiment(folder, experiment=read_manifest(folder / "experiment.toml"), **found)


def read_table(path: Path) -> pd.DataFrame | None:
    """Read a table of this version; `None` where there is none."""
    try:
        # A method may be named NA.
        texts = dict.fromkeys(TEXTS, str)
        table = pd.read_csv(
            path,
            dtype=texts,
            keep_default_na=False,
            na_values={
                column: ["", "NaN"] for column in pd.read_csv(path, nrows=0) if column not in TEXTS
            },
        )
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise LoadError(f"{path}: {error}") from None
    if wrong := sorted(set(table.get("schema", ())) - {SCHEMA}):
        raise LoadError(
            f"{path}: schema {wrong[0]}; this version of the package reads schema {SCHEMA}. "
            "Use the package that belongs to the program which wrote it."
        )
    for column in set(FLAGS) & set(table.columns):
        table[column] = table[column].astype(str).str.lower() == "true"
    return table


def read_manifest(path: Path) -> dict[str, Any]:
    """Read `experiment.toml`; nothing where there is none."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise LoadError(f"{path}: {error}") from None


def file_name(name: str) -> str:
    """Write a name as `pathspace compare` does in paths: letters, digits, `.`, `-` and `_` stay."""
    name = "".join(c if c.isalnum() or c in ".-_" else "_" for c in name)
    return f"_{name}" if not name or name.startswith(".") else name


def unique(values: Iterable[Any]) -> list[Any]:
    """Return the values in order of first appearance."""
    return list(dict.fromkeys(values))
