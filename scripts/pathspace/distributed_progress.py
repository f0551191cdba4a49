"""How far the runs are: a bar in a terminal, lines in a pipe."""

import sys
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from .distributed_job import Outcome


class Progress:
    """Counts the runs that have ended."""

    def __init__(self, count: int) -> None:
        self.count, self.done, self.failed = count, 0, 0
        console = Console(stderr=True)
        self.bar = None
        if console.is_terminal:
            columns = (BarColumn(16), MofNCompleteColumn(), TextColumn("{task.description}"))
            self.bar = Bar(*columns, TimeRemainingColumn(), console=console, transient=True)
            self.task = self.bar.add_task("", total=count)

    def __enter__(self) -> Self:
        if self.bar:
            self.bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self.bar:
            self.bar.stop()

    def ended(self, outcome: Outcome) -> None:
        """Count a run."""
        self.done += 1
        self.failed += bool(outcome.error)
        if self.bar:
            failed = f", {self.failed} failed" if self.failed else ""
            self.bar.update(self.task, advance=1, description=f"runs{failed}; {outcome.job}")
            return
        what = outcome.error or f"{outcome.seconds:.1f} s on {outcome.host}"
        print(f"{self.done}/{self.count} {outcome.job}: {what}", file=sys.stderr, flush=True)
