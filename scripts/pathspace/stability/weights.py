"""Heuristics of multiple importance sampling (Veach 1997, §9.2), of densities of any magnitude."""

from dataclasses import dataclass
from typing import Any

import mpmath as mp
import numpy as np

from .geometry import FACTOR, UNIT, ZERO, Number

Share = tuple[Number, Number]
"""Least and largest weight that rounding may make: the same but where a choice is at a tie."""


@dataclass(frozen=True)
class Competitor:
    """A technique that can draw the path."""

    n: int
    """Its samples that serve a pixel."""
    density: Number
    cumulated: float
    """Error of its density [u], all factors but those that it shares with its neighbours."""
    emitter: float
    """Error of the factors from the emitter's side [u]."""
    sensor: float
    """Error of those from the sensor's side [u]."""

    @property
    def share(self) -> Number:
        """n p."""
        return self.n * self.density


def differences(competitors: list[Competitor]) -> np.ndarray:
    """Return the error of every ratio p_j / p_i [u].

    Two techniques have the factors of their shorter walks in common, from either end; what they do
    not share is what one of them has and the other has not.
    """
    emitter = np.array([c.emitter for c in competitors])
    sensor = np.array([c.sensor for c in competitors])
    with np.errstate(invalid="ignore"):
        apart = np.abs(emitter[:, None] - emitter) + np.abs(sensor[:, None] - sensor)
    own = np.array([c.cumulated for c in competitors])
    return np.nan_to_num(apart, nan=np.inf) + own[:, None] + own


def weights(heuristic: dict[str, Any], competitors: list[Competitor]) -> list[Share]:
    """Return the weights of all techniques."""
    shares = [c.share for c in competitors]
    kind = heuristic["kind"]
    if kind in ("balance", "power"):
        exponent = mp.mpf(heuristic.get("exponent", 1))
        powers = [share**exponent for share in shares]
        total = mp.fsum(powers)
        return [(power / total,) * 2 for power in powers]
    error = differences(competitors) * float(UNIT)
    largest = max(range(len(shares)), key=lambda i: shares[i])
    least = ZERO if kind == "maximum" else mp.mpf(heuristic["threshold"])
    if kind == "maximum":
        # All to the first of the largest; where two are as large as rounding can tell, to either.
        near = [
            share >= shares[largest] * (1 - mp.mpf(error[i, largest]))
            for i, share in enumerate(shares)
        ]
        alone = sum(near) == 1
        return [(mp.mpf(int(is_near and alone)), mp.mpf(int(is_near))) for is_near in near]
    limit = least * shares[largest]
    surely = [s >= limit * (1 + mp.mpf(error[i, largest])) for i, s in enumerate(shares)]
    perhaps = [s >= limit * (1 - mp.mpf(error[i, largest])) for i, s in enumerate(shares)]
    few = mp.fsum(s for s, taken in zip(shares, surely, strict=True) if taken)
    many = mp.fsum(s for s, taken in zip(shares, perhaps, strict=True) if taken)
    return [
        (
            shares[i] / many if surely[i] else ZERO,
            shares[i] / (few if surely[i] else few + shares[i]) if perhaps[i] else ZERO,
        )
        for i in range(len(shares))
    ]


def errors(
    heuristic: dict[str, Any], competitors: list[Competitor], values: list[Number]
) -> np.ndarray:
    """Return the largest relative error of each weight.

    With r_j = n_j p_j / (n_i p_i), w_i = 1 / Σ r_j^β: its error is the mean of β times those of the
    r_j, by the weights w_j, and one of each term of the sum.
    """
    exponent = float(heuristic.get("exponent", 1))
    apart = differences(competitors)
    np.fill_diagonal(apart, 0.0)
    by = np.array([float(value) for value in values])
    with np.errstate(invalid="ignore"):
        spread = np.where(by[None, :] > 0, apart * by[None, :], 0.0).sum(axis=1)
    return (exponent * (spread + FACTOR) + len(by)) * float(UNIT)
