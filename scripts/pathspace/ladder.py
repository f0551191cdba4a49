"""A ladder of short passes: their running mean at given times, and their block means."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.floating]
Render = Callable[[int, int], Image]
"""Renders `(seed, spp)` to height × width × 3, finished when it returns."""


@dataclass(frozen=True)
class Timed:
    """An image and what it took."""

    image: Image
    seconds: float
    cpu_seconds: float


def timed(render: Render, seed: int, spp: int) -> Timed:
    """Render once, measuring wall-clock time and the CPU time of all threads."""
    cpu, start = time.process_time(), time.perf_counter()
    image = render(seed, spp)
    return Timed(image, time.perf_counter() - start, time.process_time() - cpu)


@dataclass(frozen=True)
class Calibration:
    """How long a pass should be."""

    spp: int
    """Samples per pixel of a pass."""
    seconds: float
    """What such a pass took."""
    setup_seconds: float
    """How much longer a first render took than a second: just-in-time compilation, once."""


def calibrate(render: Render, seconds: float) -> Calibration:
    """Find the largest power of two whose pass takes at most about `seconds`; at least 1.

    Every number of samples that is tried is rendered twice, so the one chosen is compiled
    afterwards.
    """
    spp, setup = 1, 0.0
    while True:
        first = timed(render, 0, spp).seconds
        second = timed(render, 1, spp).seconds
        setup = max(setup, first - second)
        factor = int(seconds / max(second, 1e-6))
        if factor < 2 or spp >= 1 << 16:
            return Calibration(spp, second, setup)
        # At most 16-fold: a pass that is all overhead says little about a long one.
        spp *= 1 << (min(factor, 16).bit_length() - 1)


def passes_for(spp: int, pass_spp: int) -> list[int]:
    """Split exactly `spp` samples into passes of about `pass_spp`, all equal where possible."""
    for size in range(min(pass_spp, spp), pass_spp // 2, -1):
        if spp % size == 0:
            return [size] * (spp // size)
    rest = spp % pass_spp
    return [pass_spp] * (spp // pass_spp) + ([rest] if rest else [])


def block_means(image: Image, block: int) -> NDArray[np.float64]:
    """Mean over each block of `block` × `block` pixels; those at the border may be smaller."""
    height, width = image.shape[:2]
    rows, columns = np.arange(0, height, block), np.arange(0, width, block)
    sums = np.add.reduceat(np.add.reduceat(image.astype(np.float64), rows, axis=0), columns, axis=1)
    areas = np.outer(np.diff(np.append(rows, height)), np.diff(np.append(columns, width)))
    return sums / areas[:, :, None]


def invalid_pixels(image: Image) -> int:
    """Number of pixels with a channel that is negative, infinite or not a number."""
    return int(np.count_nonzero(~(np.isfinite(image) & (image >= 0)).all(axis=-1)))


@dataclass
class Ladder:
    """Accumulates passes in double precision."""

    block: int
    targets: list[float] = field(default_factory=list)
    """Times of checkpoints [s], ascending."""
    sum: NDArray[np.float64] | None = None
    spp: int = 0
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    invalid: int = 0
    blocks: list[NDArray[np.float64]] = field(default_factory=list)
    pass_spp: list[int] = field(default_factory=list)
    pass_seconds: list[float] = field(default_factory=list)

    def add(self, result: Timed, spp: int) -> int | None:
        """Add a pass; return the index of the checkpoint that it reached, the latest if several.

        Values that cannot be right are counted and stay in the mean: nothing is dropped in silence.
        """
        image = result.image.astype(np.float64)
        self.sum = image * spp if self.sum is None else self.sum + image * spp
        self.spp += spp
        before = self._reached()
        self.seconds += result.seconds
        self.cpu_seconds += result.cpu_seconds
        self.invalid += invalid_pixels(image)
        self.blocks.append(block_means(image, self.block))
        self.pass_spp.append(spp)
        self.pass_seconds.append(result.seconds)
        after = self._reached()
        return after - 1 if after > before else None

    def mean(self) -> NDArray[np.float32]:
        """The image so far."""
        if self.sum is None:
            raise ValueError("no pass has been added")
        return (self.sum / self.spp).astype(np.float32)

    def _reached(self) -> int:
        return sum(self.seconds >= target for target in self.targets)


def pass_sizes(spp: int | None, pass_spp: int) -> Iterator[int]:
    """Sizes of the passes for a budget of `spp` samples, or without end where it is `None`."""
    if spp is not None:
        yield from passes_for(spp, pass_spp)
    else:
        while True:
            yield pass_spp
