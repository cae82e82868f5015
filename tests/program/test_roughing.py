"""Passes of a roughing cycle, by hand."""

from __future__ import annotations

import itertools

import pytest

from vcmm.program.moves import Move, Source
from vcmm.program.roughing import Rough, passes


def test_a_pass_shorter_than_its_retraction_goes_back_to_where_it_began() -> None:
    """From X 10, Z 3 down a step at Z 2.5 to X 5: a pass 2 deep is 0.5 long; it leaves by 2 in X, and by 0.5 in Z, not by 2."""
    at = Source(1, 1, 2)
    corners = [(10.0, 0.0, 3.0), (5.0, 0.0, 3.0), (5.0, 0.0, 2.5), (10.0, 0.0, 2.5)]
    moves = [Move("line", at, a, b) for a, b in itertools.pairwise(corners)]
    cuts = list(passes(moves, (10.0, 3.0), Rough(2.0, 2.0, 0.0, 0.0), "XZ"))
    assert [c.end for c in cuts[:4]] == [(8.0, 3.0), (8.0, 2.5), (10.0, 3.0), (10.0, 3.0)]
    assert [c.end for c in cuts[4:8]] == [(6.0, 3.0), (6.0, 2.5), (8.0, 3.0), (8.0, 3.0)]


def test_a_pass_meets_an_arc_on_its_circle() -> None:
    """A nose of radius 10 about X 0, Z -10: at X 6 it lies sqrt(100 - 36) = 8 above the centre, at Z -2; the pass comes down from X 10."""
    at = Source(1, 1, 2)
    lead = Move("line", at, (10.0, 0.0, 3.0), (0.0, 0.0, 0.0))
    nose = Move("arc", at, (0.0, 0.0, 0.0), (10.0, 0.0, -10.0), centre=(0.0, 0.0, -10.0), clockwise=False)
    cuts = list(passes([lead, nose], (10.0, 3.0), Rough(4.0, 1.0, 0.0, 0.0), "XZ"))
    assert [c.end for c in cuts[:4]] == [
        (6.0, 3.0), (6.0, pytest.approx(-2.0, abs=1e-12)), (7.0, pytest.approx(-1.0, abs=1e-12)), (7.0, 3.0),
    ]  # fmt: skip
