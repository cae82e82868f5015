"""Sweeps displaced by errors, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit
from vcmm.shop.cutting.displacement import displace, split_by_direction
from vcmm.shop.cutting.envelope import surface_left
from vcmm.shop.cutting.sweeps import UP, arcs, lines, position
from vcmm.shop.cutting.tools import flat


def test_displaced_lines_and_arcs_by_hand() -> None:
    """A constant displacement moves everything; one that grows with the angle leaves an arc an arc plus a drift."""
    circle = arcs([[20, 0, 0]], [[20, 0, 0]], [[0, 0, 0]], 2 * np.pi, (flat(5.0),))
    moved = displace(circle, lambda x, row, t: np.tile([0.01, 0.0, 0.0], (len(x), 1)))
    assert len(moved) == 1
    out = np.array([[1.0, 0, 0]])
    assert surface_left(25 * out + [0, 0, 1], -out, moved).s[0] == pytest.approx(-0.01, abs=1e-12)
    grows = displace(circle, lambda x, row, t: np.outer(t, [0.0, 0.0, 0.01]))
    assert len(grows) == 1
    assert position(grows, np.array([0.5]))[0] == pytest.approx([-20, 0, 0.005], abs=1e-12)
    wavy = displace(lines([[0, 0, 0]], [[40, 0, 0]], (flat(5.0),)), lambda x, r, t: 0.01 * np.sin(x / 5.0))
    assert 20 < len(wavy) < 60  # chord A L^2 k^2 / 8 = 5e-5: L = sqrt(8 x 5e-5 x 25 / 0.01) = 1 mm, 40 pieces
    with pytest.raises(ModelLimit, match="pieces"):
        displace(wavy, lambda x, r, t: 1.0 * (x > 13.0))


def test_what_tilts_is_refused_or_cut_into_indexed_pieces() -> None:
    line = lines([[0, 0, 0]], [[40, 0, 0]], (flat(5.0),))
    from dataclasses import replace

    tilting = replace(line, axis_end=np.array([[0.0, math.sin(0.01), math.cos(0.01)]]))
    with pytest.raises(ModelLimit, match="split_by_direction"):
        surface_left(np.zeros((1, 3)), UP, tilting)
    parts = split_by_direction(tilting, 0.005)  # 0.01 rad x hypot(5, 10) / (2 x 0.005) = 11.18: 12 pieces
    assert len(parts) == 12
    assert parts.axis[0] @ line.axis[0] == pytest.approx(math.cos(0.01 / 24), abs=1e-12)
