"""Calibration end to end: drawn machines, hand-computed cases, outliers, instruments, what is not identified, bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.calibration.drawn import (
    STRUCTURE,
    TRAVEL,
    bare,
    draw,
    found_by,
    laser_and_plates,
    mean,
    recorded,
    slope,
    tracers,
    truth,
)
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.learn.calibration.checks import check_agreement
from vcmm.learn.calibration.job import bare_machine, calibrate
from vcmm.learn.calibration.model import error_model, gauge
from vcmm.learn.calibration.readings import readings
from vcmm.learn.calibration.solve import nuisance_basis
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.instruments import find
from vcmm.task.instruments.artefact import plate
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.laser import diagonal, line
from vcmm.task.instruments.laying import simulate_reading
from vcmm.task.instruments.tracker import lengths_to, move_stations

MIDDLE = {"X": 300.0, "Y": 250.0, "Z": -200.0}
TIP = np.array([0.0, 0.0, -100.0])


def z_scores(found, machine) -> np.ndarray:
    """Departures of all identified curves from the drawn ones, in units of their u."""
    out = []
    for curve in found.kept_model.curves:
        nodes, value, u = found.band(curve.component)
        out.append((value - truth(machine, curve.component, nodes)) / u)
    return np.concatenate(out)


@pytest.mark.thorough
@pytest.mark.parametrize("design", ["laser", "tracer"])
def test_bands_hold_the_truth(design):
    # one machine, whose nodes move together; tools/calibrate_statistics.py (make exam) counts many
    machine, _, found = found_by(design, 11)
    assert len(found.identified.names) == 21
    assert not found.identified.combinations
    scores = z_scores(found, machine)
    assert 0.85 < (np.abs(scores) < 1.96).mean() < 0.999
    assert 0.6 < np.sqrt(np.mean(scores**2)) < 1.4
    squareness = _squareness_scores(found, machine)
    assert np.abs(squareness).max() < 3.5


def _squareness_scores(found, machine) -> list[float]:
    """C0Y etc. against the drawn angle and what straightness slopes and mean rotations add to it, written out by hand.

    Chain b Y X Z: Y carries X and Z, X carries Z. C0Y: the slope of EYX turns X by +a about z, that of EXY turns Y by -a;
    a constant turn of Y takes X along. Tip shifts of (-c y, 0, 0) are +c.
    """
    nodes = {c.axis: c.nodes for c in found.kept_model.curves}
    s = {n: slope(machine, n, nodes[n[2]]) for n in ("EYX", "EXY", "EZX", "EXZ", "EZY", "EYZ")}
    m = {n: mean(machine, n, nodes[n[2]]) for n in ("ECY", "EBY", "EBX", "EAY", "EAX")}
    drawn = {p: next(e for e in machine.effects if e.where == p).angle for p in ("C0Y", "B0Z", "A0Z")}
    expected = {
        "C0Y": drawn["C0Y"] - s["EXY"] - s["EYX"] - m["ECY"],
        "B0Z": drawn["B0Z"] + s["EXZ"] + s["EZX"] + m["EBX"],
        "A0Z": drawn["A0Z"] - s["EYZ"] - s["EZY"] + m["EAY"] + m["EAX"],
    }
    return [float((found.band(p)[1][0] - v) / found.band(p)[2][0]) for p, v in expected.items()]


def test_the_conventions_change_no_reading():
    """Drawn curves with means and lines, and the same machine by the conventions, predict every length alike."""
    rng = np.random.default_rng(5)
    machine = draw(rng)
    model = error_model(TRAVEL, 17)
    full = np.zeros(model.size)
    for curve in model.curves:
        effect = next(e for e in machine.effects if e.where == curve.component)
        full[model.slices[curve.component]] = np.interp(curve.nodes, effect.grids[0], effect.values)
    full[-3:] = [next(e for e in machine.effects if e.where == p).angle for p in model.pairs]
    turned = gauge(model, bare()) @ full
    assert np.abs(turned - full).max() > 1e-3
    for recording in (tracers(bare(), step=4)[1], laser_and_plates(bare())[-1]):
        part = readings(recording, bare(), model)
        change = part.errors @ (turned - full)
        basis = nuisance_basis(part.nuisance)
        assert np.abs(change - basis @ (basis.T @ change)).max() < 1e-9  # mm


def test_scale_and_squareness_of_a_plate_by_hand():
    # machine: EXX = 10 um/m x and C0Y = 20 urad only. Balls along two sides of a 400 mm square, no noise to speak of:
    # the X sides read -4 um (indicated - true), a Y side moves by -20e-6 * 400 = -8 um of tip, so reads +8 um in x
    machine = bare().with_effect(ComponentPolynomial("EXX", np.array([0.0, 10e-3])), Squareness("C0Y", 20e-6))
    corners = np.array([[x, y, -300.0] for y in (50, 450) for x in np.linspace(100, 500, 9)])
    one = plate(bare(), corners, "1", TIP, 1e-6)
    read = simulate_reading(one, machine, np.random.default_rng(0))
    at = corners + read.value.reshape(18, 3)
    diagonals = [np.linalg.norm(at[17] - at[0]), np.linalg.norm(at[9] - at[8])]
    # diagonal reading: +-: sqrt(2)/2 * (-4 um +- 8 um) to first order
    assert np.array(diagonals) - 400 * np.sqrt(2) == pytest.approx(
        np.array([4e-3, -12e-3]) / np.sqrt(2), abs=2e-5
    )
    found = calibrate([read], bare_machine(STRUCTURE), only=("EXX", "C0Y"))
    nodes, value, _ = found.band("EXX")
    assert nodes[[0, -1]].tolist() == [100.0, 500.0]
    assert value[-1] - value[0] == pytest.approx(4e-3, abs=2e-5)
    assert found.band("C0Y")[1][0] == pytest.approx(20e-6, abs=1e-7)
    assert "taken as zero" in " ".join(found.warnings)


def test_u_of_the_instrument_stays_in_the_slope():
    # a laser with u(scale) = 2 um/m: over 600 mm the end of EXX is known to 2e-6 * 300 = 0.6 um from the middle, whatever
    # the number of readings; the band of 13 targets x 2 x 3 readings of 0.05 um alone is below 0.05 um
    machine = bare().with_effect(ComponentPolynomial("EXX", np.array([0.0, 5e-3])))
    read = simulate_reading(
        line(bare(), "X", np.linspace(0, 600, 13), MIDDLE, TIP, "X", 0.05e-3, 3),
        machine,
        np.random.default_rng(1),
    )
    laser = InstrumentCertificate.of(find("laser linear"), {"scale": "2 um/m"})
    sharp = calibrate([read], bare(), only=("EXX",))
    blunt = calibrate([read], bare(), {read.name: laser}, only=("EXX",))
    assert sharp.band("EXX")[2][-1] < 0.05e-3
    assert blunt.band("EXX")[2][-1] == pytest.approx(0.6e-3, rel=0.05)


def test_one_laser_in_two_recordings_has_one_scale():
    # its scale of u = 2 um/m moves the end of EXX by 0.6 um in both; two lasers would leave 0.6 / sqrt(2)
    machine = bare().with_effect(ComponentPolynomial("EXX", np.array([0.0, 5e-3])))
    rng = np.random.default_rng(1)
    meant = line(bare(), "X", np.linspace(0, 600, 13), MIDDLE, TIP, "X", 0.05e-3, 2)
    lines = [
        simulate_reading(replace(meant, name=name), machine, rng) for name in ("before noon", "after noon")
    ]

    def found(*serials: str):
        made = [
            InstrumentCertificate.of(find("laser linear"), {"scale": "2 um/m"}, serial=s) for s in serials
        ]
        return calibrate(lines, bare(), {r.name: m for r, m in zip(lines, made)}, only=("EXX",))

    one, two = found("L-2041", "L-2041"), found("L-2041", "L-2042")
    assert one.posterior.instrument_names == ("laser linear scale of L-2041",)
    assert one.band("EXX")[2][-1] == pytest.approx(0.6e-3, rel=0.03)
    assert two.band("EXX")[2][-1] == pytest.approx(0.6e-3 / np.sqrt(2), rel=0.03)
    assert found("", "").band("EXX")[2][-1] == pytest.approx(0.6e-3 / np.sqrt(2), rel=0.03)
    other = InstrumentCertificate.of(find("laser linear"), {"scale": "1 um/m"}, serial="L-2041")
    first = InstrumentCertificate.of(find("laser linear"), {"scale": "2 um/m"}, serial="L-2041")
    with pytest.raises(UsageError, match='serial = "L-2041", but state different u'):
        calibrate(lines, bare(), {lines[0].name: first, lines[1].name: other}, only=("EXX",))


def test_the_scale_of_a_six_d_laser_is_in_no_angle():
    roll = line(bare(), "X", np.linspace(0, 600, 13), MIDDLE, TIP, "A", 0.3e-6)
    certificate = InstrumentCertificate.of(find("6-D laser"), {"scale": "0.5 um/m"})
    assert certificate.columns(roll, bare().prepare(roll.run)) == []


@pytest.mark.thorough
def test_outliers_carry_little_weight():
    rng = np.random.default_rng(7)
    machine, design, _ = found_by("tracer", 11)
    spoilt = []
    for one in design:
        value = one.value.copy()
        value[rng.choice(one.m, 3, replace=False)] += 0.05
        spoilt.append(replace(one, value=value))
    found = calibrate(spoilt, bare())
    assert (np.abs(z_scores(found, machine)) < 1.96).mean() > 0.85
    assert sum(int(n.outliers.sum()) for n in found.posterior.noise) >= 18
    assert any("outliers carry little weight" in w for w in found.warnings)


@pytest.mark.thorough
def test_stations_50_mm_off_are_found():
    _, design, near = found_by("tracer", 11)
    away = [
        move_stations(r, bare(), r.run.vector("from_x_mm", "from_y_mm", "from_z_mm") + [30.0, -30.0, 26.0])
        for r in design
    ]
    far = calibrate(away, bare())
    assert all(min(p.station_moves.values()) > 45 for p in far.readings)
    for name in ("EXX", "EBY", "C0Y"):
        assert far.band(name)[1] == pytest.approx(
            near.band(name)[1], abs=0.05 * float(near.band(name)[2].mean())
        )


def diagonals(design_machine) -> list:
    ends = np.array([TRAVEL[a] for a in "XYZ"])
    out = []
    for k, flips in enumerate(((0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1))):
        start = ends[range(3), flips]
        way = ends[range(3), 1 - np.array(flips)] - start
        tips = start + np.linspace(0.1, 1.0, 10)[:, None] * way
        out.append(lengths_to(design_machine, f"diagonal {k}", tips, start, (0, 0, 0), {"zero": ""}, 0.2e-3))
    return out


@pytest.mark.thorough
def test_body_diagonals_alone_are_refused_with_the_combination():
    rng = np.random.default_rng(2)
    read = recorded(draw(rng), diagonals(bare()), rng)
    with pytest.raises(UsageError, match="identify no error of the machine by itself") as error:
        calibrate(read, bare())
    text = str(error.value)
    assert "cannot be told apart" in text
    assert "slope of E" in text  # scale
    assert any(pair in text for pair in ("C0Y", "B0Z", "A0Z"))  # and squareness
    assert len(text) < 800  # what the command line shows of it
    # read from their corners through the volume, squareness is told to 10 urad by the prior of the other errors alone
    ends = np.array([TRAVEL[a] for a in "XYZ"])
    corners = [
        (ends[range(3), f], ends[range(3), 1 - np.array(f)])
        for f in ((0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1))
    ]
    meant = [
        replace(diagonal(bare(), (a.tolist(), b.tolist()), 9, 0.3e-3), name=f"d{k}")
        for k, (a, b) in enumerate(corners)
    ]
    with pytest.raises(UsageError, match="identify no error"):
        calibrate(recorded(draw(rng), meant, rng), bare())
    # scales and squareness alone, everything else zero: four diagonals tell the squareness, and only one sum of the scales
    found = calibrate(read, bare(), only=("EXX", "EYY", "C0Y"))
    assert found.identified.names == ("C0Y",)
    slopes = next(
        c for c in found.identified.combinations if ("EYY", "slope") in {(n, s) for n, s, _ in c.members}
    )
    amount = {name: value for name, shape, value in slopes.members if shape == "slope"}
    # a diagonal of 600 x 500 mm is blind where (dx/dX) 600^2 + (dy/dY) 500^2 = 0; the slope of unit rms is dx/dX 600 / sqrt(12)
    # (9 or more nodes: within a tenth), so the rms amounts stand as 500 to -600
    assert amount["EXX"] / amount["EYY"] == pytest.approx(-500 / 600, rel=0.15)


def test_a_missing_measurement_is_named():
    rng = np.random.default_rng(4)
    design = [r for r in laser_and_plates(bare())[:6] if r.name != "ECX"]  # X alone
    found = calibrate(recorded(draw(rng), design, rng), bare())
    assert found.identified.names == ("EXX", "EYX", "EZX", "EAX", "EBX")
    assert [c.names for c in found.identified.combinations] == [("ECX",)]
    assert "measure the angle along X" in found.identified.combinations[0].text


@pytest.mark.thorough
def test_one_half_predicts_the_other():
    rng = np.random.default_rng(6)
    _, design, _ = found_by("tracer", 11)
    order = [rng.permutation(r.m) for r in design]
    halves = [[r.take(np.sort(o[k::2])) for r, o in zip(design, order)] for k in (0, 1)]
    found = calibrate(halves[0], bare())
    inside = []
    for one in halves[1]:
        part = readings(one, bare(), found.kept_model)
        basis = nuisance_basis(part.nuisance)
        e = part.value - part.errors @ found.theta
        e -= basis @ (basis.T @ e)
        spread = part.errors @ found.covariance @ part.errors.T + np.diag(part.u**2)
        left = np.eye(part.m) - basis @ basis.T
        inside.append(np.abs(e) < 1.96 * np.sqrt(np.diag(left @ spread @ left)))
    assert 0.92 < np.concatenate(inside).mean() < 0.975


@pytest.mark.parametrize(
    ("times", "said"),
    [(-1.0, "times -1; its sign is the other way round"), (1 / 4.848, "arcsec taken for urad")],
)
def test_a_sign_or_unit_that_contradicts_the_others_is_named(times, said):
    rng = np.random.default_rng(8)
    machine = draw(rng)
    design = recorded(
        machine,
        [*tracers(bare(), step=5), line(bare(), "X", np.linspace(0, 600, 13), MIDDLE, TIP, "B", 0.3e-6)],
        rng,
    )
    model = error_model(TRAVEL, 9)
    parts = [readings(r, bare(), model) for r in design]
    check_agreement(parts, model)
    wrong = [*parts[:-1], replace(parts[-1], value=parts[-1].value * times)]
    with pytest.raises(UsageError, match=f"EBX contradicts the other recordings.*{said}"):
        check_agreement(wrong, model)


def test_bad_recordings():
    one = line(bare(), "X", np.linspace(0, 600, 5), MIDDLE, TIP, "B", 1e-7)
    with pytest.raises(UsageError, match="check the unit"):
        calibrate([replace(one, value=np.linspace(0, 0.01, one.m))], bare())
    with pytest.raises(UsageError, match="two recordings have the name"):
        calibrate([one, one], bare())
    with pytest.raises(UsageError, match="no axis moves"):
        calibrate([one.take(np.zeros(1, dtype=int)).__class__(**{**vars(one), "run": _still(one)})], bare())
    few = lengths_to(
        bare(), "few", np.eye(3) * 100.0, (-100, 0, 0), (0, 0, 0), {"station": "setup", "zero": "setup"}, 1e-4
    )
    with pytest.raises(ModelLimit, match="3 lengths; expected 4 or more"):
        calibrate([few], bare())


def _still(one):
    position = {a: np.full(one.run.n, 1.0) for a in one.run.position}
    return replace(one.run, position=position)
