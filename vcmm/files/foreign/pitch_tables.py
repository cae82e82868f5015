"""Tables of axis errors for SINUMERIK ($AA_ENC_COMP) and FANUC (stored pitch error compensation), each an axis along itself.

SINUMERIK: Function Manual Extended Functions, K3, "Compensation of leadscrew errors and measuring system errors" (6FC5397-1BP40-3BA1):
the actual value of the axis is altered by the value of its table, so that "a positive compensation value causes the corresponding
machine axis to move in the negative direction": a value is actual - nominal. Between the points it is linear, beyond them the end values hold.

FANUC: Series 0i Parameter Manual B-63980EN/01, parameters 3620 to 3624 and the example behind them. The points lie at reference +
k x interval; point number 3620 + k (k = 1, 2 ...) holds what is put out between (k - 1) and k intervals on the plus side, point
3620 - k what is put out between -(k + 1) and -k on the minus side, in detection units, moving towards plus. A value adds to the
motion (it is a correction): the sum up to a position is nominal - actual there.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.files.foreign.axis_errors import (
    Tables,
    cross_errors,
    errors_both_ways,
    linear,
    of_the_tool,
    rest_of,
)

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
