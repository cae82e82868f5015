"""The modal state: speeds by hand, and its snapshot."""

from __future__ import annotations

import math

import pytest

from vcmm.program.radius import RadiusCompensation
from vcmm.program.state import ModalState


def test_turns_at_constant_surface_speed():
    # 100 m/min at a radius of 10 mm: 100000 / (2 pi 10) = 1591.549 turns per minute
    state = ModalState(surface=True, speed=100.0)
    assert state.turns(10.0) == pytest.approx(1591.5494309)
    assert state.turns(-10.0) == state.turns(10.0)
    assert state.turns(0.0) == math.inf
    state.speed_limit = 1200.0
    assert state.turns(10.0) == state.turns(0.0) == 1200.0
    assert ModalState(speed=500.0).turns(3.0) == 500.0


def test_diameters():
    assert not ModalState().diametral()
    assert ModalState(diameter="always", absolute=False).diametral()
    assert ModalState(diameter="absolute").diametral()
    assert not ModalState(diameter="absolute", absolute=False).diametral()


def test_the_snapshot_does_not_follow():
    state = ModalState(motion="G1", feed=200.0, surface=True, compensation=RadiusCompensation("left", 5.0))
    before = state.modal()
    state.motion, state.feed_mode = "G0", "G93"
    assert (before.motion, before.feed, before.spindle_mode, before.side) == ("G1", 200.0, "G96", "left")
    assert state.modal() == before._replace(motion="G0", feed_mode="G93", feed=0.0)
