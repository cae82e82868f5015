"""Mistakes of the stored error table: hypotheses with a fixed coefficient and no free parameter, tested first.

the recording holds ...   sign: minus the table; missing: none of it; counted twice: twice; unit: the table times a
unit factor; swapped: another component's table.   departure = (coefficient - 1) x observed effect of the table

Names that hold others as special cases by their definition, on any recording; among them the simplest that the data can
resolve counts. A name that holds an answer only because this recording is poor is a rival, not a generalisation.

Labels that are some rows too early or too late: a label says which rows share a placement, an offset or a radius. Labels that slipped by
some rows give the first rows of each group the nuisance of the one before. The same number of free nuisance numbers is fitted either way, so the
evidence is the ratio of their residuals:

    ln BF = dof / 2 ln(|residual beside the labels as logged|^2 / |residual beside the shifted labels|^2)
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, without_span
from vcmm.core.effect import Effect, own_nodes, with_parameter
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.inputs import STATE
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.constants import CLOSING, FAR_SIGMAS, MISMATCH, STRONG, VANISHING_SHARE, VERY_STRONG
from vcmm.learn.diagnosis.evidence import orthonormal
from vcmm.learn.diagnosis.log_mistakes import LABELS_EXCHANGED, LOG, MISTAKE, Mistake, log_hypotheses
from vcmm.learn.diagnosis.null_recordings import clip_residuals, robust_scale
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import POINTS, ROUNDS
from vcmm.physics import BY_NAME
from vcmm.physics.structure.abbe import AbbeCountedTwice
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.geometric_change import GeometricChange
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.response.observe import Observer, nuisance_columns
from vcmm.task.response.recording import ALL_ROWS

TAKEN_FOR = (
    1e3,
    10.0,
    25.4,
    4.848136811,
    np.degrees(1.0),
)  # mm for um, ppm for um in 100 mm, inches, arcsec for urad, deg
UNIT_FACTORS = (*TAKEN_FOR, *(1.0 / k for k in TAKEN_FOR))
TABLE_ROLES = (ComponentTable, Squareness)  # effects whose numbers a table file holds
LEAST_TABLE_VALUE = 1e-7  # mm or rad: a table this small says nothing


def find_mistake(problem: Problem, white: Whitener, raw: Array, limit: float) -> Mistake | None:
    """Return the most probable mistake of the table if it beats nothing by VERY_STRONG nats, prior shared by all hypotheses.

    raw (m,): white residual. Outliers count as `limit` robust standard deviations, the same number for all hypotheses.
    """
    candidates = [*hypotheses(problem), *slipped_labels(problem, white)]
    if not candidates:
        return None
    departures = white.apply(np.stack([h.departure for h in candidates], axis=1))
    is_visible = np.linalg.norm(departures, axis=0) > VANISHING_SHARE
    left = raw[:, None] - departures
    bound = limit * min(float(robust_scale(raw)), float(robust_scale(left).min()))
    total = float(np.minimum(raw**2, bound**2).sum())
    rest = np.minimum(left**2, bound**2).sum(axis=0)
    prior = np.array([h.prior for h in candidates])
    scores = -0.5 * white.dof * np.log(rest / total) + prior - np.logaddexp.reduce(prior)
    scores[~is_visible] = -np.inf
    best = int(np.argmax(scores))
    if scores[best] <= VERY_STRONG:
        return None
    candidates[best] = _refine_clock(candidates[best], white, raw, bound)
    left[:, best] = raw - white.apply(candidates[best].departure)
    departures[:, best] = raw - left[:, best]
    near = [
        candidates[i]
        for i in np.flatnonzero(scores > scores[best] - STRONG)
        if i != best and not (candidates[i].clock and candidates[i].what == candidates[best].what)
    ]
    rivals = tuple(
        dict.fromkeys(
            f"{h.component} {h.what}" for h in near if (h.component, h.what) != _name(candidates[best])
        )
    )
    # the nats of all against nothing, outliers pulled in about the mistake as they are about fitted terms
    clipped = clip_residuals(left[:, best], white, limit)
    with_it = departures[:, best] + clipped
    nats = 0.5 * white.dof * float(np.log(with_it @ with_it / (clipped @ clipped)))
    score = nats + float(prior[best] - np.logaddexp.reduce(prior))
    return replace(candidates[best], score=score, rivals=rivals)


def _refine_clock(mistake: Mistake, white: Whitener, raw: Array, bound: float) -> Mistake:
    """Return a mistake with one number at the value that leaves least: a grid between its neighbours, and again about the best of it."""
    if mistake.clock is None:
        return mistake
    clock = mistake.clock
    value, step = clock.value, clock.step

    def misfit(m: Mistake) -> float:
        return float(np.minimum((raw - white.apply(m.departure)) ** 2, bound**2).sum())

    for _ in range(ROUNDS):
        for trial in value + step * np.linspace(-1.0, 1.0, POINTS):
            made = clock.at(float(trial))
            if made is not None:
                at_trial = replace(clock, value=float(trial))
                new = replace(mistake, component=made[0], departure=made[1], clock=at_trial)
                if misfit(new) < misfit(mistake):
                    mistake, value = new, float(trial)
        step /= POINTS / 2
    return mistake


def factor_fits(departure: Array, rest: Array, chosen: Array, sigma: float) -> bool:
    """Return whether the mistake's own number, 1 times its departure, is the one that fits.

    A mistake of bookkeeping is exact; a calibration that is off in its direction is so by any amount. departure, rest
    (m,): white departure of the mistake and what it and the chosen columns (m, k) leave; 1 + c is the best multiple,

        c = d · rest / d · d with d the departure outside the chosen columns,    u(c) = sigma / |d|
    """
    d = without_span(departure, orthonormal(chosen))
    size = float(np.linalg.norm(d))
    if size <= VANISHING_SHARE:
        return True
    c = float(d @ rest) / size**2
    return abs(c) <= max(FAR_SIGMAS * sigma / size, MISMATCH)


def _name(mistake: Mistake) -> tuple[str, str]:
    return mistake.component, mistake.what


_HYPOTHESES: WeakKeyDictionary[Observer, tuple[Mistake, ...]] = WeakKeyDictionary()
"""Hypotheses per recording as it is observed now: they depend neither on the noise nor on found effects, and every pass needs them."""


def hypotheses(problem: Problem) -> tuple[Mistake, ...]:
    """Return all mistakes of all tables (and of all together), and of the log. Tables of a machine that was followed hold no mistake."""
    if problem.observer not in _HYPOTHESES:
        of_tables = () if is_followed(problem.machine) else _of_tables(problem)
        of_log = log_hypotheses(problem.recording, problem.machine)
        _HYPOTHESES[problem.observer] = (*of_tables, *of_log)
    return _HYPOTHESES[problem.observer]


def is_followed(machine: Machine) -> bool:
    """Return whether earlier recordings agreed with the numbers of the machine: they were not typed, so that a departure is a
    change of the machine."""
    return any(i.members and i.parameter == STATE for i in machine.inputs)


def _of_tables(problem: Problem) -> Iterator[Mistake]:
    tables = tables_of(problem)
    nothing = _baseline_of(problem, ())
    errors = {name: _baseline_of(problem, (effect,)) - nothing for name, effect in tables.items()}
    errors = {name: e for name, e in errors.items() if np.abs(e).max(initial=0.0) > LEAST_TABLE_VALUE}
    if len(errors) > 1:
        errors["all"] = np.sum(list(errors.values()), axis=0)
    for name, e in errors.items():
        yield Mistake(name, "sign", -2.0 * e, factor=-1.0)
        yield Mistake(name, "missing", -e, factor=0.0)
        yield Mistake(name, "counted twice", e, factor=2.0)
        for factor in UNIT_FACTORS:
            prior = -float(np.log(len(UNIT_FACTORS)))
            yield Mistake(name, "unit", (factor - 1.0) * e, prior=prior, factor=factor)
    yield from _swaps(problem, tables, errors, nothing)
    yield from _abbe(problem, nothing)


def _abbe(problem: Problem, nothing: Array) -> Iterator[Mistake]:
    """Yield the arm of the reference line (measured_at) counted twice, or left out: rotation tables x arm."""
    for letter, axis in problem.machine.axes.items():
        if axis.rotary or axis.measured_at is None:
            continue
        try:
            effect = AbbeCountedTwice.from_tables(letter, problem.machine.effects, axis.measured_at)
            e = _baseline_of(problem, (effect,)) - nothing
        except (UsageError, ModelLimit):
            continue  # no rotation tables, or a position outside them
        if np.abs(e).max(initial=0.0) > LEAST_TABLE_VALUE:
            yield Mistake(letter, "Abbe error counted twice", e, effect=AbbeCountedTwice.name)
            yield Mistake(letter, "Abbe error left out", -e, effect=AbbeCountedTwice.name, factor=-1.0)


def tables_of(problem: Problem) -> dict[str, Effect]:
    """Return the component tables and squareness errors of the machine by component name."""
    out: dict[str, Effect] = {}
    for effect in problem.machine.effects:
        if isinstance(effect, TABLE_ROLES):
            out[effect.where] = effect
    return out


def _baseline_of(problem: Problem, effects: tuple[Effect, ...]) -> Array:
    return problem.observer.of_effects(effects)


def _swaps(
    problem: Problem, tables: dict[str, Effect], errors: dict[str, Array], nothing: Array
) -> Iterator[Mistake]:
    """Yield one component in the place of another, and both exchanged."""
    single = {k: t for k, t in tables.items() if len(getattr(t, "arguments", ())) == 1}
    moved: dict[tuple[str, str], Array] = {}
    for a, table in single.items():
        for b, source in single.items():
            if a != b and (a[1] in "XYZ") == (b[1] in "XYZ"):
                moved[a, b] = _baseline_of(problem, (with_numbers_of(table, source),)) - nothing
    zero = np.zeros(problem.m)
    share = -float(np.log(max(2 * len(single), 1)))
    for (a, b), instead in moved.items():
        change = instead - errors.get(a, zero)
        yield Mistake(a, f"swapped with {b}", change, prior=share, source=b)
        if a < b:
            whole = change + moved[b, a] - errors.get(b, zero)
            yield Mistake(a, f"swapped with {b}", whole, prior=share, source=b, both=True)


def with_numbers_of(effect: Effect, source: Effect) -> Effect:
    """Return a table with the numbers of another component: node by node where the counts agree, else by position."""
    grid, other = table_nodes(effect), table_nodes(source)
    values = np.asarray(getattr(source, "values"), dtype=float)  # noqa: B009 - tables and splines have it
    if len(values) != len(grid):
        values = np.interp(grid, other, values)
    return with_parameter(effect, "values", values)


def table_nodes(effect: Effect) -> Array:
    """Return the nodes (k,) of a table over one axis. Raises UsageError for anything else."""
    nodes = own_nodes(effect)
    if nodes is None:
        raise UsageError(f"{effect.id} is no table over one axis; it cannot be exchanged")
    return nodes


def generalises(large: str, small: str) -> bool:
    """Return whether every motion of `small` is a motion of `large`, on any recording. A mistake is an edit of a table of one axis."""
    if small == MISTAKE:
        return large in BY_NAME and BY_NAME[large].diagnosis.holds_table_edits
    return small in BY_NAME and large in BY_NAME[small].diagnosis.special_case_of


def is_stale(effect: str, component: object) -> bool:
    """Return whether an answer is the calibration as a whole. Its size is a covariance, not a number: the renewed tables state the
    uncertainty of each."""
    return component == "all" and effect == GeometricChange.name


def slipped_labels(problem: Problem, white: Whitener) -> Iterator[Mistake]:
    """Yield every label of the nuisance, some rows too early or too late. white: of the problem as given."""
    recording = problem.recording
    labels = sorted({w for w in recording.nuisance.values() if w not in ALL_ROWS} & set(recording.run.labels))
    labels = [n for n in labels if len(np.unique(recording.run.labels[n][recording.row])) > 1]
    steps = [k for k in range(-CLOSING, CLOSING + 1) if k]
    for label, by in itertools.product(labels, steps):
        meant = replace(recording, run=_slip_label(recording.run, label, by, recording.lines))
        try:
            columns = np.reshape(nuisance_columns(meant, problem.machine)[0], (problem.m, -1))
            whitener = replace(problem, nuisance=columns).whitener()
        except ModelLimit:
            continue
        weight = 1.0 / problem.u[:, None]
        fit = np.linalg.lstsq(weight * columns, problem.residual / problem.u, rcond=None)[0]
        departure = columns @ fit
        left = white.apply(problem.residual - departure)  # beside both nuisances, which is too little
        alone = whitener.apply(problem.residual)
        too_little = 0.5 * white.dof * float(np.log((alone @ alone) / (left @ left)))
        share = -float(np.log(len(labels) * len(steps)))
        rows = "row" if abs(by) == 1 else "rows"
        text = f"{label}, {abs(by)} {rows} too {'late' if by < 0 else 'early'}"
        yield Mistake(text, LABELS_EXCHANGED, departure, prior=share - max(too_little, 0.0), effect=LOG)


def _slip_label(run: Run, label: str, by: int, lines: np.ndarray | None) -> Run:
    """Return the run with a label taken from `by` rows before (by < 0: after) in the order of the file."""
    rows = np.arange(run.n) if lines is None or len(lines) != run.n else np.argsort(lines, kind="stable")
    values = run.labels[label].copy()
    place = np.clip(np.arange(run.n) - by, 0, run.n - 1)
    values[rows] = run.labels[label][rows[place]]
    return replace(run, labels={**run.labels, label: values})
