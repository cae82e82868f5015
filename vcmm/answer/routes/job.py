"""One task by three routes: the model (virtual CMM), a calibrated part, several positions; and E_n between them.

With measured data every route uses these data. Without, the data are simulated on a machine and on parts that are sampled
and hidden from the routes, and the result of each route is compared with the truth as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vcmm.answer.evaluation.indication import at_indication
from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.one_line import first_few, of_name
from vcmm.answer.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.routes import hidden_machine
from vcmm.answer.routes.calibrated_part import CalibratedValue, Warmth, calibrated_part
from vcmm.answer.routes.estimate import (
    PART_EXPANSION,
    READING,
    Contribution,
    RouteAgreement,
    RouteEstimate,
    agreements,
)
from vcmm.answer.routes.positions import Corrections, StandardReadings, corrections, several_positions
from vcmm.core.blocks import Progress
from vcmm.core.errors import UsageError
from vcmm.core.pose import Pose
from vcmm.core.readable import Readable, Reading
from vcmm.core.run import T0_DEG_C, Array
from vcmm.part.gps import characteristics as gps
from vcmm.physics.structure.expansion import PartExpansion
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.settings import CORRECTED, Settings
from vcmm.task.measuring.task import Task

MODEL = "virtual CMM"
BETTER = 0.25  # u of the calibration of a drawn calibrated part, over that of the task
REPEATS = 20


@dataclass(frozen=True, eq=False)
class RouteData:
    """Measured data, by characteristic, mm or rad. repeats: of the calibrated part; positions: of the part itself, by position.

    readings: of the part itself, once; temperatures: of the calibrated part during its repeats, mean degC.
    """

    readings: Mapping[str, float] = field(default_factory=dict)
    calibrations: Mapping[str, CalibratedValue] = field(default_factory=dict)
    repeats: Mapping[str, Array] = field(default_factory=dict)
    temperatures: Mapping[str, float] = field(default_factory=dict)
    positions: Mapping[str, Mapping[str, Array]] = field(default_factory=dict)
    standards: Sequence[StandardReadings] = ()


@dataclass(frozen=True, eq=False)
class RoutedCharacteristic:
    """One characteristic by all routes that could be taken. reading: the indicated value; truth: of a hidden part, else None."""

    name: str
    unit: str
    reading: float
    is_handed_in: bool  # the reading was handed in
    truth: float | None
    routes: tuple[RouteEstimate, ...]
    agreements: tuple[RouteAgreement, ...]

    def error(self, route: RouteEstimate) -> float | None:
        """Return (estimate - truth) / U of a route."""
        return None if self.truth is None else (route.value - self.truth) / route.expanded


@dataclass(frozen=True, eq=False)
class RoutesResult(Readable):
    """All characteristics; simulated: everything was measured on a sampled machine. left_out: name -> why a route gives no result for it."""

    characteristics: tuple[RoutedCharacteristic, ...]
    simulated: bool
    seed: int
    remarks: tuple[str, ...]
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        verdict = "all routes agree" if self.agree else "not all routes agree"
        return f"<RoutesResult: {verdict}; {first_few(c.name for c in self.characteristics)}>"

    def __getitem__(self, name: str) -> RoutedCharacteristic:
        """Return the characteristic of this name. KeyError: none has it."""
        return of_name(self.characteristics, name)

    @property
    def agree(self) -> bool:
        return all(a.agrees for c in self.characteristics for a in c.agreements)


def routes(
    scenario: Scenario,
    data: RouteData | None = None,
    *,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> RoutesResult:
    """Compare all routes of a scenario. data None: simulate them on a sampled machine. UsageError: no second route."""
    chosen = replace(settings or scenario.settings, known_bias=CORRECTED)
    task = scenario.task()
    modelled = _evaluate_models(task, chosen, progress)
    names = [c.name for c in task.part.characteristics]
    remarks = [
        f"{n}: an extreme value is no sum of a true value and an error that is the same for all parts; only a calibrated part of "
        "like form is a second route, and no E_n is given (see evaluate and audit)"
        for n in names
        if n not in modelled
    ]
    truth: dict[str, float] = {}
    if data is None:
        given, truth = simulate(scenario, task, modelled, seed=chosen.seed, progress=progress)
    else:
        given = data
    nominal = np.asarray(hidden_machine.indicated_values(task))
    known_errors, shown = corrections(given.standards), hidden_machine.shows(task)
    compared = []
    for i, c in enumerate(task.part.characteristics):
        question = _Question(
            c.name,
            gps.unit(c),
            float(nominal[i]),
            (float(shown[i, 0]), float(shown[i, 1])),
            modelled.get(c.name),
        )
        compared.append(_ask_routes(scenario, question, given, known_errors, truth.get(c.name)))
    compared = [c for c in compared if c.routes]
    if not any(r.route != MODEL for c in compared for r in c.routes):
        raise UsageError(
            "there is no second route here: give --calibrated with --repeats, or --positions, for a characteristic of the part"
        )
    return RoutesResult(tuple(compared), data is None, chosen.seed, tuple(remarks))


def _evaluate_models(
    task: Task, settings: Settings, progress: Progress | None
) -> dict[str, UncertaintyResult]:
    """Evaluate those characteristics that are a true value and an error, under the name of each."""
    smooth = tuple(c for c in task.part.characteristics if gps.is_linear(c, task.part.features))
    if not smooth:
        return {}
    result = evaluate(replace(task, part=replace(task.part, characteristics=smooth)), settings, progress)
    endless = [c.name for c in result.characteristics if not math.isfinite(c.u)]
    if endless:
        raise UsageError(
            f'"{endless[0]}" has no standard uncertainty, since a law of its budget has 2 or fewer degrees of freedom; routes are compared '
            "by theirs: state dof above 2"
        )
    return {c.name: result for c in result.characteristics if not c.extreme}


def _of(result: UncertaintyResult, name: str) -> CharacteristicResult:
    return next(c for c in result.characteristics if c.name == name)


@dataclass(frozen=True, eq=False)
class _Question:
    """One characteristic: its indication on the nominal part, the effect of points scaled and moved outwards, its evaluation or None."""

    name: str
    unit: str
    indicated: float
    shows: tuple[float, float]
    model_result: UncertaintyResult | None


def _ask_routes(
    scenario: Scenario,
    question: _Question,
    data: RouteData,
    corrections_known: Corrections,
    truth: float | None,
) -> RoutedCharacteristic:
    y = data.readings.get(question.name)
    reading = question.indicated if y is None else y
    warmth, routes = _warmth(scenario, question.shows[0]), []
    if question.model_result is not None:
        of = _of(question.model_result, question.name)
        routes.append(model_route(of, question.model_result.model, reading, scenario.settings.rule))
    if question.name in data.repeats and question.name in data.calibrations:
        warm = replace(warmth, temperature=data.temperatures.get(question.name, warmth.temperature))
        routes.append(
            calibrated_part(reading, data.repeats[question.name], data.calibrations[question.name], warm)
        )
    if question.name in data.positions and question.model_result is not None:
        routes.append(
            several_positions(data.positions[question.name], question.shows, corrections_known, warmth)
        )
    return RoutedCharacteristic(
        name=question.name, unit=question.unit, reading=reading, is_handed_in=y is not None, truth=truth, routes=tuple(routes),
        agreements=agreements(routes),
    )  # fmt: skip


def model_route(c: CharacteristicResult, model: LinearModel, reading: float, rule: str) -> RouteEstimate:
    """Return the virtual CMM at a reading: known bias corrected, contributions by Input, those sampled anew together as scatter."""
    indication = at_indication(c, reading, rule)
    inputs = {influence.input.id: influence.input for influence in model.influences}
    scatter, kept = [], []
    for line in c.budget:
        quantity = inputs.get(line.input)
        if quantity is not None and quantity.effect == PartExpansion.name:
            kept.append(Contribution(PART_EXPANSION, line.u, line.dof))
        elif quantity is not None and hidden_machine.anew(quantity):
            scatter.append(line.u)
        else:
            kept.append(Contribution(line.input, line.u, line.dof))
    contributions = (Contribution(READING, math.hypot(*scatter)), *kept)
    half = (indication.interval[1] - indication.interval[0]) / 2
    u = math.hypot(*(p.u for p in contributions))
    return RouteEstimate(MODEL, sum(indication.interval) / 2, contributions, half / u)


def _warmth(scenario: Scenario, length: float) -> Warmth:
    """Return the temperature of the part, and the uncertainty of its expansion; of a characteristic that grows by `length` mm per 1."""
    u = [i.size for i in scenario.inputs if i.effect == PartExpansion.name]
    return Warmth(scenario.constants.get("temp_part_C", T0_DEG_C), u[0] if u else 0.0, abs(length))


def simulate(
    scenario: Scenario,
    task: Task,
    modelled: Mapping[str, UncertaintyResult],
    *,
    seed: int,
    progress: Progress | None = None,
) -> tuple[RouteData, dict[str, float]]:
    """Return (measured data, true values): one sampled machine, one part, one calibrated part, standards."""
    report = progress or (lambda text, share: None)
    machine, names = hidden_machine.HiddenMachine(seed + 1), [c.name for c in task.part.characteristics]
    hidden_task = hidden_machine.hidden_part(task, machine.seed, "the part")
    same = hidden_machine.hidden_part(task, machine.seed, "the calibrated part")
    report("repeats of a calibrated part", 0.0)
    rng = np.random.default_rng(machine.seed)
    true_same, repeats = (
        hidden_machine.true_values(same),
        machine.measure(same, hidden_machine.CALIBRATED_ONE, 100, REPEATS),
    )
    better = [
        BETTER * (_of(modelled[n], n).u if n in modelled else float(np.std(repeats[:, i], ddof=1)))
        for i, n in enumerate(names)
    ]
    calibrations = {
        n: CalibratedValue(float(v + u * rng.standard_normal()), u)
        for n, v, u in zip(names, true_same, better)
    }
    reading = machine.measure(hidden_task, hidden_machine.OWN, 0, 1)[0]
    report("repeats in several positions", 0.4)
    places = hidden_machine.usable_positions(scenario)
    readings = {
        name: machine.measure(
            _task_at(scenario, pose, hidden_task),
            hidden_machine.OWN,
            200 + 50 * i,
            hidden_machine.PER_POSITION,
        )
        for i, (name, pose) in enumerate(places.items())
    }
    positions = {n: {place: values[:, i] for place, values in readings.items()} for i, n in enumerate(names)}
    report("standards of length and a ring", 0.8)
    data = RouteData(
        readings=dict(zip(names, map(float, reading))), calibrations=calibrations,
        repeats={n: repeats[:, i] for i, n in enumerate(names)},
        positions=positions if len(places) > 1 else {},
        standards=hidden_machine.standards(scenario, machine, places),
    )  # fmt: skip
    return data, dict(zip(names, map(float, hidden_machine.true_values(hidden_task))))


def _task_at(scenario: Scenario, pose: Pose, hidden_task: Task) -> Task:
    """Return the same part elsewhere in the machine."""
    return replace(scenario.at(pose).task(), form=hidden_task.form)
