"""Calibration by nets and nodes: tools for published procedures beside `vcmm.calibrate`."""

from __future__ import annotations

from vcmm.files.learned.calibrated_machine import bare_text
from vcmm.learn.calibration.net import BEST_LAYOUT, EPOCHS, LAYOUTS, AxisNet, folds, share_left, train_net
from vcmm.learn.calibration.nodes import NodeScatter, node_scatter

__all__ = [
    "BEST_LAYOUT",
    "EPOCHS",
    "LAYOUTS",
    "AxisNet",
    "NodeScatter",
    "bare_text",
    "folds",
    "node_scatter",
    "share_left",
    "train_net",
]
