"""Candidates of a plan: every place on every feature that a stylus can touch, with the effect of errors there.

The whole grid is placed in the machine as one plan, so that the influences are those of `vcmm uncertainty`. Time is
fixed while points are chosen; drift is kept apart, per second, for the order (plan_order.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vcmm.answer.placing.access import GRAZE, ROUNDING
from vcmm.answer.placing.collision import missing_clearance
from vcmm.answer.placing.design import TouchCandidates
from vcmm.answer.placing.form_field import DEFAULT, form_factor, surface_grid
from vcmm.answer.placing.material import part_points, part_solid
from vcmm.answer.placing.motions import Motions, motions_of
from vcmm.answer.placing.reach import Feasibility
from vcmm.answer.placing.solid import Union, cuboid
from vcmm.answer.placing.tool import NAMES, Tooling, touch_sequence
from vcmm.core.errors import ModelLimit
from vcmm.core.pose import Array, Pose
from vcmm.core.run import Run
from vcmm.part.part import Feature, normal
from vcmm.task.measuring.plan import Ints, Plan, Step
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.response.influence import Influence, influences

DENSE = 24  # candidates around a round feature; half as many along the side of a plane
HOUR = 3600.0


@dataclass(frozen=True, eq=False)
class TouchProblem:
    """Everything that the choice of touches needs, for one choice of styli.

    drift (N, D) mm/s: change of the reading along the normal per second. form: columns of `shared` that are form.
    """

    scenario: Scenario
    styli: Mapping[str, str]
    candidates: TouchCandidates
    motions: Mapping[str, Motions]
    drift: Array
    form: slice


def spots(
    scenario: Scenario, styli: Mapping[str, str], extra: Mapping[str, Array] | None = None
) -> dict[str, Array]:
    """Return feature -> points (k, 3) that its stylus can touch: a dense grid, the present points, and `extra` ones."""
    out = {}
    for name, stylus in styli.items():
        feature = scenario.part.features[name]
        radius = scenario.plan.styli[stylus].tip_radius
        present = [s.points for s in scenario.plan.steps if s.feature == name]
        more = [extra[name]] if extra and name in extra else []
        dense = DENSE // 2 if feature.kind == "plane" else DENSE
        grid = surface_grid(feature, dense, margin=radius)
        points = np.unique(np.round(np.concatenate([grid, *present, *more]), 9), axis=0)
        out[name] = points[accessible(scenario, feature, stylus, points)]
    return out


def accessible(scenario: Scenario, feature: Feature, stylus: str, points: Array) -> npt.NDArray[np.bool_]:
    """Return which points (k,) on a feature the stylus reaches at the pose of the scenario: travels, direction, room for the tool."""
    if not len(points):
        return np.zeros(0, dtype=bool)
    plan = replace(
        scenario.plan, steps=(Step(feature.name, stylus, points, normals_at(scenario, feature, points)),)
    )
    rows, around = touch_sequence(plan), scenario.surroundings
    candidate = replace(scenario, plan=plan)
    tooling = Tooling(rows, around)
    boxes = [cuboid(c.pose, c.size) for c in around.clamps if c.on == "part"]
    back = scenario.pose.inverse()
    boxes += [cuboid(back @ c.pose, c.size) for c in around.clamps if c.on == "table"]
    solid = Union((part_solid(scenario.part, around.wall), *boxes))
    corners = part_points(scenario.part)
    check = Feasibility(candidate, rows, tooling, solid, reach=corners, corners=corners)
    rotation, every = scenario.pose.rotation, np.arange(rows.n)
    bodies = [tooling.body(b, every, rows.tip, rows.start, rotation.T) for b in range(len(NAMES))]
    bodies.append(tooling.ball(every, rows.tip, rows.start, np.full(rows.n, -GRAZE)))
    bodies.append(tooling.ball(every, rows.start, rows.start, np.zeros(rows.n)))
    lacks = missing_clearance(solid, bodies).max(axis=0)
    wanted, (low, high) = check.positions(Pose(rotation[None], scenario.pose.shift[None]))[0], check.limits()
    over = np.maximum(low - wanted, wanted - high)[:-1].max(axis=1).reshape(3, -1).max(axis=0)
    return np.asarray((lacks == 0.0) & (over <= ROUNDING) & (check.steep(rotation) == 0.0))


def normals_at(scenario: Scenario, feature: Feature, points: Array) -> Array:
    """Return normals (k, 3); on a mesh those of the present points."""
    if feature.kind != "mesh":
        return normal(feature, points)
    from vcmm.part.mesh import closest

    assert scenario.part.mesh is not None
    return closest(scenario.part.mesh, points)[1]


def problem_of(
    scenario: Scenario,
    styli: Mapping[str, str],
    places: Mapping[str, Array],
    forms: Mapping[str, float],
    drift: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> TouchProblem:
    """Return candidates with their sensitivities. drift (3,): standard uncertainty of a linear drift, mm/s, workpiece axes,
    beyond the inputs of the scenario. ModelLimit where a feature has too few places.
    """
    steps = []
    for name, points in places.items():
        feature = scenario.part.features[name]
        least = sum(1 for _ in motions_of(feature).step)
        if len(points) < max(least, 1):
            raise ModelLimit(
                f'only {len(points)} places on "{name}" can be touched with stylus "{styli[name]}", {least} are needed; '
                "add a stylus of another direction, or turn the part"
            )
        steps.append(Step(name, styli[name], points, normals_at(scenario, feature, points)))
    plan = replace(scenario.plan, steps=tuple(steps))
    task = replace(scenario, plan=plan).task()
    run = task.touches.run
    still = influences(task.machine, _at(run, 0.0), task.inputs)
    later = influences(task.machine, _at(run, HOUR), task.inputs)
    shared, touch, slopes = _columns(still, later, run)
    slopes.append(run.normal * np.asarray(drift, dtype=float))
    names = tuple(places)
    number = np.concatenate([np.full(len(places[n]), i) for i, n in enumerate(names)])
    moving = {n: motions_of(scenario.part.features[n]) for n in names}
    short = np.zeros(run.n)
    fields = np.zeros((run.n, 0))
    for i, name in enumerate(names):
        rows = np.flatnonzero(number == i)
        factor, short[rows] = _form(scenario, moving[name], places[name], forms.get(name, DEFAULT))
        block = np.zeros((run.n, factor.shape[1]))
        block[rows] = factor
        fields = np.concatenate([fields, block], axis=1)
    machine = _compress(np.concatenate(shared, axis=1))
    seconds = np.array([_seconds(plan, places[n]) for n in names])
    jac = tuple(moving[n].rows(places[n], steps[i].normals) for i, n in enumerate(names))
    everything = np.concatenate([machine, fields], axis=1)
    candidates = TouchCandidates(
        names, number, task.touches.points, task.touches.normals, rows=jac, common=everything, touch=touch,
        short=short, seconds=seconds,
    )  # fmt: skip
    drifting = np.concatenate(slopes, axis=1)
    return TouchProblem(
        scenario, dict(styli), candidates, moving, drifting[:, np.abs(drifting).max(axis=0) > 0.0],
        slice(machine.shape[1], everything.shape[1]),
    )  # fmt: skip


def _at(run: Run, time: float) -> Run:
    return run.with_columns({"time_s": np.full(run.n, time)})


def _columns(
    still: tuple[Influence, ...], later: tuple[Influence, ...], run: Run
) -> tuple[list[Array], Array, list[Array]]:
    """Return (shared columns, scatter per touch, drift per second) along the normal, in standard uncertainties."""
    shared, square, slopes = [np.zeros((run.n, 0))], np.zeros(run.n), [np.zeros((run.n, 0))]
    for now, then in zip(still, later):
        along = [_along(i, run) for i in (now, then)]
        if now.input.redraw == "touch":
            square += np.sum(along[0] ** 2, axis=1)
            continue
        slope = (along[1] - along[0]) / HOUR
        for code in range(len(now.copies)):
            mine = (now.codes == code)[:, None]
            shared.append(np.where(mine, along[0], 0.0))
            if np.abs(slope).max(initial=0.0) > 0.0:
                slopes.append(np.where(mine, slope, 0.0))
    return shared, np.sqrt(square), slopes


def _along(influence: Influence, run: Run) -> Array:
    law, factor = influence.input.spread(influence.response.shape[2])
    u = np.atleast_1d(np.asarray(getattr(law, "u", np.nan), dtype=float))
    if not np.all(np.isfinite(u)):
        raise ModelLimit(
            f"{influence.input.id} has no finite standard deviation; give a law of more than 2 degrees of freedom"
        )
    along = np.einsum("nik,ni->nk", influence.response, run.normal)
    return np.asarray(along @ (factor * u))


def _compress(columns: Array) -> Array:
    """Return the same covariance with no more columns than it has rank."""
    if columns.shape[1] == 0:
        return columns
    u, s, _ = np.linalg.svd(columns, full_matrices=False)
    keep = s > 1e-10 * max(float(s[0]), 1e-300)
    return np.asarray(u[:, keep] * s[keep])


def _form(scenario: Scenario, motions: Motions, points: Array, spread: float) -> tuple[Array, float]:
    feature = motions.feature
    if feature.free or feature.kind == "point":
        return np.zeros((len(points), 0)), spread
    reference = surface_grid(feature, 2 * DENSE)
    there = (reference, normal(feature, reference))
    return form_factor(motions, points, spread, scenario.forms.get(feature.name), there)


def _seconds(plan: Plan, points: Array) -> float:
    """Return the seconds of one touch on a feature: approach, retract, and the way to a neighbour, as vcmm.task.measuring.plan counts them."""
    hop = float(np.linalg.norm(np.ptp(points, axis=0))) / max(1.0, np.sqrt(min(len(points), 12)))
    return 2.0 * plan.touch.approach / plan.touch.speed + hop / plan.touch.positioning


def nearest(candidates: TouchCandidates, name: str, points: Array) -> Ints:
    """Return the numbers of the candidates at points (k, 3) of a feature; -1 where none lies within 1 um."""
    rows = candidates.of(candidates.names.index(name))
    apart = np.linalg.norm(candidates.points[rows][None] - points[:, None], axis=2)
    best = apart.argmin(axis=1)
    return np.where(apart[np.arange(len(points)), best] < 1e-3, rows[best], -1)
