"""Compare a measured part with its prediction at the same points.

    measured points -> feet on the nominal surfaces -> the cut of exactly these points -> predicted surface and its covariance
                    -> characteristics side by side -> covariates of the difference (vcmm.shop.machining.mismatch)

Both sides are evaluated alike, in the same alignment. The difference of one characteristic is judged with the uncertainty of
its prediction and of the measured points: E_n = difference / (2 u_difference), ISO 13528.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel, build
from vcmm.answer.evaluation.montecarlo import Term, covariance
from vcmm.answer.inference.given_points import GivenPoints
from vcmm.answer.inference.point_checks import OnSurface, check_points, feature_rows, surfaces
from vcmm.core.errors import DataError, UsageError
from vcmm.core.laws import Law
from vcmm.core.run import Array, Run
from vcmm.part.gps import characteristics as gps
from vcmm.shop.cutting.envelope import UNCUT
from vcmm.shop.machining.contact_path import surface_at
from vcmm.shop.machining.cut_world import Cutting
from vcmm.shop.machining.gauge import gauge_plan, ideal_gauge
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.mismatch import LEAST_SCATTER, MismatchEntry, ObservedPoints, locate_mismatch
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import PreparedCut
from vcmm.shop.machining.scatter_sizes import (
    ScatterSizes,
    found_scatter,
    scatter_notes,
    with_scatter,
)
from vcmm.shop.machining.waves import Wave
from vcmm.task.measuring.cut_scenario import IDEAL, OTHER, CutScenario
from vcmm.task.measuring.plan import Plan, Step
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.task import evaluate_all, fit_features
from vcmm.task.response.recording import UNKNOWN

ALONE = 1e-9  # of a variance: rounding
TRIALS = 2000  # of the predicted part with its points measured: u to 1.6 %


@dataclass(frozen=True)
class BesidePrediction:
    """One characteristic: measured and predicted value, u of their difference (mm or rad)."""

    name: str
    unit: str
    nominal: float
    measured: float
    prediction: float
    u: float

    @property
    def e_n(self) -> float:
        """Difference over its expanded uncertainty (k = 2); nan where nothing is uncertain."""
        return (self.measured - self.prediction) / (2.0 * self.u) if self.u > 0 else float("nan")


@dataclass(frozen=True, eq=False)
class MeasuredCut:
    """comparisons: by characteristic; mismatch: covariates of the difference; scatter: of one measured point, mm.

    observed: the points with the state of the machine when each was cut; normal (n, 3) of the cutter: along which `departure` (n,) mm
    counts, the motion of the tool less its prediction. uncertainty_columns: (Input id, columns (n, r)), its uncertainty, mm per draw of
    unit variance. noise (n,): scatter that is independent at every point, mm along `normal`. notes: points left out, statements that were
    not possible. wave: of no known cause, where
    no covariate explains the difference better.
    """

    comparisons: tuple[BesidePrediction, ...]
    mismatch: tuple[MismatchEntry, ...]
    scatter: float
    observed: ObservedPoints
    departure: Array
    normal: Array
    in_machine: bool
    noise: Array
    uncertainty_columns: tuple[tuple[str, Array], ...]
    notes: tuple[str, ...] = ()
    wave: Wave | None = None
    off: Array = field(
        default_factory=lambda: np.zeros(0)
    )  # (n,) mm, of the measured points along the normals of the drawing
    sizes: ScatterSizes | None = None


def left_of(cut: MeasuredCut, rest: Array) -> Array:
    """Return the residual of a prediction, `rest` (n,) mm along the normals of the drawing; where the part was aligned, less the best
    rigid motion, which is
    the alignment's."""
    if cut.in_machine:
        return rest
    n, arm = cut.observed.normals, cut.observed.place - cut.observed.place.mean(axis=0)
    rigid = np.hstack([n, np.cross(arm, n)])
    return np.asarray(rest - rigid @ np.linalg.lstsq(rigid, rest, rcond=None)[0])


def rest_of(scenario: CutScenario, given: GivenPoints, in_machine: bool = False) -> Array:
    """Return measured less predicted (n,) mm along the normals, in the order of `measured_cut`."""
    job = set_up(scenario)
    job, points, _ = _cut_there(job, *_on_part(job, given, in_machine), given)
    task, world, _ = finished_part(job)
    touches = task.touches
    predicted = ((build(task, world).points - touches.points) * touches.normals).sum(axis=1)
    return np.asarray(((points - touches.points) * touches.normals).sum(axis=1) - predicted)


def measured_cut(
    scenario: CutScenario, given: GivenPoints, *, in_machine: bool = False, u_point: float | None = None, seed: int | None = None,
    job: PreparedCut | None = None,
) -> MeasuredCut:  # fmt: skip
    """Compare a measured part with its prediction. in_machine: points in the frame of the machine that measured, else in the drawing
    frame. The place of the part on a measuring machine is unrelated to the cut, so there both are aligned.

    u_point: standard uncertainty of one measured point, mm; None: the residual after everything that is tested. job: the prepared
    scenario, for several parts of it.
    Raises DataError for points that are not of this part (file and line), UsageError and ModelLimit as `cut` does.
    """
    job = job or set_up(scenario)
    aligned = not in_machine or scenario.inspection.kind == OTHER
    placed, frame_points = _on_part(job, given, in_machine)
    job, points, notes = _cut_there(job, placed, frame_points, given)
    task, world, more = finished_part(job)
    model = build(task, world)
    touches = task.touches
    predicted = ((model.points - touches.points) * touches.normals).sum(axis=1)
    deviation = ((points - touches.points) * touches.normals).sum(axis=1)
    columns = known_columns(model)
    observed = _observe(world, deviation - predicted, columns.covariance)
    sizes = found_scatter(observed, columns.common, columns.single, aligned, u_point, world.tool.inputs)
    columns = replace(columns, common=with_scatter(columns.common, sizes))
    observed = replace(observed, covariance=columns.covariance)
    located = locate_mismatch(observed, rigid=aligned, u_point=u_point)
    scatter = located.scatter
    values = evaluate_all(task, fit_features(task, points))
    alone = (
        scatter if scatter > LEAST_SCATTER or u_point is not None else 0.0
    )  # of points that scatter less, none is seen
    spread = observed.covariance + alone**2 * np.eye(len(points))
    rng = np.random.default_rng(scenario.settings.seed if seed is None else seed)
    row, gain = world.makers()
    size = np.linalg.norm(gain, axis=1)
    normal = world.tool.in_workpiece(gain / size[:, None], row)
    return MeasuredCut(
        comparisons=_compare(model, values, rng.multivariate_normal(np.zeros(len(points)), spread, TRIALS)),
        mismatch=located.entries,
        scatter=scatter,
        observed=observed,
        departure=(deviation - predicted) / size,
        normal=normal,
        in_machine=not aligned,
        noise=np.hypot(scatter, np.linalg.norm(columns.single, axis=1)) / size,
        uncertainty_columns=tuple(
            (name, columns / size[:, None])
            for name, columns in (*columns.common, *_unknown(located.wave, observed))
        ),
        wave=located.wave,
        off=deviation,
        notes=(*notes, *more, *scatter_notes(sizes)),
        sizes=sizes,
    )


def _on_part(job: PreparedCut, given: GivenPoints, in_machine: bool) -> tuple[dict[str, OnSurface], Array]:
    """Return the feet of the points on the nominal surfaces, and the points (n, 3) in the drawing frame."""
    scenario = job.scenario
    plan = gauge_plan(scenario.part, scenario.plan)
    scenario_on_part = Scenario(scenario.name, ideal_gauge(), scenario.part, plan, job.pose)
    elsewhere = scenario.inspection.pose if scenario.inspection.kind == OTHER else None
    points = (elsewhere or job.pose).inverse().apply(given.points) if in_machine else given.points
    placed = surfaces(scenario.part, feature_rows(scenario_on_part, given), points)
    check_points(scenario_on_part, given, points, placed, in_machine)
    return placed, points


def _cut_there(
    job: PreparedCut, placed: dict[str, OnSurface], points: Array, given: GivenPoints
) -> tuple[PreparedCut, Array, list[str]]:
    """Return the job with the measured points as its plan, and these points in its order, less those that no tool reaches."""
    plan = _inspection_plan(job)
    stylus = {step.feature: step.stylus for step in plan.steps}
    steps, order, notes = [], [], []
    for name, on in placed.items():
        left = surface_at(job, on.foot, on.normal, exact=False).status == UNCUT
        kept = np.flatnonzero(~left)
        if left.any():
            where = given.where[int(on.rows[np.flatnonzero(left)[0]])]
            notes.append(
                f"{name}: the program cuts nothing at {int(left.sum())} of its {len(left)} measured points (first: {where}); they are left out"
            )
        if len(kept):
            first = next(iter(plan.styli))
            steps.append(Step(name, stylus.get(name, first), on.foot[kept], on.normal[kept]))
            order.append(on.rows[kept])
    if not steps:
        raise DataError(f"{given.where[0]}: the program cuts nothing at any of the measured points")
    scenario = replace(job.scenario, plan=replace(plan, steps=tuple(steps)))
    return replace(job, scenario=scenario), points[np.concatenate(order)], notes


def _inspection_plan(job: PreparedCut) -> Plan:
    scenario = job.scenario
    if scenario.inspection.kind == IDEAL:
        return gauge_plan(scenario.part, scenario.plan)
    if scenario.plan is None:
        raise UsageError(
            "inspection on a machine needs a plan with styli; add [plan], or leave [inspection] out"
        )
    return scenario.plan


@dataclass(frozen=True, eq=False)
class KnownColumns:
    """Uncertainty of n predicted points along their normals, mm per draw of unit variance.

    common: (Input id, columns (n, r)) shared by several points; single (n, s): independent at every point.
    """

    common: tuple[tuple[str, Array], ...]
    single: Array

    @property
    def covariance(self) -> Array:
        """Covariance of the points (n, n) mm^2."""
        every = np.concatenate([*(c for _, c in self.common), np.zeros((len(self.single), 0))], axis=1)
        return every @ every.T + np.diag((self.single**2).sum(axis=1))


def known_columns(model: LinearModel) -> KnownColumns:
    """Return the columns of everything that is uncertain of the predicted points."""
    n = len(model.points)
    along = replace(model, operator=np.eye(n), q0=np.zeros(n))
    common, single = [], [np.zeros((n, 0))]
    for influence in model.influences:
        columns = _per_draw(along.term(influence))
        if _drawn_anew(columns):
            single.append(columns)
        elif columns.shape[1]:
            common.append((influence.input.id, columns))
    return KnownColumns(tuple(common), np.concatenate(single, axis=1))


def _drawn_anew(columns: Array) -> bool:
    """Return whether no two points (rows) share a draw: whatever its law says of copies, their covariance is diagonal. An Input that acts on one
    point alone is no scatter."""
    shared = columns @ columns.T
    alone = np.diag(shared).copy()
    np.fill_diagonal(shared, 0.0)
    return bool(
        np.abs(shared).max(initial=0.0) <= ALONE * alone.max(initial=0.0) and np.sum(alone > 0.0) != 1
    )


def _per_draw(term: Term) -> Array:
    """Return the columns (n, r) with the covariance of a term."""
    if isinstance(term.law, Law) and np.isfinite(term.law.u):
        return np.asarray(term.gain * term.law.u)
    value, vector = np.linalg.eigh(covariance([term]))
    kept = value > 1e-12 * value.max(initial=0.0)
    return np.asarray(vector[:, kept] * np.sqrt(value[kept]))


def _unknown(wave: Wave | None, observed: ObservedPoints) -> list[tuple[str, Array]]:
    """Return an unnamed wave as one more covariance, so that no named cause takes its place: columns (n, 6) whose rms is that of the wave as
    the points show it.
    """
    if wave is None:
        return []
    cov = observed.covariance + LEAST_SCATTER**2 * np.eye(len(observed.rest))
    lower = np.linalg.cholesky(cov)
    columns, rest = np.linalg.solve(lower, wave.columns), np.linalg.solve(lower, observed.rest)
    shown = wave.columns @ np.linalg.lstsq(columns, rest, rcond=None)[0]
    size = np.sqrt(np.mean(shown**2) / np.mean(wave.columns**2))
    return [(f"{UNKNOWN}wave of {wave.period:.4g} s", wave.columns * size)]


def _observe(world: Cutting, rest: Array, covariance: Array) -> ObservedPoints:
    """Return the points with the state of the machine when each was cut."""
    row, _ = world.makers()
    run: Run = world.tool.run.take(row)
    return ObservedPoints(
        rest=rest,
        covariance=covariance,
        normals=world.contacts.normal,
        place=run.vector("part_x_mm", "part_y_mm", "part_z_mm"),
        feature=run.labels["feature"],
        line=run.columns["line"].astype(np.intp),
        run=run,
    )


def _compare(model: LinearModel, measured: Array, trials: Array) -> tuple[BesidePrediction, ...]:
    """Compare each characteristic with the prediction of measuring such a part. trials (m, n): departures of the points, mm.

    The scatter of the points is in the trials, so that a form that grows with it is predicted with its expected size.
    """
    drawn = model.values(model.q0 + trials @ model.operator.T)
    mean, u = drawn.mean(axis=0), drawn.std(axis=0)
    features = model.task.part.features
    return tuple(
        BesidePrediction(c.name, gps.unit(c), gps.nominal(c, features), float(value), float(m), float(s))
        for c, value, m, s in zip(model.characteristics, measured, mean, u)
    )
