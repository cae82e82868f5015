"""Fixture and goal of a placement: the poses that the fixture allows, and the measure by which poses are compared.

A pose is six numbers: shift x y z (mm) of the part's origin and turns about the fixed x, then y, then z (rad), as in
[pose]. Each of them is fixed, free within a range, or one of a list; slots and faces tie several together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.pose import Array, Pose, unit

TILT = 1e-6  # rad: how well a face must lie on the table, a list of turns be met
SAME_PLACE_MM = 1e-6  # mm
DOFS = ("x", "y", "z", "turn_x", "turn_y", "turn_z")
OBJECTIVE_KINDS = ("U", "U/T", "risk", "cost")
COSTS = ("accept_bad", "reject_good", "undecided")
DOWN: Mapping[str, tuple[float, float, float]] = {
    "-z": (0, 0, -1), "+z": (0, 0, 1), "-x": (-1, 0, 0), "+x": (1, 0, 0), "-y": (0, -1, 0), "+y": (0, 1, 0),
}  # fmt: skip


@dataclass(frozen=True)
class Freedom:
    """One degree of freedom: free between low and high, or one of `values`. Units mm or rad.

    UsageError when the range is empty or nothing is allowed.
    """

    name: str
    low: float = 0.0
    high: float = 0.0
    values: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.name not in DOFS:
            raise UsageError(f'"{self.name}" is no degree of freedom.{choose_from(self.name, DOFS)}')
        if not self.values and not self.low < self.high:
            raise UsageError(
                f"the range of {self.name} is empty: {self.low:g} is not below {self.high:g}; exchange its ends or fix it"
            )

    @property
    def continuous(self) -> bool:
        return not self.values


@dataclass(frozen=True)
class Fixture:
    """Degrees of freedom of the pose. Degrees of freedom that are not named stay as in the present pose.

    slots: allowed shifts (mm), one of them is taken. faces: directions in the drawing (unit vectors by name), one of
    which points down; they set turn_x and turn_y. UsageError when two entries set the same freedom.
    """

    freedoms: tuple[Freedom, ...] = ()
    slots: tuple[tuple[float, float, float], ...] = ()
    faces: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        names = [f.name for f in self.freedoms]
        for name in names:
            if names.count(name) > 1:
                raise UsageError(f"{name} is given {names.count(name)} times; keep one")
        for what, given, taken in (
            ("slots", self.slots, ("x", "y", "z")),
            ("faces_down", self.faces, ("turn_x", "turn_y")),
        ):
            both = [n for n in names if n in taken]
            if given and both:
                raise UsageError(f"{what} sets {', '.join(both)} already; remove {what} or {', '.join(both)}")

    def orientations(self, present: Array) -> list[tuple[str, Array]]:
        """Yield (label, six numbers) of every combination of the discrete choices; free ranges at the present value."""
        choices: list[tuple[str, Array]] = [("", np.array(present, dtype=float))]
        if self.slots:
            choices = [
                (f"slot {i + 1}", _with(p, (0, 1, 2), s))
                for _, p in choices
                for i, s in enumerate(self.slots)
            ]
        if self.faces:
            choices = [
                (_join(label, f"{name} down"), _with(p, (3, 4), turned_down(direction)))
                for label, p in choices
                for name, direction in self.faces.items()
            ]
        for f in self.freedoms:
            if f.continuous:
                continue
            at = DOFS.index(f.name)
            choices = [
                (_join(label, f"{f.name} {format_freedom(f.name, v)}"), _with(p, (at,), (v,)))
                for label, p in choices
                for v in f.values
            ]
        return choices

    @property
    def continuous(self) -> tuple[Freedom, ...]:
        return tuple(f for f in self.freedoms if f.continuous)


def format_freedom(name: str, value: float) -> str:
    """Return a value of a degree of freedom with its unit."""
    return f"{np.degrees(value):.6g} deg" if name.startswith("turn") else f"{value:.6g} mm"


def _join(label: str, more: str) -> str:
    return f"{label}, {more}" if label else more


def _with(six: Array, where: tuple[int, ...], values: Sequence[float]) -> Array:
    out = six.copy()
    out[list(where)] = values
    return out


def turned_down(direction: tuple[float, float, float]) -> tuple[float, float]:
    """Turns about the fixed x, then y (rad) that bring a direction of the drawing (unit vector) to machine -z.

    Rx(a) takes the y component to zero and z to -r, r = sqrt(dy^2 + dz^2); Ry(b) then turns (dx, 0, -r) to (0, 0, -1).
    """
    dx, dy, dz = direction
    r = float(np.hypot(dy, dz))
    a = 0.0 if r < 1e-12 else float(np.arctan2(dy, dz)) + np.pi
    a = float((a + np.pi) % (2 * np.pi) - np.pi)
    return (a if abs(a + np.pi) > 1e-12 else np.pi), float(np.arctan2(dx, r))


def six_of(pose: Pose) -> Array:
    """Return the six numbers of a pose, (6,) or (m, 6): shift mm and turns rad."""
    return np.concatenate([pose.shift, pose.turns()], axis=-1)


def pose_of(six: Array) -> Pose:
    """Return the pose of six numbers (6,) or a batch (m, 6)."""
    six = np.asarray(six, dtype=float)
    return Pose.from_turns(six[..., :3], six[..., 3:])


def off_fixture(fixture: Fixture, poses: Array) -> tuple[Array, Array]:
    """Return the largest departure of poses (m, 6) from what the fixture allows: mm (m,) and rad (m,), 0 where it is met."""
    shift, turn = np.zeros(len(poses)), np.zeros(len(poses))
    for freedom in fixture.freedoms:
        at = DOFS.index(freedom.name)
        off = _off(freedom, poses[:, at], at >= 3)
        if at < 3:
            shift = np.maximum(shift, off)
        else:
            turn = np.maximum(turn, off)
    if fixture.slots:
        apart = np.linalg.norm(poses[:, None, :3] - np.array(fixture.slots, dtype=float), axis=2).min(axis=1)
        shift = np.maximum(shift, np.where(apart > SAME_PLACE_MM, apart, 0.0))
    if fixture.faces:
        down = unit(np.array(list(fixture.faces.values()), dtype=float))
        turned = pose_of(poses).turn(down)
        tilt = np.arctan2(np.hypot(turned[..., 0], turned[..., 1]), -turned[..., 2]).min(axis=1)
        turn = np.maximum(turn, np.where(tilt > TILT, tilt, 0.0))
    return shift, turn


def _off(freedom: Freedom, value: Array, turns: bool) -> Array:
    if freedom.values:
        apart = value[:, None] - np.array(freedom.values)
        if turns:
            apart = (apart + np.pi) % (2.0 * np.pi) - np.pi
        off = np.abs(apart).min(axis=1)
        return np.where(off > (TILT if turns else SAME_PLACE_MM), off, 0.0)
    off = np.maximum(freedom.low - value, value - freedom.high)
    return np.where(off > (TILT if turns else SAME_PLACE_MM), off, 0.0)


@dataclass(frozen=True)
class Goal:
    """Objective to minimise: a mixture of "U", "U/T", "risk" and "cost", each a weighted sum over characteristics.

    weights: characteristic -> share, summing to 1; empty: equal over those that suit. costs: money per wrong decision.
    process: characteristic -> (mean departure from the middle of the tolerance, standard deviation) of the true
    values of the parts to come; where it is not said, mean 0 and a sixth of the tolerance.
    """

    mixture: Mapping[str, float] = field(default_factory=dict)
    weights: Mapping[str, float] = field(default_factory=dict)
    costs: Mapping[str, float] = field(default_factory=dict)
    process: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.mixture:
            if name not in OBJECTIVE_KINDS:
                raise UsageError(f'objective = "{name}" is not known.{choose_from(name, OBJECTIVE_KINDS)}')
        for name in self.costs:
            if name not in COSTS:
                raise UsageError(f'costs: "{name}" is not known.{choose_from(name, COSTS)}')
        for what, table in (("objective", self.mixture), ("weights", self.weights)):
            _check_sum(what, table)
        if any(v < 0 for v in self.costs.values()):
            raise UsageError("costs must not be negative; a gain is the absence of a cost")
        if self.mixture.get("cost") and not self.costs:
            raise UsageError(
                'objective = "cost" needs costs = { accept_bad = 100, reject_good = 20, undecided = 5 } in your currency'
            )


def _check_sum(what: str, table: Mapping[str, float]) -> None:
    if not table:
        return
    total = sum(table.values())
    if any(v < 0 for v in table.values()):
        raise UsageError(f"{what}: a weight is negative; weights are shares from 0 to 1")
    if abs(total - 1) > 1e-6:
        parts = ", ".join(f'"{k}" = {v / total:.4g}' for k, v in table.items()) if total > 0 else ""
        fix = f"; in the same proportion: {{ {parts} }}" if parts else ""
        raise UsageError(f"the {what} sum to {total:.6g}, not to 1{fix}")


@dataclass(frozen=True)
class Placement:
    """[placement] of a scenario. fixture None: x and y free within the travels, turn_z free."""

    fixture: Fixture | None = None
    goal: Goal = field(default_factory=Goal)
