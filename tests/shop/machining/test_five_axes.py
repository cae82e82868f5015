"""Cutting with the tip led over the workpiece: closed forms for tools that lean, tables beside their place, zeros that turn."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import rotary_shop
from vcmm.shop.machining.contact_path import surface_at
from vcmm.shop.machining.job import cut
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.recut import recut

HEAD, TABLES = "w X' Y' b Z C B t", "w C' B' X' Y' b Z t"
PIVOT = "0 0 -250"
BALL, FLAT = 'diameter = "10 mm"\nshape = "ball"\n', 'diameter = "10 mm"\n'
BULL = 'diameter = "10 mm"\nshape = "bull"\ncorner_radius = "1 mm"\n'
STRIP = 'strip = { type = "plane", point = "0 0 %.12f mm", normal = [0, 0, 1], size = "40 0.001 mm" }\n'
WALLS = """\
right = { type = "plane", point = "30 0 -6 mm", normal = [1, 0, 0], size = "20 4 mm" }
left = { type = "plane", point = "-30 0 -6 mm", normal = [-1, 0, 0], size = "20 4 mm" }
[[part.characteristics]]
name = "width"
type = "distance"
between = ["left", "right"]
"""
BOTH = """\
G43.4 H1 G0 X60. Y-30. Z5.
G1 X60. Y-30. Z-10. F1000
X35.
Y30.
X60.
G0 Z50.
C180.
G0 X-60. Y-30.
G1 Z-10. F1000
X-35.
Y30.
X-60.
G0 Z50.
"""


def head(more: str = "") -> str:
    return rotary_shop.machine(HEAD, rotary_shop.axis("C", PIVOT) + rotary_shop.axis("B", PIVOT) + more)


def tables(more: str = "") -> str:
    return rotary_shop.machine(TABLES, rotary_shop.axis("B") + rotary_shop.axis("C") + more)


@pytest.mark.parametrize("turning", [False, True], ids=["leaning", "turning"])
@pytest.mark.parametrize(
    ("tool", "under"),
    [
        (BALL, lambda b: 5.0 * (1 - np.cos(b))),  # the centre of the ball is led 5 mm up the axis
        (FLAT, lambda b: 5.0 * np.sin(b)),  # the edge on the far side
        (BULL, lambda b: 4.0 * np.sin(b) + 1.0 * (1 - np.cos(b))),  # core of 4 mm, corner of 1 mm
    ],
    ids=["ball", "flat", "bull"],
)  # fmt: skip
def test_how_deep_a_leaning_tool_cuts_below_its_tip(tmp_path, tool, under, turning):
    """The tip runs along Y on Z -2 while B stands at 20 deg, or turns from 20 to 20.6 deg: the deepest point is known."""
    b = np.radians(20.0)
    program = (
        "G43.4 H1 G0 X0 Y-30. Z20. B20.\nG1 Z-2. F1000\n"
        + ("Y30. B20.6\n" if turning else "Y30.\n")
        + "G0 Z50.\n"
    )
    # beside the tip the deepest point lies by 5 sin b (ball), 5 cos b (flat), 4 cos b + sin b (bull)
    ready = rotary_shop.shop_of(rotary_shop.write(tmp_path, head(), program, STRIP % (-2.0 - under(b)), tool))
    y = np.linspace(-18.0, 18.0, 7)
    lean = b + np.radians(0.6) * (y + 30) / 60 * turning
    x = {BALL: 5 * np.sin(lean), FLAT: 5 * np.cos(lean), BULL: 4 * np.cos(lean) + np.sin(lean)}[tool]
    points = np.column_stack([x, y, -2.0 - under(lean)])
    found = surface_at(ready, points, np.tile([0.0, 0.0, 1.0], (7, 1)))
    assert found.contact_s[:, 0] == pytest.approx(0.0, abs=1e-5)


def test_a_table_that_stands_beside_its_place(tmp_path):
    """C stands 5 um off in X: the zero was set at C 0, and the control turns it with the part, so both add up at C 180.

    left: 2 x 5 um, along +X of the part, which takes 10 um of the left wall; right: nothing. With a zero along the machine axes
    (no tool centre point control) both would cancel.
    """
    location = '[[effects]]\neffect = "rotary_location"\ncomponent = "X0C"\noffset = "5 um"\n'
    path = rotary_shop.write(tmp_path, tables(location), BOTH, WALLS, FLAT)
    found = {n: p.height - p.nominal for n, p in rotary_shop.patches(path).items()}
    assert np.abs(found["right"]).max() < 1e-7
    assert np.abs(found["left"]) == pytest.approx(10e-3, abs=1e-6)


@pytest.mark.thorough
def test_a_zero_set_wrongly_turns_with_the_part(tmp_path):
    """3 um in X under tool centre point control: both walls go the same way, the width keeps its size."""
    path = rotary_shop.write(tmp_path, tables(), BOTH, WALLS, FLAT, 'work_offset = { u = "3 um" }')
    (width,) = cut(vcmm.load_cut(path)).characteristics
    assert width.u < 1e-6
    plain = (
        BOTH.replace("G43.4 H1", "G43 H1")
        .replace("G0 X-60. Y-30.", "G0 X60. Y30.")
        .replace("X-35.\nY30.\nX-60.", "X35.\nY-30.\nX60.")
    )
    path = rotary_shop.write(tmp_path, tables(), plain, WALLS, FLAT, 'work_offset = { u = "3 um" }')
    (width,) = cut(vcmm.load_cut(path)).characteristics
    assert width.u == pytest.approx(6e-3, rel=0.01)  # along the axes of the machine: 3 um on either side


def test_a_head_whose_tilting_axis_stands_beside_that_of_its_turn(tmp_path):
    """C of the head carries B, which stands 4 um off in X: at C 180 the tool is 4 um on the other side, 8 um off the zero.

    The left wall is cut by a tool that stands 8 um too far in -X: 8 um of material are left.
    """
    location = '[[effects]]\neffect = "rotary_location"\ncomponent = "X0B"\noffset = "4 um"\n'
    path = rotary_shop.write(tmp_path, head(location), BOTH, WALLS, FLAT)
    found = {n: p.height - p.nominal for n, p in rotary_shop.patches(path).items()}
    assert np.abs(found["right"]).max() < 1e-7
    assert found["left"] == pytest.approx(8e-3, abs=1e-6)


def test_cut_again_with_the_tools_really_displaced(tmp_path):
    location = '[[effects]]\neffect = "rotary_location"\ncomponent = "X0C"\noffset = "5 um"\n'
    ready = set_up(vcmm.load_cut(rotary_shop.write(tmp_path, tables(location), BOTH, WALLS, FLAT)))
    points = np.column_stack([np.full(5, 30.0), np.linspace(-8, 8, 5), np.full(5, -6.0)])
    found = recut(ready, surface_at(ready, points, np.tile([1.0, 0.0, 0.0], (5, 1)), exact=False))
    assert found is not None
    assert found.largest < 1e-4
