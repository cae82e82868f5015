"""Thermal logs of Klipper kind."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import data_file
from tests.recordings.convert import gantry_heating
from vcmm.core.errors import DataError
from vcmm.files.foreign.klipper import read_klipper
from vcmm.files.own.recording import load_recording

MACHINE = """vcmm = "machine/1"
structure = "w Y' b Z X t"
[axes.X]
travel = ["-1 mm", "350 mm"]
[axes.Y]
travel = ["-1 mm", "350 mm"]
[axes.Z]
travel = ["-1 mm", "340 mm"]
[repeatability]
u = "2 um"
"""
LOG = """# step_dist=0.0025
sample,time,mcu_pos_z,frame_t,bed_t,bed_target
0,2021/06/13-05:42:16,-1000,21.9,23.4,105
0,2021/06/13-05:42:20,-996,22.0,26.0,105
1,2021/06/13-05:43:16,-980,22.4,60.0,105
1,2021/06/13-05:43:20,90000,22.4,60.0,105
"""


def test_a_log_by_hand(tmp_path):
    (tmp_path / "log.csv").write_text(LOG)
    found = read_klipper(tmp_path / "log.csv")
    # median of -1000, -996, -980 and 90000 is -988: -12, -8 and +8 steps of 2.5 um; the last row is no homing
    assert found.height * 1e3 == pytest.approx([-30.0, -20.0, 20.0])
    assert found.time.tolist() == [0.0, 4.0, 60.0]
    assert found.temperatures["temp_bed_C"].tolist() == [23.4, 26.0, 60.0]
    assert sorted(found.temperatures) == ["temp_bed_C", "temp_frame_C"]
    assert found.lines.tolist() == [3, 4, 5]
    assert read_klipper(tmp_path / "log.csv", 0.0125).height[0] * 1e3 == pytest.approx(-150.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (LOG.replace("# step_dist=0.0025\n", ""), "the length of a step is not stated"),
        (LOG.replace("mcu_pos_z", "z"), "time and one of mcu_pos_x"),
        (LOG.replace("frame_t", "frame"), 'unknown column "frame"'),
        (LOG.replace("2021/06/13-05:43:16", "later"), 'log.csv:5: "later" is no time'),
    ],
)
def test_mistakes(tmp_path, text, words):
    (tmp_path / "log.csv").write_text(text)
    with pytest.raises(DataError, match=words):
        read_klipper(tmp_path / "log.csv")


def test_the_published_run_is_read_as_it_was_converted(tmp_path):
    source = data_file("data/recordings/klipper_frame_thermal/run1_2021-06-13_05-41-53.csv")
    known, _ = load_recording(gantry_heating(source, tmp_path / "known"))
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / "log.csv").write_text(source.read_text())
    (tmp_path / "recording.toml").write_text(
        'vcmm = "recording/1"\ndata = "log.csv"\nmachine = "machine.toml"\nkind = "displacement"\nformat = "klipper"\n'
        'history = "none"\n[counter]\nstep = "0.0025 mm"\n[nuisance]\nzero = ""\n'
    )
    found, _ = load_recording(tmp_path / "recording.toml")
    assert found.m == known.m == 1203
    assert np.ptp(found.value - known.value) < 1e-4  # another zero, and one decimal of a um
    assert found.run.column("temp_bed_C") == pytest.approx(known.run.column("temp_bed_C"))
    assert found.run.column("time_s") == pytest.approx(known.run.column("time_s"))
