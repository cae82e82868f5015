"""vcmm/physics/catalogue/learned_residual.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Run
from vcmm.physics.catalogue.learned_residual import LearnedResidual


def _run(x: list[float], **columns: float) -> Run:
    n = len(x)
    position = {"X": np.array(x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(position, np.zeros((n, 3)), {k: np.full(n, v) for k, v in columns.items()})


def test_between_two_nodes_it_follows_the_kernel():
    # nodes 200 mm apart: length 400 mm; k(200) = exp(-0.125) = 0.8824969, k(100) = exp(-0.03125) = 0.9692332.
    # half way both weights are w with w (1 + 0.8824969) = 0.9692332: w = 0.5148658, so 2 um at one node give 1.0297316 um
    effect = LearnedResidual("EYX", nodes=np.array([0.0, 200.0]), values=np.array([2e-3, 0.0]))
    six = effect.error_motion(_run([0.0, 100.0, 200.0]))
    assert six[:, 1] == pytest.approx([2e-3, 1.0297316e-3, 0.0], abs=1e-10)
    assert np.all(np.delete(six, 1, axis=1) == 0.0)


def test_over_a_column_both_kernels_are_multiplied():
    # the same length rule over the levels: 18 and 22 degC, half way at 20 again w = 0.5148658, so 4 um at one value give 4 w w um
    effect = LearnedResidual(
        "EXX", "temp_air_C", np.array([0.0, 200.0]), "18 22", values=np.array([4e-3, 0.0, 0.0, 0.0])
    )
    six = effect.error_motion(_run([100.0], temp_air_C=20.0))
    assert six[0, 0] == pytest.approx(4e-3 * 0.5148658**2, abs=1e-9)


def test_what_was_not_seen_is_not_said():
    effect = LearnedResidual("EXX", nodes=np.array([0.0, 200.0]), values=np.array([1e-3, 1e-3]))
    with pytest.raises(ModelLimit, match="lies outside what it was learned from"):
        effect.error_motion(_run([201.0]))
