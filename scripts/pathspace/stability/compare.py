"""What a path log says against what its vertices say."""

from dataclasses import dataclass, field
from typing import Any

import mpmath as mp

from .geometry import FACTOR, UNIT, Number, Uncertain
from .scene import Scene
from .walks import Path
from .weights import Competitor, Share, errors, weights

SCHEMA = 4
TOO_COARSE = 0.1
"""Where rounding alone may change a number by so much, comparing it says nothing."""
TECHNIQUES = {
    "path": lambda s, t: s < 2 and t > 1,
    "path_bsdf": lambda s, t: s == 0,
    "light": lambda s, t: t < 2,
    "bdpt": lambda s, t: True,
}
"""Which of all (s, t) an integrator has."""
SMALLEST = mp.mpf(2) ** -1022


@dataclass
class Quantity:
    """The worst of one kind of number."""

    error: float = 0.0
    """Largest relative error."""
    bound: float = 0.0
    """What rounding explains of the number that is nearest to its bound, or furthest beyond it."""
    ratio: float = 0.0
    """Its error over that bound."""
    at: str = ""
    """Which it is."""
    loosest: float = 0.0
    """The largest bound: no error above it can have been missed."""
    numbers: int = 0
    beyond: int = 0
    """Numbers of which rounding may leave no digit."""

    def add(self, error: float, bound: float, at: str) -> None:
        """Take an error with its bound."""
        self.numbers += 1
        if not bound < TOO_COARSE:
            self.beyond += 1
            return
        self.error = max(self.error, error)
        self.loosest = max(self.loosest, bound)
        ratio = error / bound if error else 0.0
        if ratio >= self.ratio:
            self.ratio, self.bound, self.at = ratio, bound, at

    @property
    def holds(self) -> bool:
        """Rounding explains all of it."""
        return self.ratio <= 1

    def record(self) -> dict[str, Any]:
        """Return what there is to print."""
        finite = self.error if mp.isfinite(self.error) else None
        return {
            "error": finite,
            "bound": self.bound,
            "loosest": self.loosest,
            "ratio": self.ratio if mp.isfinite(self.ratio) else None,
            "at": self.at,
            "numbers": self.numbers,
            "beyond": self.beyond,
        }


@dataclass
class Comparison:
    """All of a log."""

    paths: int = 0
    longest: int = 0
    skipped: dict[str, int] = field(default_factory=dict)
    """Paths that are not evaluated, by the reason."""
    log10_p: list[float] = field(default_factory=lambda: [float("inf"), float("-inf")])
    """Range of the densities."""
    quantities: dict[str, Quantity] = field(default_factory=dict)

    def of(self, name: str) -> Quantity:
        """Return the quantity of this name."""
        return self.quantities.setdefault(name, Quantity())

    @property
    def holds(self) -> bool:
        """Every number of the log is right within rounding, and there are some."""
        return self.paths > 0 and all(quantity.holds for quantity in self.quantities.values())


class LogError(ValueError):
    """The file is none that can be read."""


def compare(lines: list[dict[str, Any]], scene: Scene) -> Comparison:
    """Evaluate all paths of a log anew."""
    comparison = Comparison()
    for number, line in enumerate(lines, 1):
        if line.get("schema") != SCHEMA:
            raise LogError(f"line {number}: schema {line.get('schema')}; this reads {SCHEMA}")
        if line["techniques"] is None:
            raise LogError(f"line {number}: {line['integrator']} has no densities in its log")
        try:
            Line(line, scene, f"line {number}", comparison).compare()
        except NotImplementedError as reason:
            comparison.skipped[str(reason)] = comparison.skipped.get(str(reason), 0) + 1
            continue
        comparison.paths += 1
        comparison.longest = max(comparison.longest, line["edges"])
    return comparison


class Line:
    """One path of the log and its evaluation."""

    def __init__(
        self, record: dict[str, Any], scene: Scene, at: str, comparison: Comparison
    ) -> None:
        self.record, self.scene, self.at, self.comparison = record, scene, at, comparison
        self.path = Path(record, scene)

    def compare(self) -> None:
        """Compare f, all densities, all weights and the contribution."""
        f = self.path.contribution()
        for channel, logged, ln in zip(
            f, self.record["f"] or [None] * 3, self.record["ln_f"], strict=True
        ):
            if logged is not None:
                self.relative("f", channel, mp.mpf(logged))
            self.logarithm("ln f", channel, ln)
        densities = self.densities()
        logged = {(by["s"], by["t"]): by for by in self.record["techniques"]}
        for technique, density in densities.items():
            self.density(technique, density, logged.get(technique))
        able = [technique for technique, p in densities.items() if p.value > 0]
        for technique in logged:
            if technique not in able:
                self.add("p", float("inf"), 0.01, f"s, t = {technique}: drawn, but has no density")
        if able and set(able) <= set(logged):
            self.weights(able, densities, logged, f)

    def densities(self) -> dict[tuple[int, int], Uncertain]:
        """Return p_{s,t} of all techniques of the integrator."""
        k = self.path.k
        chosen = TECHNIQUES.get(self.record["integrator"].split(":")[0])
        if chosen is None:
            every = [(by["s"], by["t"]) for by in self.record["techniques"]]
            if len(set(every)) < len(every):
                raise NotImplementedError(f"{self.record['integrator']} is none that is evaluated")
        else:
            every = [(s, k + 1 - s) for s in range(k + 2) if chosen(s, k + 1 - s)]
        return {technique: self.path.technique(*technique) for technique in every}

    def density(
        self, technique: tuple[int, int], exact: Uncertain, logged: dict[str, Any] | None
    ) -> None:
        """Compare a density, which may be in one place and not in the other."""
        at = f"s, t = {technique}"
        if logged is None:
            if exact.value > 0:
                self.add("p", 1.0, exact.bound, f"{at}: not in the log")
            return
        p = mp.ldexp(mp.mpf(logged["p"]["mantissa"]), logged["p"]["exponent"])
        self.relative("p", exact, p, at)
        self.logarithm("ln p", exact, logged["ln_p"], at)
        if exact.value > 0:
            decades = float(mp.log10(exact.value))
            low, high = self.comparison.log10_p
            self.comparison.log10_p[:] = [min(low, decades), max(high, decades)]

    def weights(
        self,
        able: list[tuple[int, int]],
        densities: dict[tuple[int, int], Uncertain],
        logged: dict[tuple[int, int], dict[str, Any]],
        f: list[Uncertain],
    ) -> None:
        """Compare the weights of all techniques, their sum, and what the integrator used."""
        heuristic = self.record["heuristic"]
        for moved, kind in ((False, "w of all"), (True, "w")):
            competitors = [self.competitor(able_, densities[able_], moved=moved) for able_ in able]
            exact = weights(heuristic, competitors)
            bounds = errors(heuristic, competitors, [high for _, high in exact])
            if kind == "w of all":
                total, slack = 0.0, len(able) * float(UNIT)
                for technique, share, bound in zip(able, exact, bounds, strict=True):
                    w = logged[technique]["weight"]
                    self.within(kind, share, w, float(bound), f"s, t = {technique}")
                    total += w
                    slack += float(share[1]) * float(bound)
                self.add("Σ w", abs(total - 1), slack, "")
                continue
            own = (self.record["s"], self.record["t"])
            if own not in able:
                self.add("w", float("inf"), 0.01, f"s, t = {own} cannot draw the path")
                return
            i = able.index(own)
            self.within("w", exact[i], self.record["weight"], float(bounds[i]), "")
            self.contribution(logged[own], competitors[i], exact[i], float(bounds[i]), f)

    def contribution(
        self,
        logged: dict[str, Any],
        own: Competitor,
        weight: Share,
        bound: float,
        f: list[Uncertain],
    ) -> None:
        """Compare f/p and w f/(n p)."""
        p = self.path.technique(logged["s"], logged["t"])
        divisor = own.share * mp.mpf(logged["length_probability"])
        for channel, value, over in zip(
            f, self.record["contribution"], logged["f_over_p"] or [None] * 3, strict=True
        ):
            ratio = channel.over(p)
            if over is not None:
                self.relative("f/p", ratio, mp.mpf(over))
            if value is not None:
                ends = tuple(w * channel.value / divisor for w in weight)
                self.within("w f/(n p)", ends, value, bound + ratio.loose_bound, "")

    def competitor(
        self, technique: tuple[int, int], density: Uncertain, *, moved: bool
    ) -> Competitor:
        """Return a technique's density with its errors by the walk that they are of."""
        s, t = technique
        n = self.scene.camera.pixels if t < 2 else 1
        if s == t == 1:
            own = self.error(density, moved=moved)
            return Competitor(n, density.value, own, 0.0, 0.0)
        emitter, sensor = self.path.from_emitter[s], self.path.from_sensor[t]
        if s < 2 or t < 2:
            # Points drawn for their neighbour are no part of a longer walk.
            own = self.error(emitter, moved=moved) if s < 2 else 0.0
            own += self.error(sensor, moved=moved) if t < 2 else 0.0
        else:
            own = FACTOR
        return Competitor(
            n,
            density.value,
            own,
            self.error(emitter, moved=moved) if s > 1 else 0.0,
            self.error(sensor, moved=moved) if t > 1 else 0.0,
        )

    @staticmethod
    def error(number: Uncertain, *, moved: bool) -> float:
        """Return its error [u]."""
        return (number.loose_bound if moved else number.bound) / float(UNIT)

    def relative(self, name: str, exact: Uncertain, logged: Number, at: str = "") -> None:
        """Compare numbers by their ratio."""
        error = relative(exact.value, logged)
        self.add(name, error, exact.bound, at)

    def logarithm(self, name: str, exact: Uncertain, logged: float | None, at: str = "") -> None:
        """Compare logarithms, whose error is absolute where that of the number is relative."""
        if exact.value <= 0 or logged is None:
            wrong = (exact.value > 0) != (logged is not None)
            self.add(name, float("inf") if wrong else 0.0, exact.bound, at)
            return
        ln = mp.log(exact.value)
        bound = exact.bound + float(UNIT) * (4 * float(abs(ln)) + 2)
        self.add(name, float(abs(mp.mpf(logged) - ln)), bound, at)

    def within(self, name: str, ends: Share, logged: float, bound: float, at: str) -> None:
        """Compare with a number between two; what no double can be has no digits to compare."""
        low, high = ends
        value = mp.mpf(logged)
        if max(high, value) < SMALLEST or low <= value <= high:
            self.add(name, 0.0, bound, at)
        else:
            self.add(name, relative(low if value < low else high, value), bound, at)

    def add(self, name: str, error: float, bound: float, at: str) -> None:
        """Take an error with its bound, and where it is."""
        self.comparison.of(name).add(error, bound, f"{self.at} {at}".strip())


def relative(exact: Number, other: Number) -> float:
    """Return |other − exact| / exact, infinite beside zero."""
    if exact == other:
        return 0.0
    return float(abs(other - exact) / exact) if exact != 0 else float("inf")
