"""States of a lathe at given times of its program: rows of a Run, the angle of the spindle among them."""

from __future__ import annotations

import numpy as np

from vcmm.core.run import OFFSET_LABEL, Array, Run
from vcmm.machining.states import HELD
from vcmm.machining.turned import Turning
from vcmm.motion.toolpath import CUTS, Toolpath

Ints = np.typing.NDArray[np.intp]


def states_when(turning: Turning, time: Array, move: Ints, tip: Array, phi: Array) -> tuple[Run, Array]:
    """Run (rows) at times (rows,) with the imaginary tip at `tip` (rows, 3), machine axes, and what is known there.

    The second result (rows, 3) is how far the nominal motion has left the programmed path, in the meridian frame: corners
    rounded within the tolerance, and the lag of the nominal position loops. Axis C stands where the tool passes phi (rows,).
    """
    path = turning.path
    timing = path.timing
    offset = np.array([timing.moves[i].tool_offset for i in move.tolist()]).reshape(-1, 3)
    following = np.clip(np.searchsorted(path.time, time, side="left"), 0, path.n - 1)
    columns = {
        name: values[following] if name.startswith(HELD) else np.interp(time, path.time, values)
        for name, values in path.columns.items()
    }
    columns["cut_length_mm"] = np.interp(time, path.time, chip_length(path, turning.centre))
    labels = {name: values[following] for name, values in path.labels.items()}
    labels["tool"] = np.array([str(timing.moves[i].tool) for i in move.tolist()])
    labels[OFFSET_LABEL] = np.array(
        [timing.moves[i].offset for i in move.tolist()]
    )  # a row that ends one may name the next
    commanded = timing.state(time).position[:, :3] - offset
    follow = np.column_stack([columns[f"follow_{c}_mm"] for c in "xyz"])
    position = {
        letter: (tip + offset)[:, "XYZ".index(letter)]
        if letter in "XYZ"
        else np.interp(time, path.time, values)
        for letter, values in path.axes.items()
    }
    if turning.rotary:
        position["C"] = turning.position_c(phi)
    return Run(position, -offset, columns, labels), commanded - tip + follow


def chip_length(path: Toolpath, centre: Array) -> Array:
    """Length (n,) mm that the edge of the tool of each row has cut by then: 2 pi x dn over its feed moves (ISO 3685)."""
    radius = np.abs(path.tip[:, 0] - centre[0])
    rate = 2 * np.pi / 60.0 * np.abs(path.columns["spindle_rpm"])
    middle = 0.5 * (radius + np.concatenate([radius[:1], radius[:-1]]))
    feeding = np.array([m.kind in CUTS for m in path.timing.moves], dtype=bool)[path.move]
    step = np.where(feeding, rate * middle * np.diff(path.time, prepend=path.time[:1]), 0.0)
    tools, out = path.columns["tool_number"], np.zeros(path.n)
    for one in np.unique(tools):
        mine = tools == one
        out[mine] = np.cumsum(np.where(mine, step, 0.0))[mine]
    return out
