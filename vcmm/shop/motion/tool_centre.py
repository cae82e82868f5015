"""Programs that lead the tip of the tool over the workpiece, as motions of the machine axes.

Under tool centre point control (G43.4, G43.5, TRAORI, M128) and in tilted planes (G68.2, CYCLE800, PLANE) the points of a block
are those of the tip in the workpiece, the tool is long along its own axis, and F is the feed of the tip in the workpiece. The
control works out the axes:

    rotary axes   by their words, or so that the tool points along the direction of the program (the position that it asks for, else
                  the nearest: vcmm.shop.motion.posture); those that the control has turned stay until a word moves them; from block end to block end they run in proportion to the path, as controls do by default
    linear axes   from the tip, the angles and the kinematic chain (vcmm.shop.motion.tool_pose), point by point

Each such move becomes short moves of the axes, no more than CHORD off the led path, with the feed that gives the tip its speed.
What comes behind reads them as it reads any other move. Where a tilted plane begins, the rotary axes are brought there first.

No machine turns an axis that it lacks: a program that asks for one is refused with its line, in whatever language it is written.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from vcmm.core.axes import ROTARY
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.program.moves import Move, Point, Posture, Remark
from vcmm.program.sensible import missing_axis_fault, without_axis
from vcmm.shop.motion.polar import led_path, polar_samples, swept_angle
from vcmm.shop.motion.posture import rotary_position, swept_angles
from vcmm.shop.motion.tool_pose import rotary_of, tip_and_axis, tip_as_at_zero


def check_axes(moves: Sequence[Move], machine: Machine, name: str) -> None:
    """Raise UsageError at the first move that turns a rotary axis which the machine has not."""
    lacking_axis = without_axis(moves, machine.axes)
    if lacking_axis is not None:
        move, axis = lacking_axis
        raise UsageError(f"{name}:{move.source.line}: {missing_axis_fault(machine.axes, axis)}")


CHORD = 1e-5  # mm by which the axes may leave the led path between two points
EVERY = 0.02  # rad of the rotary axes, or of an arc, between two looks at it
LEAST_LOOKS = 4
MOST_ROWS = 2_000_000  # moves
# an axis that turns by more, and that many times as far as the tool: near a singular position
SWING = math.radians(10.0)
TILT = 5.0
NO_TURN_RAD = 1e-10  # rad
SAME_VECTOR = 1e-9  # mm, or of a unit vector


@dataclass(eq=False)
class Leading:
    """State of the axes while a program is followed: tip as with rotary axes at zero (3,) mm, A B C (3,) rad."""

    machine: Machine
    name: str
    tip: Array
    angle: Array
    offset: Array  # of the tool, mm: a tool change leaves the axes where they stand, and moves the tip
    moves: list[Move] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)
    last_posture: tuple[Posture, Point] | None = (
        None  # which position has been taken last, and for what direction
    )

    def pose(self, offset: Array) -> tuple[Array, Array]:
        """Return the tip and tool axis (3,) in the workpiece."""
        tip = tip_and_axis(self.machine, self.tip[None], self.angle[None], offset[None])
        return tip[0][0], tip[1][0]


def leads(moves: Sequence[Move]) -> bool:
    """Return whether a program leads the tip over the workpiece anywhere."""
    return any(m.is_tip_led for m in moves)


def in_machine_axes(
    moves: Sequence[Move], machine: Machine, name: str = "the program"
) -> tuple[tuple[Move, ...], tuple[Remark, ...]]:
    """Return the moves with led ones as motions of the axes, and remarks on singular positions.

    Raises UsageError for a machine without rotary axes, ModelLimit where no position of its axes turns the tool as asked.
    """
    check_axes(moves, machine, name)
    if not leads(moves):
        return tuple(moves), ()
    state = _beginning(moves, machine, name)
    for m in moves:
        _take_move(state, m)
        if len(state.moves) > MOST_ROWS:
            raise ModelLimit(
                f"{name}:{m.source.line}: more than {MOST_ROWS:.0e} motions of the axes; simulate the program in parts"
            )
    return tuple(state.moves), tuple(state.remarks)


def orient_moves(
    moves: Sequence[Move], machine: Machine, name: str = "the program"
) -> tuple[tuple[Move, ...], tuple[Remark, ...]]:
    """Return the same moves with the angles of their rotary axes and the tool axes at both ends, and remarks; raises as `in_machine_axes`."""
    check_axes(moves, machine, name)
    if (not rotary_of(machine) and not leads(moves)) or _lacks_linear(machine):
        return tuple(moves), ()  # without Y the path over the end face (G12.1) has its angles already
    state = _beginning(moves, machine, name)
    ends = np.empty((len(moves), 2, 3))
    for i, m in enumerate(moves):
        before = len(state.moves)
        _take_move(state, m)
        ends[i] = state.moves[before].rotary_start, state.moves[-1].rotary_end
    none = np.zeros((2 * len(moves), 3))
    axes = tip_and_axis(machine, none, ends.reshape(-1, 3), none)[1].reshape(-1, 2, 3)
    turned = np.abs(ends).max(axis=(1, 2)) > NO_TURN_RAD
    out = [
        m._replace(
            rotary_start=_point(ends[i, 0]), rotary_end=_point(ends[i, 1]), tool_axis_start=_point(axes[i, 0]),
            tool_axis_end=_point(axes[i, 1]),
        )
        if m.is_tip_led or turned[i]
        else m
        for i, m in enumerate(moves)
    ]  # fmt: skip
    return tuple(out), tuple(state.remarks)


def _lacks_linear(machine: Machine) -> bool:
    """Return whether the machine, such as a lathe, does not place its tip in all three directions."""
    return not {"X", "Y", "Z"} <= set(machine.axes)


def _beginning(moves: Sequence[Move], machine: Machine, name: str) -> Leading:
    """Return the state of the axes before the first move. Raises UsageError for a machine that cannot lead the tip."""
    if not rotary_of(machine):
        line = next(m.source.line for m in moves if m.is_tip_led)
        raise UsageError(
            f"{name}:{line}: the program leads the tool over the workpiece (tool centre point control or a tilted plane), but "
            f"{machine.name} has no rotary axes; add them to its structure, for example structure = \"w C' B' Y' b X Z t\", with "
            "[axes.B] centre"
        )
    led = next((m for m in moves if m.is_tip_led and not m.over_face), None)
    if led is not None and _lacks_linear(machine):
        raise ModelLimit(
            f"{name}:{led.source.line}: the tip is led over the workpiece here (tool centre point control or a tilted plane), which is simulated on "
            f"machines with X, Y and Z only, and {machine.name} has not all of them; take these blocks out"
        )
    first = moves[0]
    state = Leading(
        machine, name, np.array(first.start), np.array(first.rotary_start), np.array(first.tool_offset)
    )
    bare = [ROTARY[i] for i in rotary_of(machine) if machine.axes[ROTARY[i]].centre == (0.0, 0.0, 0.0)]
    if led is not None and bare:
        text = (
            f"axis {' and '.join(bare)} turns about the zero of the machine frame: where the tip is led hangs on it; state [axes.{bare[0]}] "
            f"centre in the file of {machine.name} where it lies elsewhere"
        )
        state.remarks.append(Remark(led.source.line, led.source.first, text))
    return state


def _take_move(state: Leading, m: Move) -> None:
    """Follow one move of the program."""
    changed = np.array(m.tool_offset)
    state.tip, state.offset = state.tip + state.offset - changed, changed
    if m.kind == "dwell":
        here = _point(state.tip)
        state.moves.append(
            m._replace(start=here, end=here, rotary_start=_point(state.angle), rotary_end=_point(state.angle))
        )
        return
    if not m.is_tip_led:
        _plain(state, m)
        return
    if m.over_face:
        _over_face(state, m)
        return
    offset = np.array(m.tool_offset)
    if m.tool_axis_start is not None and m.tool_axis_start == m.tool_axis_end:
        _bring_tool(state, m, _angle(state, m, np.array(m.tool_axis_end)))
    target = (
        _programmed_angles(state, m)
        if m.tool_axis_end is None
        else _angle(state, m, np.array(m.tool_axis_end))
    )
    _check_swing(state, m, target)
    share, at, angle = _samples(state, m, target, offset)
    pieces = _pieces(state, m, share, at, angle)
    state.moves += pieces
    state.tip, state.angle = np.array(pieces[-1].end), target


def _plain(state: Leading, m: Move) -> None:
    """Follow a move of the axes themselves: it begins at their actual position; arcs begin where they are programmed."""
    if m.tool_axis_end is not None:  # a tilted plane is in force, and this block runs in machine coordinates
        _bring_tool(state, m, _angle(state, m, np.array(m.tool_axis_end)))
        m = m._replace(rotary_end=_point(state.angle), tool_axis_start=None, tool_axis_end=None)
    start, angle = m.start if m.centre is not None else _point(state.tip), _programmed_angles(state, m)
    if np.abs(angle - state.angle).max() > NO_TURN_RAD:
        state.last_posture = None
    end = np.array(m.end)
    stays = [i for i, a in enumerate("XYZ") if a in m.unmoved_axes and m.centre is None]
    end[stays] = state.tip[stays]
    state.moves.append(
        m._replace(start=start, end=_point(end), rotary_start=_point(state.angle), rotary_end=_point(angle))
    )
    state.tip, state.angle = end, angle


def _programmed_angles(state: Leading, m: Move) -> Array:
    """Return angles (3,) that the words of the program give; for axes that the control has turned, their present angles."""
    angle = np.array(m.rotary_end)
    stays = [i for i, a in enumerate(ROTARY) if a in m.unmoved_axes]
    angle[stays] = state.angle[stays]
    return angle


def _over_face(state: Leading, m: Move) -> None:
    """Follow polar interpolation: X is the distance of the tip from the axis of C, which turns the point of the face to it; Y stays there."""
    if "C" not in state.machine.chain.work:
        raise UsageError(
            f"{state.name}:{m.source.line}: polar interpolation turns axis C under the tool, and {state.machine.name} has none that carries the "
            'part; add it, for example structure = "w C\' b Z X t"'
        )
    zero = np.array(state.machine.axes["C"].centre)
    at, tip, angle = polar_samples(m, zero, state.tip, float(state.angle[2]))
    both = np.tile(state.angle, (len(at), 1))
    both[:, 2] = angle
    state.moves += [
        p._replace(tool_axis_start=None, tool_axis_end=None, over_face=False)
        for p in _moves_between(m, at, tip, both)
    ]
    state.tip, state.angle = tip[-1], both[-1]


def _angle(state: Leading, m: Move, axis: Array) -> Array:
    """Return the angles (3,) at which the tool points along `axis` (3,), workpiece axes."""
    none = np.zeros(3)
    now = tip_and_axis(state.machine, none[None], state.angle[None], none[None])[1][0]
    aim = _point(axis)
    is_chosen = m.posture is None or state.last_posture == (m.posture, aim)
    if np.abs(now - axis).max() < SAME_VECTOR and is_chosen:
        return state.angle
    angles = rotary_position(state.machine, axis, state.angle, m.posture)
    state.last_posture = None if m.posture is None else (m.posture, aim)
    if angles is None:
        letters = " and ".join(ROTARY[i] for i in rotary_of(state.machine))
        as_asked = f" as {m.posture.words} asks for" if m.posture is not None and m.posture.words else ""
        raise ModelLimit(
            f"{state.name}:{m.source.line}: no position of {letters} within their travels{as_asked} points the tool along ({axis[0]:.4f} {axis[1]:.4f} "
            f"{axis[2]:.4f}) of the workpiece; turn the part in its fixture, or check travels and structure of {state.machine.name}"
        )
    return angles


def _bring_tool(state: Leading, m: Move, angle: Array) -> None:
    """Turn the rotary axes into a tilted plane while X, Y and Z rest, or keep the tip at its place on the workpiece (G53.6, MOVE)."""
    if np.abs(angle - state.angle).max() <= NO_TURN_RAD:
        return
    if m.posture is not None and m.posture.keeps_tip:
        offset = np.array(m.tool_offset)
        at = _point(state.pose(offset)[0])
        turn = m._replace(
            kind="rapid", start=at, end=at, centre=None, clockwise=None, feed=None, compensation=None
        )
        pieces = _pieces(state, turn, *_samples(state, turn, angle, offset))
        state.moves += pieces
        state.tip, state.angle = np.array(pieces[-1].end), angle
        return
    here = _point(state.tip)
    plain = m._replace(
        kind="rapid", start=here, end=here, rotary_start=_point(state.angle), rotary_end=_point(angle), centre=None,
        clockwise=None, feed=None, is_tip_led=False, tool_axis_start=None, tool_axis_end=None, compensation=None,
    )  # fmt: skip
    state.moves.append(plain)
    state.angle = angle


def _check_swing(state: Leading, m: Move, target: Array) -> None:
    """Add a remark where an axis swings while the tool hardly tilts: the block passes near a singular position."""
    turn = np.abs(target - state.angle)
    if turn.max() < SWING:
        return
    ends = np.stack([state.angle, target])
    axes = tip_and_axis(state.machine, np.zeros((2, 3)), ends, np.zeros((2, 3)))[1]
    tilt = float(np.arctan2(np.linalg.norm(np.cross(axes[0], axes[1])), axes[0] @ axes[1]))
    letter = ROTARY[int(turn.argmax())]
    if m.kind != "rapid" and turn.max() > TILT * tilt:
        state.remarks.append(
            Remark(
                m.source.line, m.source.first,
                f"axis {letter} swings by {math.degrees(float(turn.max())):.1f} deg while the tool tilts by {math.degrees(tilt):.2f} deg: the "
                "block passes near a singular position of the rotary axes, or rewinds one",
            )
        )  # fmt: skip


def _samples(state: Leading, m: Move, target: Array, offset: Array) -> tuple[Array, Array, Array]:
    """Return (shares (k,), tips in the workpiece (k, 3), angles (k, 3)) dense enough for CHORD, ends included."""
    begin, _ = state.pose(offset)
    turned = np.abs(target - state.angle).max()
    count = max(LEAST_LOOKS, math.ceil(max(turned, abs(swept_angle(m))) / EVERY))
    share = np.linspace(0.0, 1.0, count + 1)
    angle, looks = _turning(state, m, target, share), count
    tip = tip_as_at_zero(state.machine, led_path(m, begin, share), angle, np.tile(offset, (count + 1, 1)))
    bend = np.linalg.norm(np.diff(tip, 2, axis=0), axis=1).max() * count**2  # of the whole move, mm
    count = max(looks if m.sweeps and turned > NO_TURN_RAD else 1, math.ceil(math.sqrt(bend / (8.0 * CHORD))))
    share = np.linspace(0.0, 1.0, count + 1)
    return share, led_path(m, begin, share), _turning(state, m, target, share)


def _turning(state: Leading, m: Move, target: Array, share: Array) -> Array:
    """Return the angles (k, 3) at shares (k,) of the path: in proportion to it, or so that the tool axis sweeps the plane of both directions."""
    angle = state.angle + share[:, None] * (target - state.angle)
    if not m.sweeps or np.abs(target - state.angle).max() <= NO_TURN_RAD:
        return angle
    angles = swept_angles(state.machine, state.angle, target, share)
    if angles is None:
        raise ModelLimit(
            f"{state.name}:{m.source.line}: the rotary axes cannot sweep the tool axis from one direction to the other (PATHCTRL VECTOR, "
            "ORIVECT) without a jump of an axis; program a direction between, or interpolate the axes (PATHCTRL AXIS, ORIAXES)"
        )
    return angles


def _pieces(state: Leading, m: Move, share: Array, at: Array, angle: Array) -> list[Move]:
    """Return motions of the axes from point to point."""
    offset = np.tile(np.array(m.tool_offset), (len(share), 1))
    tip = tip_as_at_zero(state.machine, at, angle, offset)
    tip[0] = state.tip
    axis = tip_and_axis(state.machine, tip, angle, offset)[1]
    return _moves_between(m, at, tip, angle, axis)


def _moves_between(m: Move, at: Array, tip: Array, angle: Array, axis: Array | None = None) -> list[Move]:
    """Return motions of the axes from point to point: at (k, 3) of the workpiece, tips as with rotary axes at zero (k, 3), angles (k, 3).

    axis (k, 3): tool axis at the points, where it is led; None: as the move says.
    """
    way, run = np.linalg.norm(np.diff(at, axis=0), axis=1), np.linalg.norm(np.diff(tip, axis=0), axis=1)
    turn = np.degrees(np.linalg.norm(np.diff(angle, axis=0), axis=1))
    tips, angles = _points(tip), _points(angle)
    axes = None if axis is None else _points(axis)
    kind, last = "rapid" if m.kind == "rapid" else "line", len(at) - 2
    plain = m._replace(kind=kind, centre=None, clockwise=None, turns=1, is_tip_led=False, exact_stop=False)
    out = []
    for i, (w, r, t) in enumerate(zip(way.tolist(), run.tolist(), turn.tolist())):
        led = (m.tool_axis_start, m.tool_axis_end) if axes is None else (axes[i], axes[i + 1])
        out.append(
            plain._replace(
                start=tips[i], end=tips[i + 1], rotary_start=angles[i], rotary_end=angles[i + 1],
                feed=_feed(m.feed, w, r, t), exact_stop=m.exact_stop and i == last,
                tool_axis_start=led[0], tool_axis_end=led[1],
            )
        )  # fmt: skip
    return out


def _feed(feed: float | None, way: float, run: float, turn: float) -> float | None:
    """Return the feed of the axes (mm/min; degrees per minute where X, Y, Z rest) that leads the tip along `way` mm at `feed`."""
    if feed is None:
        return None
    if run < SAME_VECTOR:
        return feed * turn / way if way > SAME_VECTOR else feed
    return feed * run / way if way > SAME_VECTOR else feed * run / turn if turn > 0.0 else feed


def _points(p: Array) -> list[Point]:
    """Return rows (k, 3) as points."""
    return [(x, y, z) for x, y, z in p.tolist()]


def _point(p: Array) -> Point:
    return float(p[0]), float(p[1]), float(p[2])
