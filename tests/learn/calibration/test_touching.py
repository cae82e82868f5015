"""Touches of a probe in the spindle, made by the referee's own kinematics, against what calibrate finds."""

from pathlib import Path

import numpy as np
import pytest

from referee import touch as own
from vcmm.core.errors import DataError
from vcmm.files.own.instruments import load_certificate
from vcmm.files.own.recording import load_recording
from vcmm.learn.calibration.job import bare_machine, calibrate
from vcmm.learn.calibration.touching import touched_errors


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A machine of the referee, its log and its R-tests."""
    folder = tmp_path_factory.mktemp("touch")
    rng = np.random.default_rng([7, 0])
    machine = own.draw(rng)
    own.write(folder, machine, rng)
    return folder, machine


def found_from(path: Path):
    recording, machine = load_recording(path)
    certificate = load_certificate(path, recording)
    return calibrate([recording], machine, {recording.name: certificate})


@pytest.fixture(scope="module")
def found(drawn):
    return found_from(drawn[0] / "touch.toml")


def test_location_errors_of_a_foreign_kinematics_are_found_within_their_u(drawn, found):
    # X0C: 1.0 um is the u of the offset of the probe, which nothing parts from the place of the trunnion
    for name, true in drawn[1].place.items():
        _, value, u = found.band(name)
        assert abs(value[0] - true) < 3.5 * u[0], name
    assert 0.9e-3 < found.band("X0C")[2][0] < 1.2e-3
    assert found.band("Y0C")[2][0] < 0.2e-3  # relative to the trunnion: the offset drops out


def test_angular_position_errors_are_found_along_the_turn(drawn, found):
    for name in ("EAA", "ECC"):
        nodes, value, u = found.band(name)
        true = drawn[1].angular(name[1], nodes)
        assert (np.abs(value - true) < 4 * u).all()
        assert np.sqrt(np.mean((value - true) ** 2)) < 2e-6 < np.abs(true).max()


def test_an_offset_that_nobody_states_is_one_with_the_place_of_the_trunnion(drawn, found):
    path = drawn[0] / "free.toml"
    path.write_text((drawn[0] / "touch.toml").read_text().replace('offset = "1 um", ', ""))
    free = found_from(path)
    open_ = {n for c in free.identified.combinations for n in c.names}
    assert open_ == {"X0C", "Y0A", "Z0A"}
    assert any("offset of the touch probe" in text for text in free.warnings)
    assert {"Y0C", "A0C", "B0C", "B0A", "C0A", "EAA", "ECC"} <= set(free.identified.names)


def test_the_spindle_turned_by_half_parts_offset_and_place(drawn):
    """Touched again with the spindle at 180 deg: the ball stands on the other side of the axis; only its length stays open."""
    folder, machine = drawn
    lines = own.touches(machine, np.random.default_rng(5))
    kept = machine.probe["offset"].copy()
    turned = own.Five(machine.place, machine.angle, dict(machine.probe))
    turned.probe["offset"] = kept * [-1, -1, 1]
    turned.probe["lobes"] = machine.probe["lobes"] * [1, 1, -1, -1]  # cos 3(t - 180 deg) = -cos 3t
    again = own.touches(turned, np.random.default_rng(5))
    assert len(lines) == len(again)
    (folder / "both.log").write_text(
        "\n".join([*(f"{t} S0" for t in lines), *(f"{t} S180" for t in again)]) + "\n"
    )
    text = (
        (folder / "touch.toml").read_text().replace('offset = "1 um", ', "").replace("touch.log", "both.log")
    )
    (folder / "both.toml").write_text(text)
    both = found_from(folder / "both.toml")
    assert {n for c in both.identified.combinations for n in c.names} == {"Z0A"}
    for name in ("X0C", "Y0A"):
        _, value, u = both.band(name)
        assert u[0] < 0.3e-3
        assert abs(value[0] - machine.place[name]) < 4 * u[0]


def test_names_follow_the_chain():
    turned = {"A": (-1.0, 1.0), "C": (0.0, 6.0), "X": (0.0, 100.0)}
    assert touched_errors(turned) == ("EAA", "ECC", "Y0A", "Z0A", "B0A", "C0A", "X0C", "Y0C", "A0C", "B0C")
    assert touched_errors({"B": (0.0, 1.0)}) == ("EBB", "X0B", "Z0B", "A0B", "C0B")
    assert touched_errors({"X": (0.0, 1.0), "Y": (0.0, 1.0)}) == ("EXX", "EYY", "C0Y")


# -- three axes: a block of 300 mm in four directions of the plane and a ring of 60 mm --
SCALE_X, SCALE_Y, SQUARE, PRE, BALL = 30e-6, -20e-6, 25e-6, 0.004, 3.0


def tip(q):
    """Where the tip of "w b Y X Z t" is: X + k X - C0Y Y, Y + k Y, Z."""
    return np.array([q[0] * (1 + SCALE_X) - SQUARE * q[1], q[1] * (1 + SCALE_Y), q[2]])


def line(number, way, stopped):
    x, y, z = stopped + way * BALL
    return f"TOUCH F{number} I{way[0]:.6f} J{way[1]:.6f} K{way[2]:.6f} X{x:.5f} Y{y:.5f} Z{z:.5f}"


def touch_of_face(point, normal, start):
    """Where the control stands when the ball has met a plane, and has gone on by its pre-travel."""
    at = normal @ (tip(start) - point) - BALL
    fall = normal @ (tip(start - normal) - tip(start))
    return start - normal * (at / -fall + PRE)


def gauges(folder, scatter):
    rng, lines, tables = np.random.default_rng(4), [], ""
    for k, angle in enumerate(np.radians([0, 90, 45, 135])):
        e, middle, off = (
            np.array([np.cos(angle), np.sin(angle), 0]),
            np.array([200, 180, 20.0]),
            rng.normal(size=3) * 0.1,
        )
        for side, normal in ((1, e), (2, -e)):
            point, number = middle + 150 * normal, 2 * k + side
            place = " ".join(f"{v:.6f}" for v in point)
            tables += f'[touch.features.{number}]\ntype = "plane"\npoint = "{place} mm"\nnormal = {[float(f"{v:.12f}") for v in normal]}\npart = "block {k}"\n'
            for along in (-6, 0, 6):
                start = point + along * np.array([-e[1], e[0], 0]) + 8 * normal
                stopped = touch_of_face(point + off, normal, start)
                lines.append(line(number, -normal, stopped - normal * rng.normal() * scatter))
    middle = np.array([100, 100, 20.0])
    tables += (
        '[touch.features.9]\ntype = "ring"\npoint = "100 100 20 mm"\naxis = [0, 0, 1]\ndiameter = "60 mm"\n'
    )
    for angle in np.radians(np.tile(np.arange(0, 360, 45), 4)):
        way = np.array([np.cos(angle), np.sin(angle), 0])
        per_mm = np.linalg.norm(tip(middle + way) - tip(middle))  # the tip goes so far per mm along way
        stopped = middle + way * (27.0 / per_mm + PRE)
        lines.append(line(9, way, stopped + way * rng.normal() * scatter))
    (folder / "gauges.log").write_text("\n".join(lines) + "\n")
    (folder / "gauges.toml").write_text(
        'vcmm = "recording/1"\nname = "gauges"\ndata = "gauges.log"\nformat = "touches"\nkind = "probe"\n[noise]\nu = "0.5 um"\n'
        '[instrument]\nname = "touch probe"\nu = { offset = "0 um", lobing = "0 um", axial = "0 um", diameter = "0.3 um" }\n'
        f'[touch]\ntip_diameter = "6 mm"\noffset = "0 0 -100 mm"\n{tables}'
    )
    path = folder / "gauges.toml"
    recording, machine = load_recording(path, bare_machine("w b Y X Z t"))
    return calibrate([recording], machine, {recording.name: load_certificate(path, recording)})


def slope(found, name):
    nodes, value, u = found.band(name)
    way = nodes[-1] - nodes[0]
    return (value[-1] - value[0]) / way, 2 * u[0] / way


def test_block_and_ring_tell_scale_squareness_and_radius(tmp_path):
    # of the block +30 um/m x 300 mm = 9 um along X; -20 um/m: -6 um along Y; diagonals differ by 25 urad x 300 mm = 7.5 um
    found = gauges(tmp_path, 0.5e-3)
    for name, true in (("EXX", SCALE_X), ("EYY", SCALE_Y)):
        k, u = slope(found, name)
        assert abs(k - true) < 3.5 * u
        assert u < 2e-6
    _, value, u = found.band("C0Y")
    assert abs(value[0] - SQUARE) < 3.5 * u[0]
    assert u[0] < 3e-6
    (radius,) = found.probe_radii()
    assert abs(radius["value_um"] + PRE * 1e3) < 3.5 * radius["u_um"]
    assert radius["u_um"] < 0.4
    assert set(found.identified.names) == {"EXX", "EYY", "C0Y"}  # Z stood still


def test_without_scatter_the_block_is_exact_to_nanometres(tmp_path):
    found = gauges(tmp_path, 0.0)
    assert slope(found, "EXX")[0] == pytest.approx(SCALE_X, abs=0.15e-6)
    assert slope(found, "EYY")[0] == pytest.approx(SCALE_Y, abs=0.15e-6)
    assert found.band("C0Y")[1][0] == pytest.approx(SQUARE, abs=0.3e-6)


def test_a_feature_that_nobody_states_is_refused_with_its_line(drawn, tmp_path):
    folder = drawn[0]
    (folder / "bad.log").write_text("TOUCH F7 I-1 J0 K0 X1 Y2 Z3 A0 C0\n")
    (folder / "bad.toml").write_text((folder / "touch.toml").read_text().replace("touch.log", "bad.log"))
    with pytest.raises(DataError, match=r'line 1: feature "7" has no table \[touch.features.7\]'):
        load_recording(folder / "bad.toml")


def test_touches_far_from_their_sphere_are_refused(drawn):
    folder = drawn[0]
    text = (folder / "touch.toml").read_text().replace('zero = "0 0 250 mm"', 'zero = "0 0 270 mm"')
    (folder / "far.toml").write_text(text)
    with pytest.raises(DataError, match="from the surface of feature"):
        load_recording(folder / "far.toml")


FACES = (
    ((60, 0, 40), (1, 0, 0)),
    ((-60, 0, 40), (-1, 0, 0)),
    ((0, 60, 40), (0, 1, 0)),
    ((0, -60, 40), (0, -1, 0)),
    ((0, 0, 80), (0, 0, 1)),
)


def test_a_square_block_tells_the_same_as_spheres(tmp_path):
    """Five faces of a cube of 120 mm on the table, four touches each; it stands anywhere, its faces to one another as stated."""
    rng = np.random.default_rng(2)
    machine = own.draw(rng)
    machine.probe = {}
    lines, nominal, aside = [], own.Five(), rng.normal(size=3) * 0.1
    for a_deg in own.TILTS:
        for c_deg in own.TURNS:
            a, c = np.radians(a_deg), np.radians(c_deg)
            meant, (really, shift) = own.on_table(nominal, a, c)[0], own.on_table(machine, a, c)
            for k, (point, n) in enumerate(np.array(FACES, float), 1):
                if (meant @ n)[2] < -0.1:
                    continue
                across = np.roll(n, 1)
                for u, v in ((-40, -30), (40, -30), (-40, 30), (40, 30)):
                    spot = point + u * across + v * np.cross(n, across)
                    way, normal = -(meant @ n), really @ n
                    start = meant @ (spot + 10 * n)
                    gap = normal @ (start - (really @ (point + aside) + shift)) - own.BALL
                    stopped = start + way * (gap / -(normal @ way) + rng.normal() * own.SCATTER)
                    x, y, z = stopped + way * own.BALL - np.array(own.ZERO)
                    i, j, w = way
                    lines.append(
                        f"TOUCH F{k} I{i:.6f} J{j:.6f} K{w:.6f} X{x:.5f} Y{y:.5f} Z{z:.5f} A{a_deg:g} C{c_deg:g}"
                    )
    tables = "".join(
        f'[touch.features.{k}]\ntype = "plane"\npoint = "{p[0]} {p[1]} {p[2]} mm"\nnormal = {list(map(float, n))}\npart = "block"\n'
        for k, (p, n) in enumerate(FACES, 1)
    )
    (tmp_path / "block.log").write_text("\n".join(lines) + "\n")
    (tmp_path / "machine.toml").write_text(own.MACHINE)
    (tmp_path / "block.toml").write_text(
        'vcmm = "recording/1"\nname = "block"\ndata = "block.log"\nformat = "touches"\nmachine = "machine.toml"\nkind = "probe"\n[noise]\nu = "0.5 um"\n'
        '[instrument]\nname = "touch probe"\nu = { offset = "0.01 um", lobing = "0 um", axial = "0 um" }\n'
        f'[touch]\ntip_diameter = "6 mm"\noffset = "0 0 -150 mm"\nzero = "0 0 250 mm"\n{tables}'
    )
    found = found_from(tmp_path / "block.toml")
    for name, true in machine.place.items():
        _, value, u = found.band(name)
        assert abs(value[0] - true) < 4 * u[0], name
        # spheres 150 mm off the axis told tilts to 0.38 urad; faces 60 mm off: 2.5 times that, and three of five seen at once
        assert u[0] < (0.3e-3 if name[0] in "XYZ" else 1.5e-6), name
