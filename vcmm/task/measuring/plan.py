"""Plan: the points to touch, their styli and order; and the Run that a machine makes of it.

`touches` places the planned points in the machine (pose), finds the axis positions that bring the tip there, and
fills the columns that effects need: approach, sense, speed, time, probe angle, temperatures, labels.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from vcmm.core.axes import is_rotary, unit_vector
from vcmm.core.errors import ModelLimit, UsageError, choose_from
from vcmm.core.kinematics import Axis, Chain, nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array, Run
from vcmm.part.alignment import Alignment

Words = npt.NDArray[np.str_]
Ints = npt.NDArray[np.intp]
POSITIONING_MM_S = 100.0  # between touches, where the machine file names no axis speed


@dataclass(frozen=True, eq=False)
class Stylus:
    """offset: tip relative to the last tool-side frame (3,) mm; tip_radius as qualified, mm; length for bending, mm.

    event: head orientation or stylus change this stylus belongs to (one draw of `reindexing` per event).
    """

    name: str
    offset: Array
    tip_radius: float
    length: float = 0.0
    event: str = ""

    @property
    def direction(self) -> Array:
        """Unit vector from head to tip; -Z for a stylus without offset."""
        size = float(np.linalg.norm(self.offset))
        return self.offset / size if size > 0 else np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class Touch:
    """Motion of a touch: speed mm/s, approach and clearance mm, positioning speed mm/s."""

    speed: float = 5.0
    approach: float = 3.0
    clearance: float = 20.0
    positioning: float = POSITIONING_MM_S


@dataclass(frozen=True, eq=False)
class Step:
    """One feature measured with one stylus. points, normals (n, 3) in the drawing frame; approach (n, 3) unit or None = -normal."""

    feature: str
    stylus: str
    points: Array
    normals: Array
    approach: Array | None = None


@dataclass(frozen=True, eq=False)
class Plan:
    """Steps in measuring order. alignment None = the part lies where the pose says."""

    steps: tuple[Step, ...]
    styli: Mapping[str, Stylus]
    touch: Touch = field(default_factory=Touch)
    alignment: Alignment | None = None

    def __post_init__(self) -> None:
        if not self.steps:
            raise UsageError(
                'the plan is empty; add [[plan.steps]] with feature, stylus and points = { strategy = "..." }'
            )
        for step in self.steps:
            if step.stylus not in self.styli:
                raise UsageError(
                    f'the step on {step.feature} uses stylus "{step.stylus}".{choose_from(step.stylus, self.styli)}'
                )


@dataclass(frozen=True, eq=False)
class Touches:
    """All touches of a plan at one pose. points, normals, approach (n, 3) in the drawing frame; run in the machine."""

    run: Run
    points: Array
    normals: Array
    approach: Array
    tip_radius: Array
    rows: Mapping[str, Ints]  # feature -> row numbers
    pose: Pose  # machine_from_part


def touches(
    plan: Plan, pose: Pose, machine: Machine, constants: Mapping[str, float] | None = None
) -> Touches:
    """Place the plan in the machine. constants: run columns with one value (temperatures).

    Raises ModelLimit when a touch lies outside the travels, naming point, feature, axis and travel.
    """
    points = np.concatenate([s.points for s in plan.steps])
    normals = np.concatenate([s.normals for s in plan.steps])
    approach = np.concatenate([-s.normals if s.approach is None else s.approach for s in plan.steps])
    feature = np.concatenate([[s.feature] * len(s.points) for s in plan.steps])
    stylus = np.concatenate([[s.stylus] * len(s.points) for s in plan.steps])
    _check_approach(feature, normals, approach)
    radius = np.array([plan.styli[s].tip_radius for s in stylus])
    offset = np.array([plan.styli[s].offset for s in stylus])
    in_machine, normal, direction = pose.apply(points), pose.turn(normals), pose.turn(approach)
    tip = in_machine + radius[:, None] * normal
    position = axis_positions(machine.chain, machine.axes, tip, offset)
    labels = _labels(plan, feature, stylus)
    columns = {f"n{c}": normal[:, i] for i, c in enumerate("xyz")}
    columns |= {f"part_{c}_mm": (in_machine - pose.shift)[:, i] for i, c in enumerate("xyz")}
    columns |= _history(plan.touch, machine, position, tip, normal, direction)
    columns |= probe_columns(plan, stylus, normal)
    columns |= {name: np.full(len(points), value) for name, value in (constants or {}).items()}
    run = Run(position, offset, columns, labels)
    run = _within_reach(machine, run, feature)
    rows = {name: np.flatnonzero(feature == name) for name in dict.fromkeys(feature)}
    return Touches(
        run=run, points=points, normals=normals, approach=approach, tip_radius=radius, rows=rows,
        pose=pose,
    )  # fmt: skip


def axis_positions(chain: Chain, axes: Mapping[str, Axis], tip: Array, offset: Array) -> dict[str, Array]:
    """Return the positions of the linear axes that bring the tip to `tip` (n, 3) in workpiece axes; rotary axes stay at zero.

    At zero angles the tip is the sum of the axis positions along their directions and the offset.
    Raises ModelLimit when a direction of travel is missing (a lathe without Y).
    """
    zero = Run({a: np.zeros(len(tip)) for a in chain.letters}, offset)
    wanted = tip - nominal_tip(chain, axes, zero)
    out = {}
    for i, letter in enumerate("XYZ"):
        if letter in chain.letters:
            out[letter] = wanted @ unit_vector(letter)
        elif np.abs(wanted[:, i]).max(initial=0.0) > 1e-9:
            raise ModelLimit(
                f"the machine {chain.structure} has no axis {letter}, but the plan needs {letter} = "
                f"{wanted[np.abs(wanted[:, i]).argmax(), i]:.6g} mm; place the points at zero there"
            )
    return out | {a: np.zeros(len(tip)) for a in chain.letters if is_rotary(a)}


def _check_approach(feature: Array, normals: Array, approach: Array) -> None:
    against = -(normals * approach).sum(axis=1)
    bad = np.flatnonzero(against < 0.17)  # 80 deg from the normal: the tip would slide, not touch
    if len(bad):
        raise UsageError(
            f"the approach to point {bad[0] + 1} ({feature[bad[0]]}) is {np.degrees(np.arccos(np.clip(against[bad[0]], -1, 1))):.0f} "
            "deg from the inward normal; keep it under 80 deg"
        )


def _within_reach(machine: Machine, run: Run, feature: Array) -> Run:
    """Return the run prepared by the machine. ModelLimit, with the feature of the point, for a touch outside the travels."""
    try:
        return machine.prepare(run)
    except ModelLimit as error:
        where = f" (a point on {feature[error.row]})" if error.row is not None else ""
        raise ModelLimit(f"some point is out of travel{where}: {error}") from None


def _labels(plan: Plan, feature: Words, stylus: Words) -> dict[str, Words]:
    count: dict[str, int] = {}
    touch = []
    for name in feature:  # named after feature and number there: other features do not change the draws
        count[name] = count.get(name, 0) + 1
        touch.append(f"{name}#{count[name]}")
    event = [plan.styli[s].event or s for s in stylus]
    return {"feature": feature, "stylus": stylus, "touch": np.array(touch), "event": np.array(event)}


def probe_columns(plan: Plan, stylus: Words, normal: Array) -> dict[str, Array]:
    """Return probe_angle about the stylus axis (0 along the machine axis nearest to +X), lateral share of n, stylus length."""
    direction = np.array([plan.styli[s].direction for s in stylus])
    length = np.array([plan.styli[s].length for s in stylus])
    return probe_angles(direction, length, normal)


def probe_angles(direction: Array, length: Array, normal: Array) -> dict[str, Array]:
    """Return the columns of `probe_columns` from the direction (n, 3) and the length (n,) of the stylus of every row."""
    along = (normal * direction).sum(axis=1)
    reference = np.where(np.abs(direction[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = reference - (reference * direction).sum(axis=1)[:, None] * direction
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(-direction, first)  # seen from the head, counter-clockwise for a stylus pointing down
    angle = np.arctan2((normal * second).sum(axis=1), (normal * first).sum(axis=1))
    lateral = np.sqrt(np.maximum(0.0, 1.0 - along**2))
    return {"probe_angle_rad": angle, "probe_lateral": lateral, "stylus_length_mm": length}


def _history(
    touch: Touch, machine: Machine, position: Mapping[str, Array], tip: Array, normal: Array, direction: Array
) -> dict[str, Array]:
    """Return time, speed and sense of every axis: positioning to the start of the approach, then the approach itself."""
    begin, away = -touch.approach * direction, touch.approach * normal
    start, left = tip + begin, tip + away  # of the approach, of the retract
    lift = np.array([0.0, 0.0, touch.clearance])
    seconds = np.full(len(tip), 2 * touch.approach / touch.speed)
    out: dict[str, Array] = {}
    for letter in machine.chain.letters:
        if letter not in "XYZ":
            out[f"sense_{letter}"] = np.zeros(len(tip))
            continue
        i = "XYZ".index(letter)
        # the axis' own travel between touches: another stylus moves the axis where the tip does not move
        q = position[letter]
        travel = (q + begin[:, i]) - np.concatenate([q[:1] + begin[:1, i] + lift[i], (q + away[:, i])[:-1]])
        final = np.where(np.abs(direction[:, i]) > 1e-9, direction[:, i], travel)
        sense = np.where(np.abs(final) > 1e-9, np.sign(final), 0.0)
        for row in range(1, len(sense)):  # an axis that did not move keeps its last sense
            sense[row] = sense[row] or sense[row - 1]
        out[f"sense_{letter}"] = sense
    moved = start - np.concatenate([start[:1] + lift, left[:-1]])
    seconds += np.linalg.norm(moved, axis=1) / touch.positioning
    for i, letter in enumerate("XYZ"):
        out[f"speed_{letter}_mm_s"] = touch.speed * direction[:, i]
    out["time_s"] = np.cumsum(seconds)
    return out
