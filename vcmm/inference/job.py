"""Measured data to statements about the part: what was measured, what is true, and whether it conforms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import DataError, choose_from
from vcmm.core.run import Array
from vcmm.evaluation.checks import remarks
from vcmm.evaluation.indication import at_indication
from vcmm.evaluation.result import CharacteristicResult, TrueValue, UncertaintyResult
from vcmm.evaluation.sampling import Progress
from vcmm.evaluation.uncertainty import evaluate
from vcmm.gps import characteristics as gps
from vcmm.gps.criteria import POINTS, wanted
from vcmm.gps.decision import Decision, decide, undecided
from vcmm.inference.belts import Inverse, coverage, inverse_of
from vcmm.inference.checked import repeated
from vcmm.inference.form_family import KNOWN, OTHER
from vcmm.inference.given import GivenPoints, GivenValue
from vcmm.inference.pairs import MOST, Drawing, both, pairs, prepared, rest_of
from vcmm.inference.points import measured_task
from vcmm.measuring.scenario import Scenario
from vcmm.measuring.settings import Settings
from vcmm.measuring.task import Task, evaluate_all, fit_features, measured_points
from vcmm.part.part import Characteristic

PARTS, COUNTED = 24_000, 2000  # drawn for the belts; drawn anew to count
FEWER = 8000  # where elements by contact are searched in every one of them
FIXED = (0.0, 20.0)  # form over noise: perfect parts and coarse ones are counted by themselves
LEAST, LEAST_OTHER = 0.93, 0.90  # least coverage for p = 95 % of parts of the family, and of another one
NEAR = (
    1.0  # mm between touches of two parts that share an evaluation: errors of machines change over tens of mm
)


@dataclass(frozen=True, eq=False)
class Evaluated:
    """One characteristic of one measured part. measured: as handed in or as the points give it, mm or rad.

    true: of an extreme value; counted: share of drawn parts whose true value lay in their interval, of the family and of another one.
    """

    result: CharacteristicResult
    measured: float
    true: TrueValue | None
    counted: tuple[float, float] | None = None

    @property
    def unit(self) -> str:
        return self.result.unit


@dataclass(frozen=True, eq=False)
class EvaluatedPart:
    """All characteristics of one part; uncertainty: the evaluation behind them; task: where the machine stood."""

    part: str
    characteristics: tuple[Evaluated, ...]
    uncertainty: UncertaintyResult
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class PreparedTask:
    """What does not depend on the measured numbers: the evaluation of a task, and the inverses of its extreme values."""

    task: Task
    result: UncertaintyResult
    drawing: Drawing | None
    inverses: dict[int, CountedInverse]
    most: float

    def serves(self, task: Task, measured: Array) -> bool:
        """Whether another part was touched at the same places (within NEAR) and is no rougher than what was drawn."""
        mine, other = self.task.touches, task.touches
        if list(mine.rows) != list(other.rows) or mine.points.shape != other.points.shape:
            return False
        if (
            np.abs(mine.points - other.points).max() > NEAR
            or np.abs(mine.pose.shift - other.pose.shift).max() > NEAR
        ):
            return False
        return self.drawing is None or _most(self.drawing, measured, list(self.inverses)) <= self.most


def known_of(
    task: Task, settings: Settings, measured: Array | None, progress: Progress | None = None
) -> PreparedTask:
    """Evaluate a task, and draw the parts that its extreme values are read with. measured (C,): what was found, if anything."""
    result = evaluate(task, settings, progress)
    extreme = [i for i, r in enumerate(result.characteristics) if r.extreme]
    if not extreme:
        return PreparedTask(task, result, None, {}, MOST)
    drawing = prepared(task, settings.seed)
    found = np.array([r.indicated for r in result.characteristics]) if measured is None else measured
    most = _most(drawing, found, extreme)
    return PreparedTask(
        task, result, drawing, inverses(drawing, extreme, settings.p, settings.seed, most), most
    )


def evaluate_points(
    scenario: Scenario,
    given: Sequence[GivenPoints],
    *,
    in_machine: bool = False,
    tip_centres: bool = False,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> tuple[EvaluatedPart, ...]:
    """Measured points of one or several parts. DataError for points that are not those of the part (see `checked`)."""
    chosen, report = settings or scenario.settings, progress or (lambda text, share: None)
    out: list[EvaluatedPart] = []
    known: PreparedTask | None = None
    for i, one in enumerate(given):
        report(f"part {one.part}" if one.part else "points", i / len(given))
        task = measured_task(scenario, one, in_machine, tip_centres)
        points = measured_points(task, task.machine.indication_error(task.touches.run))
        measured = np.asarray(evaluate_all(task, fit_features(task, points)))
        if known is None or not known.serves(task, measured):
            known = known_of(task, chosen, measured, progress)
        rest = None if known.drawing is None else rest_of(known.drawing, points)
        out.append(_part(scenario, one.part, known, measured, rest, settings=chosen, said=repeated(one)))
    return tuple(out)


def evaluate_values(
    scenario: Scenario,
    given: Sequence[Sequence[GivenValue]],
    *,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> tuple[EvaluatedPart, ...]:
    """Measured values of one or several parts: the points are those of the plan. DataError: unknown or wrong kind of value."""
    chosen = settings or scenario.settings
    task = scenario.task()
    return tuple(_valued(scenario, task, values, chosen, progress) for values in given)


def _valued(
    scenario: Scenario,
    task: Task,
    values: Sequence[GivenValue],
    settings: Settings,
    progress: Progress | None,
) -> EvaluatedPart:
    """The characteristics that were handed in, each at its value."""
    measured = absolute_values(scenario, values)
    wanted = [c for c in scenario.part.characteristics if c.name in measured]
    asked = replace(task, part=replace(task.part, characteristics=tuple(wanted)))
    y = np.array([measured[c.name] for c in wanted])
    return _part(scenario, values[0].part, known_of(asked, settings, y, progress), y, None, settings)


def absolute_values(scenario: Scenario, values: Sequence[GivenValue]) -> dict[str, float]:
    """Characteristic -> mm or rad. DataError: an unknown name, an angle in mm, a value no such characteristic can have."""
    known = {c.name: c for c in scenario.part.characteristics}
    out, problems = {}, []
    for v in values:
        c = known.get(v.name)
        if c is None:
            problems.append(
                f'{v.where}: the part has no characteristic "{v.name}".{choose_from(v.name, known)}'
            )
            continue
        angle = gps.unit(c) == "rad"
        if angle != v.angle:
            due = "an angle: name the column value_deg" if angle else "a length: name the column value_mm"
            problems.append(f'{v.where}: "{c.name}" is {due}')
            continue
        nominal = gps.nominal(c, scenario.part.features)
        out[c.name] = v.number + (nominal if v.deviation else 0.0)
        wrong = _implausible(c, nominal, out[c.name], v)
        problems += [f"{v.where}: {wrong}"] if wrong else []
    if problems:
        raise DataError(problems)
    return out


def _implausible(c: Characteristic, nominal: float, value: float, given: GivenValue) -> str:
    """Why a number cannot be meant: a negative form, a deviation written as a value, another unit."""
    if gps.one_sided(c):
        return f'"{c.name}": {c.type} is never negative' if value < 0 else ""
    if abs(value - nominal) <= 0.1 * max(abs(nominal), 1.0):
        return ""
    if not given.deviation and abs(value) < 0.1 * nominal:
        return (
            f'"{c.name}" = {given.number:g} is far from its nominal {nominal:g}; for a deviation from nominal name the column '
            "deviation_um (deviation_mm)"
        )
    return f'"{c.name}" = {value:g} is more than a tenth off its nominal {nominal:g}; check the unit in the column name'


def _part(
    scenario: Scenario,
    name: str,
    known: PreparedTask,
    measured: Array,
    rest: Array | None,
    settings: Settings,
    said: Sequence[str] = (),
) -> EvaluatedPart:
    out = []
    for i, r in enumerate(known.result.characteristics):
        y, one = float(measured[i]), known.inverses.get(i)
        if one is None:
            out.append(Evaluated(at_indication(r, y, settings.rule), y, None))
        else:
            out.append(_inverted(r, y, one, None if rest is None else float(rest[i]), settings))
    warnings = tuple(
        w
        for w in (*remarks(scenario), *known.result.warnings, *said)
        if "classic virtual-CMM recipe" not in w
        and "its coverage is not shown" not in w  # said below of what was measured
    )
    return EvaluatedPart(name, tuple(out), known.result, (*warnings, *_not_claimed(out)))


def _not_claimed(found: Sequence[Evaluated]) -> list[str]:
    return [
        f"{e.result.name}: the interval of the true value held it in {e.counted[0]:.0%} of drawn parts and in "
        f"{e.counted[1]:.0%} of parts of another kind; its coverage is not claimed. More points would help"
        for e in found
        if e.true and e.counted and not e.true.claimed
    ]


@dataclass(frozen=True, eq=False)
class CountedInverse:
    """The inverse of one characteristic with what was counted of it: parts of the family, parts of another one."""

    inverse: Inverse
    counted: tuple[float, float]

    def claimed(self, p: float) -> bool:
        """Whether enough of the drawn parts of both kinds had their true value in the interval for p."""
        return self.counted[0] >= p - (0.95 - LEAST) and self.counted[1] >= p - (0.95 - LEAST_OTHER)


def in_contact(task: Task) -> bool:
    """Whether a characteristic asks for elements by contact, which take a hundred times as long as least squares."""
    return any(set(asked) - {POINTS} for asked in wanted(task.part.characteristics).values())


def inverses(
    drawing: Drawing, numbers: Sequence[int], p: float, seed: int, most: float = MOST
) -> dict[int, CountedInverse]:
    """Belts of some characteristics, each counted on parts that were not used for it."""
    count = (FEWER if in_contact(drawing.task) else PARTS) // len(KNOWN)
    made = [pairs(drawing, count, seed, family, most=most) for family in KNOWN]
    anew = [pairs(drawing, COUNTED // len(KNOWN), seed + 1, family, most=most) for family in KNOWN]
    anew += [both(drawing, COUNTED, seed + 3 + k, ratio=ratio) for k, ratio in enumerate(FIXED)]
    other = pairs(drawing, COUNTED, seed + 2, OTHER, most=most)
    out = {}
    for i in numbers:
        inverse = inverse_of(drawing.task.part.characteristics[i], i, made)
        out[i] = CountedInverse(
            inverse, (min(coverage(inverse, i, one, p) for one in anew), coverage(inverse, i, other, p))
        )
    return out


def _most(drawing: Drawing, measured: Array, extreme: Sequence[int]) -> float:
    """Largest form over noise that is drawn: well beyond what was measured."""
    bounded = [float(measured[i]) for i in extreme if drawing.task.part.characteristics[i].type != "size"]
    return max([MOST, *(3.0 * y / min(*drawing.noise.values(), drawing.attitude) for y in bounded)])


def _inverted(
    r: CharacteristicResult, y: float, one: CountedInverse, rest: float | None, settings: Settings
) -> Evaluated:
    """Interval and decision of an extreme value are those of the true one."""
    known = None if rest is None else np.array([rest])
    middle = float(one.inverse.estimate(np.array([y]), known)[0])
    low, high = (float(end[0]) for end in one.inverse.interval(r.p, np.array([y]), known))
    claimed = one.claimed(r.p)
    true = TrueValue(middle, (low, high), claimed)
    k = (high - low) / 2 / r.u if np.isfinite(r.u) and r.u > 0 else float("nan")
    why = "" if claimed else "the coverage of the interval about the true value was counted and is too small"
    changed = replace(
        r,
        value=y,
        indicated=y,
        interval=(low, high),
        coverage_shown=claimed,
        k=k,
        why_not_shown=why,
        half_width=None,
    )
    decided = replace(changed, decision=_decision(changed, true, one, rest, settings.rule), true_value=true)
    return Evaluated(decided, y, true, one.counted)


def _decision(
    r: CharacteristicResult, true: TrueValue, one: CountedInverse, rest: float | None, rule: str
) -> Decision | None:
    if r.tolerance is None:
        return None
    if not true.claimed:
        return undecided(rule, r.why_not_shown)
    low, high = r.tolerance
    p = one.inverse.within(-np.inf if r.one_sided else low, high, r.value, rest)
    half, where = (true.interval[1] - true.interval[0]) / 2, sum(true.interval) / 2
    return decide(where, r.tolerance, float(np.clip(p, 0, 1)), U=half, rule=rule, one_sided=r.one_sided)
