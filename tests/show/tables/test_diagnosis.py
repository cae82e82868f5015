"""The tables of a diagnosis, from an answer made by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

from vcmm.learn.diagnosis.estimates import Estimate
from vcmm.show.tables import diagnosis
from vcmm.show.tables.table import in_terminal, on_page


def answer(**changes):
    given = {
        "effect": "backlash", "where": {"axis": "Y"}, "parameters": {"gap": Estimate(1.5, 0.19, (1.12, 1.871), "um")},
        "probability": 0.976, "share": 0.77, "cannot_be_told_from": (), "fitted": None, "share_of_rows": 0.8, "kin": None,
        "mistake": None, "remark": None,
    }  # fmt: skip
    return SimpleNamespace(**{**given, **changes})


def test_answers_and_candidates_stand_apart():
    d = SimpleNamespace(
        found=(answer(),), candidates=(answer(effect="lag", where={}, cannot_be_told_from=("a", "b")),)
    )
    first, second = diagnosis.answers(d)
    assert in_terminal(first).rows == [
        ["backlash", "Y", "gap = 1.50 µm (95 %: 1.12 to 1.87)", "0.976", "77%", "80%", "–"]
    ]
    assert in_terminal(second).rows[0][1::5] == ["–", "a, b"]
    assert on_page(first).heads[0] == "effect"
    assert diagnosis.answers(SimpleNamespace(found=(), candidates=())) == []


def test_folds():
    """1.5 µm before, 0.5 µm after; nats of the rows left out."""
    held = SimpleNamespace(
        fold="pose 2", rms_before=1.5e-3, rms_after=5e-4, effect_energy_left=math.nan, gain=12.34
    )
    d = SimpleNamespace(
        angle=False,
        fit=SimpleNamespace(before=2e-3, after=1e-3, noise=9e-4, held_out=(held,), candidates=5e-4),
    )
    assert in_terminal(diagnosis.folds(d)).rows == [
        ["all rows, fitted", "2 µm", "1 µm", "noise 0.9 µm", "–"],
        ["with candidates too", "2 µm", "0.5 µm", "noise 0.9 µm", "–"],
        ["pose 2", "1.5 µm", "0.5 µm", "–", "+12.3 nats"],
    ]


def test_next_steps_places_and_what_is_seen():
    d = SimpleNamespace(
        angle=True,
        next_measurement=(
            SimpleNamespace(separates=("a", "b"), do="turn it", minutes=4.25, expected_probability=None),
        ),
        location=(SimpleNamespace(covariate="X", direction="z", p=0.0123, text="low end"),),
        detectable=(SimpleNamespace(effect="lag", where={}, amplitude=2e-6),),
    )
    assert in_terminal(diagnosis.next_steps(d)).rows == [["a, b", "turn it", "–", "4.2"]]
    assert in_terminal(diagnosis.places(d)).rows == [["X", "z", "0.012", "low end"]]
    assert in_terminal(diagnosis.detectable_table(d)).rows == [["lag", "–", "2 µrad"]]
