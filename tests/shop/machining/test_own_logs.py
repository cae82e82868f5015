"""Logs that a program writes by itself: a cut and a correction need no file of the speed of the spindle."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import vcmm
from tests.compensation import block
from vcmm.compensation.job import compensate
from vcmm.core.run import Run
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.structure.spindle_growth import SpindleGrowth
from vcmm.shop.machining.own_logs import with_own_logs
from vcmm.shop.machining.proof import inspected_cut, proof_by_cut

GROWS = '[[effects]]\neffect = "spindle_growth"\naxis = "Z"\nA = "60 um"\ntau = "40 s"\nfollows = 1\n'


def path(time, rpm):
    return SimpleNamespace(
        n=len(time), time=np.array(time), columns={"spindle_rpm": np.array(rpm)}, seconds=10.0
    )


RUN = Run({"Z": np.zeros(1)}, np.zeros((1, 3)), {"time_s": np.array([6.0]), "spindle_rpm": np.array([1.0])})
GROWTH = SpindleGrowth("Z", 60e-3, 40.0, follows=1)


def test_a_speed_holds_from_the_row_before():
    """0 until 2 s, then 3000 (M4: -3000) until 5 s, then 1000 until 10 s; a second part the same again."""
    found = with_own_logs(
        RUN, path([0.0, 2.0, 4.0, 5.0, 10.0], [0.0, 0.0, -3000.0, -3000.0, 1000.0]), (GROWTH,)
    ).series["spindle_rpm"]
    assert found.time.tolist() == [0.0, 2.0, 2.0, 5.0, 5.0, 10.0]
    assert found.value.tolist() == [0.0, 0.0, 3000.0, 3000.0, 1000.0, 1000.0]
    twice = with_own_logs(RUN, path([0.0, 10.0], [500.0, 500.0]), (GROWTH,), parts=2).series["spindle_rpm"]
    assert twice.time.tolist() == [0.0, 10.0, 10.0, 20.0]


def test_only_what_an_effect_asks_for_is_made():
    assert with_own_logs(RUN, path([0.0, 1.0], [1.0, 1.0]), (Backlash("Z", 1e-3),)).series == {}


@pytest.mark.thorough
def test_a_growth_by_speed_is_cut_and_corrected_without_a_log(tmp_path):
    """60 um x 3000 / 10000 x (1 - exp(-t / 40 s)): at most 18 um, and 13 um where the first floor is cut after t = 50 s. It was refused: "needs a log"."""
    scenario = vcmm.load_cut(block.write(tmp_path, GROWS))
    before = inspected_cut(scenario)
    floor = before.off[before.feature == "floor"]
    assert -18e-3 < floor.min() < floor.max() < -12e-3
    made = compensate(scenario.program, scenario.setup, scenario.machine, decimals=4)
    (tmp_path / "new.nc").write_text(made.text)
    proof = proof_by_cut(scenario, tmp_path / "new.nc", 1e-3)
    assert proof.is_met
    assert proof.after is not None
    assert proof.after.largest == pytest.approx(0.0, abs=0.4e-3)
