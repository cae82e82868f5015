"""Convert a measured part into a recording: the motion of the tool at every point, for `diagnose`.

The value is actual - commanded of the tool along the normal of the cutter. It is made so that its value less the prediction of the machine file for
these rows is the measured less the predicted departure: known errors of the set-up (the zero was set on this very
machine, a tool of known compliance bends) are explained, and its uncertainty is passed on as a covariance.
The alignment of the part is free parameters.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.shop.machining.measured_part import MeasuredCut
from vcmm.task.response.observe import baseline
from vcmm.task.response.recording import Recording

ROUNDING = 1e-6  # of a scatter: rounding
LABELS = ("tool", "feature", "part", "setup")
WITHOUT_MEANING = ("spindle_angle_rad",)  # of a milled wall: the most protruding tooth passes everywhere


def part_recording(name: str, cut: MeasuredCut, machine: Machine, keep: frozenset[str]) -> Recording:
    """Return the recording, to be diagnosed beside `machine`. keep: columns that a recording file may have, as a run names them; others
    are left out.
    """
    run = cut.observed.run
    kept = keep - set(WITHOUT_MEANING)
    columns = {k: v for k, v in run.columns.items() if k in kept or k.startswith("temp_")}
    columns |= {f"n{c}": cut.normal[:, i] for i, c in enumerate("xyz")}
    labels = {k: v for k, v in run.labels.items() if k in LABELS} | {
        "clamp": np.full(run.n, "1")
    }  # it was held once
    # in the order in which the points were cut, as a reader of the table expects them
    order = np.argsort(run.column("time_s"), kind="stable")
    ordered = Run(run.position, run.offset, columns, labels, run.series).take(order)
    count = ordered.n
    empty = Recording(
        name=name, kind="path", run=ordered, value=np.zeros(count), measuring=False, row=np.arange(count),
        direction=cut.normal[order], other=np.full(count, -1), nuisance={} if cut.in_machine else {"rigid": "run"},
        **_noise(cut.noise[order]), known=tuple((word, columns[order]) for word, columns in cut.uncertainty_columns),
    )  # fmt: skip
    return replace(empty, value=baseline(empty, machine) + cut.departure[order])


def _noise(u: Array) -> dict[str, Any]:
    """Return one law where every point scatters alike, else u of each."""
    alike = float(np.ptp(u)) <= ROUNDING * float(u.max(initial=0.0))
    return {"noise": Normal(float(u.mean()))} if alike else {"u": u}
