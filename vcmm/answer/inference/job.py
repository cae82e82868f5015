"""Evaluate measured data: measured values, true values, and conformity of the part."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from vcmm.answer.evaluation.checks import remarks
from vcmm.answer.evaluation.indication import at_indication
from vcmm.answer.evaluation.inversion import Inversion, TrueValueByBelt
from vcmm.answer.evaluation.jointly import JointJudgement, judged_jointly
from vcmm.answer.evaluation.one_line import answer, first_few, of_name
from vcmm.answer.evaluation.pairs import rest_of
from vcmm.answer.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.answer.evaluation.uncertainty import evaluate, warnings_of
from vcmm.answer.inference.bends import bend_ranges, with_bends
from vcmm.answer.inference.between_points import FeatureForms, FormTold, forms_of, told_by
from vcmm.answer.inference.doubts import LARGEST, coarse_mesh, doubts_of, outward, without_claim
from vcmm.answer.inference.form_between_points import UNSEEN, is_moved_by_form, with_form
from vcmm.answer.inference.given_points import GivenPoints, GivenValue
from vcmm.answer.inference.point_checks import repetition_remarks
from vcmm.answer.inference.points import task_and_rows
from vcmm.answer.inference.power import NO_POINTS, memory_not_covered
from vcmm.answer.inference.residual_tests import Ints, ResidualTests
from vcmm.core.blocks import Progress
from vcmm.core.errors import DataError, choose_from
from vcmm.core.readable import Readable, Reading
from vcmm.core.run import Array
from vcmm.part.fit import FittedElement
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.criteria import notes
from vcmm.part.part import Characteristic
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.task import Task, evaluate_all, fit_features, measured_points

# mm between touches of two parts that share an evaluation: errors of machines change over tens of mm
SHARED_EVALUATION_MM = 1.0
KEPT = 20  # earlier parts that are searched for such an evaluation: parts of several kinds may take turns

UNITS_TAKEN = {
    "in inches": (25.4, "value_in"),
    "in metres": (1000.0, "value_m"),
    "in micrometres": (1e-3, "value_um"),
    "in mm, not inches": (1 / 25.4, "value_mm"),
}


@dataclass(frozen=True, eq=False)
class EvaluatedCharacteristic:
    """One characteristic of one measured part. measured: as handed in or as the points give it, mm or rad; by_points: which."""

    result: CharacteristicResult
    measured: float
    by_points: bool = False

    @property
    def name(self) -> str:
        return self.result.name

    @property
    def unit(self) -> str:
        return self.result.unit


@dataclass(frozen=True, eq=False)
class EvaluatedPart(Readable):
    """All characteristics of one part; uncertainty: the evaluation behind them; task: the positions of the machine."""

    part: str
    characteristics: tuple[EvaluatedCharacteristic, ...]
    uncertainty: UncertaintyResult
    warnings: tuple[str, ...]
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        of = f" {self.part}" if self.part else ""
        return f"<EvaluatedPart{of}: {first_few(f'{e.result.name} {answer(e.result)}' for e in self.characteristics)}>"

    def __getitem__(self, name: str) -> EvaluatedCharacteristic:
        """Return the characteristic of this name. KeyError: none has it."""
        return of_name(self.characteristics, name)

    @cached_property
    def joint(self) -> JointJudgement | None:
        """All tolerances of the part judged together; None where fewer than two are stated."""
        results = [e.result for e in self.characteristics]
        readings = [e.measured for e in self.characteristics]
        return judged_jointly(self.uncertainty.model, results, readings, self.uncertainty.seed)


@dataclass(frozen=True, eq=False)
class PreparedTask:
    """Everything that does not depend on the measured numbers: the evaluation of a task, with the belts of its extreme values."""

    task: Task
    result: UncertaintyResult
    _memory: dict[str, tuple[str, ...]] = field(default_factory=dict, repr=False)

    def serves(self, task: Task) -> bool:
        """Return whether another part was touched at the same places (within SHARED_EVALUATION_MM)."""
        mine, other = self.task.touches, task.touches
        if list(mine.rows) != list(other.rows) or mine.points.shape != other.points.shape:
            return False
        apart = np.abs(mine.points - other.points).max(), np.abs(mine.pose.shift - other.pose.shift).max()
        return bool(max(apart) <= SHARED_EVALUATION_MM)

    @cached_property
    def tests(self) -> ResidualTests:
        """Tests of the residuals of measured points; their nulls are sampled when first needed."""
        return ResidualTests(self.result.model, self.result.seed)

    @property
    def inversion(self) -> Inversion | None:
        """The belts, where a characteristic is extreme."""
        inversion = (
            c.truth.inversion for c in self.result.characteristics if isinstance(c.truth, TrueValueByBelt)
        )
        return next(inversion, None)

    def rest(self, points: Array) -> Array:
        """Return the root mean square of the residuals of measured points (n, 3), (C,) mm, NaN for values that are not extreme."""
        out = np.full(len(self.result.characteristics), np.nan)
        if self.inversion is not None:
            out[list(self.inversion.numbers)] = rest_of(self.inversion.drawing, points)
        return out

    @cached_property
    def forms(self) -> tuple[FeatureForms, ...]:
        """Forms of the features that move sizes, distances and angles, except those that the scenario states."""
        smooth = [i for i, c in enumerate(self.result.characteristics) if is_moved_by_form(c)]
        return forms_of(self.result.model, smooth, self.task.forms) if smooth else ()

    def memory_not_covered(self, task: Task, rows: Ints) -> tuple[str, ...]:
        """Return the remarks on memory; counted once, since parts that share an evaluation have the same points. rows: of the file, per touch."""
        if "said" not in self._memory:
            order = {n: np.argsort(rows[task.touches.rows[n]], kind="stable") for n in self.tests.features}
            self._memory["said"] = (
                memory_not_covered(self.tests, order) if task.touches.run.n <= LARGEST else ()
            )
        return self._memory["said"]

    def bends(self, task: Task, points: Array, fitted: Mapping[str, FittedElement]) -> dict[int, Array]:
        """Return, by characteristic, ranges (m,) mm that the bends of measured points (n, 3) leave possible up to the ends of a feature."""
        out, parts = dict[int, Array](), task.part
        for i, c in enumerate(parts.characteristics):
            name = c.of[0] if len(c.of) == 1 else ""
            if name in task.touches.rows and isinstance(
                self.result.characteristics[i].truth, TrueValueByBelt
            ):
                places = task.touches.points[task.touches.rows[name]]
                ranges = bend_ranges(
                    c, parts.features[name], places, outward(task, name, points, fitted), self.result.seed
                )
                out |= {} if ranges is None else {i: ranges}
        return out

    def form_statements(self, task: Task, fitted: Mapping[str, FittedElement]) -> dict[int, list[FormTold]]:
        """Return, by characteristic, the effect of the form between the points of its features, from their residuals."""
        p, out = self.result.characteristics[0].p, defaultdict[int, list[FormTold]](list)
        for between in self.forms:
            rows, element = task.touches.rows[between.name], fitted[between.name]
            side = np.sign((element.normals * task.touches.normals[rows]).sum(axis=1))
            floors = {i: self.result.characteristics[i].expanded for i in between.moves}
            for i, form in told_by(between, side * element.residuals, p, floors).items():
                out[i].append(form)
        return out


@dataclass(frozen=True, eq=False)
class ReadPart:
    """Measured values of one part, without its points.

    measured (C,): NaN where none was given. rest (C,): root mean square of the residuals, of points; forms: estimates from them of
    the form between them, by characteristic; doubts: by the name of a characteristic, why its coverage may not be claimed; unseen:
    what no test of the residuals would notice; bends: by characteristic, how far the bends that the points show may go beyond them.
    """

    name: str
    measured: Array
    rest: Array | None = None
    remarks: tuple[str, ...] = ()
    forms: Mapping[int, Sequence[FormTold]] | None = None
    doubts: Mapping[str, str] | None = None
    unseen: tuple[str, ...] = ()
    bends: Mapping[int, Array] | None = None

    @property
    def readings(self) -> list[tuple[int, float, float | None]]:
        """Number, value and residuals of the given data."""
        rests = [None] * len(self.measured) if self.rest is None else [float(x) for x in self.rest]
        return [(i, float(y), rests[i]) for i, y in enumerate(self.measured) if np.isfinite(y)]


def evaluate_points(
    scenario: Scenario,
    given: Sequence[GivenPoints],
    *,
    in_machine: bool = False,
    tip_centres: bool = False,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> tuple[EvaluatedPart, ...]:
    """Evaluate measured points of one or several parts. DataError for points that are not those of the part (see `checked`)."""
    chosen, report = settings or scenario.settings, progress or (lambda text, share: None)
    read: list[tuple[PreparedTask, ReadPart]] = []
    for i, file in enumerate(given):
        report(f"points of part {file.part}" if file.part else "points", i / len(given))
        task, rows = task_and_rows(scenario, file, in_machine, tip_centres)
        points = measured_points(task, task.machine.indication_error(task.touches.run))
        fitted = fit_features(task, points)
        measured = np.asarray(evaluate_all(task, fitted))
        prepared = next((k for k, _ in reversed(read[-KEPT:]) if k.serves(task)), None)
        prepared = prepared or PreparedTask(task, evaluate(task, chosen, progress, read=False))
        doubts = doubts_of(prepared.tests, task, (points, fitted), (file, rows), prepared.result)
        coarse = coarse_mesh(task, prepared.result.characteristics)
        part = ReadPart(
            file.part, measured, prepared.rest(points),
            remarks=(*doubts.notes, *notes(task.part.characteristics, fitted), *coarse, *repetition_remarks(file)),
            forms=prepared.form_statements(task, fitted), doubts=doubts.reasons(task, prepared.result),
            unseen=prepared.memory_not_covered(task, rows), bends=prepared.bends(task, points, fitted),
        )  # fmt: skip
        read.append((prepared, part))
    return _all_parts(scenario, read, chosen, report)


def evaluate_values(
    scenario: Scenario,
    given: Sequence[Sequence[GivenValue]],
    *,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> tuple[EvaluatedPart, ...]:
    """Evaluate measured values of one or several parts: the points are those of the plan. DataError: unknown or wrong kind of value."""
    chosen, report = settings or scenario.settings, progress or (lambda text, share: None)
    measured = [absolute_values(scenario, values) for values in given]
    task = scenario.task()
    prepared = PreparedTask(task, evaluate(task, chosen, progress, read=False))
    order = [c.name for c in scenario.part.characteristics]
    read = [
        (
            prepared,
            ReadPart(
                v[0].part,
                np.array([y.get(n, np.nan) for n in order]),
                remarks=prepared.result.warnings,
                unseen=(NO_POINTS,),
            ),
        )
        for v, y in zip(given, measured)
    ]
    return _all_parts(scenario, read, chosen, report)


def absolute_values(scenario: Scenario, values: Sequence[GivenValue]) -> dict[str, float]:
    """Convert values: characteristic -> mm or rad. DataError: an unknown name, an angle in mm, a value no such characteristic can have."""
    by_name = {c.name: c for c in scenario.part.characteristics}
    out, problems = {}, []
    for v in values:
        c = by_name.get(v.name)
        if c is None:
            problems.append(
                f'{v.where}: the part has no characteristic "{v.name}".{choose_from(v.name, by_name)}'
            )
            continue
        angle = gps.unit(c) == "rad"
        if angle != v.angle:
            due = "an angle: name the column value_deg" if angle else "a length: name the column value_mm"
            problems.append(f'{v.where}: "{c.name}" is {due}')
            continue
        nominal = gps.nominal(c, scenario.part.features)
        out[c.name] = v.number + (nominal if v.deviation else 0.0)
        if c.material and v.bonus is None:
            problems.append(
                f'{v.where}: "{c.name}" is what its size does not pay for, and the heading has no column BONUS; add it to the report'
            )
        elif c.material:
            out[c.name] = max(out[c.name] - (v.bonus or 0.0), 0.0)
        wrong = _implausible(c, nominal, out[c.name], v)
        problems += [f"{v.where}: {wrong}"] if wrong else []
    if problems:
        raise DataError(problems)
    return out


def _implausible(c: Characteristic, nominal: float, value: float, given: GivenValue) -> str:
    """Return why a number is implausible: a negative form, a deviation written as a value, another unit."""
    if gps.is_one_sided(c):
        return f'"{c.name}": {c.type} is never negative' if value < 0 else ""
    if abs(value - nominal) <= 0.1 * max(abs(nominal), 1.0):
        return ""
    meant = _other_unit(nominal, value) if gps.unit(c) == "mm" else ""
    if meant and not given.deviation:
        return f'"{c.name}" = {value:g} mm is far from its nominal {nominal:g} mm; {meant}'
    if not given.deviation and abs(value) < 0.1 * nominal:
        return (
            f'"{c.name}" = {given.number:g} is far from its nominal {nominal:g}; for a deviation from nominal name the column '
            "deviation_um (deviation_mm)"
        )
    return f'"{c.name}" = {value:g} is more than a tenth off its nominal {nominal:g}; check the unit in the column name'


def _other_unit(nominal: float, value: float) -> str:
    """Return what to do where a number would be the nominal one, within 1 %, in another unit."""
    for words, (factor, column) in UNITS_TAKEN.items():
        if nominal and abs(value * factor / nominal - 1.0) < 0.01:
            small = " (or deviation_mm, if it is meant from nominal)" if abs(value) < 1.0 else ""
            return f"it would fit if it were {words}: name the column {column}{small}"
    return ""


def _all_parts(
    scenario: Scenario, read: Sequence[tuple[PreparedTask, ReadPart]], settings: Settings, report: Progress
) -> tuple[EvaluatedPart, ...]:
    """Evaluate all parts; all are read before the first is judged, so that parts sampled for one serve the others too."""
    for prepared, part in read:
        if prepared.inversion is not None:
            prepared.inversion.expect(part.readings)
    out = []
    for n, (prepared, part) in enumerate(read):
        report(f"part {part.name}" if part.name else "true values", n / len(read))
        out.append(
            _part(scenario, prepared, part, settings, report if len(read) == 1 else lambda text, share: None)
        )
    return tuple(out)


def _part(
    scenario: Scenario, prepared: PreparedTask, part: ReadPart, settings: Settings, report: Progress
) -> EvaluatedPart:
    results, out = prepared.result.characteristics, []
    for n, (i, y, rest) in enumerate(part.readings):
        report(f"true value of {results[i].name}", n / len(part.readings))
        result = without_claim(with_form(results[i], (part.forms or {}).get(i, ())), part.doubts)
        if part.forms is not None or isinstance(result.truth, TrueValueByBelt):
            result = replace(result, not_covered=(*result.not_covered, *part.unseen))
        read = _read(result, y, rest, settings, (part.bends or {}).get(i))
        out.append(EvaluatedCharacteristic(read, y, part.forms is not None))
    of_results = [w for e in out for w in warnings_of(e.result)]
    warnings = tuple(
        w
        for w in (*remarks(scenario), *of_results, *part.remarks)
        if "classic virtual-CMM recipe" not in w
        and "its coverage is not demonstrated" not in w  # said below of what was measured
    )
    return EvaluatedPart(
        part.name, tuple(out), prepared.result, (*warnings, *_claims_missing(out, part.doubts or {}))
    )


def _claims_missing(evaluated: Sequence[EvaluatedCharacteristic], doubts: Mapping[str, str]) -> list[str]:
    return [
        f"{e.result.name}: {e.result.why_not_shown}"
        for e in evaluated
        if (e.result.true_value and not e.result.true_value.is_claimed)
        or e.result.why_not_shown.startswith(UNSEEN)
        or (e.result.name in doubts and not e.result.coverage_shown)
    ]


def _read(
    r: CharacteristicResult, y: float, rest: float | None, settings: Settings, bends: Array | None
) -> CharacteristicResult:
    """Return the result where y was indicated; of an extreme value U is half the interval of this very part."""
    if isinstance(r.truth, TrueValueByBelt):
        r = replace(r, truth=replace(r.truth, rest=rest), half_width=None, indicated=y)
        r = r if bends is None else with_bends(r, bends)
    return at_indication(r, y, settings.rule)
