"""A later part of a batch: tools are worn, spindle and screws warm from the parts before it."""

from __future__ import annotations

import numpy as np

from vcmm.nc.toolpath import Toolpath
from vcmm.run import Run


def later_in_batch(states: Run, path: Toolpath, number: int) -> Run:
    """The same states while the `number`-th part in a row is cut: time, cut length of each tool and travel have gone on.

    The parts follow one another without a pause, and the spindle does not cool while tools are changed. Tools and work
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
    fed = {
        t: float(path.columns["cut_length_mm"][path.labels["tool"] == t].max())
        for t in set(path.labels["tool"])
    }
    tools = states.labels["tool"]
    columns["cut_length_mm"] = states.column("cut_length_mm") + before * np.array(
        [fed.get(t, 0.0) for t in tools]
    )
    return states.with_columns(columns)
