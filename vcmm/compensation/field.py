"""The known error of the machine along a program: actual - commanded of the tool tip, less that where the offset was set.

    e(x) = tip error(x, state) - tip error(place of setting, at rest)

Where a rotary axis is off zero and the tip is not led, both are shifts of the commanded X, Y, Z: an offset that was set with the
rotary axes at zero errs along the axes of the machine while the table turns the part (as in vcmm.shop.machining.zero_setting).

States (time, speed, sense, distance since reversal) are those of the motion of a whole program, and are computed only
where an effect of the machine needs them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from vcmm.core.effect import Effect, parameter_fields, required
from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array, Run
from vcmm.program.moves import Move, Point
from vcmm.program.setup import Setup, first_tool
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.machining.own_logs import with_own_logs
from vcmm.shop.machining.rotary import commands_to_work
from vcmm.shop.machining.states import states_at
from vcmm.shop.machining.tool_errors import cutting_effects
from vcmm.shop.machining.warming import add_temperatures, warmed_when_set
from vcmm.shop.machining.zero_setting import setting_rows
from vcmm.shop.motion.tool_centre import leads
from vcmm.shop.motion.tool_pose import tip_and_axis, tip_as_at_zero
from vcmm.shop.motion.toolpath import Toolpath, toolpath

SETTLED = 1e-7  # mm: last step of the fixed point of a command
DYNAMIC = (
    "sense_",
    "since_reversal_",
    "accel_",
    "speed_",
    "time_since_accel",
)  # what changes at once, or with the speed
SHAPE_OF_CONTACT = (
    "nx",
    "ny",
    "nz",
    "cut_length_mm",
    "force_x_N",
    "spindle_load_W",
)  # needed by effects that a path cannot correct


@dataclass(frozen=True, eq=False)
class KnownErrors:
    """Known errors of a machine. machine: with the effects that are corrected; full: also with those that the drives must correct.

    left_out: ids of effects that are not corrected, and why.
    """

    machine: Machine
    full: Machine
    left_out: tuple[str, ...]

    @property
    def dynamic(self) -> bool:
        return len(self.full.effects) > len(self.machine.effects)

    @property
    def needs_states(self) -> bool:
        return any(required(e) for e in self.machine.effects)

    def whole(self) -> KnownErrors:
        """Return the same with every known effect on the path, to evaluate the total remaining error."""
        return KnownErrors(self.full, self.full, self.left_out)


def absent(effect: Effect) -> bool:
    """Return whether an effect is a placeholder: every parameter is zero."""
    values = [np.asarray(getattr(effect, f.name)) for f in parameter_fields(effect)]
    return bool(values) and not any(np.any(v) for v in values if v.dtype.kind in "fiu")


def known_errors_of(machine: Machine) -> KnownErrors:
    """Return the errors of a machine that its path can correct: those that are known and smooth along it.

    Reversal, lag and vibration jump or depend on the speed: steps in the path would mark the surface, and the control has
    its own parameters for them (backlash, quadrant compensation, gains), so they are left to it and reported.
    """
    moves, stated, idle = cutting_effects(machine)
    kept, rest, left = [], [], [f"{name} acts on measuring, not on cutting" for name in idle]
    for effect in moves.effects:
        if effect.about.is_random or absent(effect):
            continue
        if set(required(effect)) & set(SHAPE_OF_CONTACT):
            left.append(f"{effect.id} depends on force or contact, which a path does not know: not corrected")
        elif "clamp" in effect.per.split(", "):
            left.append(
                f"{effect.id} bends the part where it is cut, which is not where the tool stands: not corrected by the path, --surface does"
            )
        elif any(column.startswith(DYNAMIC) for column in required(effect)):
            rest.append(effect)
            left.append(
                f"{effect.id} jumps at reversals or goes with the speed: left to the control's own compensation, not corrected"
            )
        else:
            kept.append(effect)
    left += [f"{e.id} is stated for the finished part: not corrected" for e in stated.effects]
    full = replace(machine, effects=(*kept, *rest))
    return KnownErrors(replace(machine, effects=tuple(kept)), full, tuple(left))


class BesidePath(Protocol):
    """Effects of the tool on the finished surface beside its path, as a shift of it (vcmm.compensation.surface)."""

    def at(self, low: Ints, high: Ints, tips: Array) -> Array:
        """Return the shift (k, 3) mm of tips (k, 3) on the nearest of moves low to high (k,)."""


class _Zeroing(NamedTuple):
    """Quantities that determine where an offset was set: its name, the tool and its length."""

    offset: str
    tool: int
    length: Point


@dataclass(frozen=True, eq=False)
class PathErrors:
    """Errors along one program. set_here: subtract the error at the work zero of each offset. constants: columns.

    setter: the tool with which X and Y of the offsets were set; 0: every tool by itself, as on a lathe. surface: effects of the tool on
    the finished surface beside it (vcmm.compensation.surface), and `surface_moves`: first and last move there that each move lies on.
    by_axes: the moves are motions of the axes; those with a tool axis lead the tip (vcmm.shop.motion.tool_centre.in_machine_axes).
    """

    known_errors: KnownErrors
    setup: Setup
    moves: tuple[Move, ...]
    path: Toolpath | None
    moving: Ints  # moves that take time
    set_here: bool
    constants: Mapping[str, float]
    sensitive: Array  # (3,) 1, or 0 for an axis in which nothing can be corrected (Y of a lathe)
    setter: int = 0
    surface: BesidePath | None = None
    surface_moves: tuple[Ints, Ints] | None = None
    by_axes: bool = False

    @cached_property
    def is_led(self) -> bool:
        """Whether the tip is led over the workpiece anywhere."""
        return leads(self.moves)

    @cached_property
    def _groups(self) -> list[_Zeroing]:
        """Work offset, tool and its length, each combination once."""
        return list(dict.fromkeys(_Zeroing(m.offset, m.tool, m.tool_offset) for m in self.moves))

    @cached_property
    def _group(self) -> Ints:
        """Number of the combination at each move (n,)."""
        at = {zeroing: k for k, zeroing in enumerate(self._groups)}
        return np.array([at[_Zeroing(m.offset, m.tool, m.tool_offset)] for m in self.moves], dtype=np.intp)

    def run(self, move: Ints, share: Array, tips: Array) -> Run:
        """Return the machine at shares (k,) of moves (k,) with its tip at tips (k, 3); in the workpiece where it is led."""
        if self.path is not None:
            near, at = self._moving(move, share)
            machine_run, _ = states_at(self.path, near, at, tips)
        else:
            machine_run = Run({}, np.zeros((len(move), 3)))
        group = self._group[move]
        offset = np.array([g.length for g in self._groups]).reshape(-1, 3)[group]
        angle = self._angles(move, share)
        zero = np.array([self._zero(g.offset) for g in self._groups]).reshape(-1, 3)[group]
        columns = {k: v for k, v in machine_run.columns.items() if not k.startswith("tip_")}
        part = self._in_workpiece(move, tips, angle, offset) - zero
        columns |= {f"part_{c}_mm": part[:, i] for i, c in enumerate("xyz")}
        columns |= {name: np.full(len(move), value) for name, value in self.constants.items()}
        linear = self.axes_at(move, tips, angle, offset) + offset
        position = {
            letter: linear[:, "XYZ".index(letter)] if letter in "XYZ" else angle[:, "ABC".index(letter)]
            for letter in self.known_errors.machine.axes
        }
        labels = {**machine_run.labels, "tool": np.array([str(g.tool) for g in self._groups])[group]}
        run = Run(position, -offset, columns, labels)
        if self.path is None:
            return run
        return add_temperatures(
            with_own_logs(run, self.path, self.known_errors.machine.effects), self.setup.log
        )

    @cached_property
    def _turns(self) -> Array:
        """A, B, C at start and end of each move (n, 2, 3), rad."""
        return np.array([(m.rotary_start, m.rotary_end) for m in self.moves]).reshape(-1, 2, 3)

    def _angles(self, move: Ints, share: Array) -> Array:
        """Return A, B, C (k, 3) rad at shares of moves, in proportion to the path."""
        ends = self._turns[move]
        return np.asarray(ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0]))

    def axes_at(self, move: Ints, tips: Array, angle: Array, offset: Array) -> Array:
        """Return the tips (k, 3) as with rotary axes at zero: of led moves from points of the workpiece, the others are such points."""
        out = tips
        if self.is_led:
            there = np.array([self.moves[i].is_tip_led for i in move.tolist()], dtype=bool)
            at_zero = tip_as_at_zero(self.known_errors.machine, tips, angle, offset)
            out = np.where(there[:, None], at_zero, tips)
        return out

    def _is_turned(self, move: Ints, angle: Array) -> Array:
        """Return the rows (k,) at which a rotary axis is off zero while X, Y and Z are those of the machine."""
        if not self._turns.any():
            return np.zeros(len(move), dtype=bool)
        there = np.array([self.moves[i].is_tip_led for i in move.tolist()], dtype=bool)
        return np.asarray(angle.any(axis=1) & ~there)

    def _leads_tip(self, move: Ints) -> Array:
        """Return the rows (k,) at which the tip is led over the workpiece."""
        moves = [self.moves[i] for i in move.tolist()]
        return np.array(
            [m.is_tip_led or (self.by_axes and m.tool_axis_end is not None) for m in moves], dtype=bool
        )

    def _in_workpiece(self, move: Ints, tips: Array, angle: Array, offset: Array) -> Array:
        """Return the tips (k, 3) as points of the workpiece as it lies with the rotary axes at zero."""
        rows = np.flatnonzero(self._is_turned(move, angle))
        if not len(rows):
            return tips
        out = tips.copy()
        out[rows] = tip_and_axis(self.known_errors.machine, tips[rows], angle[rows], offset[rows])[0]
        return out

    def _command_shift(self, run: Run, move: Ints, error: Array) -> Array:
        """Return errors (k, 3) in axes of the workpiece as the shifts of the commanded X, Y, Z with the same effect there."""
        angle = np.stack([run.position.get(a, np.zeros(run.n)) for a in "ABC"], axis=1)
        rows = np.flatnonzero(self._is_turned(move, angle))
        if not len(rows):
            return error
        out = error.copy()
        ways = commands_to_work(self.known_errors.machine, run.take(rows))
        out[rows] = np.linalg.solve(ways, error[rows][:, :, None])[:, :, 0]
        return out

    def _moving(self, move: Ints, share: Array) -> tuple[Ints, Array]:
        """Return moves that take time: a move of no duration is at the end of the one before it."""
        place = np.searchsorted(self.moving, move, side="right") - 1
        first = place < 0
        near = self.moving[np.maximum(place, 0)]
        return near, np.where(near == move, share, np.where(first, 0.0, 1.0))

    def _zero(self, offset: str) -> Point:
        return self.setup.offsets.get(offset, (0.0, 0.0, 0.0))

    def errors(self, run: Run, move: Ints) -> Array:
        """Return e (k, 3) mm of rows of `run`, which belong to moves (k,)."""
        on_surface = self._on_surface(run, move) * self.sensitive
        machine = self.known_errors.machine
        if not machine.effects:
            return on_surface
        try:
            error = -machine.indication_error(run)
        except ModelLimit as limit:
            if limit.row is None:
                raise
            line = self.moves[move[limit.row]].source.line
            raise ModelLimit(
                f"line {line} is out of travel: {limit}; check work offset and tool length", line=line
            ) from None
        taken = self._setting(run, move) if self.set_here else np.zeros_like(error)
        led = self._leads_tip(move)[:, None]  # the control turns its zero with the part
        error = self._command_shift(run, move, error - np.where(led, taken, 0.0)) - np.where(led, 0.0, taken)
        return np.asarray(error * self.sensitive + on_surface)

    def _on_surface(self, run: Run, move: Ints) -> Array:
        """Return the shift (k, 3) mm beside the path; the zero was set where nothing was cut, so nothing is subtracted."""
        if self.surface is None:
            return np.zeros((run.n, 3))
        low, high = self.surface_moves or (np.arange(len(self.moves)),) * 2
        zero = np.array([self._zero(g.offset) for g in self._groups]).reshape(-1, 3)[self._group[move]]
        return self.surface.at(
            low[move], high[move], run.vector("part_x_mm", "part_y_mm", "part_z_mm") + zero
        )

    @cached_property
    def _was_turned_at_zero(self) -> bool:
        """Whether rotary axes were off zero where offsets were set; a led tip is zeroed in the workpiece, with all axes at zero."""
        return self.setup.set_as_cut and bool(self._turns.any()) and not self.is_led

    def _setting(self, run: Run, move: Ints) -> Array:
        """Return the error (k, 3) where the offset of each row was set.

        It is set at the work zero unless the set-up states the place, with the rotary axes at zero unless it states that they
        were as in the cut. Z with the tool of the row, X and Y with the tool that set the
        offset.
        """
        ways = group = self._group[move]
        out = np.zeros((run.n, 3))
        if self._was_turned_at_zero:
            turned = [q for a, q in run.position.items() if a not in "XYZ"]
            ways = np.unique(np.column_stack([group, *turned]), axis=0, return_inverse=True)[1].ravel()
        for number in dict.fromkeys(ways.tolist()):
            rows = np.flatnonzero(ways == number)
            zeroing, first = self._groups[int(group[rows[0]])], run.take(rows[:1])
            tool = self.setup.tools.get(
                zeroing.tool
            )  # a rapid before G43 leads no other length than the tool was set with
            length = tool.offset if tool and not any(zeroing.length) else zeroing.length
            out[rows] = self._set_with(first, zeroing.offset, zeroing.tool, length)
            if self.setter and self.setter in self.setup.tools:
                setter = self.setup.tools[self.setter]
                out[rows, :2] = self._set_with(first, zeroing.offset, self.setter, setter.offset)[:2]
        return out

    def _set_with(self, first: Run, offset: str, tool: int, length: Point) -> Array:
        """Return the error (3,) at the place of setting with a tool of that length, in the state of the run `first` (one row)."""
        at = np.array(self.setup.set_at or self.setup.offsets.get(offset, (0.0, 0.0, 0.0)))
        first = replace(first, labels={**first.labels, "tool": np.array([str(tool)])})
        here = setting_rows(first, np.array([0]), -np.array([length]), at[None], Pose(np.eye(3), at))
        if self._was_turned_at_zero:
            stood = {a: q for a, q in first.position.items() if a not in "XYZ"}
            here = replace(here, position={**here.position, **stood})
        here = warmed_when_set(here, self.setup.log)
        try:
            error = -self.known_errors.machine.indication_error(here)[0]
        except ModelLimit as limit:
            raise ModelLimit(
                f"the work zero of {offset} cannot be reached with tool {tool} ({limit}); say --set-on elsewhere "
                "where the offset was not set on this machine"
            ) from None
        if not self._was_turned_at_zero:
            return np.asarray(error)
        return np.asarray(np.linalg.solve(commands_to_work(self.known_errors.machine, here)[0], error))

    def _error_position(self, letter: str, nominal: Array, q: Array) -> Array:
        """Return the position at which the error is evaluated: at the end of a travel a correction must not lead beyond it (a command that does is
        refused later); the error changes by less than its gradient times the correction."""
        low, high = self.known_errors.machine.axes[letter].travel
        inside = (nominal >= low) & (nominal <= high)
        return np.asarray(np.where(inside, np.clip(q, low, high), q))

    def correct(self, move: Ints, share: Array, nominal: Array, beside: Array) -> Array:
        """Return the commands T (k, 3) for which T + e(T + beside) is nominal, by fixed point T = nominal - e(T + beside).

        beside (k, 3): from the programmed contour to the tool centre. Raises ModelLimit where it does not settle.
        """
        run = self.run(move, share, nominal + beside)
        wanted, angle = nominal, self._angles(move, share)
        for _ in range(8):
            linear = self.axes_at(move, wanted + beside, angle, -run.offset) - run.offset
            moved = {
                a: q if a not in "XYZ" else self._error_position(a, q, linear[:, "XYZ".index(a)])
                for a, q in run.position.items()
            }
            now = replace(run, position=moved)
            new = nominal - self.errors(now, move)
            change = float(np.abs(new - wanted).max(initial=0.0))
            wanted = new
            if change < SETTLED:
                return wanted
        raise ModelLimit(
            f"the correction does not settle (last step {change * 1e3:.3g} um): the error changes too fast with position; "
            "check the error table"
        )


def field_of(
    known_errors: KnownErrors, setup: Setup, moves: Sequence[Move], *, set_here: bool = True, constants: Mapping[str, float] | None = None, lathe: bool = False,
) -> PathErrors:  # fmt: skip
    """Return the errors along the motion of a program."""
    needs_path = known_errors.needs_states and moves and not leads(moves)
    path = toolpath(tuple(moves), known_errors.machine, setup) if needs_path else None
    moving = np.arange(len(moves)) if path is None else path.timing.moving
    if path is not None and not len(moving):
        path = None
    sensitive = np.array([float(a in known_errors.machine.axes and not (lathe and a == "Y")) for a in "XYZ"])
    return PathErrors(
        known_errors=known_errors,
        setup=setup,
        moves=tuple(moves),
        path=path,
        moving=moving,
        set_here=set_here,
        constants=constants or {},
        sensitive=sensitive,
        setter=0 if lathe else first_tool(moves, setup),
    )
