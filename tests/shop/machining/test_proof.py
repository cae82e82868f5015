"""What is said of a part that was cut by a program, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.shop.machining.proof import CutProof, InspectedCut


def test_the_worst_feature_is_that_of_the_largest_departure_of_either_sign() -> None:
    """4, -9 and 2 um: the bore is 9 um off, the mean of sizes is (4 + 9 + 2) / 3 = 5 um; 9 um meet 9 um, with a point that nothing reached no longer."""
    off, names = np.array([4e-3, -9e-3, 2e-3]), np.array(["face", "bore", "slot"])
    cut = InspectedCut(off, names, uncut=0)
    assert (cut.worst, cut.largest) == ("bore", 9e-3)
    assert cut.mean == pytest.approx(5e-3)
    assert CutProof(None, cut, limit=9e-3).is_met
    assert not CutProof(None, InspectedCut(off, names, uncut=1), limit=9e-3).is_met
