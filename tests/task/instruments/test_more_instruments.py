"""Straightedge, square, probes, grid plate, hole plate, ball bar artefact, sphere, 6-D laser, diagonal: read by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.calibration.drawn import bare
from vcmm.core.errors import UsageError
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.instruments import find
from vcmm.task.instruments.artefact import bar, grid_of_balls, plate, sphere
from vcmm.task.instruments.ball_bar import both_senses
from vcmm.task.instruments.circular import grid_circle
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.laser import diagonal, six_d
from vcmm.task.instruments.straight import edge, square
from vcmm.task.response.observe import Observer

AT = {"X": 100.0, "Y": 50.0, "Z": -200.0}
SCALE = ComponentPolynomial("EXX", np.array([0.0, 10e-3]))  # 10 um/m


def read(recording, *effects) -> np.ndarray:
    """actual - commanded, um or urad, nothing free."""
    machine = bare().with_effect(*effects)
    scale = 1e6 if recording.kind == "angle" else 1e3
    return -Observer(replace(recording, nuisance={}), machine).baseline() * scale


def own(name, stated, recording) -> dict[str, np.ndarray]:
    certificate = InstrumentCertificate.of(find(name), stated)
    return dict(certificate.columns(recording, Observer(recording, bare()).run))


def test_a_straightedge():
    # EYX = 5 um/m^2 x^2: at 400 mm 0.8 um; own form: one column per place, read there and back
    one = edge(bare(), "X", np.array([0.0, 400.0]), AT, np.zeros(3), "Y", 1e-4)
    bow = ComponentPolynomial("EYX", np.array([0.0, 0.0, 5e-3]))
    assert read(one, bow) == pytest.approx([0, 0.8, 0.8, 0])
    form = own("straightedge", {"form": "0.3 um"}, one)["straightedge form"]
    assert form == pytest.approx(0.3e-3 * np.array([[1, 0], [0, 1], [0, 1], [1, 0]]))
    with pytest.raises(UsageError, match="read across it"):
        edge(bare(), "X", np.array([0.0, 400.0]), AT, np.zeros(3), "X", 1e-4)


def test_a_square():
    # C0Y = 20 urad: along Y the tip moves by -20e-6 y in X: over 300 mm -6 um; the first arm, along X, sees nothing
    targets = (np.linspace(100, 400, 4), np.linspace(50, 350, 4))
    one = square(bare(), ("X", "Y"), targets, AT, np.zeros(3), 1e-4)
    seen = read(one, Squareness("C0Y", 20e-6))
    assert np.ptp(seen[:8]) == pytest.approx(0.0, abs=1e-9)
    assert seen[8:12] - seen[8] == pytest.approx([0, -2, -4, -6])
    # the second arm turned by +1 rad about Z: its points, 150 mm to either side of its middle, move by -y
    column = own("square", {"angle": "1 urad"}, one)["square angle"][:, 0]
    assert column[:8] == pytest.approx(0.0)
    assert column[8:12] * 1e6 == pytest.approx([150, 50, -50, -150])
    with pytest.raises(UsageError, match='"first" and "second"'):
        own("square", {"angle": "1 urad"}, replace(one, run=replace(one.run, labels={})))


def test_a_capacitance_probe_drifts():
    one = edge(bare(), "X", np.array([0.0, 400.0]), AT, np.zeros(3), "Z", 1e-5)
    timed = replace(one, run=one.run.with_columns({"time_s": np.array([0.0, 900.0, 1800.0, 3600.0])}))
    drift = own("capacitance probe", {"drift": "0.1 um/h"}, timed)["capacitance probe drift"][:, 0]
    assert drift * 1e3 == pytest.approx([0, 0.025, 0.05, 0.1])
    assert own("optical probe", {"drift": "0.1 um/h"}, one) == {}


def test_a_grid_plate_and_a_bar_go_round_both_ways():
    one = grid_circle(bare(), (300, 250, -200), 100.0, "XY", 1e-4, points=8)
    assert (one.run.n, one.m) == (16, 32)
    # scale 10 um/m about X = 0: at angle 0 X stands at 400: dx = 4 um, dy = 0
    assert read(one, SCALE)[:2] == pytest.approx([4.0, 0.0])
    # backlash of 2 um: -1/2 gap sense: at 90 degrees X goes backwards counter-clockwise (+1 um), forwards clockwise (-1 um)
    bar_ = both_senses(bare(), (300, 250, -200), 100.0, "XY", 1e-4, points=8)
    assert bar_.run.column("sense_X")[[1, 2, 9, 14]] == pytest.approx([-1, -1, -1, 1])
    shifted = read(one, Backlash("X", 2e-3)).reshape(16, 2)[:, 0]
    assert shifted[[2, 14]] == pytest.approx([1.0, -1.0])


def test_a_hole_plate_is_read_in_its_plane():
    holes = grid_of_balls((100, 50, -200), (400, 0, 0), (0, 400, 0), (2, 2))
    one = plate(bare(), holes, "flat", (0, 0, 0), 1e-4, axes="XY")
    assert one.m == 8
    assert read(one, SCALE) == pytest.approx([1, 0, 1, 0, 5, 0, 5, 0])
    assert own("hole plate", {"balls": "0.2 um"}, one)["hole plate balls"].shape == (8, 8)


def test_a_ball_bar_artefact():
    # 300 x 400 mm: 500 mm long, direction (0.6, 0.8): a scale of 10 um/m on X lengthens it by 3 um * 0.6 = 1.8 um
    one = bar(bare(), [((100, 50, -200), (400, 450, -200)), ((400, 50, -200), (100, 450, -200))], 1e-4)
    assert read(one, SCALE) == pytest.approx([1.8, 1.8])
    columns = own("ball bar artefact", {"length": "0.5 um", "scale": "1 um/m"}, one)
    assert columns["ball bar artefact length"][:, 0] * 1e3 == pytest.approx([0.5, 0.5])
    assert columns["ball bar artefact scale"][:, 0] * 1e3 == pytest.approx([0.5, 0.5])


def test_a_calibrated_sphere():
    normals = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 0, 1]])
    one = sphere(bare(), (300, 250, -200), 25.0, normals, 1e-4)
    assert one.run.q("X") == pytest.approx([312.5, 287.5, 300.0])
    assert read(one, SCALE) == pytest.approx([3.125, -2.875, 0.0])
    assert own("sphere", {"diameter": "0.2 um"}, one)["sphere diameter"][:, 0] * 1e3 == pytest.approx(
        [0.1] * 3
    )


def test_a_6d_laser_on_the_line_where_errors_are_stated():
    # pitch of 10 urad/m about the line measured_at: its linear channel sees none of it, its angle channel all
    machine = bare()
    axes = {**machine.axes, "X": replace(machine.axes["X"], measured_at=(0.0, 250.0, -300.0))}
    machine = replace(machine, axes=axes)
    pitch = ComponentPolynomial("EBX", np.array([0.0, 10e-6]))
    at = {"Y": 250.0, "Z": -200.0}
    u = {"linear": 1e-4, "straightness": 1e-4, "angle": 1e-7}
    six = six_d(machine, "X", np.array([0.0, 500.0]), at, None, u)
    assert six[0].run.offset[0] == pytest.approx([0, 0, -100])
    seen = [-Observer(replace(one, nuisance={}), machine.with_effect(pitch)).baseline() for one in six]
    assert seen[0] == pytest.approx([0, 0, 0, 0], abs=1e-12)
    assert seen[4] * 1e6 == pytest.approx([0, 5, 5, 0])
    with pytest.raises(UsageError, match="no measured_at for Y"):
        six_d(machine, "Y", np.array([0.0, 500.0]), {"X": 0.0, "Z": -200.0}, None, u)
    # own errors act on their channels: the gain of the angles on angles alone
    angle = InstrumentCertificate.of(find("6-D laser"), {"angle": "1 %", "straightness": "1 %"})
    read_ = [replace(one, value=np.full(one.m, 1e-5)) for one in six]
    used = [[n for n, _ in angle.columns(one, Observer(one, machine).run)] for one in read_]
    assert used == [[], ["6-D laser straightness"], ["6-D laser straightness"]] + [["6-D laser angle"]] * 3


def test_a_diagonal_has_the_senses_of_its_axes():
    one = diagonal(bare(), ((0, 500, -400), (600, 0, 0)), 3, 1e-4, runs=1)
    assert one.run.q("Y") == pytest.approx([500, 250, 0, 0, 250, 500])
    assert one.run.column("sense_Y") == pytest.approx([-1, -1, -1, 1, 1, 1])
    # a scale of 10 um/m on X: 6 um in X at the end, times 600 / 877.5 along the diagonal
    assert read(one, SCALE)[2] == pytest.approx(6.0 * 600 / np.sqrt(600**2 + 500**2 + 400**2))
