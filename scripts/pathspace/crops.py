"""Rectangles of an image, and the display of radiance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .exr import Image


@dataclass(frozen=True)
class Crop:
    """A rectangle of pixels, from the top left."""

    x: int
    y: int
    width: int
    height: int

    @classmethod
    def parse(cls, text: str) -> "Crop":
        """Read `X,Y,WIDTH,HEIGHT`."""
        try:
            x, y, width, height = (int(part) for part in text.split(","))
        except ValueError:
            raise ValueError(f"{text}: not X,Y,WIDTH,HEIGHT in pixels") from None
        if min(x, y) < 0 or min(width, height) < 1:
            raise ValueError(f"{text}: a crop begins within the image and has a size")
        return cls(x, y, width, height)

    def of(self, image: Image) -> Image:
        """Cut it out."""
        return image[self.y : self.y + self.height, self.x : self.x + self.width]

    def within(self, image: Image) -> bool:
        """Tell whether all of it is in the image."""
        height, width = image.shape[:2]
        return self.x + self.width <= width and self.y + self.height <= height


def displayed(image: Image, exposure: float = 0.0) -> NDArray[np.float64]:
    """Scale by 2^exposure and encode as sRGB (IEC 61966-2-1), 0 … 1."""
    value = np.clip(np.nan_to_num(image.astype(np.float64)) * 2.0**exposure, 0.0, 1.0)
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)


def automatic_exposure(image: Image) -> float:
    """Return the whole stops that bring the luminance's 95th percentile to just below one."""
    luminance = np.nan_to_num(image.astype(np.float64) @ np.array([0.2126, 0.7152, 0.0722]))
    bright = np.percentile(luminance, 95)
    return float(np.floor(-np.log2(bright))) if bright > 0 else 0.0


def telling(reference: Image, images: Sequence[Image], count: int = 2) -> list[Crop]:
    """Choose crops where methods differ most: the largest ratio of their relative errors.

    Two crops keep a distance of their own size, so that they show different things.
    """
    height, width = reference.shape[:2]
    side = max(min(height, width) // 6, 1)
    weight = np.square(reference.astype(np.float64)) + 0.01
    errors = [np.mean(np.square(image - reference) / weight, axis=-1) for image in images]
    places = [
        (x, y)
        for y in range(0, height - side + 1, max(side // 2, 1))
        for x in range(0, width - side + 1, max(side // 2, 1))
    ]

    def spread(place: tuple[int, int]) -> float:
        x, y = place
        means = [np.nanmean(error[y : y + side, x : x + side]) + 1e-6 for error in errors]
        return max(means) / min(means)

    found: list[tuple[int, int]] = []
    for x, y in sorted(places, key=spread, reverse=True):
        if len(found) < count and all(max(abs(x - a), abs(y - b)) >= 2 * side for a, b in found):
            found.append((x, y))
    return [Crop(x, y, side, side) for x, y in found]
