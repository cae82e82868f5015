"""A later part of a batch: tools are worn, spindle and screws warm from the parts before it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.core.run import Array, Run
from vcmm.motion.toolpath import Toolpath


def later_in_batch(states: Run, path: Toolpath, number: int, worn: Mapping[str, float] | None = None) -> Run:
    """The same states while the `number`-th part in a row is cut: time, cut length of each tool and travel have gone on.

    worn: what each tool adds to the cut length of its states in one part, mm; default: what the toolpath counts, the
    length of X, Y and Z. The parts follow one another without a pause, and the spindle does not cool while tools are changed. Tools and work
    offset were set before the first part.
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
    tools = states.labels["tool"]
    columns["cut_length_mm"] = states.column("cut_length_mm") + before * np.array(
        [fed.get(t, 0.0) for t in tools]
    )
    return states.with_columns(columns)


def by_tool(path: Toolpath, length: Array) -> dict[str, float]:
    """Cut length of each tool (mm) at the end of the program; length (n,) of the tool of each row of the path up to there."""
    tools = path.labels["tool"]
    return {str(t): float(length[tools == t].max()) for t in set(tools)}
