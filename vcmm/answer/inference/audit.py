"""Audit the intervals: sample parts and machines from the stated knowledge, measure them, evaluate, and count.

A size, distance or angle is sampled with the exact engine (transforms multiplied, contact found, fits iterated) on parts as the
scenario states them. Extreme values are counted on parts with forms: over the whole prior, at fixed sizes of the form (so many
times the noise of the machine), and on parts of another family, which the inverse does not know. Then all of them are counted as users
evaluate them, from points to results (`audit_by_points`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from vcmm.answer.evaluation.belts import Reading, UnitedInverse, coverage, parts_with_element
from vcmm.answer.evaluation.exact import draw_inputs, exact_values
from vcmm.answer.evaluation.form_family import OTHER
from vcmm.answer.evaluation.indication import at_indication
from vcmm.answer.evaluation.inversion import (
    LEAST_COVERAGE,
    LEAST_OTHER_COVERAGE,
    CountedInverse,
    Inversion,
    NoInverse,
    TrueValueByBelt,
)
from vcmm.answer.evaluation.pairs import UNIT, Pairs, both, pairs
from vcmm.answer.evaluation.result import CharacteristicResult
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.inference.audit_by_points import (
    IN_WORDS,
    HeldByPoints,
    count_by_points,
    why_not_by_points,
)
from vcmm.answer.inference.job import PreparedTask
from vcmm.answer.inference.oracle import IntervalLengths, lengths
from vcmm.core.blocks import Progress, Sharing, blocks_of
from vcmm.core.run import Array
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.task import Task

PARTS = 2000
RATIOS = (0.0, 2.0, 6.0, 20.0)  # form over noise of the machine
STATED, PRIOR, ANOTHER = "stated knowledge", "prior over forms", "another family of forms"
BLOCK = 250
CERTAIN = 0.025  # of a count to lie as far outside by chance: one end of a 95 % interval
BAND = 0.02  # either side of the target
# over the prior of forms: an interval that holds each of two families holds more of both together
ABOVE = 0.04


@dataclass(frozen=True)
class AuditResult:
    """Coverage of the intervals of one characteristic. width: mean over the parts, mm or rad.

    oracle: mean width, over the prior, of an oracle that knows the family of every part, oracle_held: its coverage (`vcmm.answer.inference.oracle`).
    claimed: the result states that the coverage of the interval is shown, why: why it does not; least, most: the band that it is held to.
    """

    name: str
    unit: str
    kind: str
    target: float
    attained: float
    parts: int
    width: float
    claimed: bool
    least: float
    most: float
    why: str = ""
    oracle: float | None = None
    oracle_held: float | None = None

    @property
    def interval95(self) -> tuple[float, float]:
        """Interval of the attained share, from the finite number of parts (Wilson score)."""
        return wilson(self.attained, self.parts)

    @property
    def p_value(self) -> float:
        """Probability of a count as far or further out, if the coverage were at the end of the band: 1 inside (exact binomial test)."""
        from scipy.special import betainc, betaincc  # the binomial sums; scipy.stats takes a second to import

        covering, n = round(self.attained * self.parts), self.parts
        if self.attained < self.least:
            return float(betaincc(covering + 1, n - covering, self.least))
        return float(betainc(covering, n - covering + 1, self.most)) if self.attained > self.most else 1.0

    @property
    def outside(self) -> bool:
        """Whether the coverage is claimed, and outside the band by more than the count may err."""
        return self.claimed and self.p_value < CERTAIN


def wilson(share: float, count: int, z: float = 1.959964) -> tuple[float, float]:
    """Return the score interval of a binomial share (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209)."""
    middle = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    return min(max(middle - half, 0.0), share), max(min(middle + half, 1.0), share)


def audit(
    scenario: Scenario,
    *,
    parts: int = PARTS,
    settings: Settings | None = None,
    progress: Progress | None = None,
    sharing: Sharing | None = None,
    key: str = "",
) -> tuple[AuditResult, ...]:
    """Count the intervals of every characteristic of a scenario. Raises what `uncertainty` raises.

    sharing: who counts; key: of the job by all that it reads, where finished blocks are kept (`vcmm.core.blocks.key_of`).
    """
    return audit_task(
        scenario.task(), settings or scenario.settings, parts,
        progress=progress, sharing=sharing, key=key, scenario=scenario,
    )  # fmt: skip


Piece = tuple[int, int]  # exact measurements: first and count; parts of a kind: its number and 0; BY_POINTS
BY_POINTS: Piece = (-1, 0)


@dataclass(frozen=True, eq=False)
class CountingJob:
    """Input of a worker that counts: the evaluated task, and the number of parts of a kind."""

    task: PreparedTask
    parts: int
    scenario: Scenario | None = None


def audit_task(
    task: Task,
    settings: Settings,
    parts: int,
    progress: Progress | None = None,
    sharing: Sharing | None = None,
    key: str = "",
    scenario: Scenario | None = None,
) -> tuple[AuditResult, ...]:
    """Audit a task. scenario: whose points are evaluated, None: they are not."""
    report = progress or (lambda text, share: None)
    prepared = PreparedTask(task, evaluate(task, settings, progress, read=False))
    extreme = [
        i for i, c in enumerate(prepared.result.characteristics) if isinstance(c.truth, TrueValueByBelt)
    ]
    additive = [i for i in range(len(prepared.result.characteristics)) if i not in extreme]
    exact: list[Piece] = blocks_of(parts, BLOCK) if additive else []
    kinds: list[Piece] = [(number, 0) for number in range(len(RATIOS) + 2)] if extreme else []
    door: list[Piece] = [BY_POINTS] if scenario is not None and not why_not_by_points(scenario) else []
    blocks = (sharing or Sharing()).map_items(
        key,
        piece,
        CountingJob(prepared, parts, scenario),
        [*exact, *kinds, *door],
        partial(report, "drawn parts"),
    )
    rows: dict[int, list[AuditResult]] = {i: [] for i in range(len(prepared.result.characteristics))}
    if additive:
        indicated = np.concatenate([np.array(block) for block in blocks[: len(exact)]])
        for i, row in _held_exactly(prepared, additive, indicated):
            rows[i].append(row)
    for counted in blocks[len(exact) : len(exact) + len(kinds)]:
        for i, row in zip(extreme, counted):
            rows[i].append(AuditResult(**row))
    for row in blocks[-1] if door else ():
        held_by_points = HeldByPoints(**row)
        rows[held_by_points.i].append(
            _by_points(prepared.result.characteristics[held_by_points.i], held_by_points)
        )
    return tuple(row for results in rows.values() for row in results)


def piece(job: CountingJob, block: Sequence[int]) -> list[Any]:
    """Compute one block of an audit, on any worker: indicated values (count, C), or the counts of one kind of part as plain values."""
    first, count = block
    if (first, count) == BY_POINTS:
        assert job.scenario is not None
        settings = replace(job.scenario.settings, seed=job.task.result.seed)
        return [asdict(counts) for counts in count_by_points(job.scenario, settings, job.parts)]
    model, inversion = job.task.result.model, job.task.inversion
    if count or inversion is None:
        drawn = draw_inputs(model, job.task.result.seed + 1000, first, count)
        return list(exact_values(model, drawn).tolist())
    kind, drawn_parts = _kind(inversion, first, job.parts)
    results = job.task.result.characteristics
    extreme = [i for i, c in enumerate(results) if isinstance(c.truth, TrueValueByBelt)]
    return [asdict(_count_held(results[i], inversion, i, drawn_parts, kind)) for i in extreme]


def _kind(inversion: Inversion, number: int, parts: int) -> tuple[str, Pairs]:
    """Return parts that were used neither for the belts nor for their counted coverage."""
    drawing, fresh = inversion.drawing, inversion.settings.seed + 1000
    if number == 0:
        return PRIOR, both(drawing, parts, fresh)
    if number > len(RATIOS):
        return ANOTHER, pairs(drawing, parts, fresh + 9, OTHER)
    ratio = RATIOS[number - 1]
    return fixed_form_in_words(drawing.bound, ratio), both(drawing, parts, fresh + number, ratio=ratio)


def fixed_form_in_words(bound: bool, ratio: float) -> str:
    """Describe parts whose forms are all of one size: standard deviations of the noise of the machine, um where only a limit is known."""
    if ratio == 0.0:
        return "parts without form"
    return (
        f"forms of {1e3 * UNIT * ratio:.3g} um"
        if bound
        else f"forms {ratio:g} times the noise of the machine"
    )


def _by_points(result: CharacteristicResult, held_by_points: HeldByPoints) -> AuditResult:
    """Return the counts by points: claimed intervals are counted; where none was claimed, all are, without a verdict."""
    other, p, counted = (
        IN_WORDS[OTHER] in held_by_points.kind,
        result.p,
        held_by_points.claimed or held_by_points.parts,
    )
    return AuditResult(
        name=result.name, unit=result.unit, kind=held_by_points.kind, target=p, attained=held_by_points.covering / max(counted, 1),
        parts=counted, width=held_by_points.width, claimed=held_by_points.claimed > 0, least=p - (0.95 - LEAST_OTHER_COVERAGE) if other else p - BAND,
        most=1.0, why="" if held_by_points.claimed else held_by_points.why,
    )  # fmt: skip


def _count_held(
    result: CharacteristicResult, inversion: Inversion, i: int, drawn: Pairs, kind: str
) -> AuditResult:
    """Count parts measured by points, whose residuals show the roughness of every part."""
    p, inverse, k = result.p, inversion.inverse(i, 0.0, 0.0), inversion.column(i)
    share, width, parts = 1.0, math.inf, len(drawn.true)  # of an interval without ends
    best: IntervalLengths | None = None
    if isinstance(inverse, CountedInverse):
        best = beside_oracle(inversion, i, drawn) if kind == PRIOR else None
        share, width = coverage(inverse.inverse, k, drawn, p), _width(inverse.inverse, k, drawn, p)
        parts = len(parts_with_element(k, drawn)[0])
    why = inverse.shortfall(p)
    least = {PRIOR: p - BAND, ANOTHER: p - (0.95 - LEAST_OTHER_COVERAGE)}.get(
        kind, p - (0.95 - LEAST_COVERAGE)
    )
    return AuditResult(
        name=result.name, unit=result.unit, kind=kind, target=p, attained=share, parts=parts, width=width,
        claimed=not why, least=least, most=p + ABOVE if kind == PRIOR and not _wider(inverse) else 1.0, why=why,
        oracle=best.oracle if best else None, oracle_held=best.oracle_held if best else None,
    )  # fmt: skip


def _wider(inverse: CountedInverse | NoInverse) -> bool:
    """Return whether the interval also holds the results of better machines than those counted here (`vcmm.answer.evaluation.bound_shares`)."""
    return isinstance(inverse, CountedInverse) and isinstance(inverse.inverse, UnitedInverse)


def beside_oracle(inversion: Inversion, i: int, drawn: Pairs) -> IntervalLengths | None:
    """Compare with the oracle characteristic i, for parts over the prior, one family after the other; None where parts have no such element."""
    inverse, k = inversion.inverse(i, 0.0, 0.0), inversion.column(i)
    if not isinstance(inverse, CountedInverse):
        return None
    of_task = inversion.draw_parts(i)
    families = [pairs.of(of_task.column(i)) for pairs in of_task.own_families]
    each = np.array_split(np.arange(len(drawn.true)), len(families))
    fresh = [drawn.of(k, rows) for rows in each]
    return lengths(inversion.characteristic(i), 0, inverse.inverse, families, fresh, inversion.settings.p)


def _width(inverse: Reading, k: int, drawn: Pairs, p: float) -> float:
    _, indicated, rest = parts_with_element(k, drawn)
    low, high = inverse.interval(p, indicated, rest)
    return float((high - low).mean())


def _held_exactly(
    prepared: PreparedTask, wanted: Sequence[int], indicated: Array
) -> list[tuple[int, AuditResult]]:
    """Count sizes, distances and angles: y of the exact engine (N, C), the interval at y, and the true value of the part."""
    model = prepared.result.model
    truth = model.at_estimates - np.array([r.bias for r in prepared.result.characteristics])
    return [
        (i, _shift_interval(prepared.result.characteristics[i], indicated[:, i], float(truth[i])))
        for i in wanted
    ]


def _shift_interval(result: CharacteristicResult, indicated: Array, truth: float) -> AuditResult:
    """Shift the interval with the indicated value: its ends at one value serve all."""
    p, rule = result.p, "probability 95 %"
    low, high = (end - result.indicated for end in at_indication(result, result.indicated, rule).interval)
    inside = (indicated + low <= truth) & (truth <= indicated + high)
    return AuditResult(
        name=result.name, unit=result.unit, kind=STATED, target=p, attained=float(inside.mean()), parts=len(indicated),
        width=high - low, claimed=result.coverage_shown, least=p - BAND, most=p + BAND, why=result.why_not_shown,
    )  # fmt: skip
