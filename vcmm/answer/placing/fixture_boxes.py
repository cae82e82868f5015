"""The poses that a fixture allows, as boxes of unit coordinates: one box per combination of discrete choices.

Turns come first. For the orientation they give, the travels leave an interval of shifts along each axis; a free shift
is the fraction of the remaining range, so that no coordinate of the box lies out of the travels and an optimum
at the end of an axis is an optimum on a face of the box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from vcmm.answer.placing.hindrances import Constraint, Hindrance
from vcmm.answer.placing.sobol import sobol
from vcmm.answer.placing.travels import Travels
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.task.measuring.fixture import DOFS, Fixture, Freedom, format_freedom, pose_of

Bools = npt.NDArray[np.bool_]
LEAST_SHIFT_RANGE_MM = 10.0  # mm: a range of shifts that is worth a search
BATCH, PROBES = 32, 64  # poses checked at a time; poses that show a box


def default_fixture() -> Fixture:
    """Return the default fixture: x and y free within the travels, any turn about the vertical."""
    ends = (-np.inf, np.inf)
    return Fixture((Freedom("x", *ends), Freedom("y", *ends), Freedom("turn_z", -np.pi, np.pi)))


@dataclass(frozen=True, eq=False)
class PoseBox:
    """One combination of discrete choices; d free coordinates, each 0 to 1."""

    label: str
    template: Array
    freedoms: tuple[Freedom, ...]
    travels: Travels
    further: Sequence[Constraint] = field(default=())

    @property
    def d(self) -> int:
        return len(self.freedoms)

    def poses(self, unit: Array) -> tuple[Array, Bools]:
        """Return poses (m, 6) of coordinates (m, d), and which of them are feasible."""
        six = np.tile(self.template, (len(unit), 1))
        for j, f in enumerate(self.freedoms):
            if f.name.startswith("turn"):
                six[:, DOFS.index(f.name)] = f.low + unit[:, j] * (f.high - f.low)
        low, high = self.travels.intervals(six)
        ok = np.ones(len(unit), dtype=bool)
        free = {DOFS.index(f.name): j for j, f in enumerate(self.freedoms)}
        for i in range(3):
            if i not in free:
                ok &= (six[:, i] >= low[:, i] - 1e-9) & (six[:, i] <= high[:, i] + 1e-9)
                continue
            f = self.freedoms[free[i]]
            a, b = np.maximum(low[:, i], f.low), np.minimum(high[:, i], f.high)
            ok &= a <= b
            six[:, i] = np.where(a <= b, a + unit[:, free[i]] * (b - a), (a + b) / 2)
        for part in self.further:
            if ok.any():
                ok[ok] = part.feasible(six[ok])
        return six, ok

    def unit(self, six: Array) -> Array:
        """Return coordinates (m, d) of poses (m, 6); outside 0 to 1 where the fixture does not allow them."""
        low, high = self.travels.intervals(six)
        out = np.zeros((len(six), self.d))
        for j, f in enumerate(self.freedoms):
            i = DOFS.index(f.name)
            a = np.maximum(low[:, i], f.low) if i < 3 else np.full(len(six), f.low)
            b = np.minimum(high[:, i], f.high) if i < 3 else np.full(len(six), f.high)
            out[:, j] = (six[:, i] - a) / np.where(b > a, b - a, 1.0)
        return out


def boxes(
    fixture: Fixture, present: Array, travels: Travels, further: Sequence[Constraint] = ()
) -> list[PoseBox]:
    """Return all boxes of a fixture. Raises ModelLimit when no pose of any of them can be reached."""
    every = all_boxes(fixture, present, travels, further)
    kept = [box for box in every if _reachable(box)]
    if not kept:
        raise ModelLimit(no_pose(every))
    return kept


def unreachable(
    fixture: Fixture, present: Array, travels: Travels, further: Sequence[Constraint], kept: Sequence[PoseBox]
) -> list[str]:
    """Return one sentence on the discrete choices (slots, faces down, listed turns) that no search can use, and why."""
    labels = {box.label for box in kept}
    lost = [b for b in all_boxes(fixture, present, travels, further) if b.label not in labels]
    if not lost:
        return []
    why = "; ".join(f"{b.label} ({_why_not(b)})" for b in lost[:4]) + ("; ..." if len(lost) > 4 else "")
    return [
        f"{len(lost)} of {len(lost) + len(kept)} choices of the fixture cannot be reached and were left out: {why}"
    ]


def _why_not(box: PoseBox) -> str:
    """Return why the middle of a box cannot be used, in a few words."""
    six, _ = box.poses(np.full((1, box.d), 0.5))
    if _lacks(box, six)[0].any():
        return _missing(box, six[0]).split("; ")[0]
    problems = [p for part in box.further for p in part.problems(pose_of(six[0]))]
    return min(problems, key=lambda p: p.amount).text if problems else "not every touch can be reached"


def _reachable(box: PoseBox) -> bool:
    """Return whether some probe is feasible; the first feasible one ends the test."""
    unit = _probes(box)
    return any(bool(box.poses(unit[at : at + BATCH])[1].any()) for at in range(0, len(unit), BATCH))


def all_boxes(
    fixture: Fixture, present: Array, travels: Travels, further: Sequence[Constraint] = ()
) -> list[PoseBox]:
    """Return one box per combination of discrete choices, reachable or not."""
    return [
        PoseBox(label, six, fixture.continuous, travels, further)
        for label, six in fixture.orientations(present)
    ]


def probe_poses(box: PoseBox) -> Array:
    """Return poses (m, 6) that cover a box, reachable or not."""
    return box.poses(_probes(box, PROBES))[0]


def _probes(box: PoseBox, count: int = 1024) -> Array:
    """Return the coordinates that cover a box, the middle and the corners of its turns among them."""
    if not box.d:
        return np.zeros((1, 0))
    return np.concatenate([sobol(box.d, count), np.full((1, box.d), 0.5)])


def no_pose(closed: Sequence[PoseBox]) -> str:
    """Return why no pose can be reached: the constraint, and the smallest relaxation that opens one."""
    best: tuple[float, PoseBox, Array] | None = None
    for box in closed:
        six = box.poses(_probes(box))[0]
        amounts = _lacks(box, six)[0].sum(axis=1)
        for row in np.flatnonzero(amounts > 1e-9):
            if best is None or amounts[row] < best[0]:
                best = float(amounts[row]), box, six[row]
    if best is None:
        return (
            "no pose of the fixture can be reached: the travels would allow some, but another constraint (collision, "
            "access) refuses every one; " + _further(closed)
        )
    return f"no pose of the fixture can be reached: {_missing(*best[1:])}"


def _lacks(box: PoseBox, six: Array) -> tuple[Array, Array, Array]:
    """Return the gap between fixture and travels (m, 3) mm; the shifts (m, 3) that the travels allow, low and high."""
    low, high = box.travels.intervals(six)
    least, most = (np.stack(e, axis=1) for e in zip(*(_ends(box, six, i) for i in range(3))))
    lacks = np.maximum(low, least) - np.minimum(high, most)
    return np.where(lacks > 1e-9, lacks, 0.0), low, high


def _ends(box: PoseBox, six: Array, i: int) -> tuple[Array, Array]:
    """Return lowest and highest shift along axis i that the fixture allows, (m,)."""
    f = next((f for f in box.freedoms if DOFS.index(f.name) == i), None)
    return (six[:, i], six[:, i]) if f is None else (np.full(len(six), f.low), np.full(len(six), f.high))


def _missing(box: PoseBox, six: Array) -> str:
    """Return by how much one pose misses, and what to change."""
    lacks, low, high = (x[0] for x in _lacks(box, six[None]))
    words = [_axis_text(box, i, six, (low[i], high[i]), lacks[i]) for i in range(3) if lacks[i]]
    return " and also ".join(words) + f" (the least, found at {_at(box, six)})"


def _axis_text(box: PoseBox, i: int, six: Array, travel: tuple[float, float], lacks: float) -> str:
    axis = "XYZ"[i]
    names = ", ".join(dict.fromkeys(x.what for x in box.travels.limits if x.direction == i))
    if travel[0] > travel[1]:
        extent = np.ptp(box.travels.rows.axis_positions(six[None])[0][:, i])
        room = extent - (travel[0] - travel[1])
        return (
            f"the part is larger than the machine: the touches need {extent:.6g} mm along {axis}, {names} leaves {room:.6g} mm; "
            f"{lacks:.4g} mm more would open a pose"
        )
    ends = [float(e[0]) for e in _ends(box, six[None], i)]
    text = f"{ends[0]:.6g} to {ends[1]:.6g} mm" if ends[0] < ends[1] else f"{ends[0]:.6g} mm"
    upper = travel[0] > ends[1]
    what = "it" if ends[0] == ends[1] else f"its {'upper' if upper else 'lower'} end"
    return (
        f"{names} allows {DOFS[i]} from {travel[0]:.6g} to {travel[1]:.6g} mm, the fixture {text}; move {what} "
        f"{'up' if upper else 'down'} by {_up(lacks)} mm to open a single pose, {_usable(box, i, upper)}"
    )


def _usable(box: PoseBox, i: int, upper: bool) -> str:
    """Return by how much to move an end so that there is something to search: room along the axis, at half of the orientations."""
    six = box.poses(_probes(box))[0]
    _, low, high = _lacks(box, six)
    ends = _ends(box, six, i)
    gap = (low[:, i] - ends[1] if upper else ends[0] - high[:, i])[high[:, i] >= low[:, i]]
    room = min(LEAST_SHIFT_RANGE_MM, float((high - low)[:, i].max()))
    where = " at half of the orientations tried" if np.ptp(gap) > 1e-6 else ""
    return f"by {_up(float(np.median(gap)) + room)} mm to leave {room:.4g} mm{where}"


def _up(amount: float) -> str:
    """Return mm as text, never rounded down."""
    return f"{np.ceil(1e3 * amount - 1e-6) / 1e3:.7g}"


def _at(box: PoseBox, six: Array) -> str:
    turns = ", ".join(format_freedom(n, six[DOFS.index(n)]) for n in DOFS[3:])
    return (f"{box.label}, " if box.label else "") + f"turn {turns}"


def _further(closed: Sequence[PoseBox]) -> str:
    """Return the smallest problem that the other constraints name at the middle of each box."""
    problems: list[Hindrance] = []
    for box in closed:
        six, _ = box.poses(np.full((1, box.d), 0.5))
        for part in box.further:
            problems += part.problems(pose_of(six[0]))
    if not problems:
        return "widen the fixture"
    least = min(problems, key=lambda p: p.amount)
    return f"at the middle of the fixture: {least.constraint} at {least.point}, {least.amount:.4g} mm to give way"
