"""The first part of the demo, in words: the figures of the evaluation, and the owners of U by name."""

from __future__ import annotations

from vcmm.face import api
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.show.pages.first import first_blocks, sentences


def test_the_words_are_those_of_the_evaluation() -> None:
    """U of the ring gauge: twice the root of the sum of squares of its budget, 0.197, 0.150, 0.100, 0.058, 0.02 um."""
    scenario = load_scenario(example("ring_gauge"))
    result = api.uncertainty(scenario, trials=2000)
    (c,) = result.characteristics
    said = sentences(scenario, c)
    assert said[0].startswith(
        "Ring gauge 50 mm, 16 touches on a measuring machine: diameter = 50.00000 mm, U = 0.5"
    )
    assert said[1] == "Limits 49.996 to 50.004 mm: conforms (ISO 14253-1, probability 95 %)."
    assert said[2].startswith("Who owns U (shares of u²): 51% stylus qualification down")
    blocks = first_blocks(scenario, result)
    assert sum("data-scene" in b for b in blocks) == 1
    assert "ISO 14253-1" in "".join(blocks)
