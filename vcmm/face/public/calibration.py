"""Calibration by nets and nodes: what a program needs to follow a published procedure beside `vcmm.calibrate`."""

from __future__ import annotations

from vcmm.learn.calibration.machine_file import bare_text
from vcmm.learn.calibration.net import CHOSEN, EPOCHS, LAYOUTS, AxisNet, folds, share_left, trained
from vcmm.learn.calibration.nodes import NodeScatter, node_scatter

__all__ = [
    "CHOSEN",
    "EPOCHS",
    "LAYOUTS",
    "AxisNet",
    "NodeScatter",
    "bare_text",
    "folds",
    "node_scatter",
    "share_left",
    "trained",
]
