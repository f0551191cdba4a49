"""Images for the viewer: half-precision values, packed into text."""

import base64
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

from pathspace.experiment import Experiment, file_name
from pathspace.exr import Image, read_channels, rgb

LARGEST = 65504.0
"""The largest half-precision number; brighter values are shown as this."""


def pack(values: Image) -> str:
    """Pack values as half precision, their low bytes before their high ones, which zlib likes."""
    halves = np.clip(np.nan_to_num(values, nan=0.0), -LARGEST, LARGEST).astype("<f2")
    planes = np.ascontiguousarray(halves).view(np.uint8).reshape(-1, 2).T
    return base64.b64encode(zlib.compress(np.ascontiguousarray(planes).tobytes(), 9)).decode()


def images_of(experiment: Experiment, scene: str) -> list[dict[str, Any]]:
    """List the reference and the mean images of a scene, as many as there are."""
    found = []
    if (reference := experiment.reference(scene)) is not None:
        found.append(entry("reference", reference))
    for method in experiment.methods:
        path = experiment.folder / "images" / file_name(scene) / f"{file_name(method)}.exr"
        if not path.is_file():
            continue
        channels = read_channels(path)
        if (image := rgb(channels)) is None:
            continue
        found.append(entry(method, image))
        if (efficiency := rgb(channels, "efficiency")) is not None:
            found[-1]["efficiency"] = logarithms(efficiency)
    return found


def entry(name: str, image: Image) -> dict[str, Any]:
    """Describe an image for the viewer."""
    height, width, _ = image.shape
    bad = int(np.count_nonzero(~np.isfinite(image).all(axis=-1)))
    return {"name": name, "width": width, "height": height, "invalid": bad, "data": pack(image)}


def logarithms(efficiency: Image) -> str:
    """Pack log10 of the mean over channels; nothing is smaller than what has no efficiency."""
    mean = efficiency.mean(axis=-1)
    return pack(np.log10(np.maximum(mean, 1e-4)).astype(np.float32))


def pictures(experiment: Experiment, scene: str) -> Iterator[dict[str, str]]:
    """Give the pyramids of a scene: PNG files that `pathspace pyramid` has put by its images."""
    folder = experiment.folder / "images" / file_name(scene)
    for kind in ("length", "technique"):
        for path in sorted(folder.glob(f"*.{kind}.png")):
            yield {"name": path.name.removesuffix(".png"), "source": data_url(path)}


def data_url(path: Path) -> str:
    """Embed a PNG file."""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()


def colours(name: str = "magma") -> list[list[int]]:
    """Give a perceptually uniform map as 256 colours."""
    table = matplotlib.colormaps[name](np.arange(256))[:, :3]
    return np.rint(255 * table).astype(int).tolist()
