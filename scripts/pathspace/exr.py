"""OpenEXR images as arrays."""

from pathlib import Path

import mitsuba
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]


def read_channels(path: Path) -> dict[str, Image]:
    """Read each channel of an image, rows from the top."""
    if mitsuba.variant() is None:
        mitsuba.set_variant("scalar_rgb")
    bitmap = mitsuba.Bitmap(str(path))
    pixels = np.array(bitmap, dtype=np.float32)
    pixels = pixels.reshape(*pixels.shape[:2], -1)
    names = [field.name for field in bitmap.struct_()]
    return {name: pixels[..., index] for index, name in enumerate(names)}


def rgb(channels: dict[str, Image], layer: str = "") -> Image | None:
    """Stack the channels of a layer, such as `standard_error`; `None` where one is missing."""
    names = [f"{layer}.{channel}" if layer else channel for channel in "RGB"]
    if any(name not in channels for name in names):
        return None
    return np.stack([channels[name] for name in names], axis=-1)
