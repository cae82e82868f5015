"""Tables for controls: the errors of a machine that the control's own compensation can hold, and notes on the others.

ISG (also Beckhoff): component errors of every axis over its own travel and the squareness errors, mm and rad, as read by
vcmm.files.foreign.isg. LinuxCNC: COMP_FILE of type 0, one per axis: nominal, actual position forwards, actual position backwards
(the axis's own positioning error and backlash only). Heidenhain: COM tables for KinematicsComp (iTNC 530 HSCI manual:
C1..C3 = EXj EYj EZj); rotations are left out, because the unit of their columns is not stated there. SINUMERIK and FANUC: pitch_tables.

Each table states its motion and sign, and one of its own numbers in the words of the operator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.files.foreign.axis_errors import (
    NAMES,
    NO_ERROR,
    Tables,
    carries_part,
    component_errors,
    cross_errors,
    errors_both_ways,
    linear,
    of_the_tool,
    rest_of,
)
from vcmm.files.foreign.isg import ErrorFile, ErrorTable
from vcmm.files.foreign.isg_writer import isg_text
from vcmm.files.foreign.pitch_tables import fanuc_tables, sinumerik_tables
from vcmm.physics.structure.squareness import Squareness


def of_the_axes(machine: Machine, of_axes: dict[str, tuple[Array, Array]]) -> list[str]:
    """Return lines for a table that holds the errors of each axis's own motion. of_axes: letter -> positions (n,) mm, error along itself (n,) mm."""
    tables = [a for a in of_axes if carries_part(machine, a)]
    whose = "the motion of each axis itself, in the directions of the machine (ISO 230-1)"
    if tables:
        whose += f"; {' and '.join(tables)} carr{'ies' if len(tables) == 1 else 'y'} the part: the motion of the table, against which the tool moves the other way"
    lines = [f"whose motion: {whose}", "sign: error = actual - nominal"]
    for letter, (q, error) in of_axes.items():
        k = int(np.argmax(np.abs(error)))
        if not error[k]:
            continue
        sense = "+" if error[k] > 0 else "-"
        body = "the table" if letter in tables else "the axis"
        effect = ""
        if letter in tables:
            back = "-" if sense == "+" else "+"
            effect = f", so that the tool is seen {abs(error[k]) * 1e3:.1f} um too far towards {back}{letter} of the part"
        lines.append(
            f"example: with {letter} commanded to {q[k]:.3f}, E{letter}{letter} = {error[k]:+.6f} mm: {body} is {abs(error[k]) * 1e3:.1f} um too far "
            f"towards {sense}{letter} of the machine{effect}"
        )
    return lines


FORMATS = ("isg", "linuxcnc", "heidenhain", "sinumerik", "fanuc")
NODES = 41
MOST_POINTS = 256  # of a COMP_FILE


def control_tables(machine: Machine, form: str, nodes: int = NODES) -> Tables:
    """Return the tables of one control. Raises UsageError for an unknown format."""
    writers: dict[str, Callable[[Machine, int], Tables]] = {
        "isg": isg_tables, "linuxcnc": linuxcnc_tables, "heidenhain": heidenhain_tables, "sinumerik": sinumerik_tables, "fanuc": fanuc_tables,
    }  # fmt: skip
    if form not in writers:
        raise UsageError(f'--table "{form}".{choose_from(form, FORMATS)}')
    if not 2 <= nodes <= MOST_POINTS:
        raise UsageError(f"{nodes} nodes: a table has 2 to {MOST_POINTS}")
    return writers[form](machine, nodes)


def isg_tables(machine: Machine, nodes: int) -> Tables:
    """Return one file with all axes and the squareness errors."""
    tables, ids, of_axes = [], set(), {}
    for letter, axis in linear(machine).items():
        q = np.linspace(*axis.travel, nodes)
        values, left = component_errors(machine, letter, q)
        of_axes[letter] = q, values[:, "XYZ".index(letter)]
        ids |= {e.id for e in machine.effects if e.link == letter and e.place == "motion"} - set(left)
        columns = {f"E{n}{letter}": values[:, i] for i, n in enumerate(NAMES)}
        tables.append(ErrorTable((letter,), (q,), columns, 0))
    square = [e for e in machine.effects if isinstance(e, Squareness)]
    angles = {e.where: float(e.angle) for e in square}
    ids |= {e.id for e in square}
    lines = [
        f"{machine.name}: errors, actual - nominal, mm and rad (ISO 230-1)",
        *of_the_axes(machine, of_axes),
    ]
    remark = "\n// ".join(lines)
    why = "depends on more than the position of its axis; a table cannot hold it"
    return Tables(
        {"errors.csv": isg_text(ErrorFile(tuple(tables), angles), remark)}, tuple(rest_of(machine, ids, why))
    )


def linuxcnc_tables(machine: Machine, nodes: int) -> Tables:
    """Return COMP_FILE of each axis: nominal, actual forwards, actual backwards, mm. Behind the last row a line states the motion: LinuxCNC
    ends its reading at the first line without three numbers (usrmotLoadComp)."""
    files, ids = {}, set()
    left = []
    for letter, axis in linear(machine).items():
        q = np.linspace(*axis.travel, nodes)
        up, down, by_axes = errors_both_ways(machine, letter, q)
        ids |= by_axes
        rows = [f"{x:.6f} {x + a:.6f} {x + b:.6f}" for x, a, b in zip(q, up, down)]
        remarks = [f"; {line}" for line in of_the_tool(machine, letter, q, up)]
        files[f"comp_{letter.lower()}.txt"] = "\n".join([*rows, *remarks]) + "\n"
        left += cross_errors(machine, letter, q, "a COMP_FILE corrects an axis along itself only")
    left += rest_of(machine, ids, "not a positioning error of one axis along itself")
    left.append("write COMP_FILE_TYPE = 0 in [JOINT_n]; BACKLASH is ignored there, it is in the tables")
    return Tables(files, tuple(left))


def heidenhain_tables(machine: Machine, nodes: int) -> Tables:
    """Return COM tables, one for each axis: AXISPOS, BACKLASH, C1 to C3 in mm."""
    files, ids, left, of_axes = {}, set(), [], {}
    for letter, axis in linear(machine).items():
        q = np.linspace(*axis.travel, nodes)
        values, _ = component_errors(machine, letter, q)
        up, down, held_here = errors_both_ways(machine, letter, q)
        ids |= held_here
        of_axes[letter] = q, values[:, "XYZ".index(letter)]
        lines = [f"BEGIN {letter}.COM MM", "NR AXISPOS BACKLASH C1 C2 C3"]
        for i, x in enumerate(q):
            numbers = (x, down[i] - up[i], *values[i, :3])
            lines.append(f"{i} " + " ".join(f"{v:+.6f}" for v in numbers))
        files[f"{letter}.com"] = "\n".join([*lines, "[END]", ""])
        turned = [
            f"E{n}{letter}" for i, n in enumerate(NAMES) if i > 2 and np.abs(values[:, i]).max() > NO_ERROR
        ]
        if turned:
            left.append(
                f"{' '.join(turned)}: rotations are left out (unit of C4 to C6 is not stated in the manual we know)"
            )
    left += rest_of(machine, ids, "not a component error over one axis")
    files["signs.txt"] = "\n".join(
        [f"{machine.name}: C1 C2 C3 of the tables", *of_the_axes(machine, of_axes), ""]
    )
    left.append(
        "signs.txt says whose motion the values are and gives an example: check the sign with one axis before all are switched on"
    )
    return Tables(files, tuple(left))


def without_scatter(machine: Machine) -> Machine:
    """Return the machine without effects that have no known value."""
    return replace(machine, effects=tuple(e for e in machine.effects if not e.about.is_random))
