"""The document of a loop, from results made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from vcmm.show.tables.loops import _held_out


def test_squares_are_in_square_micrometres():
    """4e-6 mm^2 is (2e-3 mm)^2 = (2 um)^2 = 4 um^2; 0.003 mm is 3 um."""
    proof = SimpleNamespace(
        holds=True,
        evidence=2.5,
        threshold=3.5,
        gain=1.5,
        visible_square=4e-6,
        rigid_square=9e-6,
        largest=3e-3,
    )
    found = _held_out(cast(Any, proof))
    assert found is not None
    assert {k: round(float(v), 9) for k, v in found.items()} == {
        "holds": 1.0, "evidence_nats": 2.5, "threshold_nats": 3.5, "held_out_nats": 1.5, "seen_um2": 4.0, "unseen_um2": 9.0,
        "largest_unseen_um": 3.0,
    }  # fmt: skip
    assert _held_out(None) is None
