"""vcmm/physics/catalogue/play.py: values by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.physics.ask import ask
from vcmm.core.effect import required
from vcmm.core.errors import UsageError
from vcmm.core.history import rows_after_turning
from vcmm.core.run import Run
from vcmm.physics.catalogue.play import BacklashRamp, LoadedPlay, PlayOperator


def one_row(position=(0.0, 0.0, 0.0), **columns: float) -> Run:
    named = {k: np.array([v]) for k, v in columns.items()}
    return Run({a: np.array([q]) for a, q in zip("XYZ", position)}, np.zeros((1, 3)), named)


def test_play_along_a_ramp():
    # gap 20 um, 12 um of it made up over 0.4 mm, moving up: -10 um at the reversal, half way -7 um, from 0.4 mm on -4 um
    effect = BacklashRamp("X", 20e-3, 12e-3, 0.4)
    for since, expected in ((0.0, -10e-3), (0.2, -7e-3), (0.4, -4e-3), (5.0, -4e-3)):
        run = one_row(sense_X=1.0, since_reversal_X_mm=since)
        assert effect.error_motion(run)[0, 0] == pytest.approx(expected, abs=1e-15)
    assert required(BacklashRamp("C")) == ("sense_C", "since_reversal_C_rad")
    with pytest.raises(UsageError, match="distance must be positive"):
        BacklashRamp("X", 1e-3, distance=0.0)


def test_the_slide_comes_over_on_the_way_after_a_reversal():
    # gap 20 um over 0.4 mm. Up, before the first reversal: -10 um. Then down: still -10 um at the reversal (d = -1: +10 (2 s / 0.4 - 1)),
    # 0 half way, +10 um from 0.4 mm on. Up again: +10 um, 0, -10 um.
    sense = np.array([1.0, 1, -1, -1, -1, 1, 1, 1])
    since = np.array([0.0, 1, 0, 0.2, 0.9, 0, 0.2, 0.4])
    columns = {
        "sense_X": sense,
        "since_reversal_X_mm": since,
        "turned_X": rows_after_turning(sense, np.arange(8.0)),
    }
    run = Run({"X": np.zeros(8)}, np.zeros((8, 3)), columns)
    expected = [-10, -10, -10, 0, 10, 10, 0, -10]
    effect = PlayOperator("X", 20e-3, 0.4)
    assert effect.error_motion(run)[:, 0] == pytest.approx([e * 1e-3 for e in expected], abs=1e-15)
    # without a word of what was before, the start counts as a reversal: at s = 0 the slide is on the other side, from 0.4 mm on over
    assert effect.error_motion(replace(run, columns={n: v for n, v in columns.items() if n != "turned_X"}))[
        :2, 0
    ] == pytest.approx([10e-3, -10e-3])


def test_rows_are_turned_by_the_clock():
    # by the clock: 1, 0, 1, -1, -1, 1: turned from the fourth on; the rows stand the other way round
    sense, time = np.array([1.0, -1, -1, 1, 0, 1]), np.array([5.0, 4, 3, 2, 1, 0])
    assert rows_after_turning(sense, time).tolist() == [1, 1, 1, 0, 0, 0]
    assert rows_after_turning(np.ones(3), np.arange(3.0)).tolist() == [0, 0, 0]


def test_a_ramp_that_goes_on_to_the_end_of_every_way_is_a_slope_and_a_step():
    # 0 to 10 mm and back: d_a s = q upwards, q - 10 downwards = q - 5 + 5 d_a; of a ramp over 10 mm nothing is left, of one over 5 mm much
    q = np.r_[np.arange(11.0), np.arange(10.0)[::-1]]
    sense = np.r_[np.ones(11), -np.ones(10)]
    since = np.r_[np.arange(11.0), 10.0 - np.arange(10.0)[::-1]]
    run = Run({"X": q}, np.zeros((21, 3)), {"sense_X": sense, "since_reversal_X_mm": since})
    for kind in (BacklashRamp, PlayOperator):
        assert [
            kind("X", distance=d).diagnosis.shows_at(kind("X", distance=d), run) for d in (5.0, 10.0, 30.0)
        ] == [True, False, False]
    assert PlayOperator("C").required_columns() == ("sense_C", "since_reversal_C_rad")


def test_play_that_grows_with_the_load():
    # 2 um + 0.01 um/kg x 300 kg = 5 um; moving down half of it, +2.5 um
    effect = LoadedPlay("Y", 2e-3, 1e-5)
    assert effect.error_motion(one_row(sense_Y=-1.0, load_kg=300.0))[0, 1] == pytest.approx(2.5e-3, abs=1e-15)
    loads = Run({}, np.zeros((2, 3)), {"load_kg": np.array([0.0, 300.0])})
    assert ask(effect, "shows_in", loads)
    assert not ask(effect, "shows_in", loads.with_columns({"load_kg": np.zeros(2)}))
