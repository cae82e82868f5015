"""The surface over all features: how densely, and what errors do to it."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.shop.machining import patches
from vcmm.shop.machining.preparation import set_up


def test_as_dense_as_a_picture_of_all_features_can_be(tmp_path, monkeypatch):
    """One cylinder: 41 across, so 81 angles by 20 heights; a fixture of this room asks for less elsewhere."""
    monkeypatch.setattr(patches, "MOST_ACROSS", 41)
    job = set_up(vcmm.load_cut(shop.write(tmp_path)))
    (one,) = patches.surface_map(job)
    assert one.height.shape == (81 * 20,)
    assert np.abs(one.height).max() < 1e-9
    assert one.nominal == pytest.approx(one.height, abs=1e-12)


def test_places_that_no_cutter_reaches_have_no_height(tmp_path):
    """The boss reaches down to -2 mm; drawn up to +4 mm, its upper part was never cut."""
    scenario = shop.SCENARIO.replace('point = "0 0 -8 mm"', 'point = "0 0 -30 mm"')
    job = set_up(vcmm.load_cut(shop.write(tmp_path, scenario=scenario)))
    (one,) = patches.surface_map(job)
    assert np.isnan(one.height).all()
