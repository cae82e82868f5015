"""A folder of recordings: members of one family are one course."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.run import Run
from vcmm.files.learned.fleet import changes, family_size
from vcmm.learn.diagnosis.estimates import Estimate
from vcmm.learn.diagnosis.result import Answer
from vcmm.physics import BY_NAME

RUN = Run({"Y": np.array([15.0, 25.0, 55.0])}, np.zeros((3, 3)))


def size(value: float, u: float, unit: str = "um") -> Estimate:
    return Estimate(value, u, (value - 2 * u, value + 2 * u), unit)


def told(effect: str, value: float, u: float) -> dict:
    """An answer of a document, with the size of its family."""
    return {
        "effect": effect,
        "where": {"axis": "Y"},
        "family": "play",
        "doubtful": False,
        "alias_of": None,
        "parameters": {"gap" if effect == "backlash" else "g0": {"value": value, "u": u, "unit": "um"}},
        "family_size": {"value": value, "u": u, "unit": "um"},
    }


def test_the_size_of_a_play_that_grows_is_that_in_the_middle():
    # middle of 15 to 55 mm: 35 mm. 2 um + 10 um/m x 0.035 m = 2.35 um; u at most 0.1 + 4 x 0.035 = 0.24 um
    where = {"axis": "Y"}
    parameters = {"rms": size(1.2, 0.1), "g0": size(2.0, 0.1), "g1": size(10.0, 4.0, "um/m")}
    grows = Answer("lost_motion", where, parameters, 0.9, 1.0, (), 9.0, fitted=BY_NAME["lost_motion"]("Y"))
    found = family_size(grows, RUN)
    assert found is not None
    assert (found["value"], found["u"]) == pytest.approx((2.35, 0.24))
    constant = Answer(
        "backlash", where, {"gap": size(1.3, 0.02)}, 0.9, 1.0, (), 9.0, fitted=BY_NAME["backlash"]("Y")
    )
    assert family_size(constant, RUN) == {"value": 1.3, "u": 0.02, "unit": "um"}


def test_a_play_by_two_names_is_one_course():
    gaps = (("lost_motion", 2.24), ("lost_motion", 1.24), ("backlash", 1.13), ("backlash", 0.28))
    records = [
        {"file": f"{k}", "machine": "m", "date": "", "problem": None, "answer": [told(name, gap, 0.02)]}
        for k, (name, gap) in enumerate(gaps)
    ]
    (course,) = changes(records)
    assert (course.name, course.parameter, course.occurrences, course.recordings_total) == (
        "play Y",
        "size in the middle",
        4,
        4,
    )
    assert course.presence[0] == "always"
    assert course.change == pytest.approx(0.28 - 2.24)
    alone = changes(records[:2])  # one member alone keeps its own numbers
    assert [(c.name, c.parameter) for c in alone] == [("lost motion Y", "g0")]
