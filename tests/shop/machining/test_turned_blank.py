"""The bar of a lathe: chip, force and volume by hand, a closed body, rapids through it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.shop.machining import lathe
from tests.shop.machining.lathe import BAR, plain
from vcmm.shop.machining.preparation import remarks
from vcmm.shop.machining.turned_blank import mesh


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
    assert blank.removed_volume == pytest.approx(math.pi * (22**2 - 20**2) * 60, rel=0.01)
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
    assert blank.removed_volume == pytest.approx(math.pi * 22**2 * 2, rel=0.01)


def test_a_part_that_is_parted_off_stays(tmp_path):
    program = "G0 X46. Z-40.\nG1 X-1.6 F0.1\nG0 X46.\n"
    blank = lathe.shop(plain(tmp_path, setup=lathe.SETUP + BAR, program=program)).blank
    assert blank.collisions == ()
    assert blank.removed_volume == pytest.approx(math.pi * 22**2 * 1.6, rel=0.02)  # the nose of 0.8 mm alone


SHOULDER = "G0 X46. Z2.\nX30.\nG1 Z-20. F0.1\nG0 X46.\n"  # turned to 30 mm before: the front is free


def test_a_shoulder_faced_deeper_than_twice_the_nose_is_no_collision(tmp_path):
    """3 mm at once with a nose of 0.8 mm: from 44 to 30 mm between Z -23 and Z -20, 2.45 cm3; the way back is free."""
    face = "G0 Z-23.\nG1 X30. F0.1\nG0 U2. W1.\nZ2.\nX46.\n"
    ready = lathe.shop(plain(tmp_path, setup=lathe.SETUP + BAR, program=SHOULDER + face))
    blank = ready.blank
    assert blank.collisions == ()
    turned = math.pi * (22**2 - 15**2) * (20 + 3)  # fillets of the nose aside: 0.2 r^2 of section each, 0.1 %
    assert blank.removed_volume == pytest.approx(turned, rel=0.005)
    # the chip of the facing cut is that of a pass 3 mm deep: S 0.3 mm2, edge 0.8 pi/2 + 2.2 = 3.4566 mm, h 0.08679 mm;
    # Fc = 3.4566 x 2109 x 0.08679^0.738 = 1200 N
    kinds = [ready.program.moves[i] for i in ready.sweep.move]
    row = max(i for i, m in enumerate(kinds) if m.kind == "line")
    assert abs(blank.forces[row][1]) == pytest.approx(1200.0, rel=0.02)


def test_a_rapid_into_the_shoulder_and_one_through_a_wide_ring_are_still_told(tmp_path):
    deeper = SHOULDER + "G0 Z-23.\nG1 X30. F0.1\nG0 Z-26.\nX46.\n"  # on into the shoulder at X30
    texts = remarks(lathe.shop(plain(tmp_path, setup=lathe.SETUP + BAR, program=deeper)))
    assert any("line 14: a rapid runs through the stock, 7.00 mm deep" in text for text in texts)
    ring = (
        SHOULDER + "G0 Z-30.\nG1 X30. F0.1\nG0 Z2.\nX46.\n"
    )  # a ring of 8.4 mm stands before the nose: no edge faces that
    texts = remarks(lathe.shop(plain(tmp_path, setup=lathe.SETUP + BAR, program=ring)))
    assert any("line 14: a rapid runs through the stock, 7.00 mm deep" in text for text in texts)


def test_a_shoulder_faced_inside_a_bore_is_no_collision(tmp_path):
    """Bore of 20 mm opened to 26 mm over 10 mm, its shoulder faced 3 mm deeper: 2.8 cm3 go, the way out is free."""
    bar = BAR.replace('"90 mm"', '"90 mm"\nbore = "20 mm"')
    program = "G0 X26. Z2.\nG1 Z-10. F0.1\nG0 X18.\nZ-13.\nG1 X26. F0.1\nG0 U-2. W1.\nZ5.\nX60.\n"
    setup = lathe.SETUP.replace("orientation = 3", "orientation = 2") + bar
    blank = lathe.shop(plain(tmp_path, setup=setup, program=program)).blank
    assert blank.collisions == ()
    assert blank.removed_volume == pytest.approx(math.pi * (13**2 - 10**2) * 13, rel=0.01)


def test_a_groove_tool_opens_the_stock_over_its_width(tmp_path):
    """3 mm wide, corners of 0.2 mm, its lower one at Z -13: pi (22^2 - 20^2) 3 = 792 mm3; out again is free, through the flank is not."""
    tool = lathe.SETUP.replace('"0.8 mm"', '"0.2 mm"\nwidth = "3 mm"')
    groove = "G0 X46. Z-13.\nG1 X40. F0.1\nG0 X46.\n"
    blank = lathe.shop(plain(tmp_path, setup=tool + BAR, program=groove)).blank
    assert blank.collisions == ()
    assert blank.removed_volume == pytest.approx(math.pi * (22**2 - 20**2) * 3, rel=0.02)
    through = "G0 X46. Z-13.\nG1 X40. F0.1\nG0 Z-5.\nX46.\n"
    blank = lathe.shop(plain(tmp_path, setup=tool + BAR, program=through)).blank
    assert [d for _, d in blank.collisions] == pytest.approx([2.0], abs=0.01)


def test_a_rapid_that_is_run_twice_is_told_once(tmp_path):
    """At X 42 a rapid runs 1 mm deep, at X 38 2 mm deeper: one line, its deepest run."""
    path = plain(tmp_path, setup=lathe.SETUP + BAR, program="G0 X48. Z2.\nG1 X46. F0.1\nM98 P2 L2\n")
    part = tmp_path / "part.nc"
    part.write_text(part.read_text().rstrip("%\n") + "\nO2\nG0 U-4.\nZ-20.\nZ2.\nM99\n%\n")
    assert [depth for _, depth in lathe.shop(path).blank.collisions] == pytest.approx([2.0], abs=0.01)
