"""Simulate measurements on a machine and of parts that no route knows: sampled once from the stated knowledge, then measured repeatedly.

One machine is sampled and kept (its geometry, its styli); parts have a size, a place, a form and an expansion of their own; the
scatter of touches and all temperatures are sampled anew at every measurement, as repeats over several days show them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.exact import draw_inputs, exact_values
from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.streams import key
from vcmm.answer.evaluation.world import FORM
from vcmm.answer.routes.positions import LENGTH, RING, USUAL_POSITIONS, StandardReadings
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.part.part import Characteristic, Feature, Part, normal
from vcmm.part.random_form import ROUND, SMOOTH, random_forms
from vcmm.physics.structure.expansion import PartExpansion
from vcmm.task.measuring.plan import Step
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.task import Task, evaluate_all, fit_features, measured_points
from vcmm.task.response.trials import Draws

SAME_EACH_TIME = (
    "machine",
    "stylus",
    "instrument",
)  # redraw labels of what stays the same from one measurement to the next
# mm: standard deviation of size and place, range of the form of a hidden part
OFF = 3e-3
SHIFTED = 3e-3
RANGE = 1e-3
PER_POSITION = 5
FIRST_ANEW = 16  # trial from which on measurements are counted; below it stand the machine and the parts
OWN, CALIBRATED_ONE, STANDARD = 1, 2, 3  # trials of the parts' own properties
FORM_KINDS = ("line", "plane", *ROUND)
SHORTEST_STANDARD, U_LENGTH, U_PER_LENGTH, U_RING = 50.0, 0.05e-3, 0.25e-6, 0.1e-3  # mm; k = 1
RING_DIAMETER = 20.0


@dataclass(frozen=True)
class HiddenMachine:
    """The machine that is sampled from a scenario, by seed."""

    seed: int

    def measure(self, task: Task, part: int, first: int, count: int) -> Array:
        """Measure a part `count` times (count, C). part: trial of its own properties; first: number of the first measurement."""
        model = build(task)
        kept = draw_inputs(model, self.seed, 0, FIRST_ANEW)
        anew = draw_inputs(model, self.seed, FIRST_ANEW + first, count)
        return exact_values(model, [_draw_inputs(a, b, part, count) for a, b in zip(kept, anew)])


def _draw_inputs(kept: Draws, anew: Draws, part: int, count: int) -> Draws:
    """Return the draws of one Input for `count` measurements: kept from one trial, or sampled anew."""
    which = _trial(anew.influence.input, part)
    if which is None:
        return anew
    rows = np.full(count, which)
    return Draws(anew.influence, kept.raw[rows], kept.departures[rows])


def _trial(quantity: Input, part: int) -> int | None:
    """Return the trial in which an Input is kept; None where it is sampled anew."""
    if quantity.effect == FORM or quantity.effect == PartExpansion.name:
        return part
    return None if quantity.is_channel or quantity.redraw not in SAME_EACH_TIME else 0


def anew(quantity: Input) -> bool:
    """Return whether repeats over several days show an Input as scatter."""
    return _trial(quantity, OWN) is None


def hidden_part(task: Task, seed: int, name: str) -> Task:
    """Return the task with a part that is off by a few um in size and place and has a form; the same for every pose."""
    rng = np.random.default_rng(key(seed, f"hidden part: {name}"))
    form = task.form.copy()
    for feature_name, rows in task.touches.rows.items():
        feature = task.part.features[feature_name]
        shift, size = rng.normal(0.0, SHIFTED, 3), rng.normal(0.0, OFF)
        form[rows] += normal(feature, task.touches.points[rows]) @ shift + size
        if feature.kind in FORM_KINDS:
            form[rows] += RANGE * random_forms(feature, task.touches.points[rows], 1, SMOOTH, rng)[0]
    return replace(task, form=form)


def true_values(task: Task) -> Array:
    """Return the indications of a machine without errors for the part at these points, (C,) mm or rad."""
    points = measured_points(task, np.zeros((task.touches.run.n, 3)))
    return np.asarray(evaluate_all(task, fit_features(task, points)))


def indicated_values(task: Task) -> Array:
    """Return the indications of the machine for the part of the task with all errors at their estimates, (C,)."""
    points = measured_points(task, task.machine.indication_error(task.touches.run))
    return np.asarray(evaluate_all(task, fit_features(task, points)))


def shows(task: Task) -> Array:
    """Return the change of every characteristic for points scaled by 1 (mm) and moved outwards by 1 mm, (C, 2)."""
    step = 1e-4
    points = measured_points(task, np.zeros((task.touches.run.n, 3)))
    ways = (1e-2 * points, task.touches.normals)
    changes = []
    for way, factor in zip(ways, (1e2, 1.0)):
        up, down = (evaluate_all(task, fit_features(task, points + s * step * way)) for s in (1.0, -1.0))
        changes.append(factor * (up - down) / (2 * step))
    return np.stack(changes, axis=1)


def usable_positions(scenario: Scenario) -> dict[str, Pose]:
    """Return poses in which the plan is within reach: the present one, turned by quarters, and moved about the table.

    Places that the scenario names come first. Fewer than USUAL where the machine has no room for more.
    """
    positions = {"as it lies": scenario.pose}
    candidates: dict[str, Pose] = dict(scenario.places)
    reach = np.array(
        [float(np.ptp(scenario.machine.axes[a].travel)) if a in scenario.machine.axes else 0.0 for a in "XYZ"]
    )
    for share in (0.25, 0.12, 0.0):
        for k, side in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
            turn = np.pi / 2 * (k + 1)
            shift = share * reach * np.array([*side, 0.0])
            about = Pose.from_turns(shift=(0.0, 0.0, 0.0), turns=(0.0, 0.0, turn))
            turned = about @ Pose(scenario.pose.rotation, np.zeros(3))
            name = f"turned by {90 * (k + 1)} deg" + (
                f", moved by {shift[0]:g} {shift[1]:g} mm" if share else ""
            )
            candidates[name] = Pose(turned.rotation, scenario.pose.shift + shift)
    for name, pose in candidates.items():
        if len(positions) < USUAL_POSITIONS and _within_reach(scenario.at(pose)):
            positions[name] = pose
    return positions


def _within_reach(scenario: Scenario) -> bool:
    try:
        scenario.task()
    except ModelLimit:
        return False
    return True


def standards(
    scenario: Scenario, machine: HiddenMachine, positions: Mapping[str, Pose]
) -> list[StandardReadings]:
    """Return a standard of length along x and y of the part in every position, and a ring, each measured five times there.

    A standard is as long as the longest feature of the part, or as the longest that is within the travels in some position. Their calibrated values are true within what their certificates say.
    """
    rng = np.random.default_rng(key(machine.seed, "certificates of the standards"))
    sizes = {abs(f.extent[0]) for f in scenario.part.features.values() if f.extent}
    lengths = sorted({max(SHORTEST_STANDARD, x) for x in sizes} | {SHORTEST_STANDARD}, reverse=True)
    out = []
    for letter, direction in (("x", np.array([1.0, 0.0, 0.0])), ("y", np.array([0.0, 1.0, 0.0]))):
        length = next(
            (x for x in lengths if _fits(scenario, positions, _length_standard(x, direction))), None
        )
        if length is None:
            raise ModelLimit(
                f"a standard of {SHORTEST_STANDARD:g} mm along {letter} of the part is within the travels in no position; move the part ([pose])"
            )
        u = U_LENGTH + U_PER_LENGTH * length
        gauge = _length_standard(length, direction)
        out.append(_standard(scenario, machine, positions, gauge, (LENGTH, length, u), rng))
    ring = _ring(RING_DIAMETER)
    out.append(_standard(scenario, machine, positions, ring, (RING, RING_DIAMETER, U_RING), rng))
    return out


def _standard(
    scenario: Scenario,
    machine: HiddenMachine,
    positions: Mapping[str, Pose],
    gauge: tuple[Part, list[tuple[str, Array]]],
    certified: tuple[str, float, float],
    rng: np.random.Generator,
) -> StandardReadings:
    """Measure one standard in every position in which it is within reach."""
    kind, size, u = certified
    job = _with_standard(scenario, gauge)
    readings = [
        machine.measure(job.at(pose).task(), STANDARD, 1000 + 50 * i, PER_POSITION)[:, 0]
        for i, pose in enumerate(positions.values())
        if _within_reach(job.at(pose))
    ]
    if not readings:
        raise ModelLimit(
            f"a {kind} of {size:g} mm is within the travels in no position; move the part ([pose])"
        )
    return StandardReadings(kind, size + u * rng.standard_normal(), u, np.concatenate(readings))


def _with_standard(scenario: Scenario, gauge: tuple[Part, list[tuple[str, Array]]]) -> Scenario:
    """Return the task with a standard in place of the part, touched by the first stylus of the plan."""
    part, touched = gauge
    stylus = scenario.plan.steps[0].stylus
    steps = tuple(Step(name, stylus, points, normal(part.features[name], points)) for name, points in touched)
    return replace(scenario, part=part, plan=replace(scenario.plan, steps=steps, alignment=None), forms={})


def _fits(
    scenario: Scenario, positions: Mapping[str, Pose], gauge: tuple[Part, list[tuple[str, Array]]]
) -> bool:
    """Return whether a standard is within reach in some position."""
    job = _with_standard(scenario, gauge)
    return any(_within_reach(job.at(pose)) for pose in positions.values())


def _length_standard(length: float, along: Array) -> tuple[Part, list[tuple[str, Array]]]:
    """Return two parallel faces, four touches on each."""
    side = np.cross([0.0, 0.0, 1.0], along)
    spots = np.array([2.0 * (i * side + j * np.array([0.0, 0.0, 1.0])) for i in (-1, 1) for j in (-1, 1)])
    faces = {
        name: Feature(name, "plane", s * length / 2 * along, s * along, np.zeros(0), extent=(8.0, 8.0))
        for name, s in (("first face", -1.0), ("second face", 1.0))
    }
    wanted = Characteristic("length", "distance", between=("first face", "second face"))
    return Part(faces, (wanted,)), [(name, f.point + spots) for name, f in faces.items()]


def _ring(diameter: float) -> tuple[Part, list[tuple[str, Array]]]:
    """Return a plain ring, sixteen touches."""
    ring = Feature(
        "bore", "circle", np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([diameter / 2]), inside=True
    )
    turn = np.arange(16) * np.pi / 8
    points = diameter / 2 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(16)])
    return Part({"bore": ring}, (Characteristic("diameter", "size", of=("bore",)),)), [("bore", points)]
