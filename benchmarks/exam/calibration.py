"""Block K: how often a stated probability is right, over every name that was answered; and what chance alone would give.

calibration error = sum over bins of (answers in the bin / all answers) |mean stated - share right|. Its mean over answers
that are right exactly as often as stated is not zero in a small sample, so that value and its 95 % point are given beside it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.exam.score import STALE, bound

EDGES = (0.0, 0.5, 0.8, 0.95, 0.99, 1.0 + 1e-9)


@dataclass(frozen=True)
class Claim:
    """One name that was answered: the probability stated, and whether it is right."""

    stated: float
    right: bool
    block: str


def claims(rows: Iterable[Mapping[str, Any]]) -> list[Claim]:
    """Names of nulls and of physics without a name are wrong; in C the names of a changed geometry are right; a name in D
    is right when it is either of the two; a mistake of the table has to be exact."""
    out = []
    for r in rows:
        if r.get("error"):
            continue
        good = {n for c in r["concealed"] for n in (c["effect"], *c["counts_too"])}
        good = STALE if r["block"] == "C" else set() if r["block"] in "BE" else good
        for name, p in zip(r["answered"], r["probabilities"]):
            if p is not None:
                right = bool(r.get("right")) if name == "map_mistake" else name in good
                out.append(Claim(float(p), right and r["block"] not in "BE", r["block"]))
    return out


@dataclass(frozen=True)
class Bin:
    low: float
    high: float
    n: int
    stated: float
    hits: int

    @property
    def interval(self) -> tuple[float, float]:
        """Two-sided 95 % interval of the share (Clopper and Pearson)."""
        from scipy.stats import beta

        low = 0.0 if self.hits == 0 else float(beta.ppf(0.025, self.hits, self.n - self.hits + 1))
        high = 1.0 if self.hits == self.n else float(beta.ppf(0.975, self.hits + 1, self.n - self.hits))
        return low, high


def bins(found: Sequence[Claim], edges: Sequence[float] = EDGES) -> list[Bin]:
    out = []
    for low, high in itertools.pairwise(edges):
        mine = [c for c in found if low <= c.stated < high]
        if mine:
            mean = float(np.mean([c.stated for c in mine]))
            out.append(Bin(low, min(high, 1.0), len(mine), mean, sum(c.right for c in mine)))
    return out


def error_of(found: Sequence[Bin]) -> float:
    n = sum(b.n for b in found)
    return sum(abs(b.stated * b.n - b.hits) for b in found) / n if n else 0.0


def by_chance(found: Sequence[Claim], draws: int = 2000) -> tuple[float, float]:
    """Mean and 95 % point of the calibration error of answers that are right as often as they say."""
    rng = np.random.default_rng(20)
    p = np.array([c.stated for c in found])
    errors = []
    for _ in range(draws):
        right = rng.random(len(p)) < p
        errors.append(error_of(bins([Claim(float(q), bool(r), "") for q, r in zip(p, right)])))
    return float(np.mean(errors)), float(np.quantile(errors, 0.95))


def table(found: Sequence[Claim]) -> list[list[str]]:
    """Rows: stated, answers, mean stated, right, 95 % interval."""
    out = []
    for b in bins(found):
        low, high = b.interval
        out.append([f"{b.low:.2f} to {b.high:.2f}", str(b.n), f"{b.stated:.3f}", f"{b.hits / b.n:.2f}", f"{low:.2f} to {high:.2f}"])  # fmt: skip
    return out


def sure(found: Sequence[Claim], level: float = 0.99) -> tuple[int, int, float]:
    """Right, all, and the one-sided bound of claims of at least `level`."""
    mine = [c for c in found if c.stated >= level]
    hits = sum(c.right for c in mine)
    return hits, len(mine), bound(hits, len(mine), lower=True)
