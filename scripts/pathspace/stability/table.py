"""stability.csv, as a picture needs it."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pathspace.panels import PlotError

SCHEMA = "1"
VERDICTS = ("holds", "noise", "blind", "slow", "beyond", "fails", "missing")

ALONE = "core"
"""The method of what needs no integrator."""


@dataclass(frozen=True)
class Row:
    """A case."""

    group: str
    case: str
    parameter: str
    values: tuple[str, ...]
    """As they are written in cells, in the order of the table."""


@dataclass(frozen=True)
class Table:
    """Verdicts by case, value and method."""

    rows: tuple[Row, ...]
    """Groups together, in the order in which they come first."""
    methods: tuple[str, ...]
    verdicts: dict[tuple[str, str, str, str], str]
    """By group, case, value and method."""

    @property
    def width(self) -> int:
        """The largest number of values of a case."""
        return max(len(row.values) for row in self.rows)

    def parts(self) -> list["Table"]:
        """Return the cases of integrators, and those of none where no case has both."""
        key_methods: dict[tuple[str, str], set[str]] = {}
        for group, case, _, method in self.verdicts:
            key_methods.setdefault((group, case), set()).add(method)
        alone = tuple(row for row in self.rows if key_methods[row.group, row.case] == {ALONE})
        others = tuple(row for row in self.rows if row not in alone)
        if not alone or not others or any(ALONE in key_methods[r.group, r.case] for r in others):
            return [self]
        methods = tuple(method for method in self.methods if method != ALONE)
        return [Table(others, methods, self.verdicts), Table(alone, (ALONE,), self.verdicts)]

    def counts(self, method: str) -> dict[str, int]:
        """Count the verdicts of a method."""
        of_method = [verdict for key, verdict in self.verdicts.items() if key[3] == method]
        return {name: of_method.count(name) for name in VERDICTS if name in of_method}


def read_table(path: Path) -> Table:
    """Read stability.csv."""
    try:
        with path.open(newline="") as file:
            lines = list(csv.DictReader(file))
    except OSError as error:
        raise PlotError(f"{path}: {error.strerror}") from None
    if not lines:
        raise PlotError(f"{path}: there are no cells to draw")
    wanted = {"schema", "group", "case", "parameter", "value", "method", "verdict"}
    if missing := wanted - set(lines[0]):
        raise PlotError(f"{path}: there is no column {', '.join(sorted(missing))}")
    values: dict[tuple[str, str], dict[str, None]] = {}
    parameters: dict[tuple[str, str], str] = {}
    verdicts = {}
    for number, line in enumerate(lines, 2):
        if line["schema"] != SCHEMA:
            raise PlotError(f"{path}: schema {line['schema']}; this reads {SCHEMA}")
        if line["verdict"] not in VERDICTS:
            raise PlotError(f"{path}: line {number}: no verdict is called '{line['verdict']}'")
        case = line["group"], line["case"]
        value = short(line["value"])
        values.setdefault(case, {})[value] = None
        parameters.setdefault(case, line["parameter"])
        verdicts[*case, value, line["method"]] = line["verdict"]
    groups = list(dict.fromkeys(group for group, _ in values))
    cases = sorted(values, key=lambda case: groups.index(case[0]))
    rows = tuple(Row(*case, parameters[case], tuple(values[case])) for case in cases)
    methods = list(dict.fromkeys(line["method"] for line in lines))
    return Table(rows, tuple(ordered(methods)), verdicts)


def ordered(methods: Sequence[str]) -> list[str]:
    """Put other renderers last."""
    return sorted(methods, key=lambda method: method.startswith("mitsuba"))


def short(value: str) -> str:
    """Write a number as briefly as it can be: 1e-6, 0.01, 179.9, 1e9."""
    try:
        number = float(value)
    except ValueError:
        return value
    if number == 0:
        return "0"
    candidates = []
    for digits in range(1, 18):
        if float(f"{number:.{digits - 1}e}") == number:
            mantissa, exponent = f"{number:.{digits - 1}e}".split("e")
            candidates.append(f"{mantissa}e{int(exponent)}")
            break
    if 1e-5 < abs(number) < 1e6:
        plain = f"{number:.17g}" if number == int(number) else repr(number)
        candidates.insert(0, plain)
    return min(candidates, key=len)
