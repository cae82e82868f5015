"""Rows of cycles: what becomes of a number by its kind, what is needed, what stays open."""

from __future__ import annotations

import math

import pytest

from vcmm.program.cycle_tables import NUMBER_KINDS, cycle, in_units
from vcmm.program.fagor.reader import ROWS
from vcmm.program.heidenhain.contours import CONTOUR_CYCLES
from vcmm.program.heidenhain.cycles import MACHINING, OLD
from vcmm.program.heidenhain.patterns import PATTERNS as KLARTEXT_PATTERNS
from vcmm.program.heidenhain.touch_cycles import CYCLES as TOUCH
from vcmm.program.iso.cycles import DRILLING
from vcmm.program.iso.grooving import GROOVING, SINGLE
from vcmm.program.iso.probing_macros import MACROS
from vcmm.program.iso.turning import CONTOURED
from vcmm.program.sinumerik.cycles import PATTERNS
from vcmm.program.sinumerik.drilling import DRILLING as SINUMERIK_DRILLING
from vcmm.program.sinumerik.measuring import MEASURED
from vcmm.program.sinumerik.milling import MILLING
from vcmm.program.sinumerik.turning import TURNING


def test_kinds_of_numbers_in_inches():
    row = cycle("Z=depth mm!, D size, A deg, F feed, P plain, R mm?", None)
    given = {"Z": -0.5, "D": -2.0, "A": 90.0, "F": 4.0, "P": 7.0, "X": 1.0}
    v = row.read(given, in_units(25.4, 2.54))
    # -0.5 inch = -12.7 mm; |-2| inch = 50.8 mm; 90 deg; 4 tenths of an inch/min = 10.16 mm/min
    assert (v["depth"], v["D"], v["A"], v["F"], v["P"]) == (-12.7, 50.8, math.pi / 2.0, 10.16, 7.0)
    assert not v.has("R")
    assert v.without("R", 3.0) == 3.0
    assert not v.has("X")  # no parameter of the row
    assert (row.required_names, row.uses("Z"), row.uses("X")) == (("Z",), True, False)


def test_arguments_in_their_order_and_two_names_of_one_meaning():
    row = cycle("RTP mm?, DP mm?, E=lead mm, F=lead mm", None)
    assert row.by_name([10.0, None, 1.0, None, 5.0]) == {
        "RTP": 10.0,
        "E": 1.0,
    }  # what is beyond is left alone
    assert row.read({"E": 1.5}, in_units(1.0, 1.0))["lead"] == 1.5
    assert row.read({"E": 1.5, "F": 2.0}, in_units(1.0, 1.0))["lead"] == 2.0


def test_an_unknown_kind_is_refused():
    with pytest.raises(ValueError, match="length is no kind of a parameter; known are mm, size"):
        cycle("Z length", None)


def test_every_row_names_each_parameter_once():
    turning = [r for t in (*GROOVING.values(), *CONTOURED.values()) for r in (t.first, t.second, t.single)]
    tables = (
        MACHINING,
        CONTOUR_CYCLES,
        SINGLE,
        KLARTEXT_PATTERNS,
        DRILLING,
        SINUMERIK_DRILLING,
        MEASURED,
        MILLING,
        PATTERNS,
        TURNING,
    )
    rows = [*(r for t in tables for r in t.values()), *turning, *ROWS.values()]
    rows += [o.row for o in OLD.values()] + [t.row for t in TOUCH.values()] + [m.row for m in MACROS.values()]
    assert len(rows) > 120
    for row in rows:
        names = [p.name for p in row.parameters]
        assert len(set(names)) == len(names), names
        assert {p.kind for p in row.parameters} <= set(NUMBER_KINDS)
    for touch in TOUCH.values():
        assert all(word.count("=") == 1 for word in touch.results.split())
    for macro in MACROS.values():
        assert bool(macro.row.required_names) == bool(macro.needs)
