"""Pictures on matplotlib Axes, for pages (`on_page`, as SVG), Python and notebooks. They know numbers, not measuring.

Imports core, report.
"""

from __future__ import annotations

from vcmm.charts.bars import bars, contributions, probabilities
from vcmm.charts.canvas import ChartSheet, panels
from vcmm.charts.curves import Band, PlotSeries, band, curve, readings
from vcmm.charts.distribution import distribution
from vcmm.charts.inline import on_page
from vcmm.charts.maps import heat_map
from vcmm.charts.polar import polar
from vcmm.charts.space import heights, motions, touches
from vcmm.charts.zones import zones

__all__ = [
    "Band",
    "ChartSheet",
    "PlotSeries",
    "band",
    "bars",
    "contributions",
    "curve",
    "distribution",
    "heat_map",
    "heights",
    "motions",
    "on_page",
    "panels",
    "polar",
    "probabilities",
    "readings",
    "touches",
    "zones",
]
