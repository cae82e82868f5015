"""Designs: what a plan identifies, the search against random designs, and a recalibration with the old file as prior."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.calibration.drawn import TRAVEL, U, bare, found_by, laser_and_plates, recorded
from vcmm.core.errors import DataError, UsageError
from vcmm.files.own.design import load_design
from vcmm.learn.calibration.design import PlannedSetup, best_within, cheapest_complete, plan_of, proposal
from vcmm.learn.calibration.job import calibrate
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.instruments.laser import six_d


def plane_machine():
    """Travels as measured, no errors."""
    machine = bare()
    return replace(machine, axes={a: replace(x, travel=TRAVEL[a]) for a, x in machine.axes.items()})


@pytest.fixture(scope="module")
def plan():
    machine = plane_machine()
    minutes = {"plate": 30.0}
    made = [
        PlannedSetup(r.name, (r,), minutes.get(r.name.split()[0], 15.0)) for r in laser_and_plates(machine)
    ]
    return plan_of(made, machine)


def test_what_a_plan_identifies(plan):
    everything = proposal(plan, range(len(plan.names)))
    assert len(everything.identifiability.names) == 21
    without = [i for i, n in enumerate(plan.names) if n != "ECZ"]
    assert "ECZ" not in proposal(plan, without).identifiability.names
    cheap = cheapest_complete(plan)
    assert len(proposal(plan, cheap).identifiability.names) == 21
    assert plan.time(cheap) < everything.minutes
    for i in cheap:  # none of them can be left out
        assert len(proposal(plan, [j for j in cheap if j != i]).identifiability.names) < 21


def test_the_search_beats_random_designs_of_equal_time(plan):
    best = plan.volume(best_within(plan, 150.0))
    rng, random = np.random.default_rng(0), []
    for _ in range(200):
        chosen, left = [], 150.0
        for i in rng.permutation(len(plan.names)):
            if plan.minutes[i] <= left:
                chosen.append(int(i))
                left -= plan.minutes[i]
        random.append(plan.volume(chosen))
    assert best <= 1.05 * min(random)


def test_more_set_ups_never_harm(plan):
    few = plan.volume([0, 1, 2])
    assert plan.volume([0, 1, 2, 3]) <= few
    assert plan.volume([]) > few


def test_a_plan_file(tmp_path):
    path = tmp_path / "plan.toml"
    head = 'vcmm = "design/1"\nstructure = "w b X t"\nbudget = "30 min"\n[axes.X]\ntravel = ["0 mm", "600 mm"]\n[[setups]]\n'
    good = 'name = "a"\ninstrument = "laser linear"\naxis = "X"\nn = 5\nu = "0.2 um"\nminutes = 10\n'
    path.write_text(head + good)
    made, machine, budget = load_design(path)
    assert budget == 30.0
    assert made[0][1][0].run.q("X").tolist() == [0, 150, 300, 450, 600, 600, 450, 300, 150, 0]
    assert machine.axes["X"].travel == (0.0, 600.0)
    path.write_text(head + good.replace("n = 5\n", ""))
    with pytest.raises(DataError, match='the set-up "a" with "laser linear" needs n'):
        load_design(path)
    with pytest.raises(UsageError, match="no set-ups"):
        plan_of([], machine)


@pytest.mark.thorough
def test_a_recalibration_keeps_what_was_not_read(tmp_path):
    """EXX gets 6 um/m more; only X is read again. Its slope follows, everything of Y and Z stays to the last digit."""
    from vcmm.files.learned.calibrated_machine import machine_texts
    from vcmm.files.own.machine import load_machine

    rng = np.random.default_rng(3)
    machine, _, first = found_by("laser", 11)
    for name, text in machine_texts(first, tmp_path / "machine.toml", ["first"]).items():
        (tmp_path / name).write_text(text)
    old = load_machine(tmp_path / "machine.toml")
    later = replace(machine, effects=tuple(_stretched(e) for e in machine.effects))
    middle = {a: (low + high) / 2 for a, (low, high) in TRAVEL.items()}
    again = six_d(bare(), "X", np.linspace(0, 600, 13), middle, np.array([0.0, 0.0, -100.0]), U)[:1]
    found = calibrate(
        recorded(later, again, rng), old, only=("EXX",)
    )  # one line alone cannot tell EXX from pitch and yaw
    was, now = first.band("EXX"), found.band("EXX")
    growth = np.interp([0.0, 600.0], now[0], now[1]) - np.interp([0.0, 600.0], was[0], was[1])
    assert growth[1] - growth[0] == pytest.approx(3.6e-3, abs=4e-4)
    for name in ("EYY", "ECZ", "C0Y"):
        nodes, value, u = first.band(name)
        after = found.band(name)
        same = (
            slice(None)
            if len(nodes) == len(after[0])
            else slice(None, None, (len(after[0]) - 1) // (len(nodes) - 1))
        )
        assert after[1][same] == pytest.approx(value, abs=2e-9 + 1e-6 * np.abs(value).max())
        assert after[2][same] == pytest.approx(u, rel=0.02)
    assert any("every other error stays as the machine file has it" in w for w in found.warnings)


def _stretched(effect: ComponentTable | Squareness):
    return replace(effect, values=effect.values + 6e-6 * effect.grids[0]) if effect.where == "EXX" else effect
