"""What a table for a control says of itself: whose motion it holds, which sign, and one of its own numbers in the words of the operator."""

from __future__ import annotations

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array


def carries_part(machine: Machine, letter: str) -> bool:
    """Whether an axis moves the part (a table) and not the tool."""
    return letter in machine.chain.work


def of_the_tool(machine: Machine, letter: str, q: Array, forward: Array) -> list[str]:
    """Lines for a table that holds actual positions. q (n,) mm commanded; forward (n,) mm: actual - nominal when it is approached
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
            f"example: commanded to {letter} {at:.3f} forwards, the tool stands over {letter} {at + error:.4f} of the part: {abs(error) * 1e3:.1f} um "
            f"{way} towards +{letter} than it should; the control {'takes them off' if error > 0 else 'adds them'}"
        )
    return lines


def of_the_axes(machine: Machine, own: dict[str, tuple[Array, Array]]) -> list[str]:
    """Lines for a table that holds the errors of each axis's own motion. own: letter -> positions (n,) mm, error along itself (n,) mm."""
    tables = [a for a in own if carries_part(machine, a)]
    whose = "the motion of each axis itself, in the directions of the machine (ISO 230-1)"
    if tables:
        whose += f"; {' and '.join(tables)} carr{'ies' if len(tables) == 1 else 'y'} the part: the motion of the table, against which the tool moves the other way"
    lines = [f"whose motion: {whose}", "sign: error = actual - nominal"]
    for letter, (q, error) in own.items():
        k = int(np.argmax(np.abs(error)))
        if not error[k]:
            continue
        sense = "+" if error[k] > 0 else "-"
        body = "the table" if letter in tables else "the axis"
        seen = ""
        if letter in tables:
            back = "-" if sense == "+" else "+"
            seen = f", so that the tool is seen {abs(error[k]) * 1e3:.1f} um too far towards {back}{letter} of the part"
        lines.append(
            f"example: with {letter} commanded to {q[k]:.3f}, E{letter}{letter} = {error[k]:+.6f} mm: {body} stands {abs(error[k]) * 1e3:.1f} um too far "
            f"towards {sense}{letter} of the machine{seen}"
        )
    return lines
