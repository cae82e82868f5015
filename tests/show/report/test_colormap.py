"""Bands of colour."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.show.report.drawn import NAN
from vcmm.show.report.colormap import bands, legend, nice_step, ramp
from vcmm.show.report.text import as_written


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


def test_a_legend_labels_what_has_room_and_both_ends():
    scale = bands(np.linspace(-5.0, 5.0, 50))
    words = [re.findall(r"<span>(.*?)</span>", legend(scale, "µm", tall)) for tall in (600.0, 60.0)]
    assert words[0] == [as_written(v) for v in scale.levels]
    assert len(words[1]) <= 60 / 16 + 1
    assert (words[1][0], words[1][-1]) == (as_written(scale.levels[0]), as_written(scale.levels[-1]))
    assert [c for c in scale.colours if c not in legend(scale, "µm", 60.0)] == []
    assert "none" in legend(scale, "µm", 60.0, missing=True)


def test_steps_are_1_2_5():
    assert [nice_step(span, 5) for span in (10.0, 4.0, 30.0, 0.6)] == pytest.approx([2.0, 1.0, 5.0, 0.1])
