"""Where rows stand along the path."""

from __future__ import annotations

import numpy as np
import pytest

from tests.programs import circle, line, mill, random_moves
from vcmm.shop.motion.toolpath import toolpath


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(4))
def test_rows_do_not_depend_on_their_density(seed):
    """Columns at the same place and time are equal, sampled coarsely or finely; time increases."""
    moves, machine = random_moves(np.random.default_rng(seed), 60), mill(gain=40.0)
    coarse = toolpath(moves, machine, plays=(0.005,))
    fine = toolpath(moves, machine, step=0.1, chord=1e-4, plays=(0.005,))
    assert fine.n > 2 * coarse.n
    assert (np.diff(coarse.time) > 0).all()
    near = np.clip(np.searchsorted(fine.time, coarse.time - 2e-9), 0, fine.n - 1)
    same = np.abs(fine.time[near] - coarse.time) < 4e-9
    assert same.sum() > 100
    for name, column in coarse.columns.items():
        if name == "time_since_accel_s":  # resolved to the spacing of the rows
            continue
        scale = max(1.0, np.abs(column).max())
        assert np.abs(column[same] - fine.columns[name][near[same]]).max() < 1e-6 * scale, name
    for name, label in coarse.labels.items():
        assert (label[same] == fine.labels[name][near[same]]).all(), name


def test_chord_and_step_are_kept():
    path = toolpath([circle(25.0, 3000.0)], mill(), step=50.0, chord=1e-3)
    angle = np.unwrap(np.arctan2(path.tip[:, 1], path.tip[:, 0]))
    assert (25.0 * (1 - np.cos(np.diff(angle) / 2))).max() <= 1e-3 * 1.001
    assert np.diff(toolpath([line((0, 0, 0), (10, 0, 0))], mill(), step=0.5).tip[:, 0]).max() <= 0.5 + 1e-9


def test_no_element_is_divided_more_than_asked_for():
    # 10 mm in steps of 0.5 mm: 21 places, besides those where the motion changes its phase
    x = toolpath([line((0, 0, 0), (10, 0, 0))], mill(), step=0.5).tip[:, 0]
    assert (np.abs(x * 2 - np.round(x * 2)) < 1e-9).sum() == 21
    assert len(x) <= 21 + 7  # seven phases of a motion of limited jerk


def test_reversals_stand_in_the_rows():
    """A circle turns X back at 0 and 180 deg, Y at 90 and 270 deg: rows are there, and distances count from them."""
    path = toolpath([circle(25.0, 3000.0)], mill(), step=7.0, chord=1.0)
    for i, places in ((0, (-25.0,)), (1, (25.0, -25.0))):
        for place in places:
            assert np.abs(path.tip[:, i] - place).min() < 1e-9
    end = path.run().column("since_reversal_Y_mm")[-1]
    assert end == pytest.approx(25.0, abs=1e-9)
    assert path.run().column("travel_X_mm")[-1] == pytest.approx(100.0, abs=1e-9)
