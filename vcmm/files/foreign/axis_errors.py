"""Errors of a machine's axes in the form of tables for controls: an axis along itself in both directions, with the sense of the motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.effect import Effect, parameter_fields, required
from vcmm.core.errors import ModelLimit
from vcmm.core.kinematics import Axis
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run

NAMES = "XYZABC"
NO_ERROR = 1e-12


@dataclass(frozen=True, eq=False)
class Tables:
    """Files by name, and one sentence for each error that they do not include."""

    files: dict[str, str]
    left_out: tuple[str, ...]


def carries_part(machine: Machine, letter: str) -> bool:
    """Return whether an axis moves the part (a table) and not the tool."""
    return letter in machine.chain.work


def of_the_tool(machine: Machine, letter: str, q: Array, forward: Array) -> list[str]:
    """Return lines for a table that holds actual positions. q (n,) mm commanded; forward (n,) mm: actual - nominal when it is approached
    forwards, as the tool moves over the part."""
    whose = (
        f"{letter} carries the part: what counts is the tool seen from the part, in the sense in which {letter} is commanded; the table "
        "itself moves the other way"
        if carries_part(machine, letter)
        else f"{letter} carries the tool: what counts is the tool itself, in the sense in which {letter} is commanded"
    )
    k = int(np.argmax(np.abs(forward)))
    at, error = float(q[k]), float(forward[k])
    lines = [
        f"whose motion: {whose}",
        "sign: actual = nominal + error, error = actual - nominal; the control adds nominal - actual to its commands",
    ]
    if error:
        way = "further" if error > 0 else "less far"
        lines.append(
            f"example: commanded to {letter} {at:.3f} forwards, the tool is over {letter} {at + error:.4f} of the part: {abs(error) * 1e3:.1f} um "
            f"{way} towards +{letter} than it should; the control {'takes them off' if error > 0 else 'adds them'}"
        )
    return lines


def linear(machine: Machine) -> dict[str, Axis]:
    return {a: axis for a, axis in machine.axes.items() if a in "XYZ"}


def component_errors(machine: Machine, letter: str, q: Array) -> tuple[Array, list[str]]:
    """Return the errors (n, 6) of the axis's own motion over its positions, as ISO 230-1 states them, and ids of effects that depend on more."""
    total, left = np.zeros((len(q), 6)), []
    for effect in machine.effects:
        if effect.link != letter or effect.place != "motion":
            continue
        motion = _alone(machine, effect, letter, q)
        if motion is None:
            left.append(effect.id)
        else:
            total += motion
    return total, left


def _alone(machine: Machine, effect: Effect, letter: str, q: Array) -> Array | None:
    """Return the motion of an effect over one axis; None where it depends on anything else."""
    if required(effect):
        return None
    motions = []
    for other in (0.25, 0.75):
        position = {a: np.full(len(q), low + other * (high - low)) for a, (low, high) in _travels(machine)}
        position[letter] = q
        try:
            motions.append(effect.error_motion(Run(position, np.zeros((len(q), 3)))))
        except ModelLimit:
            return None
    if np.abs(motions[0] - motions[1]).max(initial=0.0) > NO_ERROR:
        return None
    # a motion that is stated for the tip of an axis on the workpiece side is the axis's own with the other sign
    sign = 1.0 if effect.own or letter not in machine.chain.work else -1.0
    return np.asarray(sign * motions[0])


def _travels(machine: Machine) -> list[tuple[str, tuple[float, float]]]:
    return [(a, axis.travel) for a, axis in machine.axes.items()]


def rest_of(machine: Machine, ids: set[str], why: str) -> list[str]:
    return [f"{e.id}: {why}" for e in machine.effects if e.id not in ids and e.link != "reading"]


def errors_both_ways(machine: Machine, letter: str, q: Array) -> tuple[Array, Array, set[str]]:
    """Return the positioning error of an axis forwards and backwards, mm, tip sense, and the ids of its effects."""
    values, left = component_errors(machine, letter, q)
    sign = -1.0 if letter in machine.chain.work else 1.0
    forward = sign * values[:, "XYZ".index(letter)]
    ids = {e.id for e in machine.effects if e.link == letter and e.place == "motion"} - set(left)
    half = np.zeros(len(q))
    for e in machine.effects:
        if e.where == letter and [p.name for p in parameter_fields(e)] == [e.about.gap_parameter]:
            half += 0.5 * float(getattr(e, e.about.gap_parameter))
            ids.add(e.id)
    return forward - half, forward + half, ids


def cross_errors(machine: Machine, letter: str, q: Array, why: str) -> list[str]:
    """Return a sentence that names the errors of an axis across itself, where it has any."""
    values, _ = component_errors(machine, letter, q)
    names = [
        f"E{n}{letter}"
        for i, n in enumerate(NAMES)
        if NAMES[i] != letter and np.abs(values[:, i]).max() > NO_ERROR
    ]
    return [f"{' '.join(names)}: {why}"] if names else []
