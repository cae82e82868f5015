"""A feed-forward net as the alternative to thermal terms: sensors at fixed lags in, the drift out. Compared, not written.

Inputs are mapped to the range of the recordings that it learns from; beyond it logistic neurons stay where they are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.net import BEST_LAYOUT, train_net
from vcmm.learn.calibration.result import rms
from vcmm.learn.calibration.solve import nuisance_basis
from vcmm.learn.calibration.thermal_terms import WarmReadings, warm_readings
from vcmm.task.response.recording import Recording

LAGS = (0.0, 300.0, 2400.0)  # s
EPOCHS, MEMBERS = 1000, 5


def inputs(part: WarmReadings, sensors: Sequence[str]) -> Array:
    """Return (m, 3 per sensor) temperatures behind the lags, degC."""
    run = part.observer.run
    columns = [run.lag(s, tau)[part.recording.row] for s in sensors for tau in LAGS]
    return np.stack(columns, axis=1)


def net_left(
    learnt: Sequence[Recording], predicted: Recording, machine: Machine, sensors: Sequence[str]
) -> float:
    """Return the rms (mm) of another recording under the mean of an ensemble, whose nuisance is fitted to it."""
    parts = [warm_readings(r, machine) for r in learnt]
    x = np.concatenate([inputs(p, sensors)[p.weight > 0] for p in parts])
    y = np.concatenate([(p.value - np.median(p.value))[p.weight > 0] for p in parts])
    other = warm_readings(predicted, machine)
    rng = np.random.default_rng(0)
    nets = [train_net(x, y[:, None], BEST_LAYOUT, rng, EPOCHS) for _ in range(MEMBERS)]
    prediction = np.mean([net.at(inputs(other, sensors))[:, 0] for net in nets], axis=0)
    basis = nuisance_basis(other.nuisance)
    left = other.value - prediction
    return rms((left - basis @ (basis.T @ left))[other.weight > 0])
