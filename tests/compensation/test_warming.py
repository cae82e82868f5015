"""Temperatures that change while the program runs: the set-up's log, in `compensate` and in `cut`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vcmm.compensation.job import compensate
from vcmm.core.errors import DataError, ModelLimit
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run, Series
from vcmm.files.own.setup import load_setup
from vcmm.physics.structure.thermal import ThermalDrift
from vcmm.program.setup import TemperatureLog
from vcmm.shop.machining.warming import add_temperatures, warmed_when_set

SETUP = """
vcmm = "setup/1"
dialect = "fanuc"
[control]
compensation = []
[offsets]
G54 = "0 0 0 mm"
[tools.1]
length = "0 mm"
diameter = "10 mm"
[temperature_log]
data = "log.csv"
"""


def written(folder, log, more=""):
    (folder / "log.csv").write_text(log)
    (folder / "setup.toml").write_text(SETUP + more)
    (folder / "part.nc").write_text("%\nG21 G90 G54\nT1 M6\nG0 X0 Y0 Z0\nG1 X100. F100\nX0.\nM30\n%\n")
    return load_setup(folder / "setup.toml")


def mill():
    axes = {a: Axis(a, (-500.0, 500.0)) for a in "XYZ"}
    drift = ThermalDrift("z", "spindle", 1e-3)  # 1 um/K
    return Machine("mill", "machine-tool", parse_structure("w X' Y' b Z t"), axes, (drift,))


def test_every_block_is_corrected_for_its_own_time(tmp_path):
    """100 mm at 100 mm/min end after about 60 s, the way back after 120: 5 K and 10 K at 10 K in two minutes, 1 um/K."""
    setup = written(tmp_path, "time_s,temp_spindle_C\n0,20\n120,30\n300,45\n")
    found = compensate(tmp_path / "part.nc", setup, mill(), tolerance=1e-3)
    assert "G1 X100. Z-0.005 F100" in found.text
    assert "X0. Z-0.010" in found.text
    assert found.is_met
    # set five minutes before, at 15 degC: 5 um more at every place
    earlier = replace(
        setup,
        log=replace(
            setup.log,
            zero_set=-300.0,
            sensors={"spindle": Series(np.array([-300.0, 0.0, 120.0]), np.array([15.0, 20.0, 30.0]))},
        ),
    )
    assert (
        "Z-0.010"
        in compensate(tmp_path / "part.nc", earlier, mill(), tolerance=1e-3).text.split("X100.")[1][:8]
    )


def test_rows_have_the_temperature_of_their_time_and_zeros_that_of_theirs():
    log = TemperatureLog({"bed": Series(np.array([-60.0, 0.0, 100.0]), np.array([18.0, 20.0, 30.0]))}, -60.0)
    run = Run({"X": np.zeros(2)}, np.zeros((2, 3)), {"time_s": np.array([50.0, 100.0])})
    assert add_temperatures(run, log).column("temp_bed_C").tolist() == [25.0, 30.0]
    assert warmed_when_set(run, log).column("temp_bed_C").tolist() == [18.0, 18.0]
    assert add_temperatures(run, None) is run
    with pytest.raises(ModelLimit, match="ends at 100 s, the program runs to 201 s"):
        add_temperatures(run.with_columns({"time_s": np.array([50.0, 201.0])}), log)


@pytest.mark.parametrize(
    ("log", "more", "said"),
    [
        ("time_s,temp_spindle_C\n10,20\n120,30\n", "", "begins at 10 s, but the program begins at 0 s"),
        ("time_s,temp_spindle_C\n0,20\n120,30\n", 'zero_set = "-90 min"\n', "the zeros were set at -5400 s"),
        ("time_s,spindle_rpm\n0,20\n", "", "logs no temperature"),
        ("time_s,temp_spindle_C\n0,20\n", 'zero_set = "-90"\n', "zero_set"),
    ],
)
def test_a_log_that_does_not_serve_is_refused(tmp_path, log, more, said):
    with pytest.raises(DataError, match=said):
        written(tmp_path, log, more)
