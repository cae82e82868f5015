"""An end that is known to worse than 3 % of the length says so."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from vcmm.show.tables.ends_known import how_well_known


def result(low_u: float, high_u: float, high: float = 4e-3) -> Any:
    true = SimpleNamespace(interval=(0.0, high), interval_u=(low_u, high_u))
    return SimpleNamespace(name="roundness", unit="mm", true_value=true)


def test_only_what_matters_is_said() -> None:
    """3 % of 4 um is 0.12 um."""
    assert how_well_known([result(0.0, 0.119e-3)]) == []
    (said,) = how_well_known([result(0.0, 0.25e-3)])
    assert said.startswith(
        "roundness: the ends of the interval rest on drawn parts and have standard uncertainties of 0 um (lower) and 0.25 um (upper)"
    )
    assert "more than 3% of its length of 4 um" in said
    assert how_well_known([result(0.0, 1.0, float("inf"))]) == []
    assert how_well_known([SimpleNamespace(name="size", unit="mm", true_value=None)]) == []  # type: ignore[list-item]
