"""Coarse maps of the cut surface: what these tests look at are single points, not pictures."""

from __future__ import annotations

import pytest

from vcmm.shop.machining import job as cutting


@pytest.fixture(autouse=True)
def coarse_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    """11 points across a feature instead of 41, a fourteenth of the points; tests/shop/machining/test_job.py asks for 41."""
    monkeypatch.setattr(cutting, "MOST_ACROSS", 11)
