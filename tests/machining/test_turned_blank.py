"""The bar of a lathe: chip, force and volume by hand, a closed body, rapids through it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.machining import lathe
from tests.machining.lathe import BAR, plain
from vcmm.machining.preparation import remarks
from vcmm.machining.turned_blank import mesh


def test_the_chip_and_its_force_by_hand(tmp_path):
    ready = lathe.shop(plain(tmp_path, setup=lathe.SETUP + BAR))
    blank = ready.blank
    assert blank is not None
    row = [ready.program.moves[i].kind for i in ready.sweep.move].index("line")
    # 2 mm deep, 0.1 mm per turn: S 0.2 mm2; edge at work 0.8 pi/2 + 1.2 = 2.4566 mm, h 0.08141 mm;
    # Fc = 2.4566 x 2109 x 0.08141^0.738 = 814 N. Chord of the edge: 0.8 along, 2 across: leans by atan 2.5 = 68.2 deg;
    # 0.45 x 814 = 366 N across it: 136 N out of the work, 340 N against the feed, which goes to -Z
    assert blank.forces[row] == pytest.approx([136.0, 814.0, 340.0], rel=0.01)
    # removed: pi (22^2 - 20^2) x 60 mm and a fillet, and of the shoulder what lies over it: 15.8 cm3
    assert blank.removed == pytest.approx(math.pi * (22**2 - 20**2) * 60, rel=0.01)
    assert blank.collisions == ()


def test_the_bar_is_a_closed_body(tmp_path):
    import trimesh

    ready = lathe.shop(lathe.write(tmp_path, setup=lathe.SETUP + BAR.replace("90", "130")))
    after = ready.blank.after
    body = trimesh.Trimesh(*mesh(after))
    assert body.is_watertight
    # 96 sides hold 0.9993 of a circle: (96 / 2 pi) sin(2 pi / 96)
    assert body.volume == pytest.approx(after.volume * 96 / (2 * np.pi) * np.sin(2 * np.pi / 96), rel=2e-3)


def test_a_rapid_through_the_bar_is_told(tmp_path):
    program = "G0 X44. Z2.\nX40.\nG0 Z-20.\nG1 Z-60. F0.1\nX52.\n"
    ready = lathe.shop(plain(tmp_path, setup=lathe.SETUP + BAR, program=program))
    assert any("a rapid runs through the stock, 2.00 mm deep" in text for text in remarks(ready))


def test_a_facing_cut_takes_off_what_lies_over_its_nose(tmp_path):
    """2 mm of a bar of 44 mm, faced by a nose of 0.8 mm, which sweeps 1.6 mm: 3.04 cm3, and the way back is free."""
    program = "G0 X46. Z2.\nZ0.\nG1 X-1.6 F0.1\nG0 Z5.\nX46.\n"
    bar = '[stock]\ndiameter = "44 mm"\nlength = "90 mm"\nfront = "2 mm"\n'
    blank = lathe.shop(plain(tmp_path, setup=lathe.SETUP + bar, program=program)).blank
    assert blank.collisions == ()
    assert blank.removed == pytest.approx(math.pi * 22**2 * 2, rel=0.01)


def test_a_part_that_is_parted_off_stays(tmp_path):
    program = "G0 X46. Z-40.\nG1 X-1.6 F0.1\nG0 X46.\n"
    blank = lathe.shop(plain(tmp_path, setup=lathe.SETUP + BAR, program=program)).blank
    assert blank.collisions == ()
    assert blank.removed == pytest.approx(math.pi * 22**2 * 1.6, rel=0.02)  # the nose of 0.8 mm alone
