"""Long recordings: a twin at another place takes the shape that was found in the rows that were searched."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace as Stub

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, whitener
from vcmm.learn.diagnosis import answers
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.evidence import dictionary


def _white(rows: int) -> Whitener:
    return whitener(np.ones(rows), np.zeros((rows, 0)), np.zeros((rows, 0)))


def test_a_twin_of_a_long_recording_is_looked_up_in_the_searched_rows(monkeypatch):
    rising, falling = (
        Option(None, np.array([v]).T, np.ones(1), ("k",), 0.0) for v in ([0.0, 1, 2, 3], [9.0, 1, 1, 1])
    )
    families = [Family("one", {"axis": "X"}, (falling,)), Family("two", {"axis": "Y"}, (falling, rising))]
    found = dictionary(families, _white(4))
    searched = Stub(
        stage=Stub(candidates=found),
        selection=Stub(signal=lambda i: found.columns(2)[:, 0], terms=[Stub(width=1.0)]),
    )
    named = Stub(
        in_searched_rows=searched,
        stage=Stub(
            candidates=replace(
                dictionary((), _white(9)), families=found.families, options=found.options, first=found.first
            )
        ),
        problem=None,
    )
    monkeypatch.setattr(answers, "rebuild_option", lambda option, problem: option)
    term = answers._twin_term(named, Stub(terms=[]), 0, 0, 1)
    assert term.family is found.families[1]
    assert term.option is found.options[2]  # the rising one, of the two shapes of that place
