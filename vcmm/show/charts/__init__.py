"""Pictures on matplotlib Axes, for pages (`on_page`, as SVG), Python and notebooks. They know numbers, not measuring."""

from __future__ import annotations

from vcmm.show.charts.bars import bars, contributions, probabilities
from vcmm.show.charts.callouts import Callout, callouts
from vcmm.show.charts.canvas import ChartSheet, panels
from vcmm.show.charts.curves import Band, PlotSeries, band, curve, over_time, readings
from vcmm.show.charts.distribution import boxes, distribution, is_grouped
from vcmm.show.charts.inline import on_page
from vcmm.show.charts.maps import heat_map, is_of_one_colour
from vcmm.show.charts.polar import polar
from vcmm.show.charts.positioning import positioning_band
from vcmm.show.charts.space import heights, motions, touches
from vcmm.show.charts.tolerance_zones import flatness_zone, position_zone
from vcmm.show.charts.traces import PolarTrace, ReferenceCircle, traces
from vcmm.show.charts.waterfall import waterfall
from vcmm.show.charts.zones import zones

__all__ = [
    "Band",
    "Callout",
    "ChartSheet",
    "PlotSeries",
    "PolarTrace",
    "ReferenceCircle",
    "band",
    "bars",
    "boxes",
    "callouts",
    "contributions",
    "curve",
    "distribution",
    "flatness_zone",
    "heat_map",
    "heights",
    "is_grouped",
    "is_of_one_colour",
    "motions",
    "on_page",
    "over_time",
    "panels",
    "polar",
    "position_zone",
    "positioning_band",
    "probabilities",
    "readings",
    "touches",
    "traces",
    "waterfall",
    "zones",
]
