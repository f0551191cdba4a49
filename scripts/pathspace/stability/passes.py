"""The child of `run`, which may die: renders the cells that come on standard input.

    python -m pathspace.stability.passes VARIANT SECONDS SEED THREADS

Each line in is a cell; out come lines `{"step", "seconds"}` before each step, with how long it
should take, and at last the cell's result.
"""

import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any, TextIO

import numpy as np

from pathspace.seeds import PassSeeds

PASSES, MOST_PASSES = 16, 64
LANES = 2**21
"""Samples of a pass at most: each takes memory in the LLVM variants."""
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Relative luminance of linear Rec. 709."""
PATIENCE = 10.0
"""Multiple of the time of a cell that one sample of every pixel may take."""


class Passes:
    """What the passes of a cell had in common."""

    def __init__(self) -> None:
        self.means: list[float | None] = []
        self.nonfinite = self.negative = 0
        self.largest: float | None = None

    def add(self, image: np.ndarray) -> None:
        """Take the image of a pass."""
        finite = np.isfinite(image)
        self.nonfinite += int((~finite.all(axis=-1)).sum())
        self.negative += int((image < 0).any(axis=-1).sum())
        if finite.any():
            largest = float(image[finite].max())
            self.largest = largest if self.largest is None else max(largest, self.largest)
        with np.errstate(invalid="ignore", over="ignore"):
            mean = float((image @ LUMINANCE).mean())
        self.means.append(mean if np.isfinite(mean) else None)


def main(arguments: list[str]) -> None:
    """Render what comes in until nothing does."""
    variant, seconds, seed, threads = arguments
    # Nothing that Mitsuba prints may come between.
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    import drjit as dr
    import mitsuba as mi

    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
    mi.logger().clear_appenders()
    dr.set_thread_count(int(threads))
    for line in sys.stdin:
        cell = json.loads(line)
        try:
            told = render(cell, out, float(seconds), int(seed))
        except Exception as error:
            told = {"failed": " ".join(str(error).split()) or type(error).__name__}
        print(json.dumps(told, allow_nan=False), file=out, flush=True)


def say(out: TextIO, step: str, seconds: float) -> None:
    """Tell what comes next."""
    print(json.dumps({"step": step, "seconds": seconds}), file=out, flush=True)


def render(cell: dict[str, Any], out: TextIO, seconds: float, seed: int) -> dict[str, Any]:
    """Render a cell."""
    import mitsuba as mi

    scene: Any = mi.load_file(cell["scene"])
    film = scene.sensors()[0].film()
    size = width, height = cell["width"], cell["height"]
    if size != (found := tuple(int(n) for n in film.crop_size())):
        return {"failed": f"its film has {found[0]} × {found[1]} pixels, not {width} × {height}"}
    integrator: Any = mi.load_dict({"type": cell["integrator"], "max_depth": cell["max_depth"]})
    seeds = PassSeeds(seed, width, height, scalar=mi.variant().startswith("scalar"))

    def timed(index: int, spp: int) -> tuple[np.ndarray, float]:
        start = time.perf_counter()
        image = np.array(integrator.render(scene, seed=seeds(index), spp=spp), dtype=np.float64)
        return image[..., :3], time.perf_counter() - start

    say(out, "pilot", seconds)
    spp, first = calibrate(timed, seconds, LANES // (width * height))
    if spp == 0:
        return {"slow": first}
    passes, spent = Passes(), 0.0
    while len(passes.means) < PASSES or (spent < seconds and len(passes.means) < MOST_PASSES):
        say(out, "a pass", seconds / PASSES)
        image, taken = timed(len(passes.means), spp)
        spent += taken
        passes.add(image)
    return {
        "passes": passes.means,
        "spp": spp,
        "nonfinite": passes.nonfinite,
        "negative": passes.negative,
        "largest": passes.largest,
        "seconds_per_sample": spent / (len(passes.means) * spp * width * height),
    }


def calibrate(
    timed: Callable[[int, int], tuple[Any, float]], seconds: float, most: int
) -> tuple[int, float]:
    """Return the samples per pixel of passes of which 16 take so long, 0 where one takes too long.

    The seconds of the last pilot besides. Pilots have seeds that no pass uses.
    """
    seeds = iter(range(MOST_PASSES, 2**16))
    share = seconds / PASSES

    def fastest(spp: int) -> float:
        """Return the time of a pass, compilation left out: it may come with any new size."""
        first = timed(next(seeds), spp)[1]
        return first if first < share / 2 else min(first, timed(next(seeds), spp)[1])

    _, taken = timed(next(seeds), 1)
    if taken > PATIENCE * seconds:
        return 0, taken
    taken = fastest(1)
    if taken > share:
        return 1, taken
    # Where calls cost more than samples, as in the LLVM variants, samples are free up to a point.
    spp, least = 2, fastest(2)
    taken, enough = least, max(share / 2, 1.5 * least)
    while taken < enough and spp < most:
        spp = min(most, 8 * spp, max(2 * spp, int(spp * max(share, least) / taken)))
        taken = fastest(spp)
    if taken > 2 * max(share, least):
        spp = max(1, int(spp * max(share, least) / taken))
    return spp, taken


if __name__ == "__main__":
    main(sys.argv[1:])
