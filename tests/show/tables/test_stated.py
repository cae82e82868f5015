"""What U is, in words, which kind of interval is stated, and an end that is known to worse than 3 % of the length."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from tests.show.tables.test_uncertainty import result
from vcmm.answer.evaluation.interval import Linear
from vcmm.answer.evaluation.result import TrueValue
from vcmm.answer.evaluation.truth import Additive
from vcmm.show.tables.stated import how_well_known, kind_of_interval, meaning_of_U


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


def with_ends(low_u: float, high_u: float, high: float = 4e-3) -> Any:
    true = SimpleNamespace(interval=(0.0, high), interval_u=(low_u, high_u))
    return SimpleNamespace(name="roundness", unit="mm", true_value=true)


def test_only_what_matters_is_said() -> None:
    """3 % of 4 um is 0.12 um."""
    assert how_well_known([with_ends(0.0, 0.119e-3)]) == []
    (said,) = how_well_known([with_ends(0.0, 0.25e-3)])
    assert said.startswith(
        "roundness: the ends of the interval rest on drawn parts and have standard uncertainties of 0 um (lower) and 0.25 um (upper)"
    )
    assert "more than 3% of its length of 4 um" in said
    assert how_well_known([with_ends(0.0, 1.0, float("inf"))]) == []
    assert how_well_known([SimpleNamespace(name="size", unit="mm", true_value=None)]) == []  # type: ignore[list-item]
