"""A ball that rests on the feed marks of a turned part."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shop.machining import lathe

UM = 1e-3


@pytest.mark.thorough
def test_a_ball_rests_on_the_feed_marks(tmp_path):
    ready = lathe.shop(lathe.write(tmp_path))
    _, points = lathe.nominal(ready, "journal")
    from vcmm.shop.machining.contact_path import surface_at

    normals = points * [1, 1, 0] / 10.0
    found = surface_at(ready, points, normals)
    on = found.contact_s[:, 0] + ready.process.cusp_lift(ready, found, np.arange(len(points)), 1.0)
    # crests 0.39072 um high, 0.025 mm either side of a valley; a ball of 1 mm comes down 1 - sqrt(1 - 0.025^2) = 0.31255 um between
    # them: it reads 0.0782 um over a valley and 0.3907 um on a crest
    assert on.min() == pytest.approx(0.0782 * UM, abs=0.004 * UM)
    assert on.max() == pytest.approx(0.3907 * UM, abs=0.004 * UM)
    assert (on >= found.contact_s[:, 0] - 1e-12).all()
    # a ball of 2 mm comes down 2 - sqrt(4 - 0.025^2) = 0.15626 um between them
    wide = found.contact_s[:, 0] + ready.process.cusp_lift(ready, found, np.arange(len(points)), 2.0)
    assert wide.min() == pytest.approx(0.2345 * UM, abs=0.004 * UM)
