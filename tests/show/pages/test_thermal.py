"""The page of a thermal model: curves over time are the readings and the temperatures of the recording."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path

import numpy as np
import pytest

from vcmm.face.cli import run
from vcmm.files.own.library import example


@pytest.mark.thorough
def test_curves_over_time_are_those_of_the_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = example("traced_cmm").parent / "traced_cmm"
    page = tmp_path / "thermal.html"
    words = ["calibrate", "thermal", str(folder / "warm_up.toml"), "--machine", str(folder / "machine.toml")]
    assert run([*words, "--report", str(page), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    charts = [
        json.loads(html.unescape(data)) for data in re.findall(r'data-chart="([^"]*)"', page.read_text())
    ]
    warm, drift = charts
    assert [s["name"] for s in warm["series"]] == ["air", "bridge"]
    rows = np.genfromtxt(folder / "warm_up.csv", delimiter=",", names=True)
    at = (rows["time_s"] - rows["time_s"][0]) / 60.0
    for one in warm["series"]:
        low, high = document["trained_degC"][one["name"]]
        assert min(one["y"]) == pytest.approx(low, abs=1e-3)
        assert max(one["y"]) == pytest.approx(high, abs=1e-3)
    before, after = drift["series"]
    assert np.allclose(before["x"], at)
    assert np.sqrt(np.mean(np.square(before["y"]))) == pytest.approx(document["rms_before_um"], rel=1e-6)
    assert np.sqrt(np.mean(np.square(after["y"]))) == pytest.approx(document["rms_after_um"], rel=1e-6)
