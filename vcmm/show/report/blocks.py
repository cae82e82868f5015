"""All blocks of a page under one name, for pages and for `vcmm.report`: a job that writes no page does not load them."""

from __future__ import annotations

from vcmm.show.report.answers import AnswerLine, answer_of, answer_text, answers_block
from vcmm.show.report.meshes import (
    box_mesh,
    cone_mesh,
    cylinder_mesh,
    disc_mesh,
    plane_mesh,
    sphere_mesh,
    torus_mesh,
    tube_mesh,
)
from vcmm.show.report.page import columns, details, heading, leaf, note, notices, page, paragraph, write
from vcmm.show.report.scene import scene
from vcmm.show.report.scene_items import Arrows, Ellipsoids, Label, Lines, Points, SceneBox, SceneMesh
from vcmm.show.report.table import Cell, Raw, table
from vcmm.show.report.text import escape, number, with_uncertainty

__all__ = [
    "AnswerLine",
    "Arrows",
    "Cell",
    "Ellipsoids",
    "Label",
    "Lines",
    "Points",
    "Raw",
    "SceneBox",
    "SceneMesh",
    "answer_of",
    "answer_text",
    "answers_block",
    "box_mesh",
    "columns",
    "cone_mesh",
    "cylinder_mesh",
    "details",
    "disc_mesh",
    "escape",
    "heading",
    "leaf",
    "note",
    "notices",
    "number",
    "page",
    "paragraph",
    "plane_mesh",
    "scene",
    "sphere_mesh",
    "table",
    "torus_mesh",
    "tube_mesh",
    "with_uncertainty",
    "write",
]
