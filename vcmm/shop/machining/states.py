"""States of the machine tool at given places of its program: the rows of a Run, made from the dense toolpath."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.core.history import axis_unit, play_name, taken_up_between
from vcmm.core.run import OFFSET_LABEL, Array, Run
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.motion.knots import times_at
from vcmm.shop.motion.timing import Timing
from vcmm.shop.motion.toolpath import Toolpath

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
    """Return the states, as `states_when`, at the times at which `share` (rows,) of moves (rows,) has been run."""
    return states_when(path, move, seconds_at(path.timing, move, share), tips)


def states_when(path: Toolpath, move: Ints, time: Array, tips: Array) -> tuple[Run, Array]:
    """Run (rows) at times (rows,) of moves (rows,) with the tool tip at tips (rows, 3), and what is known there.

    The second result (rows, 3) is how far the nominal motion has left the programmed path: corners rounded within the
    tolerance, and the lag of the nominal position loops (mm, axes of the tips).
    """
    timing = path.timing
    columns, labels = moment(path, move, time)
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


def seconds_at(timing: Timing, move: Ints, share: Array) -> Array:
    """Return the time at which `share` (n,) of the moves (n,) has been run, s."""
    place = np.searchsorted(timing.moving, move)
    length = np.diff(timing.ends, prepend=0.0)[place]
    return times_at(timing, timing.ends[place] - (1.0 - share) * length)


def moment(path: Toolpath, move: Ints, time: Array) -> tuple[dict[str, Array], dict[str, Words]]:
    """Return the columns and labels (k,) of the toolpath at times (k,) of moves (k,)."""
    following = np.clip(np.searchsorted(path.time, time, side="left"), 0, path.n - 1)
    columns = {
        name: values[following] if name.startswith(HELD) else np.interp(time, path.time, values)
        for name, values in path.columns.items()
    }
    columns |= _memory(path, following, time)
    labels = {name: values[following] for name, values in path.labels.items()}
    moves = [path.timing.moves[i] for i in move.tolist()]  # a row that ends one may name the next
    labels["tool"] = np.array([str(m.tool) for m in moves])
    labels[OFFSET_LABEL] = np.array([m.offset for m in moves])
    return columns, labels


def _memory(path: Toolpath, following: Ints, time: Array) -> dict[str, Array]:
    """Return the distance since a reversal and state of play (k,) between two rows, where every axis goes one way (vcmm.shop.motion.knots)."""
    out, before = {}, np.maximum(following - 1, 0)
    for letter, q in path.axes.items():
        here, name = np.interp(time, path.time, q), f"since_reversal_{letter}_{axis_unit(letter)}"
        out[name] = np.maximum(path.columns[name][following] - np.abs(q[following] - here), 0.0)
        state = path.columns.get(play_name(letter))
        if state is not None:
            half = path.plays[letter].half
            out[play_name(letter)] = taken_up_between(state[before], q[before], here, half[following])
    return out


def later_in_batch(states: Run, path: Toolpath, number: int, worn: Mapping[str, float] | None = None) -> Run:
    """Return the same states while the `number`-th part in a row is cut: time, cut length of each tool and travel have gone on.

    worn: what each tool adds to the cut length of its states in one part, mm; default: what the toolpath counts, the
    length of X, Y and Z. The parts follow one another without a pause, and the spindle does not cool while tools are
    changed. Tools and work offset were set before the first part.
    """
    if number == 1:
        return states
    before = float(number - 1)
    going_on = {"time_s": path.seconds} | {
        name: float(values[-1]) for name, values in path.columns.items() if name.startswith("travel_")
    }
    columns = {name: states.column(name) + before * amount for name, amount in going_on.items()}
    on = states.column("spindle_on_s")
    columns["spindle_on_s"] = np.where(on > 0.0, on + before * path.seconds, on)
    fed = by_tool(path, path.columns["cut_length_mm"]) if worn is None else worn
    columns["cut_length_mm"] = states.column("cut_length_mm") + before * np.array(
        [fed.get(t, 0.0) for t in states.labels["tool"]]
    )
    return states.with_columns(columns)


def by_tool(path: Toolpath, length: Array) -> dict[str, float]:
    """Cut length of each tool (mm) at the end of the program; length (n,) of the tool of each row of the path up to there."""
    tools = path.labels["tool"]
    return {str(t): float(length[tools == t].max()) for t in set(tools)}
