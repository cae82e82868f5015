"""The order of touches: short ways, and drift that does not look like the measurand."""

from __future__ import annotations

import numpy as np

from vcmm.placing.plan_order import Visit, ordered, ways


def on_plane(*xy):
    return np.array([[x, y, 0.0] for x, y in xy])


def test_there_and_back_takes_drift_out_of_a_distance():
    """Two faces, four touches each, drift along the distance: A B ... A again leaves less than a tenth of A A A A B B B B."""
    group = np.repeat([0, 1], 4)
    tips = np.concatenate(
        [on_plane(*((0, y) for y in range(0, 40, 10))), on_plane(*((100, y) for y in range(0, 40, 10)))]
    )
    pull = np.where(group == 0, -0.25, 0.25)[None, :, None]
    visit = Visit(group, 1.2, ways(tips, group, group * 0, 100.0, 20.0, 0.0), pull)
    plain, careful = ordered(visit, 0.0), ordered(visit, 1e3)
    assert visit.drift(careful) < 0.01 * visit.drift(plain)
    assert sorted(careful) == list(range(8))
    assert visit.times(plain)[-1] <= visit.times(careful)[-1]
