"""Mitsuba's side of `pathspace stability`: independent passes of each cell.

    python -m pathspace.stability.run --cells OUT/cells.json --variant scalar_rgb|llvm_ad_rgb
        --seconds S [--seed N] [--threads N]

cells.json is `{"schema": 1, "cells": [CELL, …]}` with cells such as `{"id": "stiff/albedo/0.01",
"scene": "stiff/albedo/0.01/scene.xml", "integrator": "path", "max_depth": -1, "width": 8,
"height": 6}`; scenes are relative to the file. As soon as a cell is done there is a line of JSON on
standard output, in the order of the file:

{"id", "variant", "passes", "spp", "nonfinite", "negative", "largest", "seconds_per_sample"}
    `passes`: the mean luminance of each pass, null where it is not finite; 16 or more, in about S
    seconds. `spp`: samples per pixel of each. `nonfinite`, `negative`: pixels, summed over passes.
    `largest`: the largest value of a pixel and channel in any pass. Seconds are per sample of a
    pixel, compilation left out.
{"id", "variant", "slow"}
    One sample of every pixel took more than 10 S: the seconds, or so far where it was not awaited.
{"id", "variant", "failed"}
    Why: what Mitsuba has to say; `crashed: …`, the process has died; `hangs: …`, it says nothing.

Cells are rendered in a child process, which is started anew after a crash. Interrupted, it ends at
once. Exit status: 0 done; 2 wrong arguments or files; 3 no such variant here; 130 interrupted.
"""

import argparse
import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

from pathspace import llvm

SCHEMA = 1
START_SECONDS = 120.0
"""For importing Mitsuba and loading a scene."""
GRACE_SECONDS = 15.0
"""Besides what a step should take: compilation, a busy machine."""
PATIENCE = 10.0
"""Multiple of S that one sample of every pixel may take."""
KEYS = {"id", "scene", "integrator", "max_depth", "width", "height"}


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m pathspace.stability.run",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--cells", type=Path, required=True)
    add("--variant", choices=("scalar_rgb", "llvm_ad_rgb"), required=True)
    add("--seconds", type=float, required=True)
    add("--seed", type=int, default=0)
    add("--threads", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(arguments)
    try:
        cells = read(options.cells)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    environment = dict(os.environ)
    if options.variant == "llvm_ad_rgb":
        library = llvm.find()
        if library is None:
            print(f"no LLVM library works here: {llvm.HOW_TO_GET}", file=sys.stderr)
            return 3
        environment["DRJIT_LIBLLVM_PATH"] = str(library)
    renderer = Renderer(options, environment)
    previous = signal.signal(signal.SIGTERM, lambda *_: raise_interrupt())
    try:
        for cell in cells:
            told = {"id": cell["id"], "variant": options.variant, **renderer.render(cell)}
            print(json.dumps(told, allow_nan=False), flush=True)
    except KeyboardInterrupt:
        return 130
    finally:
        signal.signal(signal.SIGTERM, previous)
        renderer.end()
    return 0


def raise_interrupt() -> None:
    """End as Ctrl-C does."""
    raise KeyboardInterrupt


def read(path: Path) -> list[dict[str, Any]]:
    """Read the cells, with scenes as absolute paths."""
    try:
        record = json.loads(path.read_text())
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise ValueError(f"{path}: is no JSON: {error}") from error
    if not isinstance(record, dict) or record.get("schema") != SCHEMA:
        raise ValueError(f"{path}: is no list of cells of schema {SCHEMA}")
    for cell in record["cells"]:
        if missing := sorted(KEYS - set(cell)):
            raise ValueError(f"{path}: cell {cell.get('id')} has no {', '.join(missing)}")
    folder = path.parent.resolve()
    return [{**cell, "scene": str(folder / cell["scene"])} for cell in record["cells"]]


class Renderer:
    """The child process, replaced when it has died or is not awaited any more."""

    def __init__(self, options: argparse.Namespace, environment: dict[str, str]) -> None:
        self.options, self.environment = options, environment
        self.command = [sys.executable, "-m", "pathspace.stability.passes", options.variant]
        self.command += [repr(options.seconds), str(options.seed), str(options.threads)]
        self.child: subprocess.Popen[str] | None = None
        self.lines: queue.Queue[str | None] = queue.Queue()

    def start(self) -> subprocess.Popen[str]:
        """Start a child that has a queue of its own for what it says."""
        child = subprocess.Popen(
            self.command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=self.environment,
            start_new_session=True,
        )
        lines: queue.Queue[str | None] = queue.Queue()

        def listen() -> None:
            for line in child.stdout or ():
                lines.put(line)
            lines.put(None)

        threading.Thread(target=listen, daemon=True).start()
        self.child, self.lines = child, lines
        return child

    def render(self, cell: dict[str, Any]) -> dict[str, Any]:
        """Render a cell; return what is to be told besides its name."""
        child = self.child or self.start()
        with contextlib.suppress(BrokenPipeError):
            child.stdin.write(json.dumps(cell) + "\n")
            child.stdin.flush()
        pilot = PATIENCE * self.options.seconds
        limit, step = START_SECONDS, "loading"
        while True:
            start = time.monotonic()
            try:
                line = self.lines.get(timeout=limit)
            except queue.Empty:
                self.end()
                seconds = time.monotonic() - start
                if step == "pilot":
                    return {"slow": seconds}
                return {"failed": f"hangs: no answer from {step} in {seconds:.0f} s"}
            if line is None:
                return {"failed": f"crashed: {self.end()}"}
            told = json.loads(line)
            if "step" not in told:
                return told
            step = told["step"]
            limit = (pilot if step == "pilot" else PATIENCE * told["seconds"]) + GRACE_SECONDS

    def end(self) -> str:
        """End the child; say how it ended where it did so by itself."""
        child, self.child = self.child, None
        if child is None:
            return ""
        # What has closed its output is about to end; that it is not killed tells how.
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(timeout=0.2)
        alive = child.poll() is None
        if alive:
            child.kill()
        code = child.wait()
        for pipe in (child.stdin, child.stdout):
            with contextlib.suppress(OSError):
                pipe.close()
        if code < 0:
            return signal.Signals(-code).name
        return f"exit status {code}"


if __name__ == "__main__":
    sys.exit(main())
