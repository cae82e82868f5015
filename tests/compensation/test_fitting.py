"""Chords and arcs through corrected points, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.compensation.test_contours import move
from vcmm.compensation.contours import points
from vcmm.compensation.fitting import arcs, chords, fitted_arc

ACROSS = np.broadcast_to(np.diag([0.0, 1.0, 1.0]), (101, 3, 3))


def test_as_few_chords_as_the_bow_allows() -> None:
    """y = 8e-4 t (1 - t) mm leaves 0.2 um in one chord, a quarter of it in each of two."""
    share = np.linspace(0.0, 1.0, 101)
    wanted = np.stack([100 * share, 8e-4 * share * (1 - share), 0 * share], axis=1)
    m = move("G1 X110.")
    assert [p.share for p in chords(m, share, wanted, ACROSS, 2.1e-4, True).pieces] == [1.0]
    assert chords(m, share, wanted, ACROSS, 2.1e-4, True).residual == pytest.approx(2e-4)
    two = chords(m, share, wanted, ACROSS, 5.1e-5, True)
    assert [p.share for p in two.pieces] == pytest.approx([0.5, 1.0])
    assert two.residual == pytest.approx(5e-5)
    assert len(chords(m, share, wanted, ACROSS, 1e-6, False).pieces) == 1  # may not be split


def test_what_lies_along_the_path_makes_no_chord() -> None:
    share = np.linspace(0.0, 1.0, 101)
    wanted = np.stack([100 * share + 0.01 * share**2, 0 * share, 0 * share], axis=1)
    assert chords(move("G1 X110."), share, wanted, ACROSS, 1e-9, True).residual == pytest.approx(
        0.0, abs=1e-12
    )


def test_a_shifted_and_larger_arc_is_found() -> None:
    """Points of a quarter of R 10.01 about (0.02, 0.03): one arc, its centre there, nothing left."""
    m = move("G3 X0 Y10. I-10. J0")
    wanted = points(m, np.linspace(0.0, 1.0, 97)) * [1.001, 1.001, 1.0] + [0.02, 0.03, 0.0]
    fit = arcs(m, wanted, 1e-4, 48)
    (piece,) = fit.pieces
    assert piece.centre == pytest.approx([0.02, 0.03, 0.0], abs=1e-9)
    assert fit.residual < 1e-9


def test_the_centre_lies_on_the_bisector_of_the_ends() -> None:
    m = move("G3 X0 Y10. I-10. J0")
    wanted = points(m, np.linspace(0.0, 1.0, 49)) + [0.02, 0.0, 0.0]
    centre, left = fitted_arc(m, wanted, math.pi / 2, 0.0, 1.0)
    assert centre == pytest.approx([0.02, 0.0, 0.0], abs=1e-9)
    assert left < 1e-12
