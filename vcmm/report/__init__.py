"""Blocks of a page: tables, charts, scenes. They know numbers, not measuring.

Imports core.

The names below are functions; the modules of the same name hold the rest (`from vcmm.report.bars import shares`).
"""

from __future__ import annotations

from vcmm.report.bars import bars, stacked
from vcmm.report.curve import Band, PlotSeries, curve
from vcmm.report.heatmap import heat_map
from vcmm.report.histogram import histogram
from vcmm.report.meshes import (
    box_mesh,
    cone_mesh,
    cylinder_mesh,
    disc_mesh,
    plane_mesh,
    sphere_mesh,
    torus_mesh,
    tube_mesh,
)
from vcmm.report.page import columns, details, heading, leaf, note, page, paragraph, write
from vcmm.report.polar import polar
from vcmm.report.scene import scene
from vcmm.report.scene_items import Arrows, Ellipsoids, Label, Lines, Points, SceneBox, SceneMesh
from vcmm.report.svg import standalone
from vcmm.report.table import Cell, Raw, table
from vcmm.report.text import escape, number, with_uncertainty
from vcmm.report.zones import zones

__all__ = [
    "Arrows",
    "Band",
    "Cell",
    "Ellipsoids",
    "Label",
    "Lines",
    "PlotSeries",
    "Points",
    "Raw",
    "SceneBox",
    "SceneMesh",
    "bars",
    "box_mesh",
    "columns",
    "cone_mesh",
    "curve",
    "cylinder_mesh",
    "details",
    "disc_mesh",
    "escape",
    "heading",
    "heat_map",
    "histogram",
    "leaf",
    "note",
    "number",
    "page",
    "paragraph",
    "plane_mesh",
    "polar",
    "scene",
    "sphere_mesh",
    "stacked",
    "standalone",
    "table",
    "torus_mesh",
    "tube_mesh",
    "with_uncertainty",
    "write",
    "zones",
]
