"""Bands of colour."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from tests.report.drawn import NAN
from vcmm.report import svg
from vcmm.report.axes import tick_text
from vcmm.report.colormap import bands, colour_legend, legend_width, ramp
from vcmm.report.text import text_width


def test_bands_are_round_and_hold_the_data() -> None:
    found = bands([0.0, 7.9], count=8)
    assert found.levels.tolist() == [0, 1, 2, 3, 4, 5, 6, 7, 8]
    assert found.index([0.0, 3.0, 7.9, 8.0, NAN]).tolist() == [0, 3, 7, 7, -1]
    both = bands([-1.0, 4.0], symmetric=True)
    assert both.levels.tolist() == [-4, -3, -2, -1, 0, 1, 2, 3, 4]
    assert bands([5.0, 5.0]).index([5.0])[0] >= 0
    assert bands([NAN]).levels.tolist() == [0, 1]


def test_ramps_are_monotone_in_lightness() -> None:
    def light(colour: str) -> float:
        return float(np.dot([int(colour[k : k + 2], 16) for k in (1, 3, 5)], [0.2126, 0.7152, 0.0722]))

    sequential = [light(c) for c in ramp(9)]
    assert sequential == sorted(sequential)
    diverging = [light(c) for c in ramp(8, diverging=True)]
    assert diverging[:4] == sorted(diverging[:4])
    assert diverging[4:] == sorted(diverging[4:], reverse=True)


@pytest.mark.parametrize("height", [60.0, 600.0])
def test_labels_of_a_legend_stand_beside_their_boundary_and_not_on_one_another(height: float) -> None:
    scale = bands(np.linspace(-5.0, 5.0, 50))
    legend = ET.fromstring(f"<svg>{colour_legend(scale, 'um', 10.0, 20.0, 20.0 + height)}</svg>")
    labels = sorted((float(t.get("y") or NAN), t.text) for t in legend.iter("text"))[1:]  # without the unit
    apart = np.diff([y for y, _ in labels])
    assert len(labels) > 1
    assert (apart >= svg.SIZE).all()
    assert labels[-1] == (pytest.approx(20.0 + height + 4.3), tick_text(scale.levels)[0])


def test_a_legend_has_room_for_its_labels() -> None:
    scale = bands(np.linspace(-5.0, 5.0, 50))
    legend = ET.fromstring(f"<svg>{colour_legend(scale, 'um', 10.0, 20.0, 220.0)}</svg>")
    ends = [float(t.get("x") or NAN) + text_width(t.text or "", svg.SIZE) for t in legend.iter("text")]
    assert max(ends) <= 10.0 + legend_width(scale, "um") <= max(ends) + 10.0
