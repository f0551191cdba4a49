"""One look for each method, in every plot and in the report."""

from collections.abc import Sequence
from dataclasses import dataclass

# Okabe and Ito (2008), told apart with all common kinds of colour vision; yellow is too light.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")


@dataclass(frozen=True)
class Style:
    """How a method is drawn, in the words of Matplotlib."""

    colour: str
    marker: str
    foreign: bool
    """Another renderer's: dashed, with hollow markers."""

    @property
    def line(self) -> dict[str, object]:
        """Return the arguments of `Axes.plot`."""
        return {
            "color": self.colour,
            "marker": self.marker,
            "linestyle": "--" if self.foreign else "-",
            "markerfacecolor": "white" if self.foreign else self.colour,
        }


def styles(methods: Sequence[str]) -> dict[str, Style]:
    """Give each method a colour and a marker by its place among all."""
    return {
        method: Style(
            COLOURS[i % len(COLOURS)],
            MARKERS[i % len(MARKERS)],
            ":" in method and is_foreign(method),
        )
        for i, method in enumerate(methods)
    }


def is_foreign(method: str) -> bool:
    """Tell another renderer's method, `mitsuba:path`, from settings, `bdpt:heuristic=power`."""
    return "=" not in method.split(":")[1]
