"""States of the machine tool at given places of its program: the rows of a Run, made from the dense toolpath."""

from __future__ import annotations

import numpy as np

from vcmm.core.kinematics import nominal_tip
from vcmm.core.run import OFFSET_LABEL, Array, Run
from vcmm.cutting.contactmap import Ints
from vcmm.machining.rotary import Motion, tool_offset_to
from vcmm.motion.knots import times_at
from vcmm.motion.toolpath import Toolpath
from vcmm.nc.limits import AXES

Words = np.typing.NDArray[np.str_]
HELD = (
    "sense_",
    "tool_number",
    "move",
    "line",
    "cutting",
    "spindle_rpm",
)  # not between two rows, but that of the later one


def states_at(path: Toolpath, move: Ints, share: Array, tips: Array) -> tuple[Run, Array]:
    """Run (rows) with the tool tip at tips (rows, 3), reached at `share` (rows,) of moves (rows,), and what is known there.

    The second result (rows, 3) is how far the nominal motion has left the programmed path: corners rounded within the
    tolerance, and the lag of the nominal position loops (mm, workpiece axes).
    """
    timing = path.timing
    time, columns, labels = _moment(path, move, share)
    offset = np.array([timing.moves[i].tool_offset for i in move.tolist()]).reshape(-1, 3)
    commanded = timing.state(time).position[:, :3] - offset
    follow = np.column_stack([columns[f"follow_{c}_mm"] for c in "xyz"])
    position = {
        letter: (tips + offset)[:, "XYZ".index(letter)]
        if letter in "XYZ"
        else np.interp(time, path.time, values)
        for letter, values in path.axes.items()
    }
    return Run(position, -offset, columns, labels), commanded - tips + follow


def turning_states(path: Toolpath, motion: Motion, row: Ints, t: Array, at: Array) -> tuple[Run, Array]:
    """As `states_at` where rotary axes stand off zero: at fractions t (k,) of rows (k,) of the sweep in workpiece axes.

    The offset of the run leads to the points `at` (k, 3), workpiece axes, which count as fixed to the tool; the second
    result (k, 3) is how far they have left their place on the programmed path.
    """
    move, share = motion.row[row], motion.share(row, t)
    time, columns, labels = _moment(path, motion.base.move[move], share)
    before, length = motion.fed  # the toolpath counts X, Y and Z only
    columns["cut_length_mm"] = before[row] + t * length[row]
    position = motion.commanded(move, share)
    offset = tool_offset_to(motion.machine, position, at)
    state = path.timing.state(time).position
    really = {letter: state[:, AXES.index(letter)] for letter in position}
    for letter, c in zip("XYZ", "xyz"):
        if letter in really:
            really[letter] = really[letter] + columns[f"follow_{c}_mm"]
    moved = nominal_tip(motion.machine.chain, motion.machine.axes, Run(really, offset))
    return Run(position, offset, columns, labels), moved - at


def _moment(path: Toolpath, move: Ints, share: Array) -> tuple[Array, dict[str, Array], dict[str, Words]]:
    """Time (k,) at which shares (k,) of moves (k,) are reached, and columns and labels of the toolpath there."""
    timing = path.timing
    place = np.searchsorted(timing.moving, move)
    length = np.diff(timing.ends, prepend=0.0)[place]
    time = times_at(timing, timing.ends[place] - (1.0 - share) * length)
    following = np.clip(np.searchsorted(path.time, time, side="left"), 0, path.n - 1)
    columns = {
        name: values[following] if name.startswith(HELD) else np.interp(time, path.time, values)
        for name, values in path.columns.items()
    }
    labels = {name: values[following] for name, values in path.labels.items()}
    labels["tool"] = np.array([str(timing.moves[i].tool) for i in move.tolist()])
    labels[OFFSET_LABEL] = np.array(
        [timing.moves[i].offset for i in move.tolist()]
    )  # a row that ends one may name the next
    return time, columns, labels
