"""Turning moves as short lines, by hand: how many, where they lead, and that standing axes keep their moves whole."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.shop.machining.test_rotary import machine
from vcmm.core.errors import ModelLimit
from vcmm.shop.cutting.sweeps import lines
from vcmm.shop.cutting.tools import ball
from vcmm.shop.machining import rotary_sweep
from vcmm.shop.machining.rotary_sweep import SEARCH, in_workpiece, turns

TABLE = machine("w B' X' Y' b Z t")
START = np.array([[0.0, 0.0, -370.0]])  # 30 mm over the centre of the table


def swept(angle: float):
    base = lines(START, START + [[0.0, 1e-6, 0.0]], (ball(3.0),))
    turned = np.array([[[0.0, 0.0, 0.0], [0.0, angle, 0.0]]])
    return in_workpiece(TABLE, base, turned, np.zeros((1, 3)), np.array([False]))


def test_a_quarter_of_a_table_by_its_chords_and_tilts():
    """Centre of the ball 33 mm from the table's centre: sagitta 33 (pi/2)^2 / 8 n^2 <= 2 um asks for n >= 72; the tilt
    (pi/2) sqrt(3^2 + 6^2) / 2 n <= 2 um for n >= 2635, which counts."""
    sweep, motion = swept(math.pi / 2)
    n = math.ceil(math.pi / 2 * math.hypot(3.0, 6.0) / (2 * SEARCH))
    assert len(sweep) == pytest.approx(n, rel=1e-3)
    assert motion.inexact.all()
    assert np.hypot(sweep.start[:, 0], sweep.start[:, 2] + 400.0) == pytest.approx(
        np.full(len(sweep), 30.0), abs=SEARCH
    )
    assert motion.first[0] == 0.0
    assert motion.last[-1] == 1.0


def test_axes_that_stand_keep_the_move_whole():
    base = lines(START, START + [[40.0, 0.0, 0.0]], (ball(3.0),))
    stands = np.full((1, 2, 3), [0.0, math.pi / 2, 0.0])
    sweep, motion = in_workpiece(TABLE, base, stands, np.zeros((1, 3)), np.array([False]))
    assert len(sweep) == 1
    assert not motion.inexact.any()
    assert np.linalg.norm(sweep.end - sweep.start) == pytest.approx(40.0)
    assert not turns(stands).any()


def test_too_many_pieces_are_refused(monkeypatch):
    monkeypatch.setattr(rotary_sweep, "MOST_ROWS", 100)
    with pytest.raises(ModelLimit, match="most of them in its move 1"):
        swept(math.pi / 2)
