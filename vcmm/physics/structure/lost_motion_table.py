"""Reversal tabulated along the travel, as a calibration finds it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Trade, Typical
from vcmm.core.effect import Effect, at, motion, param, positions
from vcmm.core.errors import UsageError
from vcmm.core.play import share_taken_up
from vcmm.core.run import Array, Run

FAMILY = "reversal curve"  # what an evaluation declares it with


@dataclass(frozen=True, eq=False)
class LostMotionTable(Effect):
    """-1/2 gap(q_a) d_a e_a, the gap tabulated over the travel and linear between the nodes, held beyond them.

    What ISO 230-2 tabulates as reversal value at each position, with the other sign: B_i = -gap.
    """

    name = "lost_motion_table"
    about = About(
        cites="ISO 230-2:2014, 2.16 and figure 1: reversal error at each position, which the standard tabulates",
        trade=Trade("lost motion of {where}", "approach from one side, or measure the reversal again"),
        along_axis=True,
        is_calibrated=True,
    )
    diagnosis = ForDiagnosis(
        is_named=False,
        family="lost_motion",
    )
    per = "axis"
    needs = ("sense_{axis}",)
    axis: str = at("X", "linear axis")
    nodes: Any = positions((0.0, 1.0))
    values: Any = param(
        lambda: np.zeros(2),
        "um",
        "lost motion at the nodes",
        shape="(nodes,)",
        typical=Typical(1 * UM, "as lost_motion"),
    )

    def __post_init__(self) -> None:
        nodes = np.asarray(self.nodes, dtype=float)
        if len(nodes) < 2 or not (np.diff(nodes) > 0).all() or np.shape(self.values) != nodes.shape:
            raise UsageError(
                f"{self.id}: {np.size(self.values)} values for {len(nodes)} nodes; give increasing nodes and one value each"
            )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        gap = np.interp(run.q(self.axis), self.nodes, self.values)
        return motion(run, **{self.axis: -0.5 * gap * share_taken_up(run, self.axis)})
