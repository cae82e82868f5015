"""Limits of drives and control: limits per axis, the rounding tolerance, pauses; and assumptions about them.

Numbers come from `[axes.X] dynamics` of the machine file and `[control]` of the set-up. What is absent is taken from
`TYPICAL`, by kind of machine, and said so in `assumptions`, which every summary prints.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.units import quantity

AXES = "XYZABC"
# speed, acceleration, jerk: mm and s (rotary: rad and s). Mid-range of published figures, 1 to 10 m/s^2, 10 to 500 m/s^3.
TYPICAL: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "machine-tool": ((500.0, 3000.0, 50_000.0), (2.1, 10.0, 200.0)),
    "lathe": ((400.0, 4000.0, 60_000.0), (40.0, 100.0, 1000.0)),
    "cmm": ((300.0, 1000.0, 10_000.0), (1.0, 3.0, 30.0)),
}
KEYS = ("speed", "acceleration", "jerk")
LEAST_PAUSE = 1e-3  # s: a tool change or a new tool length takes a row of its own, and time must increase


@dataclass(frozen=True)
class Control:
    """Behaviour of the control beside the axis limits.

    tolerance: mm by which a corner may be rounded where the program states none (0: run to the corner and stop).
    rapid_stop: rapids end in position before the next move starts (the usual in-position check).
    tool_change: s, chip to chip.   stated: names of the keys that somebody wrote down.
    """

    tolerance: float = 0.010
    rapid_stop: bool = True
    tool_change: float = 5.0
    stated: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.tolerance >= 0 or not self.tool_change >= 0:
            raise UsageError("control: tolerance and tool_change must be zero or positive")


def control_from(table: Mapping[str, object]) -> Control:
    """Return a `[control]` table: tolerance = "10 um", tool_change = "5 s", rapid_stop = true. Raises UsageError."""
    keys = ("tolerance", "rapid_stop", "tool_change")
    for key in table:
        if key not in keys:
            raise UsageError(f'control has no key "{key}".{choose_from(key, keys)}')
    stop = table.get("rapid_stop", True)
    if not isinstance(stop, bool):
        raise UsageError("control.rapid_stop must be true or false")
    default = Control()
    tolerance, change = default.tolerance, default.tool_change
    if "tolerance" in table:
        tolerance = quantity(table["tolerance"], "length", "control.tolerance", "10 um")
    if "tool_change" in table:
        change = quantity(table["tool_change"], "time", "control.tool_change", "5 s")
    return Control(tolerance, stop, change, tuple(table))


@dataclass(frozen=True, eq=False)
class Limits:
    """Per axis in the order XYZABC, (6,): speed, acceleration, jerk in mm or rad and s; infinite where there is no axis.

    lag: 1/Kv in s, 0 where no gain is stated.   feed_forward: share of the speed that is fed forward, 0 to 1.
    """

    speed: Array
    acceleration: Array
    jerk: Array
    lag: Array
    feed_forward: Array
    letters: tuple[str, ...]
    assumptions: tuple[str, ...] = ()


def axis_limits(machine: Machine) -> Limits:
    """Return the limits of a machine, with the assumptions."""
    table = np.full((3, 6), np.inf)
    lag, forward, notes = np.zeros(6), np.ones(6), []
    for letter, axis in machine.axes.items():
        column = AXES.index(letter)
        typical = TYPICAL.get(machine.kind, TYPICAL["machine-tool"])[axis.rotary]
        for row, key in enumerate(KEYS):
            table[row, column] = axis.dynamics.get(key, typical[row])
            if not table[row, column] > 0:
                raise UsageError(f"dynamics.{key} of axis {letter} must be positive")
        absent = [i for i, key in enumerate(KEYS) if key not in axis.dynamics]
        if absent:
            figures = ", ".join(f"{KEYS[i]} {_limit_text(typical[i], i, axis.rotary)}" for i in absent)
            notes.append(f"axis {letter}: {figures} (typical of kind {machine.kind}, not stated)")
        lag[column], forward[column] = _servo(letter, axis.dynamics, notes)
    return Limits(
        table[0],
        table[1],
        table[2],
        lag=lag,
        feed_forward=forward,
        letters=tuple(machine.axes),
        assumptions=tuple(notes),
    )


def _servo(letter: str, dynamics: Mapping[str, float], notes: list[str]) -> tuple[float, float]:
    """Return 1/Kv (s) and feed-forward share: a gain alone is a plain position loop, no gain is one without lag."""
    if "gain" not in dynamics:
        notes.append(f"axis {letter}: no gain stated, so it follows its command without lag")
        return 0.0, 1.0
    share = dynamics.get("feed_forward", 0.0)
    if not 0.0 <= share <= 1.0:
        raise UsageError(f"dynamics.feed_forward of axis {letter} is {share:g}; it must lie between 0 and 1")
    if "feed_forward" not in dynamics:
        notes.append(f"axis {letter}: no feed_forward stated, so none is at work")
    return 1.0 / dynamics["gain"], share


def _limit_text(value: float, order: int, rotary: bool) -> str:
    power = ("/s", "/s^2", "/s^3")[order]
    if rotary:
        return f"{value:g} rad{power}"
    return f"{value:g} mm/s" if order == 0 else f"{value / 1e3:g} m{power}"
