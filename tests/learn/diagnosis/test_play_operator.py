"""A trace there and back with the operator of play, and a protractor whose scale is off: data by numpy alone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vcmm.face.cli import run

MACHINE = """vcmm = "machine/1"
structure = "w b A t"
[axes.A]
travel = ["-60 deg", "60 deg"]
[repeatability]
law = "normal"
u = "1 um"
"""
RECORDING = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "angle"
observed = "actual - commanded"
history = "none"
[nuisance]
zero = ""
[noise]
law = "normal"
u = "5 urad"
"""


def there_and_back(folder: Path, deg: float, error) -> Path:
    """150 rows up and 150 down over +-deg; error(q, sense, since) in urad and 5 urad of noise."""
    up = np.linspace(-deg, deg, 151)[1:]
    q = np.deg2rad(np.concatenate([up, up[::-1][1:]]))
    sense = np.r_[np.ones(150), -np.ones(149)]
    since = np.r_[np.abs(q[:150] - q[0]), np.abs(q[150:] - q[149])]
    d = error(q, sense, since) + np.random.default_rng(6).normal(0, 5, len(q))
    rows = [
        f"{np.rad2deg(a):.7f},{s:g},{w:.9f},1,0,0,{v:.3f},{k}"
        for k, (a, s, w, v) in enumerate(zip(q, sense, since, d))
    ]
    (folder / "data.csv").write_text(
        "\n".join(["A_deg,sense_A,since_reversal_A_rad,nx,ny,nz,d_urad,time_s", *rows]) + "\n"
    )
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(RECORDING)
    return folder / "recording.toml"


def answer(path: Path, capsys: pytest.CaptureFixture[str]) -> dict:
    assert run(["diagnose", str(path), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.thorough
def test_a_slide_that_comes_over_on_the_way(tmp_path, capsys):
    def error(q, sense, since):
        """The operator of play by its definition, row by row: p follows q within +-150 urad."""
        p, out, r = q[0] - 150e-6, [], 150e-6
        for x in q:
            p = max(x - r, min(x + r, p))
            out.append((p - x) * 1e6)
        return np.array(out)

    found = answer(there_and_back(tmp_path, 0.2, error), capsys)
    (play,) = [a for a in found["answer"] if not a["doubtful"]]
    assert play["effect"] == "backlash"
    assert play["parameters"]["gap"]["value"] == pytest.approx(300.0, rel=0.05)
    assert play["parameters"]["distance"]["value"] == pytest.approx(300e-6, rel=0.15)
    assert found["fit"]["rms_after_um"] < 1.15 * 5.0


@pytest.mark.thorough
def test_a_scale_of_an_axis_that_turns_is_found_however_large(tmp_path, capsys):
    # 2 mrad/rad over +-40 deg, far more than the 320 um/m that were looked for, and a play of 800 urad
    found = answer(there_and_back(tmp_path, 40.0, lambda q, sense, since: 2e3 * q - 400.0 * sense), capsys)
    named = {a["effect"]: a for a in found["answer"] if not a["doubtful"]}
    assert named["scale_factor"]["parameters"]["k"]["value"] == pytest.approx(2e3, rel=0.01)
    assert found["fit"]["rms_after_um"] < 1.15 * 5.0
