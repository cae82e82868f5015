"""States of the machine tool at given places of its program: the rows of a Run, made from the dense toolpath."""

from __future__ import annotations

import numpy as np

from vcmm.machining.contacts import Ints
from vcmm.nc.knots import times_at
from vcmm.nc.toolpath import Toolpath
from vcmm.run import Array, Run

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
    place = np.searchsorted(timing.moving, move)
    length = np.diff(timing.ends, prepend=0.0)[place]
    time = times_at(timing, timing.ends[place] - (1.0 - share) * length)
    offset = np.array([timing.moves[i].tool_offset for i in move.tolist()]).reshape(-1, 3)
    following = np.clip(np.searchsorted(path.time, time, side="left"), 0, path.n - 1)
    columns = {
        name: values[following] if name.startswith(HELD) else np.interp(time, path.time, values)
        for name, values in path.columns.items()
    }
    labels = {name: values[following] for name, values in path.labels.items()}
    labels["tool"] = np.array([str(timing.moves[i].tool) for i in move.tolist()])
    commanded = timing.state(time).position[:, :3] - offset
    follow = np.column_stack([columns[f"follow_{c}_mm"] for c in "xyz"])
    position = {
        letter: (tips + offset)[:, "XYZ".index(letter)]
        if letter in "XYZ"
        else np.interp(time, path.time, values)
        for letter, values in path.axes.items()
    }
    return Run(position, -offset, columns, labels), commanded - tips + follow
