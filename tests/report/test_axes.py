"""Ticks of an axis."""

from __future__ import annotations

import pytest

from vcmm.report.axes import Scale, nice_ticks, tick_text


def test_ticks() -> None:
    assert nice_ticks(0.0, 10.0, 5).tolist() == [0, 2, 4, 6, 8, 10]
    assert nice_ticks(-0.31, 0.29, 6) == pytest.approx([-0.3, -0.2, -0.1, 0, 0.1, 0.2])
    assert tick_text([-0.5, 0.0, 0.5]) == ["−0.5", "0", "0.5"]
    assert tick_text([30.0, 30.005, 30.01]) == ["30.000", "30.005", "30.010"]
    assert Scale(10, 20, 100, 300)(15) == 200
