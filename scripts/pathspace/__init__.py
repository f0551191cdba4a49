"""Mitsuba as an opponent, and what a comparison found: as tables, plots and a report.

    import pathspace
    experiment = pathspace.load("results/cornell_box")

`src/docs/scripting.md` shows what can be done with it.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .experiment import Experiment, LoadError, load

__all__ = ["Experiment", "LoadError", "load"]


def __getattr__(name: str) -> Any:  # noqa: ANN401
    """Import on first use: what runs Mitsuba has no need of pandas."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import experiment

    return getattr(experiment, name)
