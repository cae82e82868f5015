"""The conventions of error curves: mean and line over the travel, by hand, and a squareness that no choice of nodes moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.calibration.drawn import STRUCTURE, TRAVEL, bare, draw, laser_and_plates, recorded
from vcmm.core.axes import is_rotary
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.calibration.job import bare_machine, calibrate
from vcmm.learn.calibration.model import Curve, error_model
from vcmm.learn.calibration.readings import readings
from vcmm.learn.calibration.solve import solve

PLANE = ("EXX", "EYX", "EXY", "EYY", "C0Y")


def test_mean_and_line_over_the_travel_by_hand():
    # a triangle with its top at 25 of 100 mm: area 50, so the mean is 1/2; its centroid is at (0 + 25 + 100) / 3 = 41.67 mm, its
    # moment about the middle 50 * (41.67 - 50) = -416.67, over 100^3 / 12 a slope of -0.005 per mm
    table = Curve("EYX", np.array([0.0, 25.0, 100.0]), kind="table")
    assert table.share @ [0.0, 1.0, 0.0] == pytest.approx([0.5, -0.005], abs=1e-12)
    # what the convention leaves: the triangle less 0.5 - 0.005 (x - 50)
    assert table.projector @ [0.0, 1.0, 0.0] == pytest.approx([-0.75, 0.375, -0.25], abs=1e-12)
    # 1, 0, 1 at 0, 10 and 100 mm: 0.5 everywhere, over the nodes it would be 2/3
    assert Curve("EXX", np.array([0.0, 10.0, 100.0]), kind="table").share @ [1.0, 0.0, 1.0] == pytest.approx(
        [0.5]
    )


@pytest.mark.parametrize("kind", ["spline", "table"])
@pytest.mark.parametrize("component", ["EYX", "EXX", "EAX", "EXC", "EAC"])
def test_what_is_taken_is_a_mean_or_a_line_of_the_curve_as_it_runs(component, kind):
    """Against a sum over 20000 places, also where the nodes are not equally spaced and of a rotary axis that turns in part."""
    end = 2.0 if is_rotary(component[-1]) else 600.0
    curve = Curve(
        component, end * np.array([0.0, 0.03, 0.2, 0.4, 0.7, 1.0]), is_centred=component == "EXC", kind=kind
    )
    values = np.array([3.0, -1.0, 4.0, 1.0, -5.0, 9.0])
    q = end * (np.arange(20000) + 0.5) / 20000
    left = curve.weights(q) @ curve.projector @ values
    columns = [
        np.ones(len(q)),
        *([q] if curve.straightness else []),
        *([np.cos(q), np.sin(q)] if curve.is_centred else []),
    ]
    assert np.abs([float(c @ left) / len(q) / np.abs(c).max() for c in columns]).max() < 1e-3
    assert curve.share @ curve.free == pytest.approx(0, abs=1e-12)
    assert curve.free @ (curve.coordinates @ curve.free) == pytest.approx(curve.free, abs=1e-12)


@pytest.fixture(scope="module")
def plane():
    """Straightness and lengths of X and Y by laser, and a plate in XY, of a machine that five nodes describe poorly."""
    machine = draw(np.random.default_rng(4), length=180.0)
    known = [e for e in machine.effects if e.where in PLANE]
    wanted = [r for r in laser_and_plates(bare()) if r.name in PLANE or r.name == "plate 1"]
    return recorded(replace(machine, effects=tuple(known)), wanted, np.random.default_rng(5))


def test_squareness_is_that_of_the_travel_whatever_the_nodes(plane):
    assert len(plane) == 5
    found = {}
    for nodes in (5, 9, 17, 33):
        model = error_model({a: TRAVEL[a] for a in "XY"}, nodes, PLANE)
        post = solve([readings(r, bare(), model) for r in plane], model)
        here = model.slices["C0Y"]
        found[nodes] = float(post.theta[here][0]), float(np.sqrt(post.covariance[here, here][0, 0]))
    angle, u = found.pop(33)
    assert u < 1e-6
    away = [abs(v - angle) / u for v, _ in found.values()]  # by the line over the nodes: 2.4, 1.6 and 0.6 u
    assert np.all(np.array(away) < [0.5, 0.1, 0.1]), away
    assert [w for _, w in found.values()] == pytest.approx([u] * 3, rel=0.05)


def test_squareness_is_the_same_for_other_orders_and_units(plane, tmp_path):
    angle, u = _squareness(plane)
    mixed = [r.take(np.random.default_rng(k).permutation(r.m)) for k, r in enumerate(plane)]
    again, u_again = _squareness(mixed[::-1])
    assert again == pytest.approx(angle, abs=1e-3 * u)
    assert u_again == pytest.approx(u, rel=1e-3)
    stored = []
    for one in plane:
        path = tmp_path / f"{one.name}.toml"
        save_recording(one, path, "unused.toml")
        text = (
            path.read_text()
            .replace('"0.0002 mm"', '"200 nm"')
            .replace('"0.0003 mm"', '"0.3 um"')
            .replace('"0.0004 mm"', '"4e-7 m"')
        )
        assert text != path.read_text()
        path.write_text(text)
        stored.append(load_recording(path, bare_machine(STRUCTURE))[0])
    assert _squareness(stored)[0] == pytest.approx(angle, abs=1e-2 * u)


def _squareness(recordings) -> tuple[float, float]:
    found = calibrate(recordings, bare(), only=PLANE)
    _, value, u = found.band("C0Y")
    return float(value[0]), float(u[0])
