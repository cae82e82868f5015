"""What a selected answer cannot be told from: rivals within 3 nats, and those that mimic it within this noise.

separability s = share of the answer's signal (as length) that the rival cannot mimic, others projected out; a gap of
3 nats needs delta s of 2.45 (delta^2 s^2 / 2 = 3). Below that, and for exact aliases, the rival is named however its
prior stands. Names that hold the answer whatever is recorded (see nested) are no rivals while the answer suffices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.diagnosis.candidates import Family
from vcmm.diagnosis.evidence import Dictionary, Scorer, scorer
from vcmm.diagnosis.nested import generalises
from vcmm.diagnosis.select import MISMATCH, SIMPLER, Selection, Setting
from vcmm.run import Array

NATS = 3.0
ALIAS = 0.15
RESOLVED = 2.45  # delta s from which 3 nats separate two names


@dataclass(frozen=True, eq=False)
class Standing:
    """One answer among its rivals. evidence: nats against nothing; names: rivals; probability of the name."""

    evidence: float
    probability: float
    names: tuple[str, ...]
    families: tuple[int, ...]  # best family of each rival name


def standing(selection: Selection, setting: Setting, i: int, generic: Dictionary | None = None) -> Standing:
    """Compare term i with every family, given the other terms; with `generic` also with physics that has no name."""
    others = [t.white for j, t in enumerate(selection.terms) if j != i]
    given = scorer(setting.found, np.concatenate(others, axis=1) if others else None)
    options = given.options(selection.y[:, None])
    scores = given.families(options)[:, 0]
    own = setting.found.families.index(selection.terms[i].family)
    gap = separability(given, selection.signal(i))
    names, families, larger = _rivals(selection, setting, i, scores, gap, own)
    unknown = _unknown(generic, given, selection, own_arguments(selection.terms[i].family))
    return Standing(float(scores[own]), _probability(setting, scores, own, larger, unknown), names, families)


def own_arguments(family: Family) -> set[str]:
    """The covariate of a change of geometry or of a drift with a temperature: a freer curve over the same axis or the same
    thermometer is the same physics, better fitted.
    """
    if "sensor" in family.where:
        return {f"temp_{family.where['sensor']}"}
    axis = str(family.where.get("component", ""))[2:]
    return {axis, f"{axis} (periodic)"} if family.name in ("geometric_change", "map_interpolation") else set()


def _unknown(generic: Dictionary | None, given: Scorer, selection: Selection, own_axis: set[str]) -> float:
    """Nats of all shapes without physics together, but those over the term's own axis; they share the prior of one name."""
    if generic is None or not generic.families:
        return -np.inf
    own = scorer(generic, given.basis)
    scores = own.families(own.options(selection.y[:, None]))[:, 0]
    foreign = [s for s, f in zip(scores, generic.families) if f.name not in own_axis]
    return float(np.logaddexp.reduce(np.array([-np.inf, *foreign])))


def separability(given: Scorer, signal: Array) -> Array:
    """s (options,) of a white signal (m,) against every option."""
    basis = given.basis
    e = signal - basis @ (basis.T @ signal)
    b2 = (given.rotated.column.T @ e) ** 2
    whole = np.repeat(given.size, np.diff(np.append(given.rotated.start, len(b2))))
    firm = given.rotated.size > 1e-6 * whole
    share = np.add.reduceat(
        np.where(firm, b2 / np.where(firm, given.rotated.size, 1.0), 0.0), given.rotated.start
    )
    return np.sqrt(np.clip(1.0 - share / max(float(e @ e), 1e-300), 0.0, 1.0))


def _rivals(
    selection: Selection, setting: Setting, i: int, scores: Array, gap: Array, own: int
) -> tuple[tuple[str, ...], tuple[int, ...], set[str]]:
    """Names and best families of the rivals, and the names that hold this answer as a special case."""
    found, term = setting.found, selection.terms[i]
    nearest = np.minimum.reduceat(gap, found.first)  # best mimic of each family
    unresolved = max(RESOLVED / max(selection.delta(i), 1e-300), MISMATCH)
    best: dict[str, int] = {}
    holding: set[str] = set()
    for j in np.argsort(-scores, kind="stable"):
        family = found.families[j]
        if family.name == term.family.name or family.name in best:
            continue
        if generalises(family.name, term.family.name):
            mimic = int(found.first[j] + np.argmin(gap[found.first[j] : _stop(setting, int(j))]))
            larger = found.options[mimic].freedom > term.option.freedom
            if larger and nearest[j] < ALIAS and scores[j] <= scores[own] + SIMPLER:
                holding.add(family.name)  # the simpler one stands
                continue
        if scores[j] > scores[own] - NATS or nearest[j] < unresolved:
            best[family.name] = int(j)
    return tuple(best), tuple(best.values()), holding - set(best)


def _stop(setting: Setting, family: int) -> int:
    first = setting.found.first
    return int(first[family + 1]) if family + 1 < len(first) else len(setting.found.options)


def _probability(
    setting: Setting, scores: Array, own: int, larger: set[str], unknown: float = -np.inf
) -> float:
    """Posterior of the name among all names, the unknown (one more name) and nothing.

    Nothing has the prior weight of all names together.

    Names that hold the answer as a special case do not count against it.
    """
    names = [f.name for f in setting.found.families]
    count = len(set(names))
    kept = np.array([s for s, name in zip(scores, names) if name not in larger])
    total = float(np.logaddexp.reduce(np.append(kept, [np.log(count), unknown])))
    mine = [s for s, name in zip(scores, names) if name == names[own]]
    return float(np.exp(np.logaddexp.reduce(np.array(mine)) - total))
