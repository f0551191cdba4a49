"""One run of an experiment, as a worker makes it. Workers need nothing else of this package."""

import contextlib
import fcntl
import os
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

PATIENCE = 3600.0
"""So long a run is waited for that another process is making \\[s\\]."""


@dataclass(frozen=True)
class Task:
    """What a worker is told."""

    job: str
    """`SCENE/METHOD/SEED`."""
    command: tuple[str, ...]
    folder: str
    threads: int
    """0 takes what the manifest says."""
    timed: bool


@dataclass(frozen=True)
class Outcome:
    """What became of it."""

    job: str
    host: str
    seconds: float
    error: str
    """Nothing, where it is finished."""


def sees(token: str) -> bool:
    """Tell whether this machine has the file."""
    return Path(token).exists()


def make(task: Task) -> Outcome:
    """Make a run. One that a lost worker's process still makes is waited for."""
    start = time.monotonic()
    run = Path(task.folder) / "runs" / task.job / "run.json"
    command = [*task.command, "--job", task.job]
    if task.threads:
        command += ["--threads", str(task.threads)]
    while True:
        with alone(task.timed) as inherited:
            ended = subprocess.run(
                command, capture_output=True, text=True, check=False, pass_fds=inherited
            )
        lines = [line for line in ended.stderr.splitlines() if line.startswith("error")]
        error = "" if run.exists() else lines[-1] if lines else ""
        waited = time.monotonic() - start
        if run.exists() or error or ended.returncode != 0 or waited > PATIENCE:
            fallback = "" if run.exists() else f"ended with exit code {ended.returncode}"
            return Outcome(task.job, socket.gethostname(), waited, error or fallback)
        time.sleep(0.5)


@contextlib.contextmanager
def alone(wanted: bool) -> Iterator[tuple[int, ...]]:
    """Wait until no other timed run is on this machine.

    The program inherits the lock, so that it holds for as long as the program runs, also where its
    worker is lost.
    """
    if not wanted:
        yield ()
        return
    path = Path(tempfile.gettempdir()) / f"pathspace-timed-{os.getuid()}.lock"
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield (file.fileno(),)
