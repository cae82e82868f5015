"""A measured part as a recording: what the tool did at every point, for `diagnose`.

The value is actual - commanded of the tool along the normal of the cutter, what the program itself leaves taken off. Where the
part was aligned, and what setting each tool erred by, is nobody's fault: free parameters.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.laws import Normal
from vcmm.core.run import Run
from vcmm.machining.measured import MeasuredCut
from vcmm.response.recording import Recording

LABELS = ("tool", "feature", "part", "setup")


def part_recording(name: str, cut: MeasuredCut, keep: frozenset[str]) -> Recording:
    """The recording. keep: columns that a recording file may have, as a run names them; others are left out."""
    run = cut.observed.run
    columns = {k: v for k, v in run.columns.items() if k in keep or k.startswith("temp_")}
    columns |= {f"n{c}": cut.normal[:, i] for i, c in enumerate("xyz")}
    labels = {k: v for k, v in run.labels.items() if k in LABELS}
    # in the order in which the points were cut: memory of the machine is made from the order of rows
    order = np.argsort(run.column("time_s"), kind="stable")
    ordered = Run(run.position, run.offset, columns, labels, run.series).take(order)
    nuisance = {} if cut.in_machine else {"rigid": "run"}
    if len(np.unique(labels["tool"])) > 1:
        nuisance["offset"] = "tool"
    elif cut.in_machine:
        nuisance["offset"] = "run"
    if cut.set_loosely:
        nuisance["radius"] = "tool"
    count = ordered.n
    return Recording(
        name=name, kind="path", run=ordered, value=cut.value[order], measuring=False, row=np.arange(count),
        direction=cut.normal[order], other=np.full(count, -1), nuisance=nuisance, noise=Normal(cut.noise),
    )  # fmt: skip
