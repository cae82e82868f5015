"""Tables for controls: the errors of a machine that the control's own compensation can hold, and notes on the others.

ISG (also Beckhoff): component errors of every axis over its own travel and the squareness errors, mm and rad, as read by
vcmm.files.foreign.isg. LinuxCNC: COMP_FILE of type 0, one per axis: nominal, actual position forwards, actual position backwards
(the axis's own positioning error and backlash only). Heidenhain: COM tables for KinematicsComp (iTNC 530 HSCI manual:
C1..C3 = EXj EYj EZj); rotations are left out, because the unit of their columns is not stated there. SINUMERIK and FANUC: one table
for each axis along itself, as below.

Each table states its motion and sign, and one of its own numbers in the words of the operator.

SINUMERIK: Function Manual Extended Functions, K3, "Compensation of leadscrew errors and measuring system errors" (6FC5397-1BP40-3BA1):
the actual value of the axis is altered by the value of its table, so that "a positive compensation value causes the corresponding
machine axis to move in the negative direction": a value is actual - nominal. Between the points it is linear, beyond them the end values hold.

FANUC: Series 0i Parameter Manual B-63980EN/01, parameters 3620 to 3624 and the example behind them. The points lie at reference +
k x interval; point number 3620 + k (k = 1, 2 ...) holds what is put out between (k - 1) and k intervals on the plus side, point
3620 - k what is put out between -(k + 1) and -k on the minus side, in detection units, moving towards plus. A value adds to the
motion (it is a correction): the sum up to a position is nominal - actual there.
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
from vcmm.files.foreign.isg import ErrorFile, ErrorTable, isg_text
from vcmm.physics.structure.squareness import Squareness

UNIT = 0.001  # mm, detection unit of a FANUC
MOST_PULSES = 7  # pulses at one point of a FANUC (-7 to +7), times the magnification 3623
ROW = {"X": 0, "Y": 1, "Z": 2}  # which points of the 1024 an axis gets: 256 each, from 256 x row
CROSS = "$AA_ENC_COMP corrects an axis along itself only; sag and straightness ($AN_CEC) are not written: no manual at hand states the sign of their values; have the programs rewritten (vcmm compensate PROGRAM) where they matter"


def sinumerik_tables(machine: Machine, nodes: int) -> Tables:
    """Return one file that is run as a program, $AA_ENC_COMP of each axis, mm."""
    lines, ids, left = ["%_N_AX_EEC_INI", "CHANDATA(1)"], set(), []
    for letter, axis in linear(machine).items():
        q = np.linspace(*axis.travel, nodes)
        up, down, by_axes = errors_both_ways(machine, letter, q)
        ids |= by_axes
        name, gap = f"{letter}1", float(np.mean(down - up))
        lines += [f"; {line}" for line in of_the_tool(machine, letter, q, up)]
        lines += [
            "; the sign of the values: a positive value moves the axis in the negative direction",
            f"; before: MD32700 $MA_ENC_COMP_ENABLE[0,{name}]=0 and MD38000 $MA_MM_ENC_COMP_MAX_POINTS[0,{name}] of {nodes} or more; "
            f"behind it $MA_ENC_COMP_ENABLE[0,{name}]=1; MD32450 $MA_BACKLASH[0,{name}]={gap:.6f}",
            *(f"$AA_ENC_COMP[0,{k},{name}]={value + 0.0:.6f}" for k, value in enumerate(np.round(up, 6))),
            f"$AA_ENC_COMP_STEP[0,{name}]={(q[-1] - q[0]) / (nodes - 1):.9f}",
            f"$AA_ENC_COMP_MIN[0,{name}]={q[0]:.6f}",
            f"$AA_ENC_COMP_MAX[0,{name}]={q[-1]:.6f}",
            f"$AA_ENC_COMP_IS_MODULO[0,{name}]=0",
        ]
        left += cross_errors(machine, letter, q, CROSS)
    left += rest_of(machine, ids, "not a positioning error of one axis along itself")
    left.append(
        "the machine axes are taken as X1, Y1, Z1; write the names of the machine where it has others"
    )
    return Tables({"AX_EEC.MPF": "\n".join([*lines, "M17", ""])}, tuple(left))


def fanuc_tables(machine: Machine, nodes: int) -> Tables:
    """Return one tape: N10000 + number of the point, P the value in detection units; `parameters.txt` holds 3620 to 3624 and 1851."""
    tape, remarks, ids, left = ["%"], [], set(), []
    for letter, axis in linear(machine).items():
        low, high = axis.travel
        if not low <= 0.0 <= high:
            left.append(
                f"{letter}: the reference point is taken as machine zero, which lies outside its travel; nothing is written for it"
            )
            continue
        interval = float(np.ceil((high - low) / (nodes - 1) / UNIT - 1e-9) * UNIT)
        first, last = -int(np.ceil(-low / interval - 1e-9)), int(np.ceil(high / interval - 1e-9))
        q: Array = np.array([interval * k for k in range(first, last + 1)])
        up, down, by_axes = errors_both_ways(machine, letter, np.clip(q, low, high))
        ids |= by_axes
        steps, factor = pulses(up, -first)
        base = 256 * ROW[letter] - first
        tape += [f"N{10000 + base + k} P{v // factor}" for k, v in zip(range(first + 1, last + 1), steps)]
        gap = round(float(np.mean(down - up)) / UNIT)
        remarks += [
            f"{letter}: 3620 = {base} (reference point, machine zero), 3621 = {base + first + 1}, 3622 = {base + last}, 3623 = {factor}, "
            f"3624 = {interval:.3f} mm, 1851 = {gap} (backlash, detection units of {UNIT} mm)",
            *of_the_tool(machine, letter, q, up),
            "sign of the tape: what the control adds, moving towards plus, between two points (nominal - actual, the difference from point to point)",
            "",
        ]  # fmt: skip
        if factor > 1:
            left.append(
                f"{letter}: steps of {factor} um (magnification 3623), for want of points; ask for more nodes where that is too coarse"
            )
        left += cross_errors(machine, letter, q, "a pitch error table corrects an axis along itself only")
    left += rest_of(machine, ids, "not a positioning error of one axis along itself")
    left.append(
        "the remaining error between the points is up to half a detection unit (0.5 um), and up to one step between two of them: the control adds whole pulses"
    )
    text = "\n".join([f"{machine.name}: stored pitch error compensation", *remarks])
    return Tables({"pitch.txt": "\n".join([*tape, "%", ""]), "parameters.txt": text}, tuple(left))


def pulses(up: Array, zero: int) -> tuple[list[int], int]:
    """Return detection units from point to point that add up to nominal - actual within half a step, from the point `zero` on, and the
    magnification that they need."""
    wanted = -(up - up[zero]) / UNIT
    for factor in range(1, 101):
        whole = np.round(wanted / factor).astype(int)
        steps = np.diff(whole)
        if np.abs(steps).max(initial=0) <= MOST_PULSES:
            return [int(v) * factor for v in steps], factor
    raise _too_steep(float(np.abs(np.diff(wanted)).max()))


def _too_steep(largest: float) -> Exception:
    from vcmm.core.errors import ModelLimit

    return ModelLimit(
        f"the error changes by {largest:.0f} um from one point to the next, more than 7 x 100 detection units; take more nodes"
    )


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
