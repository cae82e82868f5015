"""What passes of the nose leave: feed marks, phase, profiles. Numbers by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shop.machining import lathe
from vcmm.shop.cutting.tools import insert

NOSE = (insert(0.8),)


def test_feed_marks_on_a_journal(tmp_path):
    """f = 0.05, r = 0.8: crests r - sqrt(r^2 - f^2/4) = 0.39072 um (f^2 / 8 r = 0.39063), mean f^2 / 24 r = 0.1302 um."""
    found, points = lathe.nominal(lathe.shop(lathe.write(tmp_path)), "journal")
    assert found.min() >= -1e-12
    assert found.max() == pytest.approx(0.39072e-3, rel=0.02)
    assert found.max() <= 0.39073e-3
    assert found.mean() == pytest.approx(0.1302e-3, rel=0.1)
    # the groove winds: on one generator 0.05 mm further along means the same height, and so does a turn
    assert len(np.unique(points[:, 2].round(9))) > 5


def test_the_phase_of_the_marks_is_that_of_the_spindle(tmp_path):
    """At any point the height is that of the nearest pass: u = distance from it along z, s = r - sqrt(r^2 - u^2)."""
    ready = lathe.shop(lathe.write(tmp_path))
    found, points = lathe.nominal(ready, "journal")
    # a turn of M3 takes the tool by -1 turn about the part: passes of the angle phi lie at z0 + f phi / 2 pi (mod f), for z falls
    # by f while the angle falls by 2 pi
    height = np.sqrt(np.maximum(0.8**2 - (0.8 - found) ** 2, 0.0))  # u of every point
    phi = np.arctan2(points[:, 1], points[:, 0])
    start = (points[:, 2] - 0.05 * phi / (2 * np.pi))[:, None] + np.stack([height, -height], axis=1)
    circular = np.exp(2j * np.pi * start / 0.05)
    off = [np.abs(np.angle(circular / one)).min(axis=1).max() for one in circular[height.argmin()]]
    assert min(off) < 1e-4


def test_every_feature_of_the_contour_lies_on_the_drawing(tmp_path):
    """With G42 the nose touches ball, journal, step, taper and seat: nothing but feed marks is left."""
    ready = lathe.shop(lathe.write(tmp_path))
    for name in ("ball", "journal", "step", "taper", "seat"):
        found, _ = lathe.nominal(ready, name)
        assert found.min() > -1e-6, name
        assert found.max() < 0.45e-3, name
