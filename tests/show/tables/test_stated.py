"""What U is, in words, and which kind of interval is stated."""

from __future__ import annotations

from tests.show.tables.test_uncertainty import result
from vcmm.answer.evaluation.interval import Linear
from vcmm.answer.evaluation.result import TrueValue
from vcmm.answer.evaluation.truth import Additive
from vcmm.show.tables.stated import kind_of_interval, meaning_of_U


def test_every_kind_of_U_is_said():
    """[0, 1.78] µm beside U = 1.28 µm is no symmetric interval, and 1.28 not half of it."""
    plain = result(name="bore")
    biased = result(name="length", truth=Additive(Linear(0.0, ()), 0.0, bias=-1e-3))
    form = result(
        name="form", one_sided=True, interval=(0.0, 1.78e-3), half_width=1.28e-3,
        true_value=TrueValue(1e-3, (0.0, 1.78e-3), True),
    )  # fmt: skip
    assert meaning_of_U([plain]) == "U: half the symmetric coverage interval for p = 95%"
    said = meaning_of_U([plain, biased, form])
    assert "of length, k u + |bias|" in said
    assert "of form, half of what the machine adds" in said
    assert [kind_of_interval(c) for c in (plain, biased, form)] == ["symmetric", "symmetric", "upper"]
    above = result(one_sided=True, interval=(0.4e-3, 1.78e-3))
    assert kind_of_interval(above) == "symmetric"
