"""The probing program of a calibration: what is said where it reads back beside its plan."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.program.test_probing_program import JOB
from vcmm.face.cli.calibrate_program import _read_back
from vcmm.program.probing_program import CONTROLS, probing_texts


@pytest.mark.parametrize("control", CONTROLS)
def test_a_program_beside_its_plan_says_by_how_much(control):
    """Against a plan whose first touch lies 0.02 mm beside in Y: 0.02 mm, though all other touches fit; against its own plan nothing."""
    texts = probing_texts(JOB, control)
    first, *others = JOB.touches
    beside = replace(first, surface=tuple(np.array(first.surface) + [0.0, 0.02, 0.0]))
    assert _read_back(replace(JOB, touches=(beside, *others)), texts, control) == pytest.approx(
        0.02, abs=1e-6
    )
    assert _read_back(JOB, texts, control) == pytest.approx(0.0, abs=1e-6)
