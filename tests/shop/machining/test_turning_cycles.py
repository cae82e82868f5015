"""Parts turned by G71 and G70: what the cycles leave is what their contour written out leaves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.shop.machining import lathe

CONTOUR = "G0 X20.\nG1 Z-30. F0.1\nX30.\nX36. Z-60.\nX40.\nZ-100.\nX46.\n"
CYCLES = (
    "G0 X46. Z2.\nG71 U1.5 R0.5\nG71 P10 Q20 U0.4 W0.1 F0.2\n"
    + CONTOUR.replace("G0 X20.", "N10 G0 X20.").replace("X46.\n", "N20 X46.\n")
    + "G70 P10 Q20\n"
)
BY_HAND = "G0 X46. Z2.\n" + CONTOUR
BAR = '[stock]\ndiameter = "44 mm"\nlength = "120 mm"\nfront = "1 mm"\nmaterial = "16MnCr5"\n'
FEATURES = lathe.SCENARIO.replace(
    'ball = { type = "sphere", point = "0 0 -10 mm", diameter = "20 mm" }\n', ""
)


def turned(folder, program, machine=""):
    folder.mkdir()
    path = lathe.write(
        folder, machine, program=lathe.HEAD + program + lathe.TAIL, scenario=FEATURES, setup=lathe.SETUP + BAR
    )
    return lathe.shop(path)


def test_the_finishing_cycle_leaves_what_its_contour_leaves(tmp_path):
    """Feed marks fall elsewhere, as the spindle stands elsewhere: their mean and the error of the machine are the same."""
    lean = lathe.effect("squareness", pair="B0Z", angle="50 urad")
    cycles, hand = (turned(tmp_path / n, p, lean) for n, p in (("a", CYCLES), ("b", BY_HAND)))
    for name in ("journal", "seat", "taper"):
        (one, _), (other, points) = lathe.moved(cycles, name), lathe.moved(hand, name)
        assert one.mean() == pytest.approx(other.mean(), abs=2e-5)
        if name != "taper":  # 50 urad from the work zero on: 0.5 um of radius per 10 mm
            assert one.mean() == pytest.approx(50e-6 * points[:, 2].mean(), abs=5e-5)


def test_roughing_removes_the_bar_layer_by_layer(tmp_path):
    """31 mm of the 44 mm bar to 20 mm, 30 mm to a taper of 30 to 36 mm, 40 mm to 40 mm; the nose leaves its fillets, 0.5 %."""
    blank = turned(tmp_path / "a", CYCLES).blank
    quarter, taper = math.pi / 4, math.pi / 12 * 30 * (30**2 + 30 * 36 + 36**2)
    removed = quarter * (31 * (44**2 - 20**2) + 40 * (44**2 - 40**2)) + quarter * 30 * 44**2 - taper
    assert blank.removed_volume == pytest.approx(removed, rel=6e-3)
    assert blank.collisions == ()
    # seven layers of 1.5 mm at 0.2 mm/turn, then 0.2 mm at 0.1 mm/turn: the finishing force is a few per cent of the roughing one
    main = np.abs(blank.forces[:, 1])
    assert 10 * np.median(main[-6:]) < main.max()
