"""Runs one of Mitsuba's integrators on an exported scene, and writes what it had at given times.

    python -m pathspace.mitsuba_run --scene scene.xml --integrator path|ptracer --out DIR
        (--seconds T | --spp N) [--checkpoints t1,t2,…] [--seed S] [--threads N]
        [--variant auto|scalar_rgb|llvm_ad_rgb] [--max-length K|none] [--rr-depth D]
        [--hide-emitters] [--pass-spp M] [--block B] [--reference-from I]

The scene's own integrator and number of samples are overridden. `--max-length` counts edges and is
Mitsuba's `max_depth`. `--rr-depth` is the length from which Russian roulette may end a path; a
huge value turns it off. `--variant auto` takes `llvm_ad_rgb` where an LLVM library works, else
`scalar_rgb`.

The run is a ladder of passes of M samples per pixel (`ptracer`: light paths per pixel), each with
a seed of its own derived from S. Without `--pass-spp`, M is calibrated: a power of two whose pass
takes at most about the time of the first checkpoint, and from 0.05 to 0.5 s where that can be.
Shorter passes put the LLVM variants at a disadvantage (5 % at 0.2 s), longer ones make checkpoints
late. What is measured is rendering until the image is in memory: wall-clock time, and CPU time of
all threads. Loading, just-in-time compilation, calibration and file output are not in it. With
`--seconds`, passes are started until the measured time reaches T; with `--spp`, exactly N samples
are taken.

`--reference-from I` renders passes I, I + 1, … of a reference, which somebody else adds up and goes
on with: it needs `--pass-spp`, its seeds are none that runs use, and each pass is told and written
as it is there. The same S, I and M give the same passes. Where all seeds are used up the run ends
with an error, since one that came twice would make the reference look more certain than it is.

Files in DIR, each written whole or not at all:

checkpoint_III.npy
    Mean image after the pass in which the measured time reached the III-th of the checkpoint times
    (where one pass reaches several, only the last of them); the end of the run is a checkpoint too.
    NumPy, float32, height × width × 3, top row first.
pass_IIIIIIII.npy
    Of a reference alone: the image of its I-th pass, as a checkpoint's. The reader removes it.
blocks.npy
    Means of each pass over blocks of B × B pixels (default 16; smaller at the right and lower
    border): NumPy, float64, passes × block rows × block columns × 3.
run.json
    `renderer`, `variant`, `llvm`, `integrator`, `max_length`, `rr_depth`, `hide_emitters`, `seed`,
    `threads`, `width`, `height`, `block`, `pass_spp` (calibrated or given), `passes` (a list of
    `{spp, seconds}`), `import_seconds`, `load_seconds`, `setup_seconds` (compilation),
    `warmup_seconds` (all that ran before the first measured pass, compilation included), `spp`,
    `render_seconds`, `cpu_seconds`, `invalid` (pixels with negative, infinite or undefined values,
    summed over passes; they stay in the mean), `rays` (null: Mitsuba does not count them),
    `interrupted`, and `checkpoints`: a list of `{index, target_seconds, file, spp, render_seconds,
    cpu_seconds, invalid}`. It is written last: where it exists, the run is complete or was
    interrupted.

On stderr, one JSON object a line: `{"variant", "pass_spp", "pass_seconds"}` when the ladder
starts, then `{"seconds", "spp"}` a few times a second and at each checkpoint (there with
`"checkpoint": index`). Each pass of a reference is `{"file", "spp", "seconds", "cpu_seconds",
"invalid"}`, times those of all passes so far, the others of this one. Anything else on stderr is a
message for people.

Exit status: 0 done; 1 failed; 2 wrong arguments; 3 this integrator or variant cannot render this
scene here; 130 interrupted by SIGINT or SIGTERM, after finishing the current pass and writing what
there is.
"""

import argparse
import json
import math
import os
import signal
import sys
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from . import llvm
from .files import write_array, write_json
from .ladder import Image, Ladder, Render, calibrate, invalid_pixels, pass_sizes, timed
from .seeds import PassSeeds

SHORTEST_PASS, LONGEST_PASS = 0.05, 0.5
"""Limits of the time of a calibrated pass [s]: overhead below, coarse checkpoints above.

The LLVM variants spend about 10 ms of each pass on tracing the program that they then run.
"""
PROGRESS_EVERY = 0.3
"""Time between lines of progress [s]."""


class UnsupportedError(Exception):
    """This integrator or variant cannot render this scene here."""


class SeedsUsedUpError(Exception):
    """Another pass would repeat the random numbers of an earlier one."""


class InterruptedEarlyError(Exception):
    """A signal came before the first pass."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    options = parse(arguments)
    interrupt = Interrupt()
    try:
        return run(options, interrupt)
    except UnsupportedError as error:
        print(error, file=sys.stderr)
        return 3
    except InterruptedEarlyError:
        return 130
    except Exception as error:
        print(f"{options.scene}: {' '.join(str(error).split())}", file=sys.stderr)
        return 1


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """Read the command line, as the module's documentation describes it."""
    parser = argparse.ArgumentParser(
        prog="python -m pathspace.mitsuba_run",
        description="Run a Mitsuba integrator on an exported scene: a ladder of timed passes.",
    )
    add = parser.add_argument
    add("--scene", type=Path, required=True, help="scene.xml as written by pathspace export")
    add("--integrator", choices=["path", "ptracer"], required=True)
    add("--variant", choices=["auto", "scalar_rgb", "llvm_ad_rgb"], default="auto")
    add("--threads", type=positive_int, default=os.cpu_count() or 1)
    add("--max-length", type=length, default=-1, help="longest path in edges, or none")
    add("--rr-depth", type=positive_int, default=5, help="roulette from this length on")
    add("--hide-emitters", action="store_true", help="do not show emission seen directly")
    add("--seed", type=int, default=0)
    budget = parser.add_mutually_exclusive_group(required=True)
    budget.add_argument("--seconds", type=positive_float, help="measured rendering time")
    budget.add_argument("--spp", type=positive_int, help="samples (light paths) per pixel")
    add("--checkpoints", type=times, default=[], help="measured times in seconds: t1,t2,…")
    add("--pass-spp", type=positive_int, help="samples of a pass; default: calibrated")
    add("--reference-from", type=index, help="render a reference on from this pass")
    add("--block", type=positive_int, default=16, help="side of a block in pixels")
    add("--out", type=Path, required=True, help="folder for the results")
    options = parser.parse_args(arguments)
    if options.reference_from is not None and options.pass_spp is None:
        parser.error("--reference-from needs --pass-spp: all passes of a reference are alike")
    return options


def positive_int(text: str) -> int:
    """Whole number of at least 1, capped at what Mitsuba can hold."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not positive")
    return min(value, 2**31 - 1)


def index(text: str) -> int:
    """Whole number of at least 0."""
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} is negative")
    return value


def positive_float(text: str) -> float:
    """Finite number above 0."""
    value = float(text)
    if not (0 < value < math.inf):
        raise argparse.ArgumentTypeError(f"{text} is not positive and finite")
    return value


def length(text: str) -> int:
    """Mitsuba's `max_depth`: −1 for `none`."""
    return -1 if text == "none" else positive_int(text)


def times(text: str) -> list[float]:
    """Ascending list of times, separated by commas."""
    return sorted({positive_float(part) for part in text.split(",") if part})


class Interrupt:
    """Remembers that SIGINT or SIGTERM came; nothing is torn apart."""

    def __init__(self) -> None:
        self.came = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._remember)

    def _remember(self, *_: object) -> None:
        self.came = True

    def check(self) -> None:
        """Give up; for use before there is anything to keep."""
        if self.came:
            raise InterruptedEarlyError


@dataclass(frozen=True)
class Loaded:
    """A scene ready to render."""

    render: Render
    size: tuple[int, int]
    """Width and height in pixels."""
    version: str
    import_seconds: float
    load_seconds: float


def run(options: argparse.Namespace, interrupt: Interrupt) -> int:
    """Load, warm up, render the ladder, write the results; return the exit status."""
    check_sensor(options.scene, options.integrator)
    options.out.mkdir(parents=True, exist_ok=True)
    # What an earlier run left must not pass for the result of this one.
    (options.out / "run.json").unlink(missing_ok=True)
    variant, library = choose_variant(options.variant)
    loaded = load(options, variant)
    interrupt.check()

    start = time.perf_counter()
    pass_spp, setup_seconds = warm_up(loaded.render, variant, options, interrupt)
    warmup_seconds = time.perf_counter() - start

    first = options.reference_from
    scalar = variant.startswith("scalar")
    seeds = PassSeeds(options.seed, *loaded.size, reference=first is not None, scalar=scalar)
    ladder = Ladder(options.block, options.checkpoints)
    checkpoints: list[dict[str, Any]] = []
    last_progress = 0.0
    for number, spp in enumerate(pass_sizes(options.spp, pass_spp), first or 0):
        if first is not None and number >= seeds.capacity:
            raise SeedsUsedUpError(
                f"no pass after the {number}-th has random numbers of its own in {variant}"
            )
        step = timed(loaded.render, seeds(number), spp)
        reached = ladder.add(step, spp)
        if first is not None:
            write_pass(options.out, number, step.image, ladder)
        done = options.seconds is not None and ladder.seconds >= options.seconds
        if reached is not None:
            checkpoints.append(write_checkpoint(options.out, ladder, reached))
        elif time.perf_counter() - last_progress > PROGRESS_EVERY:
            last_progress = time.perf_counter()
            tell(seconds=ladder.seconds, spp=ladder.spp)
        if done or interrupt.came:
            break
    if not checkpoints or checkpoints[-1]["spp"] < ladder.spp:
        last = checkpoints[-1]["index"] if checkpoints else -1
        at_end = last + 1 if interrupt.came else len(options.checkpoints)
        checkpoints.append(write_checkpoint(options.out, ladder, at_end))

    write_array(options.out / "blocks.npy", np.stack(ladder.blocks))
    width, height = loaded.size
    result = {
        "renderer": f"mitsuba {loaded.version}",
        "variant": variant,
        "llvm": library,
        "integrator": options.integrator,
        "max_length": None if options.max_length < 0 else options.max_length,
        "rr_depth": options.rr_depth,
        "hide_emitters": options.hide_emitters,
        "seed": options.seed,
        "threads": options.threads,
        "width": width,
        "height": height,
        "block": options.block,
        "pass_spp": pass_spp,
        "passes": [
            {"spp": spp, "seconds": seconds}
            for spp, seconds in zip(ladder.pass_spp, ladder.pass_seconds, strict=True)
        ],
        "import_seconds": loaded.import_seconds,
        "load_seconds": loaded.load_seconds,
        "setup_seconds": setup_seconds,
        "warmup_seconds": warmup_seconds,
        "spp": ladder.spp,
        "render_seconds": ladder.seconds,
        "cpu_seconds": ladder.cpu_seconds,
        "invalid": ladder.invalid,
        "rays": None,
        "interrupted": interrupt.came,
        "checkpoints": checkpoints,
    }
    write_json(options.out / "run.json", result)
    return 130 if interrupt.came else 0


def check_sensor(scene: Path, integrator: str) -> None:
    """Refuse what Mitsuba's particle tracer cannot do, before it fails in the middle."""
    sensor = ElementTree.parse(scene).getroot().find("sensor")
    kind = None if sensor is None else sensor.get("type")
    if integrator == "ptracer" and kind not in ("perspective", "thinlens"):
        raise UnsupportedError(
            f"{scene}: Mitsuba's ptracer needs a perspective or thinlens sensor, not {kind}; "
            "use --integrator path"
        )


def choose_variant(wanted: str) -> tuple[str, str | None]:
    """Return variant and LLVM library; the latter is also put where Mitsuba looks for it."""
    if wanted == "scalar_rgb":
        return wanted, None
    library = llvm.find()
    if library is not None:
        os.environ["DRJIT_LIBLLVM_PATH"] = str(library)
        return "llvm_ad_rgb", str(library)
    if wanted == "llvm_ad_rgb":
        raise UnsupportedError(f"no LLVM library works with Mitsuba here; {llvm.HOW_TO_GET}")
    print(f"Mitsuba runs as scalar_rgb; {llvm.HOW_TO_GET}", file=sys.stderr)
    return "scalar_rgb", None


def load(options: argparse.Namespace, variant: str) -> Loaded:
    """Import Mitsuba and load the scene."""
    start = time.perf_counter()
    import drjit as dr
    import mitsuba as mi

    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Warn)
    dr.set_thread_count(options.threads)
    imported = time.perf_counter()

    scene: Any = mi.load_file(str(options.scene))
    dr.sync_thread()
    loaded = time.perf_counter()

    integrator: Any = mi.load_dict(
        {
            "type": options.integrator,
            "max_depth": options.max_length,
            "rr_depth": options.rr_depth,
            "hide_emitters": options.hide_emitters,
        }
    )
    # The particle tracer draws a progress bar at every log level.
    mi.logger().clear_appenders()

    def render(seed: int, spp: int) -> Image:
        # The array is a copy in main memory: asynchronous evaluation has ended when it exists.
        return np.array(integrator.render(scene, sensor=0, seed=seed, spp=spp))[..., :3]

    width, height = scene.sensors()[0].film().crop_size()
    return Loaded(
        render, (int(width), int(height)), mi.__version__, imported - start, loaded - imported
    )


def warm_up(
    render: Render, variant: str, options: argparse.Namespace, interrupt: Interrupt
) -> tuple[int, float]:
    """Compile, and find the size of a pass; return it with the time of compilation [s]."""
    if options.pass_spp is None:
        end = options.seconds or math.inf
        first = options.checkpoints[0] if options.checkpoints else end / 10
        found = calibrate(render, min(max(first, SHORTEST_PASS), LONGEST_PASS))
        pass_spp, pass_seconds, setup_seconds = found.spp, found.seconds, found.setup_seconds
    else:
        pass_spp = options.pass_spp
        first_seconds = timed(render, 0, pass_spp).seconds
        pass_seconds = timed(render, 1, pass_spp).seconds
        setup_seconds = max(0.0, first_seconds - pass_seconds)
    interrupt.check()
    if options.spp is not None:
        # Sizes that calibration has not seen may need a compilation of their own.
        sizes = set(pass_sizes(options.spp, pass_spp))
        pass_spp = max(sizes)
        for spp in sizes:
            first_seconds = timed(render, 0, spp).seconds
            pass_seconds = timed(render, 1, spp).seconds
            setup_seconds = max(setup_seconds, first_seconds - pass_seconds)
    interrupt.check()
    tell(variant=variant, pass_spp=pass_spp, pass_seconds=pass_seconds)
    return pass_spp, setup_seconds


def write_checkpoint(folder: Path, ladder: Ladder, index: int) -> dict[str, Any]:
    """Write the mean image, tell, and return the entry for `run.json`."""
    file = f"checkpoint_{index:03d}.npy"
    write_array(folder / file, ladder.mean())
    tell(seconds=ladder.seconds, spp=ladder.spp, checkpoint=index)
    return {
        "index": index,
        "target_seconds": ladder.targets[index] if index < len(ladder.targets) else None,
        "file": file,
        "spp": ladder.spp,
        "render_seconds": ladder.seconds,
        "cpu_seconds": ladder.cpu_seconds,
        "invalid": ladder.invalid,
    }


def write_pass(folder: Path, number: int, image: Image, ladder: Ladder) -> None:
    """Write the image of the ladder's latest pass, and tell."""
    file = f"pass_{number:08d}.npy"
    write_array(folder / file, image.astype(np.float32, copy=False))
    tell(
        file=file,
        spp=ladder.pass_spp[-1],
        seconds=ladder.seconds,
        cpu_seconds=ladder.cpu_seconds,
        invalid=invalid_pixels(image),
    )


def tell(**values: float | int | str) -> None:
    """Write a line of JSON to stderr."""
    print(json.dumps(values), file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
