"""The first part of the demo, in words: the figures of the evaluation, and the main contributor by name."""

from __future__ import annotations

import pytest

from vcmm.face import api
from vcmm.face.cli.demo import first_blocks, first_lines
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario


@pytest.mark.thorough
def test_the_words_are_those_of_the_evaluation() -> None:
    """U of the ring gauge: twice the root of the sum of squares of its budget, 0.197, 0.150, 0.100, 0.058, 0.02 um."""
    scenario = load_scenario(example("ring_gauge"))
    result = api.uncertainty(scenario)
    (c,) = result.characteristics
    what, _, said = first_lines(scenario, c)
    assert what == "Ring gauge 50 mm: 16 points on a measuring machine, measured virtually."
    # sqrt(0.197^2 + 0.150^2 + 0.100^2 + 0.058^2 + 0.02^2) = 0.274; 1.96 x 0.274 = 0.54 um; 0.197^2 / 0.274^2 = 51 %
    first, second = said.replace("\u00a0", " ").splitlines()
    assert (
        first
        == "diameter: 50.00000 mm ± 0.54 µm (k = 1.96, p = 95 %); limits 49.996 … 50.004 mm: conforms, > 99.9 %"
    )
    assert second.startswith(
        "    mostly qualification of stylus down, repeatability, 51 % of u²; to improve: qualify stylus down"
    )
    blocks = first_blocks(scenario, result)
    assert sum("data-scene" in b for b in blocks) == 1
    assert "ISO 14253-1" in "".join(blocks)
