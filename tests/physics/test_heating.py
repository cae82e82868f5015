"""vcmm/physics/catalogue/heating.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run, Series
from vcmm.learn.diagnosis.scans import trials
from vcmm.physics.catalogue.heating import ScrewHeating

E1 = 0.632121  # 1 - 1/e


def _run(time: list[float], x: float = 0.0, log: Series | None = None, **columns: float) -> Run:
    n = len(time)
    more = {k: np.full(n, v) for k, v in columns.items()}
    position = {"X": np.full(n, x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(
        position, np.zeros((n, 3)), {"time_s": np.array(time), **more}, {}, {"air": log} if log else {}
    )


def test_screw_heating_grows_with_travel():
    # 50 um/m x 300 mm = 15 um when warm, less 5 um: 10 um x (1 - 1/e) after 100 m of travel
    effect = ScrewHeating("X", 50e-6, -5e-3, 1e5)
    error = machine(effect).tip_error(_run([0.0], 300.0, travel_X_mm=1e5))
    assert error[0] == pytest.approx([10e-3 * E1, 0, 0], abs=1e-8)
    assert effect.error_motion(_run([0.0], 300.0, travel_X_mm=0.0))[0, 0] == 0.0


def test_a_search_begins_near_every_screw():
    """From 3 m to 1 km the starts are 3, 10, 30 ... with the means between them, so the nearest is off by a factor (10 / 3)^(1/4) at most, 0.301 of
    a logarithm; d(1 - exp(-s/d)) / d ln d = -(s/d) exp(-s/d) is at most 1/e: 0.301 / e = 0.1107 of the warm screw is missed, nowhere more.
    """
    travel = np.geomspace(100.0, 1e7, 400)
    position = {"X": np.full(400, 1000.0), "Y": np.zeros(400), "Z": np.zeros(400)}
    run = Run(position, np.zeros((400, 3)), {"travel_X_mm": travel})

    def stretch(distance: float) -> np.ndarray:
        """1000 mm by 1 mm/m: 1 mm when warm."""
        return ScrewHeating("X", 1e-3, 0.0, distance).error_motion(run)[:, 0]

    starts = np.array([stretch(changes["distance"]) for changes, _ in trials(ScrewHeating("X", 1e-3), run)])
    missed = [np.abs(starts - stretch(d)).max(axis=1).min() for d in np.geomspace(3e3, 1e6, 300)]
    assert max(missed) < np.log(10 / 3) / 4 / np.e
