"""Free shapes over everything that a recording knows, as white columns, and how strongly a residual follows each.

    t = |X^T r|^2,   X: bumps about places, white, outside some chosen terms;   r: white residual

is the score of a Gaussian process with the kernel X X^T (a variance component; Lin, Biometrika 84 (1997) 309). It needs no
shape: a stair, a swirl or a waviness of changing period raise it alike. Its law is that of the simulated null recordings:
z is ln t in standard deviations of theirs.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.diagnosis.closeness import nearness, of_component
from vcmm.diagnosis.locate import modulators
from vcmm.diagnosis.problem import Problem
from vcmm.diagnosis.select import Term
from vcmm.gaussian import Whitener, without_span
from vcmm.run import Array

VANISHED = 1e-3  # share of the length of the bumps that must survive nuisance, calibration and terms


@dataclass(frozen=True, eq=False)
class Kernel:
    """White bumps (m, k) outside the chosen terms. names: covariates; direction: "x", "y", "z" or "normal"; component: of a
    free shape over its axis, or "".
    """

    names: tuple[str, ...]
    direction: str
    white: Array
    component: str = ""


@dataclass(frozen=True, eq=False)
class Asked:
    """One question: kernels that are added, the clearest of them, t and z of the residual and of every null (1 + M,)."""

    kernels: tuple[Kernel, ...]
    clearest: Kernel
    t: Array
    z: Array

    @property
    def white(self) -> Array:
        """All bumps (m, k) of the question."""
        return np.concatenate([k.white for k in self.kernels], axis=1)


def of_components(
    problem: Problem, components: Iterable[str], white: Whitener, basis: Array
) -> Iterator[list[Kernel]]:
    """Free shapes of component errors over their axes."""
    for c in (c for c in components if np.ptp(problem.run.q(c[2])) > 0):
        for moved in of_component(problem, c):
            x = without_span(white.apply(moved), basis)
            if _seen(x, moved, white):
                yield [Kernel((c[2],), "normal", x, c)]


def everywhere(problem: Problem, white: Whitener, basis: Array) -> Iterator[list[Kernel]]:
    """Groups of kernels that differ by their direction only."""
    factors = modulators(problem)
    for near in nearness(problem):
        k = near.bumps.shape[1]
        columns = np.concatenate([near.bumps * f[:, None] for f in factors.values()], axis=1)
        x = without_span(white.apply(columns), basis)
        parts = [(d, slice(i * k, (i + 1) * k)) for i, d in enumerate(factors)]
        yield [Kernel(near.names, d, x[:, at]) for d, at in parts if _seen(x[:, at], columns[:, at], white)]


def _seen(x: Array, columns: Array, white: Whitener) -> bool:
    return float(np.linalg.norm(x)) > VANISHED * float(np.linalg.norm((white.weight * columns.T).T))


def questions(groups: Iterable[list[Kernel]], rows: Array) -> Iterator[Asked]:
    """Every kernel by itself, and those of x, y and z together: a swirl turns. rows (m, 1 + M): residual, nulls; length 1."""
    rows = rows.astype(np.float32)
    return itertools.chain.from_iterable(_of_group(group, rows) for group in groups)


def _of_group(group: list[Kernel], rows: Array) -> Iterator[Asked]:
    alone = [Asked((k,), k, t, departed(t)) for k in group for t in (_score(k.white, rows),)]
    yield from alone
    turned = [a for a in alone if a.clearest.direction in tuple("xyz")]
    if len(turned) > 1:
        total = np.sum([a.t for a in turned], axis=0)
        clearest = max(turned, key=lambda a: float(a.z[0])).clearest
        yield Asked(tuple(a.clearest for a in turned), clearest, total, departed(total))


def _score(white: Array, rows: Array) -> Array:
    return np.asarray(((white.astype(np.float32).T @ rows) ** 2).sum(axis=0), dtype=float)


def departed(t: Array, forgiven: float = 0.0) -> Array:
    """z (1 + M,) of t; `forgiven` is taken off the residual's own, the first: what errors of templates may bring."""
    own = max(float(np.sqrt(t[0]) - np.sqrt(forgiven)), 1e-12) ** 2
    logs = np.log(np.maximum(np.r_[own, t[1:]], 1e-30))
    return np.asarray((logs - logs[1:].mean()) / max(float(logs[1:].std()), 1e-12))


def reach(x: Array) -> float:
    """Largest of |X^T e|^2 over unit vectors e."""
    small = x.T @ x if x.shape[1] < len(x) else x @ x.T
    return float(np.linalg.eigvalsh(small)[-1])


def principal(x: Array, count: int) -> Array:
    """The first principal functions (m, count at most) of bumps x (m, k), the first of rms 1."""
    value, vector = np.linalg.eigh(x.T @ x)
    first = np.argsort(-value)[:count]
    return np.asarray(x @ vector[:, first] * np.sqrt(len(x) / max(float(value[first[0]]), 1e-300)))


def components_of(terms: Sequence[Term]) -> tuple[str, ...]:
    """The component errors in which terms move their axes: of their places, or the positioning errors of their axes."""
    found = {c for t in terms for c in (t.family.where.get("component", ""), _positioning(t))}
    return tuple(sorted(c for c in found if len(c) == 3 and c[0] == "E" and c[2] in "XYZ"))


def _positioning(term: Term) -> str:
    axis = term.family.where.get("axis", "")
    return f"E{axis}{axis}"
