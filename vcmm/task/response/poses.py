"""Poses of the tool of an arm, seen by a tracker, against the angles of its joints.

    position = B (t + R o),   orientation = B_R R Q

R, t: frame of the last axis by the machine, its errors included. B: place of the tracker (6 numbers); o, Q: where on the tool the
target sits (3, with orientations 6). B, o and Q are no errors of the machine; they are estimated from the poses themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.rigid import Frame, rotation_from_vector
from vcmm.core.run import Array, Run
from vcmm.task.response.recording import Ints, Recording

LEVER = 1000.0  # mm: tips that far out tell the turn of a frame
STEPS, CONVERGED_STEP = 60, 1e-10  # of Gauss-Newton; step, mm and rad, below which it has come to rest
FIRST_U = (0.1, 1e-4)  # mm, rad: weights of position and orientation before their scatter is known
STARTS = (0.0, 150.0, -150.0)  # mm along every axis of the tool: places of the target that are tried
FAR_STARTS = (1.0, -1.0, 2.0, -2.0)  # in rms radii of the positions, where near starts lead nowhere
NOWHERE = 0.01  # of the spread of the positions: rms of a coordinate beyond which a start led to no placement


@dataclass(frozen=True, eq=False)
class PoseReadings:
    """n poses. position (n, 3) mm; orientation (n, 3, 3) of the target, or None. u: standard uncertainties of both, mm and rad; 0 = not
    stated. lines (n,) of the data file. The offset of `run` is the assumed place of the target on the tool.
    """

    name: str
    run: Run
    position: Array
    orientation: Array | None = None
    u: tuple[float, float] = (0.0, 0.0)
    lines: Ints | None = None

    @property
    def n(self) -> int:
        return len(self.position)

    def take(self, rows: Ints | Sequence[int]) -> PoseReadings:
        """Return some of the poses."""
        which = np.asarray(rows)
        return replace(
            self,
            run=self.run.take(which),
            position=self.position[which],
            orientation=None if self.orientation is None else self.orientation[which],
            lines=None if self.lines is None else self.lines[which],
        )


@dataclass(frozen=True, eq=False)
class TrackerPlacement:
    """Places of tracker and target: turn (3, 3) and shift (3,) of B, offset (3,) mm, turn of the target on the tool (3, 3)."""

    turn: Array
    shift: Array
    offset: Array
    target: Array

    def predict(self, frames: Frame) -> tuple[Array, Array]:
        """Return positions (n, 3) and orientations (n, 3, 3) that the tracker would read."""
        assert frames.rotation is not None
        points = frames.shift + frames.rotation @ self.offset
        return points @ self.turn.T + self.shift, self.turn @ frames.rotation @ self.target

    def after_step(self, step: Array) -> TrackerPlacement:
        """Return the placement after a step of `nuisance_columns`: shift, turn about the points' own origin, offset, and turn of the target."""
        turn = rotation_from_vector(step[None, 3:6])[0]
        target = rotation_from_vector(step[None, 9:12])[0] if len(step) > 9 else np.eye(3)
        return TrackerPlacement(
            turn @ self.turn, turn @ self.shift + step[:3], self.offset + step[6:9], self.target @ target
        )


def tool_frames(machine: Machine, run: Run) -> Frame:
    """Return the frame of the last axis in workpiece axes, errors of the machine included, transforms multiplied: (n, 3, 3) and (n, 3)."""

    def tip(offset: Array) -> Array:
        there = Run(
            run.position,
            np.tile(offset, (run.n, 1)),
            run.columns,
            run.labels,
            run.series,
        )
        ideal = nominal_tip(machine.chain, machine.axes, there)
        return ideal + machine.tip_error(there, exact=True) if machine.effects else ideal

    origin = tip(np.zeros(3))
    columns = [(tip(LEVER * e) - origin) / LEVER for e in np.eye(3)]
    return Frame(np.stack(columns, axis=2), origin)


def departures(poses: PoseReadings, frames: Frame, place: TrackerPlacement) -> tuple[Array, Array | None]:
    """Return measured less predicted: positions (n, 3) mm; orientations (n, 3), the rotation vector from predicted to measured, or None."""
    from scipy.spatial.transform import Rotation

    position, orientation = place.predict(frames)
    if poses.orientation is None:
        return poses.position - position, None
    turned = Rotation.from_matrix(poses.orientation @ orientation.transpose(0, 2, 1)).as_rotvec()
    return poses.position - position, np.asarray(turned)


def stack_rows(position: Array, orientation: Array | None, u: tuple[float, float]) -> Array:
    """Stack departures, or columns (n, 3, k) of them, each over its standard uncertainty: (3 n,) or (6 n,)."""
    parts = [position / u[0]] + ([] if orientation is None else [orientation / u[1]])
    return np.concatenate([p.reshape((-1, *p.shape[2:])) for p in parts])


def nuisance_columns(
    poses: PoseReadings, frames: Frame, place: TrackerPlacement
) -> tuple[Array, Array | None]:
    """Return the change of position (n, 3, k) and orientation per unit of shift, turn (tracker), offset and turn of the target; k = 9, or 12."""
    assert frames.rotation is not None
    n, eye = poses.n, np.eye(3)
    predicted, orientation = place.predict(frames)
    turned = np.stack([np.cross(axis, predicted) for axis in eye], axis=2)
    offset = place.turn @ frames.rotation
    shift, nothing = np.broadcast_to(eye, (n, 3, 3)), np.zeros((n, 3, 3))
    if poses.orientation is None:
        return np.concatenate([shift, turned, offset], axis=2), None
    return (
        np.concatenate([shift, turned, offset, nothing], axis=2),
        np.concatenate([nothing, shift, nothing, orientation], axis=2),
    )


def settle_placement(
    poses: PoseReadings, frames: Frame, start: TrackerPlacement | None = None
) -> TrackerPlacement:
    """Fit the placement of tracker and target by least squares (Gauss-Newton), from any start. Raises ModelLimit where poses are too few or
    too similar to determine it.
    """
    if poses.n < 3:
        raise ModelLimit(
            f"{poses.name}: {poses.n} poses; three or more are needed to find the place of the tracker"
        )
    if start is not None:
        return _refine(poses, frames, start)[0]
    stated = poses.run.offset[0]
    offsets = [stated] if stated.any() else [s * e for e in np.eye(3) for s in STARTS]
    best = _best_of(poses, frames, offsets)
    spread = float(np.sqrt(poses.position.var(axis=0).sum()))
    left = float(np.sqrt(np.mean(departures(poses, frames, best[0])[0] ** 2)))
    if left > NOWHERE * spread:  # a planar arm has its target far from where its axes meet the origin
        far = [s * spread * e for e in np.eye(3) for s in FAR_STARTS]
        best = min(best, _best_of(poses, frames, far), key=lambda end: end[1])
    return best[0]


def _best_of(poses: PoseReadings, frames: Frame, offsets: Sequence[Array]) -> tuple[TrackerPlacement, float]:
    """Return the best placement of those that start with the target at these offsets, and its sum of squares."""
    ends = (_refine(poses, frames, placement_at(poses, frames, o)) for o in offsets)
    return min(ends, key=lambda end: end[1])


def placement_at(poses: PoseReadings, frames: Frame, offset: Array) -> TrackerPlacement:
    """Return the placement from the positions alone, for a target at that offset (Kabsch, Acta Cryst. A32 (1976) 922); then the turn of
    the target."""
    assert frames.rotation is not None
    points = frames.shift + frames.rotation @ offset
    turn = best_turn(points - points.mean(axis=0), poses.position - poses.position.mean(axis=0))
    target = np.eye(3)
    if poses.orientation is not None:
        # B_R R Q = M gives M_i M_j^T = B_R R_i R_j^T B_R^T: rotation vectors that B_R turns (Park & Martin, IEEE Trans. Robotics 10 (1994) 717)
        turn = _turn_by_orientations(frames.rotation, poses.orientation)
        left, _, right = np.linalg.svd(
            np.mean(frames.rotation.transpose(0, 2, 1) @ turn.T @ poses.orientation, axis=0)
        )
        target = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return TrackerPlacement(turn, poses.position.mean(axis=0) - turn @ points.mean(axis=0), offset, target)


def _turn_by_orientations(commanded: Array, measured: Array) -> Array:
    from scipy.spatial.transform import Rotation

    def changes(frames: Array) -> Array:
        return np.asarray(Rotation.from_matrix(frames[1:] @ frames[:-1].transpose(0, 2, 1)).as_rotvec())

    return best_turn(changes(commanded), changes(measured))


def best_turn(points: Array, measured: Array) -> Array:
    """Return the rotation (3, 3) that takes points (n, 3) nearest to those seen, both about their origin."""
    left, _, right = np.linalg.svd(measured.T @ points)
    return np.asarray(left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right)


def _refine(poses: PoseReadings, frames: Frame, place: TrackerPlacement) -> tuple[TrackerPlacement, float]:
    """Return the best placement near `place`, and the sum of squares that it leaves."""
    u = weights(poses)
    cost = np.inf
    for _ in range(STEPS):
        rest = stack_rows(*departures(poses, frames, place), u)
        columns = stack_rows(*nuisance_columns(poses, frames, place), u)
        size = np.linalg.norm(columns, axis=0)
        used = size > 0
        step = np.zeros(len(size))
        step[used] = np.linalg.lstsq(columns[:, used] / size[used], rest, rcond=1e-10)[0] / size[used]
        cost = float(rest @ rest)
        place = _shorter(poses, frames, place, step, cost, u)
        if np.abs(step).max() < CONVERGED_STEP:
            break
    return place, cost


def _shorter(
    poses: PoseReadings,
    frames: Frame,
    place: TrackerPlacement,
    step: Array,
    cost: float,
    u: tuple[float, float],
) -> TrackerPlacement:
    """Return the placement after the step, halved until it is no worse."""
    for _ in range(12):
        there = place.after_step(step)
        rest = stack_rows(*departures(poses, frames, there), u)
        if float(rest @ rest) <= cost * (1 + 1e-12):
            return there
        step = step / 2
    return place


def weights(poses: PoseReadings) -> tuple[float, float]:
    """Return the standard uncertainties of position and orientation as stated, else usual ones."""
    return poses.u[0] or FIRST_U[0], poses.u[1] or FIRST_U[1]


def as_recording(poses: PoseReadings, machine: Machine) -> Recording:
    """Return the positions as a recording of displacements, actual - commanded, in workpiece axes: the tracker's axes laid on the machine's, the
    target at its estimated place. The remaining freedom of both is nuisance (`rigid`, `tool`). Only a calibration uses orientations.
    """
    frames = tool_frames(machine, poses.run)
    place = settle_placement(replace(poses, orientation=None), frames)
    offset = np.tile(place.offset, (poses.n, 1))
    run = Run(poses.run.position, offset, poses.run.columns, poses.run.labels, poses.run.series)
    measured = (poses.position - place.shift) @ place.turn
    value = measured - nominal_tip(machine.chain, machine.axes, run)
    return Recording(
        name=poses.name,
        kind="displacement",
        run=run,
        value=value.ravel(),
        measuring=False,
        row=np.repeat(np.arange(poses.n), 3),
        direction=np.tile(np.eye(3), (poses.n, 1)),
        other=np.full(3 * poses.n, -1, dtype=np.intp),
        u=None if not poses.u[0] else np.full(3 * poses.n, poses.u[0]),
        nuisance={"rigid": "", "tool": ""},
        lines=poses.lines,
    )


def check_arm(machine: Machine, what: str) -> None:
    """Raises UsageError for a chain that is no arm: an axis that carries the workpiece, a linear axis, fewer than two joints."""
    wrong = [a for a in machine.chain.letters if not machine.axes[a].rotary]
    if machine.chain.work or wrong or len(machine.chain.tool) < 2:
        raise UsageError(
            f'{what}: poses are of an arm, a chain of joints that carry the tool, such as structure = "w b C1 A2 A3 C4 A5 C6 t"; this is '
            f'"{machine.chain.structure}"'
        )
