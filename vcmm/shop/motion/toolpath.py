"""Toolpath: the dense motion of a program, row by row, and the Run that every effect accepts.

    path = toolpath(program, machine, control)
    machine.tip_error(path.run())                    tip error along the whole program
    path.seconds; path.seconds_by("tool")            cycle time

Rows stand at knots: at most `step` mm apart, chord within `chord` mm of the arc, and wherever the acceleration of the
path changes its law or an axis turns back. What a row holds does not depend on how dense the rows are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.history import RESTING, Width, axis_unit, path_history
from vcmm.core.machine import Machine
from vcmm.core.play import widths
from vcmm.core.run import Array, Run
from vcmm.program.limits import AXES, Control
from vcmm.program.moves import Move, Program
from vcmm.shop.motion.curves import Ints
from vcmm.shop.motion.knots import knots_of, rest_points
from vcmm.shop.motion.servo import contour_deviation
from vcmm.shop.motion.timing import AxisState, Timing, plan_motion

LEAST_DWELL = 1e-6  # s: what rounding leaves of a pause that was a tool change only
MODES = {"rapid": "rapid", "line": "feed", "arc": "feed", "thread": "thread", "dwell": "dwell"}
CUTS = ("line", "arc", "thread")


@dataclass(frozen=True, eq=False)
class Toolpath:
    """n rows in order of time. axes: positions by letter (n,), mm or rad; tip (n, 3) mm, tool length taken off.

    move: index into `timing.moves`.   deviation (n, 3) mm: followed path less commanded path at the same path point,
    tool-relative, from the nominal gains.   columns: as in `Run`.   plays: of the axes that have play.
    """

    timing: Timing
    time: Array
    axes: Mapping[str, Array]
    tip: Array
    tool_offset: Array
    move: Ints
    deviation: Array
    columns: Mapping[str, Array]
    labels: Mapping[str, np.typing.NDArray[np.str_]]
    plays: Mapping[str, Width] = field(default_factory=dict)

    @property
    def n(self) -> int:
        return len(self.time)

    @property
    def seconds(self) -> float:
        """Cycle time, pauses included."""
        return self.timing.seconds

    @cached_property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions that were needed because nothing was stated, one sentence each."""
        control = self.timing.control
        texts = list(self.timing.limits.assumptions)
        for key, text in (
            ("tolerance", f"corners are rounded within {control.tolerance * 1e3:g} um"),
            (
                "rapid_stop",
                "rapids end in position" if control.rapid_stop else "rapids are rounded like feeds",
            ),
            ("tool_change", f"a tool change takes {control.tool_change:g} s"),
        ):
            if key not in control.stated:
                texts.append(f"control: {text} (not stated)")
        first = self.timing.moves[0].tool if self.timing.moves else 0
        if first:
            texts.append(
                f"control: tool {first} is in the spindle when the program begins: its change, before the first move, takes no time"
            )
        return tuple(texts)

    def run(self, followed: bool = False) -> Run:
        """Return the rows as a Run: positions as commanded, offset such that the nominal tip is the tool tip.

        followed: positions as the nominal servo follows them; only then its contour deviation is part of the positions
        (it is in the columns follow_x_mm, follow_y_mm, follow_z_mm either way).
        """
        axes = dict(self.axes)
        if followed:
            axes |= {
                letter: axes[letter] + self.deviation[:, i]
                for i, letter in enumerate("XYZ")
                if letter in axes
            }
        return Run(axes, -self.tool_offset, self.columns, self.labels)

    def seconds_by(self, what: str) -> dict[str, float]:
        """Return the time by "tool" or by "mode" (rapid, feed, thread, tool change, dwell: every other pause), s; sums to `seconds`.

        The tool that the program calls before its first move is no tool change: it is taken to stand in the spindle.
        """
        if what not in ("tool", "mode"):
            raise UsageError(f'seconds_by("{what}"): allowed are "tool" and "mode"')
        length = np.diff(self.time, prepend=0.0)
        out: dict[str, float] = {}
        names = self.labels[what]
        for name in dict.fromkeys(names.tolist()):
            out[name] = float(length[names == name].sum())
        rest = self.seconds - float(self.time[-1]) if self.n else self.seconds
        if rest > 0:
            name = "dwell" if what == "mode" else (names[-1] if self.n else "0")
            out[name] = out.get(name, 0.0) + rest
        changing = self.timing.joints.tool_changes * self.timing.control.tool_change
        if what == "mode" and changing > 0:
            waiting = max(out.pop("dwell", 0.0) - changing, 0.0)
            out |= {"tool change": changing} | ({"dwell": waiting} if waiting > LEAST_DWELL else {})
        return out


def toolpath(
    program: Program | Sequence[Move],
    machine: Machine,
    setup: object = None,
    *,
    control: Control | None = None,
    step: float = 1.0,
    chord: float = 1e-3,
    plays: Sequence[float] = (),
) -> Toolpath:
    """Compute the motion of a program at knots no more than `step` mm and `chord` mm (height over the chord) apart.

    control: what the control does; else `setup.control` where the set-up has one, else the defaults, which the
    assumptions then name.   plays: mm, for which the play state of history.play is kept.
    """
    if not step > 0 or not chord > 0:
        raise UsageError(f"toolpath: step = {step:g} and chord = {chord:g} must be positive lengths in mm")
    stated = control if control is not None else getattr(setup, "control", None)
    timing = plan_motion(program, machine, stated)
    s, time, stretch = knots_of(timing, step, chord)
    first, last = rest_points(stretch)
    state = _state_at_knots(timing, s, time, stretch, first | last)
    deviation = contour_deviation(timing, s, time, stretch)
    move = timing.move_at(s, state.element)
    shared = first & np.append(False, np.diff(time) <= 1e-9)  # a stretch that starts where and when one ends
    rows = np.flatnonzero(~shared)
    knots = Knots(time[rows], _take_rows(state, rows), move[rows], deviation[rows], first[rows])
    return _assemble(timing, machine, plays, knots)


def _state_at_knots(
    timing: Timing, s: Array, time: Array, stretch: Ints, rest: np.typing.NDArray[np.bool_]
) -> AxisState:
    """Return the state at the knots, exactly at rest at the ends of each stretch."""
    row = np.clip(np.searchsorted(timing.start, time, side="right") - 1, 0, max(len(timing.start) - 1, 0))
    _, v0, a0, jerk, length = timing.phase[row].T
    t = np.clip(time - timing.start[row], 0.0, length)
    v = np.where(rest, 0.0, v0 + t * (a0 + t * jerk / 2))
    a = np.where(rest, 0.0, a0 + t * jerk)
    return timing.state_on_path(s, v, a, np.where(rest, 0.0, jerk), stretch)


def _take_rows(state: AxisState, rows: Ints) -> AxisState:
    return AxisState(**{f.name: getattr(state, f.name)[rows] for f in fields(state)})


@dataclass(frozen=True, eq=False)
class Knots:
    """The rows of a toolpath before it exists: time (n,) s, axes, move, deviation (n, 3) mm, begins: first of a stretch."""

    time: Array
    state: AxisState
    move: Ints
    deviation: Array
    begins: np.typing.NDArray[np.bool_]


def _assemble(timing: Timing, machine: Machine, plays: Sequence[float], knots: Knots) -> Toolpath:
    time, state, move = knots.time, knots.state, knots.move
    axes = {letter: state.position[:, AXES.index(letter)] for letter in machine.axes}
    moves = timing.moves
    offset = np.array([m.tool_offset for m in moves], dtype=float).reshape(-1, 3)[move]
    wide = widths(machine.effects, axes)
    columns = path_history(axes, radii=plays, widths=wide) | _motion_columns(axes, state)
    columns["time_s"] = time
    columns["time_since_accel_s"] = _since_acceleration(
        time, np.linalg.norm(state.acceleration[:, :3], axis=1)
    )
    columns |= _move_columns(timing, time, state, move)
    columns |= {f"follow_{c}_mm": knots.deviation[:, i] for i, c in enumerate("xyz")}
    return Toolpath(
        timing=timing, time=time, axes=axes, tip=state.position[:, :3] - offset, tool_offset=offset, move=move,
        deviation=knots.deviation, columns=columns, labels=_labels(moves, move, knots.begins, time),
        plays=wide,
    )  # fmt: skip


def _motion_columns(axes: Mapping[str, Array], state: AxisState) -> dict[str, Array]:
    out: dict[str, Array] = {}
    for letter in axes:
        unit, i = axis_unit(letter), AXES.index(letter)
        out[f"speed_{letter}_{unit}_s"] = state.speed[:, i]
        out[f"accel_{letter}_{unit}_s2"] = state.acceleration[:, i]
    return out


def _since_acceleration(time: Array, size: Array) -> Array:
    """Return the time (n,) s since the acceleration was last above RESTING of its maximum, counted from the crossing.

    Between two knots the acceleration is taken as linear in time, which it is on straight moves.
    """
    limit = RESTING * size.max(initial=0.0)
    active = size > limit
    active[:1] = True
    fall = np.flatnonzero(active[:-1] & ~active[1:])
    ended = time.copy()
    drop = size[fall] - size[fall + 1]
    share = np.where(drop > 0, (size[fall] - limit) / np.where(drop > 0, drop, 1.0), 0.0)
    ended[fall] += np.clip(share, 0.0, 1.0) * (time[fall + 1] - time[fall])
    latest = np.maximum.accumulate(np.where(active, np.arange(len(time)), 0))
    return np.where(active, 0.0, time - ended[latest])


def _move_columns(timing: Timing, time: Array, state: AxisState, move: Ints) -> dict[str, Array]:
    """Return the columns that follow from the moves: feed, spindle, tool, line, cut length."""
    moves = timing.moves
    rpm = np.array([m.spindle for m in moves], dtype=float)[move]
    tip_speed = np.linalg.norm(state.speed[:, :3], axis=1)
    cutting = np.array([m.kind in CUTS for m in moves], dtype=float)[move]
    length = np.diff(time, prepend=time[:1])
    turned = np.cumsum(rpm * length)  # every end of a move is a row, so a new speed holds from the row before
    return {
        "feed_mm_min": 60.0 * tip_speed,
        "cutting": cutting,
        "spindle_rpm": rpm,
        "spindle_angle_rad": 2 * np.pi / 60.0 * turned,
        "spindle_on_s": _spindle_on(time - length, time, rpm),
        "cut_length_mm": _cut_length(timing, state.s, move),
        "tool_number": np.array([m.tool for m in moves], dtype=float)[move],
        "move": move.astype(float),
        "line": np.array([m.source.line for m in moves], dtype=float)[move],
    }


def _spindle_on(before: Array, time: Array, rpm: Array) -> Array:
    """Return the time (n,) s since the spindle was started; 0 while it stands. before (n,): time of the row before each."""
    on = rpm != 0
    started = on & ~np.concatenate([[False], on[:-1]])[: len(on)]
    latest = np.maximum.accumulate(np.where(started, np.arange(len(on)), 0))
    return np.where(on, time - before[latest], 0.0) if len(on) else np.zeros(0)


def _cut_length(timing: Timing, s: Array, move: Ints) -> Array:
    """Return the distance (n,) mm that the tool of each row has been fed up to there, over all its calls; mm of X, Y and Z only."""
    kept = [timing.moves[i] for i in timing.moving]
    length = np.diff(timing.ends, prepend=0.0)
    fed = np.array([(m.kind in CUTS and m.start != m.end) or m.kind == "arc" for m in kept], dtype=bool)
    done: dict[int, float] = {}
    before = np.zeros(len(kept))
    for i, m in enumerate(kept):
        before[i] = done.get(m.tool, 0.0)
        done[m.tool] = before[i] + (length[i] if fed[i] else 0.0)
    place = np.searchsorted(timing.moving, move)
    inside = np.clip(s - (timing.ends - length)[place], 0.0, length[place])
    return before[place] + np.where(fed[place], inside, 0.0)


def _labels(
    moves: Sequence[Move], move: Ints, begins: np.typing.NDArray[np.bool_], time: Array
) -> dict[str, np.typing.NDArray[np.str_]]:
    """Return tool, work_offset (its name), event (tool call by tool call), mode; a row after a pause is a dwell."""
    tools = np.array([m.tool for m in moves], dtype=int)
    calls = np.concatenate([[1], 1 + np.cumsum(np.diff(tools) != 0)]) if len(moves) else np.zeros(0)
    mode = np.array([MODES[m.kind] for m in moves], dtype="<U6")[move]
    waited = begins & (np.diff(time, prepend=0.0) > 0)
    return {
        "tool": np.array([str(t) for t in tools])[move],
        "work_offset": np.array([m.offset for m in moves])[move],
        "event": np.array([f"tool call {int(k)}" for k in calls])[move],
        "mode": np.where(waited, "dwell", mode),
    }


def summary(path: Toolpath) -> str:
    """Return the cycle time in words: by mode, by tool, beside length over feed, and the assumptions."""
    lines = [
        f"cycle time {path.seconds:.1f} s ({clock(path.seconds)}), length over feed {naive_seconds(path.timing):.1f} s"
    ]
    for what in ("mode", "tool"):
        parts = path.seconds_by(what).items()
        prefix = "tool " if what == "tool" else ""
        lines.append("  " + ", ".join(f"{prefix}{name} {seconds:.1f} s" for name, seconds in parts))
    stops, joints = len(path.timing.first), path.timing.joints
    lines.append(
        f"  {len(path.timing.moves)} moves, {stops} starts from rest, {np.count_nonzero(joints.reach)} rounded "
        f"corners, {len(joints.smooth.joints)} smoothed joints, {joints.tool_changes} tool changes, {path.n} rows"
    )
    return "\n".join(lines + [f"  assumed: {text}" for text in path.assumptions])


def clock(seconds: float) -> str:
    """Return seconds as text: 3725.4 -> '1:02:05'."""
    whole = round(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"


def naive_seconds(timing: Timing) -> float:
    """Return the result of a calculator: every move at its feed (rapids at the speed of the axes), without acceleration, s."""
    length = np.diff(timing.ends, prepend=0.0)
    direction = (
        np.abs(timing.curves.coefficients[: len(length), 1]) / length[:, None]
        if len(length)
        else np.zeros((0, 6))
    )
    with np.errstate(divide="ignore"):
        fastest = 1.0 / (direction / timing.limits.speed).max(axis=1, initial=0.0)
    feed = np.array([np.inf if (f := timing.moves[i].feed) is None else f / 60.0 for i in timing.moving])
    speed = np.where(np.isfinite(feed), feed, fastest)
    return float((length / speed).sum() + timing.joints.pause.sum())
