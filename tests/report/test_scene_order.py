"""What lies in front."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.report.drawn import coordinates, display_of, the_svg
from vcmm import report
from vcmm.report.scene_order import _side_of
from vcmm.report.scene_paint import basis

COLOURS = ("#ff0000", "#00ff00", "#0000ff", "#ffff00", "#ff00ff", "#00ffff")


BOXES = (  # a table, legs, a beam on them, a ram that runs through the beam, a part on the table
    ((-50, -50, -10), (50, 50, 0)),
    ((-48, -5, 0), (-40, 5, 60)),
    ((40, -5, 0), (48, 5, 60)),
    ((-48, -6, 60), (48, 6, 72)),
    ((0, -9, 20), (8, 3, 100)),
    ((-20, -40, 0), (15, -15, 12)),
)


def front_item(origin: np.ndarray, towards: np.ndarray) -> tuple[int, float]:
    """SceneBox that a viewer at +towards sees on the line through origin (-1: none), and how clear the case is."""
    entries = []
    for lo, hi in BOXES:
        with np.errstate(divide="ignore"):
            t = np.sort((np.array([lo, hi]) - origin) / towards, axis=0)
        entries.append(t[1].min() if t[0].max() < t[1].min() else -math.inf)
    ranked = np.sort(entries)
    if ranked[-1] == -math.inf:
        return -1, math.inf
    return int(np.argmax(entries)), float(ranked[-1] - ranked[-2])


def contains(polygon: list[tuple[float, float]], x: float, y: float) -> bool:
    inside = False
    for (x1, y1), (x2, y2) in zip(polygon, polygon[1:] + polygon[:1]):
        if (y1 > y) != (y2 > y) and x < x1 + (y - y1) / (y2 - y1) * (x2 - x1):
            inside = not inside
    return inside


@pytest.mark.parametrize("view", [(-60, 22), (30, 5), (140, 60), (-130, -25), (5, 85)])
def test_painter_shows_what_a_ray_hits(view: tuple[float, float]) -> None:
    items = [report.SceneBox(lo, hi, c, wire=False) for (lo, hi), c in zip(BOXES, COLOURS)]
    markup = report.scene(items, title="t", view=view, axes=False)
    faces = [(p.get("fill") or "", coordinates(p)) for p in the_svg(markup)[1]]
    display, frame = display_of(markup), basis(*view)
    camera = np.array(display["v"]) @ frame.T
    scale = min(display["fit"][2 + k] / np.abs(camera[:, k]).max() for k in range(2))
    centre = np.array(BOXES).reshape(-1, 3)
    middle = (centre.min(axis=0) + centre.max(axis=0)) / 2
    seen = (np.array([[b[i][0], b[j][1], b[k][2]] for b in BOXES for i in (0, 1) for j in (0, 1) for k in (0, 1)]) - middle) @ frame.T  # fmt: skip
    shift = (seen.min(axis=0) + seen.max(axis=0))[:2] / 2
    checked = doubtful = 0
    for right, up in np.random.default_rng(7).uniform(-55, 55, size=(400, 2)):
        item, margin = front_item(
            middle + (right + shift[0]) * frame[0] + (up + shift[1]) * frame[1], frame[2]
        )
        x = display["fit"][0] + scale * right / display["grain"]
        y = display["fit"][1] - scale * up / display["grain"]
        hits = [colour for colour, polygon in faces if contains(polygon, x, y)]
        if margin < 0.5 or bool(hits) != (
            item >= 0
        ):  # two surfaces meet, or the outline passes within a rounding
            continue
        if hits:
            pattern = [int(hits[-1][k : k + 2], 16) > 0 for k in (1, 3, 5)]
            assert pattern == [int(COLOURS[item][k : k + 2], 16) > 0 for k in (1, 3, 5)]
            checked += 1
    assert checked > 100
    assert doubtful <= 2


@pytest.mark.parametrize("view", [(-60, 22), (20, 3), (140, 60), (-130, -25)])
def test_a_part_on_a_table_cuts_nothing(view: tuple[float, float]) -> None:
    table = report.SceneBox((-50, -50, -10), (50, 50, 0), "#ff0000")
    part = report.SceneBox((30, -45, 0), (33, -40, 1), "#00ff00")
    faces = [
        p for p in the_svg(report.scene([part, table], title="t", view=view))[1] if p.get("fill") != "none"
    ]
    below = view[1] < 0  # then the table hides the part and is drawn last
    assert [(p.get("fill") or "").startswith("#00") for p in faces] == [below] * 3 + [not below] * 3


def test_a_piece_through_the_plane_is_cut() -> None:
    eps = 1e-9
    ends = {"low": [0.0, 0.5], "high": [0.5, 1.0], "in": [0.5, 0.5], "": [0.0, 1.0]}
    for side, at in ends.items():
        assert _side_of(np.array(at), 0.5, eps) == side
