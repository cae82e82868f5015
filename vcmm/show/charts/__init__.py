"""Pictures on matplotlib Axes, for pages (`on_page`, as SVG), Python and notebooks. They know numbers, not measuring."""

from __future__ import annotations

from vcmm.show.charts.bars import bars, contributions, probabilities
from vcmm.show.charts.canvas import ChartSheet, panels
from vcmm.show.charts.curves import Band, PlotSeries, band, curve, readings
from vcmm.show.charts.distribution import distribution
from vcmm.show.charts.inline import on_page
from vcmm.show.charts.maps import heat_map
from vcmm.show.charts.polar import polar
from vcmm.show.charts.space import heights, motions, touches
from vcmm.show.charts.time import over_time
from vcmm.show.charts.zones import zones

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
    "over_time",
    "panels",
    "polar",
    "probabilities",
    "readings",
    "touches",
    "zones",
]
