"""By how much part and work offsets move where a program is placed."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from vcmm.face.cli.place_cut import shift_of


def test_the_shift_leads_from_the_present_pose_to_the_best():
    """From (100, 50, 0) to (130, 40, 5) mm: +30, -10, +5; the angles of the pose are no shift."""
    present = SimpleNamespace(pose=np.array([100.0, 50.0, 0.0, 0.0, 0.0, 0.0]))
    best = SimpleNamespace(pose=np.array([130.0, 40.0, 5.0, 0.0, 0.0, 0.1]))
    placed = SimpleNamespace(best=best, present=present)
    assert shift_of(placed).tolist() == [30.0, -10.0, 5.0]  # type: ignore[arg-type]
