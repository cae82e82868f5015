"""The CMM that `vcmm new traced_cmm` copies: its files, and that they find what was concealed in it."""

from __future__ import annotations

import numpy as np
import pytest
from vcmm_twins.traced_cmm import recorded as traced_cmm

import vcmm
from vcmm.files.own.library import companions, example, folder
from vcmm.learn.calibration.job import calibrate
from vcmm.learn.calibration.thermal import thermal_model
from vcmm.learn.calibration.verification import put_to_test


def test_the_files_of_the_example_are_what_the_case_makes():
    made = traced_cmm.texts()
    for name, text in made.items():
        stored = (folder() / "traced_cmm" / name).read_text(encoding="utf-8")
        assert stored.splitlines()[0] == text.splitlines()[0]
        assert numbers(stored) == pytest.approx(numbers(text), abs=1e-6)
    tables = {f"traced_cmm/{n}.toml" for n in ("machine", "diagonal", "warm_up")}
    assert set(companions("traced_cmm")) == tables | {f"traced_cmm/{n}" for n in made}


def numbers(text: str) -> np.ndarray:
    return np.array([[float(v) for v in row.split(",")] for row in text.splitlines()[1:]])


@pytest.mark.thorough
def test_its_curves_lie_within_their_bands():
    """All 21 errors; the curves at their nodes without mean or line, 18 of them, hold the truth at 95 % of the nodes."""
    recording, bare = vcmm.load_recording(example("traced_cmm"))
    found = calibrate([recording], bare)
    assert len(found.identified.names) == 21
    inside = []
    for curve in found.kept_model.curves:
        nodes, value, u = found.band(curve.component)
        true = next(e for e in traced_cmm.truth().effects if e.where == curve.component)
        at = curve.projector @ np.interp(nodes, true.grids[0], true.values)
        inside.append((np.abs(value - at) < 1.96 * u).mean())
        q, fine, _ = found.along(curve.component)
        assert np.interp(nodes, q, fine) == pytest.approx(value, abs=1e-12)
    assert np.mean(inside) >= 0.85
    diagonal, _ = vcmm.load_recording(folder() / "traced_cmm" / "diagonal.toml")
    after = bare.with_effect(*found.kept_model.effects(found.theta))
    assert put_to_test(diagonal, bare, after).gain > 0.9


def test_the_bridge_pushes_the_tip():
    """1.8 um/K behind 2600 s."""
    recording, bare = vcmm.load_recording(folder() / "traced_cmm" / "warm_up.toml")
    model = thermal_model([recording], bare)
    u = np.sqrt(np.diag(model.covariance))
    assert [t.where for t in model.terms] == [("z", "bridge")]
    assert abs(model.amounts[0] - traced_cmm.BEND) < 3 * u[0]
    assert abs(model.lags[0] - traced_cmm.LAG) < 3 * u[1]
