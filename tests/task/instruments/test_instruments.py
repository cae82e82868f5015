"""What instruments read and how they err themselves, against numbers computed by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.calibration.drawn import bare
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.files.own.setups import SetupTable, plan_setup
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.instruments import ALL, find
from vcmm.task.instruments.ball_bar import circle
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.laser import line
from vcmm.task.instruments.laying import simulate_reading
from vcmm.task.instruments.level import readings
from vcmm.task.instruments.tracker import at_station, lengths_to, locate_stations, move_stations
from vcmm.task.response.observe import Observer

AT = {"X": 300.0, "Y": 250.0, "Z": -200.0}


def quiet(recording):
    """Without noise and without anything left free."""
    return replace(recording, noise=Normal(1e-15), nuisance={})


def test_names_and_kinds():
    assert len({i.name for i in ALL}) == len(ALL)
    assert find("level").kind == "angle"
    with pytest.raises(UsageError, match='Did you mean "tracker"'):
        find("traker")


def test_a_laser_reads_abbe():
    # EBX = 10 urad/m x, reflector 100 mm below the axis: at x = 600 the turn is 6 urad about y, the reflector moves by
    # 6e-6 * (-200 - 100) = -1.8 um in x (arm from the axis frame at Z = 0 to the tip at -300), indicated - true = +1.8 um
    machine = bare().with_effect(ComponentPolynomial("EBX", np.array([0.0, 10e-6])))
    rng = np.random.default_rng(0)
    one = quiet(line(bare(), "X", np.array([0.0, 600.0]), AT, np.array([0, 0, -100.0]), "X", 1e-3))
    assert simulate_reading(one, machine, rng).value == pytest.approx([0, 1.8e-3, 1.8e-3, 0], abs=1e-9)
    # the angle itself, in the same sense: -6 urad; a level about y reads it too, and refuses a turn about the vertical
    tilt = quiet(readings(bare(), "X", np.array([0.0, 600.0]), AT, "Y", 1e-7))
    assert simulate_reading(tilt, machine, rng).value == pytest.approx([0, -6e-6, -6e-6, 0], abs=1e-12)
    with pytest.raises(UsageError, match="does not see a turn about the vertical"):
        readings(bare(), "X", np.array([0.0, 600.0]), AT, "Z", 1e-7)


def test_a_ball_bar_reads_squareness():
    # C0Y = 20 urad: the tip moves by -20e-6 y in x, y = 200 + 150 sin a; the length by that times cos a, indicated - true
    # by the opposite: at 45 degrees +20e-6 * (200 + 106.07) * 0.7071 = 4.328 um
    machine = bare().with_effect(Squareness("C0Y", 20e-6))
    one = quiet(circle(bare(), (300.0, 200.0, -200.0), 150.0, "XY", 1e-3, points=8))
    read = simulate_reading(one, machine, np.random.default_rng(0)).value
    angle = np.arange(8) * np.pi / 4
    assert read[1] == pytest.approx(4.3284e-3, abs=1e-7)
    assert read == pytest.approx(20e-6 * (200 + 150 * np.sin(angle)) * np.cos(angle), abs=1e-8)


def test_own_errors_by_hand():
    one = line(bare(), "X", np.array([0.0, 600.0]), AT, np.zeros(3), "X", 1e-3)
    laser = InstrumentCertificate.of(find("laser linear"), {"scale": "0.5 um/m"})
    ((name, column),) = laser.columns(one, Observer(one, bare()).run)
    assert name == "laser linear scale"
    assert column[:, 0] == pytest.approx([0, 0.3e-3, 0.3e-3, 0])  # 0.5e-6 * 600 mm
    with pytest.raises(UsageError, match="is negative"):
        InstrumentCertificate.of(find("laser linear"), {"scale": "-1 um/m"})
    with pytest.raises(UsageError, match="no such label column"):
        InstrumentCertificate(find("laser linear"), {"scale": 1e-6}, "setup").columns(one, one.run)


def test_a_station_is_found_from_lengths():
    """Lengths computed with numpy from a station at (-200, -150, -500); the file says it stands 50 mm elsewhere."""
    grid = np.array(
        [[x, y, z] for x in (0.0, 300.0, 600.0) for y in (0.0, 250.0, 500.0) for z in (-400.0, 0.0)]
    )
    true, said = np.array([-200.0, -150.0, -500.0]), np.array([-230.0, -110.0, -500.0])
    free = {"station": "setup", "zero": "setup"}
    one = lengths_to(bare(), "tracer", grid, said, (0, 0, 0), free, 1e-4)
    actual = np.linalg.norm(grid - true, axis=1)
    one = replace(one, value=np.linalg.norm(grid - said, axis=1) - actual + 12.5)  # a dead path of 12.5 mm
    found, way = locate_stations(one, bare())
    assert way["1"] == pytest.approx(50.0, abs=1e-6)
    assert found.run.column("from_x_mm")[0] == pytest.approx(-200.0, abs=1e-6)
    assert found.value == pytest.approx(12.5, abs=1e-6)
    assert move_stations(found, bare(), np.tile(said, (18, 1))).value == pytest.approx(one.value, abs=1e-9)
    split = at_station(one, bare(), np.arange(54.0).reshape(18, 3))
    with pytest.raises(ModelLimit, match="has different places"):
        locate_stations(split, bare())


def test_a_reflector_on_the_table_stands_still_in_the_workpiece():
    """X' carries the table; pitch of 20 urad at 100 mm; the reflector lies 50 mm beside where the table's errors are stated."""
    axes = {a: Axis(a, (0.0, 100.0), measured_at=(10.0, 0.0, 0.0) if a == "X" else None) for a in "XYZ"}
    bare = Machine("mill", "machine-tool", parse_structure("w X' Y' b Z t"), axes)
    tilted = bare.with_effect(ComponentPolynomial("EBX", np.array([0.0, 20e-5])))  # 0.2 urad per mm
    table = SetupTable(
        name="EZX", instrument="laser straightness", minutes=1, u="1 um", axis="X", component="Z",
        at={"Y": "50 mm", "Z": "50 mm"}, reflector="60 0 0 mm", n=3,
    )  # fmt: skip
    ((one,), _) = plan_setup(table, bare)
    assert bare.prepare(one.run).tip == pytest.approx(np.tile([60.0, 0.0, 0.0], (6, 1)))
    # the table rises at the reflector by (0 b 0) x (50 0 0) = (0, 0, -50 b); the tool seems to stand as much higher: indicated - true
    assert Observer(one, tilted).baseline()[:3] == pytest.approx([0.0, -50 * 10e-6, -50 * 20e-6], abs=1e-12)
    with pytest.raises(UsageError, match="keep one"):
        plan_setup(table.model_copy(update={"offset": (0.0, 0.0, -100.0)}), bare)
