"""Knobs of a measuring task: the quantities that a user varies, their ranges, and the scenario with the knobs changed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.pose import Pose
from vcmm.task.measuring.plan import Plan, Step
from vcmm.task.measuring.scenario import Scenario

REPEATS = 5  # touches at one place
LEAST_FACTOR, MOST_FACTOR = 0.5, 3.0  # factors of the scatter and of the length of styli
ROOM_RANGE_K = 10.0  # K about the temperatures of the scenario
RISING = ("temp_", "reading_")  # columns of a temperature, and what its sensor reads, which rises with it
DIFFERENCE = "gradient_C"  # stays where all temperatures rise
POSE = ("x", "y", "z", "turn")  # what a file says in [pose]; the rest it says in [knobs]
SPREADS = ("u", "scale", "half_width")  # the number of a law that says how wide it is


@dataclass(frozen=True)
class Knob:
    """name, words, unit, range, step and initial value."""

    name: str
    words: str
    unit: str
    reach: tuple[float, float]
    step: float
    start: float


def knobs_of(scenario: Scenario) -> tuple[Knob, ...]:
    """Return the knobs: pose within the travels, turn about the vertical, temperature, length of styli, touches per place, scatter."""
    axes = scenario.machine.axes
    shift = scenario.pose.shift
    turn = math.degrees(float(scenario.pose.turns()[2]))
    out = []
    for i, letter in enumerate("XYZ"):
        if letter in axes:
            wide = axes[letter].travel[1] - axes[letter].travel[0]
            at = float(shift[i])
            out.append(
                Knob(letter.lower(), f"part along {letter}", "mm", (at - wide / 2, at + wide / 2), 1.0, at)
            )
    out += [
        Knob("turn", "part about the vertical", "deg", (turn - 180.0, turn + 180.0), 1.0, turn),
        Knob("room", "all temperatures", "K", (-ROOM_RANGE_K, ROOM_RANGE_K), 0.1, 0.0),
        Knob("styli", "length of the styli", "x", (LEAST_FACTOR, MOST_FACTOR), 0.05, 1.0),
        Knob("touches", "touches at every place", "", (1.0, REPEATS), 1.0, 1.0),
        Knob("spread", "scatter of one touch", "x", (LEAST_FACTOR, MOST_FACTOR), 0.05, 1.0),
    ]
    return tuple(out)


def with_knobs(scenario: Scenario, values: Mapping[str, Any]) -> Scenario:
    """Return the scenario with the knobs at `values`; knobs that are not named stay. Raises UsageError: no such knob, beyond its range."""
    knobs = {k.name: k for k in knobs_of(scenario)}
    at = {name: _check_knob(knobs, name, value) for name, value in values.items()}
    pose = scenario.pose
    shift = np.array([at.get(c, float(pose.shift[i])) for i, c in enumerate("xyz")])
    turns = pose.turns()
    turns[2] = math.radians(at["turn"]) if "turn" in at else turns[2]
    warmer = at.get("room", 0.0)
    factor = at.get("spread", 1.0)
    return replace(
        scenario,
        pose=Pose.from_turns(shift, turns),
        constants={n: v + warmer if _is_temperature(n) else v for n, v in scenario.constants.items()},
        plan=_plan_with(scenario.plan, at.get("styli", 1.0), round(at.get("touches", 1.0))),
        machine=replace(scenario.machine, inputs=tuple(_wider(i, factor) for i in scenario.machine.inputs)),
        inputs=tuple(_wider(i, factor) for i in scenario.inputs),
        forms=scenario.forms,
    )


def _check_knob(knobs: Mapping[str, Knob], name: str, value: Any) -> float:
    if name not in knobs:
        raise UsageError(f'there is no knob "{name[:40]}".{choose_from(name, knobs)}')
    knob = knobs[name]
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise UsageError(f"{name}: expected a finite number")
    low, high = knob.reach
    if not low - 1e-9 <= value <= high + 1e-9:
        raise UsageError(f"{name} = {value:g}: the knob goes from {low:g} to {high:g} {knob.unit}".rstrip())
    if name == "touches" and value != round(value):
        raise UsageError(
            f"{name} = {value:g}: a place is touched a whole number of times, {low:g} to {high:g}"
        )
    return float(value)


def _is_temperature(column: str) -> bool:
    return column.startswith(RISING) and column.endswith("_C") and not column.endswith(DIFFERENCE)


def _plan_with(plan: Plan, longer: float, times: int) -> Plan:
    """Return the plan with styli `longer` times as long, and every place touched `times` times in a row."""
    styli = {n: replace(s, offset=s.offset * longer, length=s.length * longer) for n, s in plan.styli.items()}
    return replace(plan, styli=styli, steps=tuple(_repeat_step(s, times) for s in plan.steps))


def _repeat_step(step: Step, times: int) -> Step:
    if times == 1:
        return step
    approach = None if step.approach is None else np.repeat(step.approach, times, axis=0)
    return replace(
        step, points=np.repeat(step.points, times, axis=0), normals=np.repeat(step.normals, times, axis=0),
        approach=approach,
    )  # fmt: skip


def _wider(quantity: Input, factor: float) -> Input:
    """Return an Input that is sampled anew at every touch, `factor` times as wide."""
    if quantity.redraw != "touch" or factor == 1.0 or quantity.members:
        return quantity
    law: Any = quantity.law
    names = {f.name for f in fields(law)}
    width = next((n for n in SPREADS if n in names), None)
    return (
        quantity
        if width is None
        else replace(quantity, law=replace(law, **{width: getattr(law, width) * factor}))
    )
