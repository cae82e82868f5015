"""How wide the play of an axis is, and how much of it is taken up."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.history import Width, path_history, taken_up, taken_up_between
from vcmm.core.play import share_taken_up, widths
from vcmm.core.run import Run
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.reversal import Hysteresis, LostMotion, ReversalSpike
from vcmm.physics.catalogue.scale import ScaleFactor

AT = {"X": np.array([0.0, 100.0])}


def test_the_slide_rests_until_all_the_play_is_crossed():
    """h = 4: at 10 the slide is at 6; 8 and 3 leave it between (2 / 4, -3 / 4), 1 pushes it to 5 (-1)."""
    q = np.array([0.0, 10.0, 8.0, 3.0, 1.0, 2.0])
    assert taken_up(q, np.full(6, 4.0)).tolist() == [0.0, 1.0, 0.5, -0.75, -1.0, -0.75]


def test_between_two_rows_it_goes_on_from_the_first():
    found = taken_up_between(
        np.array([1.0, 1.0, 0.3]), np.zeros(3), np.array([-2.0, -50.0, 9.0]), np.array([4.0, 4.0, 0.0])
    )
    assert found.tolist() == [0.5, -1.0, 0.3]


def test_effects_of_one_axis_share_one_slide():
    """4 um and 2 um + 30 um/m x 0 and 0.1 m: 6 and 9 um, half of it 3 and 4.5. A scale has no play."""
    found = widths(
        (Backlash("X", 4e-3), LostMotion("X", 2e-3, 30e-6), ScaleFactor("X", 1e-5), Backlash("Y", 1.0)), AT
    )
    assert list(found) == ["X"]
    assert found["X"].half == pytest.approx([3e-3, 4.5e-3])
    assert found["X"].band == pytest.approx([6e-3, 9e-3])


def test_what_sticks_has_no_play_but_a_band():
    """Right at a reversal hysteresis and a gamma pulse jump by nothing; the loop is 2 x 3 um wide, the pulse 5 um high."""
    for effect, band in ((Hysteresis("X", 3e-3), 6e-3), (ReversalSpike("X", 5e-3), 5e-3)):
        width = widths((effect,), AT)["X"]
        assert width.half.tolist() == [0.0, 0.0]
        assert width.band == pytest.approx([band] * 2, rel=0.01)


def test_an_axis_that_comes_back_by_less_than_its_band_has_not_turned():
    wide = {"X": Width(np.full(4, 2.0), np.full(4, 4.0))}
    columns = path_history({"X": np.array([0.0, 10.0, 7.0, 5.0])}, widths=wide)
    assert columns["sense_X"].tolist() == [0.0, 1.0, 1.0, -1.0]
    assert columns["since_reversal_X_mm"].tolist() == [0.0, 10.0, 10.0, 5.0]
    assert columns["play_X"].tolist() == [0.0, 1.0, -0.5, -1.0]


def test_backlash_is_half_the_gap_times_what_is_taken_up():
    """-8 / 2 x (1, 0.5, -1) um; without a dense path the direction counts."""
    run = Run(
        {"X": np.zeros(3)},
        np.zeros((3, 3)),
        {"sense_X": np.array([1.0, 1.0, -1.0]), "play_X": np.array([1.0, 0.5, -1.0])},
    )
    assert Backlash("X", 8e-3).error_motion(run)[:, 0] == pytest.approx([-4e-3, -2e-3, 4e-3])
    bare = Run(run.position, run.offset, {"sense_X": run.columns["sense_X"]})
    assert share_taken_up(bare, "X").tolist() == [1.0, 1.0, -1.0]
