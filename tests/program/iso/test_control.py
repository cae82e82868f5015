"""What a control of the G-code family remembers, by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.program.dialects import FANUC, FANUC_LATHE, LINUXCNC
from vcmm.program.faults import BlockFault
from vcmm.program.iso.control import new_control
from vcmm.program.setup import Setup

SETUP = Setup(offsets={"G54": (100.0, 0.0, 0.0)}, rotations={"G54": math.pi / 2})


def test_how_controls_wake_up():
    assert (new_control("p", FANUC, Setup()).retract, new_control("p", LINUXCNC, Setup()).retract) == (
        "G98",
        "G99",
    )
    lathe = new_control("p", FANUC_LATHE, Setup())
    assert (lathe.plane, lathe.diametral(), lathe.feed_mode) == ("ZX", True, "G95")


def test_shifts_lie_inside_the_rotation_of_the_offset():
    # G92 (1, 0, 0) and G52 (0, 2, 0), turned by 90 deg, on (100, 0, 0) + common (0, 0, 5): p = 0 -> (98, 1, 5)
    c = new_control("p", FANUC, SETUP)
    c.g92, c.g52, c.common = (1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 5.0)
    c.rebuild()
    assert c.world.apply((0.0, 0.0, 0.0)) == (98.0, 1.0, 5.0)


def test_g68_leaves_its_centre_where_it_is():
    c = new_control("p", FANUC, Setup())
    c.turn = ("XY", (10.0, 0.0, 0.0), math.pi / 2)
    c.rebuild()
    assert c.world.apply((10.0, 0.0, 3.0)) == (10.0, 0.0, 3.0)
    assert c.world.apply((12.0, 0.0, 3.0)) == (10.0, 2.0, 3.0)


def test_feeds_and_speeds_in_inches():
    # F10 inch/min = 254 mm/min; 100 ft/min at a radius of 1 inch: 30480 / (2 pi 25.4) = 190.986 turns per minute
    c = new_control("p", LINUXCNC, Setup())
    c.set_unit(25.4)
    c.feed, c.speed = 10.0, 100.0
    assert c.rate(1.0, 0.0) == pytest.approx(254.0)
    c.surface = True
    assert c.feeding(25.4) == pytest.approx(190.98593171)
    assert c.feeding(0.0) == c.speed_at_centre() == 0.0
    # a rotary axis alone is fed in degrees per minute, whatever the unit
    assert c.line_feed((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)) == pytest.approx(10.0)
    c.column, c.feed_mode = 7, "G95"
    with pytest.raises(BlockFault, match="the spindle has no speed") as fault:
        c.rate(1.0, 0.0)
    assert fault.value.column == 7
