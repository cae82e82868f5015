"""Ticks of an axis."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from vcmm.report import svg
from vcmm.report.axes import Area, Scale, fitting_ticks, nice_ticks, tick_text, x_axis
from vcmm.report.text import text_width


def test_ticks() -> None:
    assert nice_ticks(0.0, 10.0, 5).tolist() == [0, 2, 4, 6, 8, 10]
    assert nice_ticks(-0.31, 0.29, 6) == pytest.approx([-0.3, -0.2, -0.1, 0, 0.1, 0.2])
    assert tick_text([-0.5, 0.0, 0.5]) == ["−0.5", "0", "0.5"]
    assert tick_text([30.0, 30.005, 30.01]) == ["30.000", "30.005", "30.010"]
    assert Scale(10, 20, 100, 300)(15) == 200


def test_the_labels_at_the_ends_of_an_axis_stay_in_the_picture_and_the_others_at_their_tick() -> None:
    width, scale = 300.0, Scale(0.0, 100_000.0, 4.0, 296.0)
    drawn = ET.fromstring(f"<svg>{x_axis(Area(4.0, 10.0, 296.0, 90.0), scale, 'x in mm', width)}</svg>")
    *labels, name = drawn.iter("text")
    assert name.text == "x in mm"
    ticks = fitting_ticks(scale)
    for tick, words, label in zip(ticks, tick_text(ticks), labels, strict=True):
        half, at = text_width(words, svg.SIZE) / 2, float(label.get("x") or "nan")
        assert label.text == words
        assert at == pytest.approx(min(max(scale(float(tick)), half), width - half), abs=0.01)
    assert float(labels[0].get("x") or "nan") > 4.0
