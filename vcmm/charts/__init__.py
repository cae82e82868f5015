"""Pictures on matplotlib Axes, for Python and notebooks. They know numbers, not measuring.

Imports core, report.
"""

from __future__ import annotations

from vcmm.charts.bars import PlottedBudget, contributions, probabilities
from vcmm.charts.canvas import canvas, panels
from vcmm.charts.curves import band, readings
from vcmm.charts.distribution import distribution
from vcmm.charts.space import heights, motions, pose_map, touches

__all__ = [
    "PlottedBudget",
    "band",
    "canvas",
    "contributions",
    "distribution",
    "heights",
    "motions",
    "panels",
    "pose_map",
    "probabilities",
    "readings",
    "touches",
]
