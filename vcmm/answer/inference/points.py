"""Convert measured points into a measuring task: the machine positions of each of them, and the surface there.

The measured points are put on their nominal surfaces; these feet are the touches of the task, and the distance of the measured point
from its foot, less the known error of the machine, is the form of the surface there. Evaluated at its estimates the
task so gives the measured points again, and everything else (bias, U, budget, decision) is what the machine does to them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vcmm.answer.inference.given_points import GivenPoints
from vcmm.answer.inference.point_checks import OnSurface, check_points, feature_rows, surfaces
from vcmm.answer.inference.rounding import with_digits
from vcmm.core.errors import DataError, VcmmError, choose_from
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.part.alignment import align
from vcmm.part.fit import FittedElement, gauss
from vcmm.part.part import Feature
from vcmm.task.measuring.plan import Ints, Step, Stylus, touches
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.task import Task, measured_points, nominal_element, per_normal

FRAMES = ("part", "machine")
ROUNDS = 3  # of the alignment from points in the machine frame; the second only moves the points where normals turn


def task_and_rows(
    scenario: Scenario, given: GivenPoints, in_machine: bool = False, tip_centres: bool = False
) -> tuple[Task, Ints]:
    """Return the task of measured points, and the row of the file of every touch.

    in_machine: they are in the machine frame, and the part is found by the alignment of the plan from where [pose] says it
    lies. tip_centres: not compensated for the tip. DataError: see
    `check_points`.
    """
    rows = feature_rows(scenario, given)
    pose, points = scenario.pose, given.points
    if in_machine:
        points = pose.inverse().apply(points)
    stylus = _styli(scenario, given, rows, points)
    if tip_centres:
        points = _compensate_tip(scenario, rows, points, stylus)
    placed = surfaces(scenario.part, rows, points)
    check_points(scenario, given, points, placed, in_machine)
    _elements(scenario, given, rows, points)
    if in_machine and scenario.plan.alignment:
        pose, points = _align(scenario, given, rows, points)
        placed = surfaces(scenario.part, rows, points)
    return _task(scenario.at(pose), placed, points, stylus, given.step)


def _task(
    scenario: Scenario, placed: Mapping[str, OnSurface], points: Array, stylus: list[str], step: float
) -> tuple[Task, Ints]:
    steps = []
    for p, name, at in _runs(placed, stylus):
        steps.append(Step(p.feature.name, name, p.foot[at], p.normal[at]))
    order = np.concatenate([p.rows[at] for p, _, at in _runs(placed, stylus)])
    machine = with_digits(scenario.informed_machine(), step)
    placed_touches = touches(
        replace(scenario.plan, steps=tuple(steps)), scenario.pose, machine, scenario.constants
    )
    bare = Task(
        machine, scenario.part, scenario.plan, placed_touches, machine.inputs, np.zeros(len(order)),
        forms=scenario.forms, from_points=True,
    )  # fmt: skip
    indicated = measured_points(bare, machine.indication_error(placed_touches.run))
    beside = ((points[order] - indicated) * placed_touches.normals).sum(axis=1)
    form = beside / (per_normal(placed_touches) * placed_touches.normals).sum(axis=1)
    return replace(bare, form=form), order


def _runs(placed: Mapping[str, OnSurface], stylus: list[str]) -> list[tuple[OnSurface, str, Ints]]:
    """Return the points of one feature with one stylus, which a plan calls a step."""
    out = []
    for p in placed.values():
        names = [stylus[i] for i in p.rows]
        for name in dict.fromkeys(names):
            out.append((p, name, np.array([i for i, n in enumerate(names) if n == name], dtype=np.intp)))
    return out


def _styli(scenario: Scenario, given: GivenPoints, rows: Mapping[str, Ints], points: Array) -> list[str]:
    """Return the stylus of every row: as labelled, else that of the plan (of the nearest planned point where several touch a feature)."""
    plan = scenario.plan
    if given.styli is not None:
        wrong = [i for i, s in enumerate(given.styli) if s not in plan.styli]
        if wrong:
            i = wrong[0]
            raise DataError(
                f'{given.where[i]}: the plan has no stylus "{given.styli[i]}".{choose_from(given.styli[i], plan.styli)}'
            )
        return list(given.styli)
    out = [""] * len(points)
    for name, at in rows.items():
        steps = [s for s in plan.steps if s.feature == name]
        used = list(dict.fromkeys(s.stylus for s in steps or plan.steps))
        if len(used) > 1 and not steps:
            raise DataError(
                f'{given.where[at[0]]}: the plan does not touch "{name}" and has several styli; add the column stylus'
            )
        for i in at:
            out[i] = used[0] if len(used) == 1 else _nearest(steps, points[i])
    return out


def _nearest(steps: list[Step], point: Array) -> str:
    return min(steps, key=lambda s: float(np.linalg.norm(s.points - point, axis=1).min())).stylus


def _compensate_tip(scenario: Scenario, rows: Mapping[str, Ints], centres: Array, stylus: list[str]) -> Array:
    """Return points (n, 3) on the surface: tip centres less the tip radius along the normal of the fitted surface.

    The centres lie on a surface parallel to the real one, so the element fitted to them has its normals. The nominal
    normal is off by the angle under which a displaced feature is seen: a bore of 12 mm that is 0.15 mm off its place
    would read r phi^2 / 2, 1.4 um too small with a tip of 5 mm. Features that no element fits keep the nominal normal.
    """
    styli: Mapping[str, Stylus] = scenario.plan.styli
    out = centres.copy()
    for name, p in surfaces(scenario.part, rows, centres).items():
        radius = np.array([styli[stylus[i]].tip_radius for i in p.rows])
        out[p.rows] = centres[p.rows] - radius[:, None] * _found_normals(
            scenario.part.features[name], p, centres
        )
    return out


def _found_normals(feature: Feature, p: OnSurface, centres: Array) -> Array:
    """Return the outward normals (n, 3) of the element that fits the centres; the nominal ones where none does."""
    if feature.kind not in ("plane", "circle", "sphere", "cylinder", "cone", "torus"):
        return p.normal
    fixed = feature.axis if feature.kind == "circle" else None
    try:
        normals = gauss(feature.kind, centres[p.rows], nominal_element(feature), fixed_axis=fixed).normals
    except VcmmError:
        return p.normal
    return normals * np.sign((normals * p.normal).sum(axis=1))[:, None]


def _align(
    scenario: Scenario, given: GivenPoints, rows: Mapping[str, Ints], points: Array
) -> tuple[Pose, Array]:
    """Return the pose that the alignment gives in the machine, and the points in the drawing frame."""
    scheme = scenario.plan.alignment
    assert scheme is not None
    pose, features = scenario.pose, scenario.part.features
    for _ in range(ROUNDS):
        alignment = align(scheme, features, _elements(scenario, given, rows, points), Pose.identity())
        points, pose = alignment.apply(points), pose @ alignment.inverse()
    return pose, points


def _elements(
    scenario: Scenario, given: GivenPoints, rows: Mapping[str, Ints], points: Array
) -> dict[str, FittedElement]:
    """Return the Gauss elements of all features. DataError, with feature and file, for points that determine none."""
    out = {}
    for name, at in rows.items():
        feature = scenario.part.features[name]
        if feature.free:
            continue
        fixed = feature.axis if feature.kind == "circle" else None
        try:
            out[name] = gauss(feature.kind, points[at], nominal_element(feature), fixed_axis=fixed)
        except VcmmError as error:
            raise DataError(f'{given.where[at[0]]}: points of "{name}": {error}') from None
    return out
