"""The nominal servo: circles that shrink, ovals, lag by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.programs import circle, mill
from vcmm.physics.catalogue.lag import ServoLag
from vcmm.shop.motion.servo import following
from vcmm.shop.motion.toolpath import toolpath

KV = 1000.0 / 60.0  # 1 m/min/mm in 1/s


def steady(path, share: float = 0.1) -> np.ndarray:
    """Rows amid the path, where the speed is steady."""
    s = path.columns["cut_length_mm"]
    return np.flatnonzero(np.abs(s / s.max() - 0.5) < share)


@pytest.mark.parametrize(("gain", "feed", "shrink"), [(2, 3000, 45.0), (5, 3000, 7.2), (5, 1000, 0.8)])
def test_a_circle_shrinks_by_its_servo_lag(gain, feed, shrink):
    """dR = R/2 (v/(R Kv))^2: Kv 2 m/min/mm = 33.3/s, 50 mm/s, R 25: 12.5 (50/833)^2 = 45.0 um; Kv 5: 12.5 (50/2083)^2
    = 7.2 um; F1000: 0.8 um. Exactly R (1 - 1/sqrt(1 + (v/(R Kv))^2)), 44.88 um for the first."""
    machine = mill(gain=gain * KV, acceleration=3000.0, jerk=50_000.0)
    path = toolpath([circle(25.0, float(feed), turns=3)], machine)
    rows = steady(path)
    radius = np.hypot(*(path.tip + path.deviation)[rows, :2].T)
    assert 1e3 * (25.0 - radius) == pytest.approx(shrink, rel=0.004)
    ratio = feed / 60 / (25.0 * gain * KV)
    assert 25.0 - radius == pytest.approx(25.0 * (1 - 1 / math.sqrt(1 + ratio**2)), abs=1e-8)


def test_feed_forward_takes_its_share_squared():
    """(1 - 0.8^2) = 0.36 of 45 um = 16.2 um; with all of it fed forward nothing is left."""
    for share, expected in ((0.8, 16.2), (1.0, 0.0)):
        machine = mill(gain=2 * KV, feed_forward=share, acceleration=3000.0, jerk=50_000.0)
        path = toolpath([circle(25.0, 3000.0, turns=3)], machine)
        radius = np.hypot(*(path.tip + path.deviation)[steady(path), :2].T)
        assert 1e3 * (25.0 - radius) == pytest.approx(expected, abs=0.1)


def unequal(gain_y: float):
    machine = mill(gain=2 * KV, acceleration=3000.0, jerk=50_000.0)
    y = replace(machine.axes["Y"], dynamics={**machine.axes["Y"].dynamics, "gain": gain_y})
    return replace(machine, axes={**machine.axes, "Y": y})


@pytest.mark.parametrize("clockwise", [False, True])
def test_unequal_gains_make_an_oval_at_45_degrees_that_turns_over(clockwise):
    """X lags by 1/Kx, Y by 1/Ky: dr = v/2 (1/Kx - 1/Ky) sin 2 phi counter-clockwise, minus that clockwise.
    Kv 2 and 2.1 m/min/mm, 50 mm/s: 30.000 - 28.571 ms = 1.4286 ms, 35.7 um."""
    path = toolpath([circle(25.0, 3000.0, turns=3, clockwise=clockwise)], unequal(2.1 * KV))
    rows = steady(path, 0.3)
    phi = np.arctan2(path.tip[rows, 1], path.tip[rows, 0])
    radial = np.einsum("ni,ni->n", path.deviation[rows, :2], np.stack([np.cos(phi), np.sin(phi)], axis=1))
    design = np.stack([np.ones(len(phi)), np.sin(2 * phi), np.cos(2 * phi)], axis=1)
    _, sine, cosine = np.linalg.lstsq(design, radial, rcond=None)[0]
    assert 1e3 * sine == pytest.approx(-35.7 if clockwise else 35.7, rel=0.01)
    assert abs(cosine) < 0.1 * abs(sine)


def test_the_effect_servo_lag_is_the_departure_from_the_nominal_gain():
    """The exact filter with 1/Kx longer by 0.1 ms, less the nominal one, at the same point of a circle.

    By hand: with tan phi = v tau / R the axes are abreast of the point at angle t when the command is at t + phi, and
    d/dtau of 1/(tau s + 1) = -s/(tau s + 1)^2 there gives X a departure of 0.1 ms v cos^2 phi sin(t - phi), across the
    path 0.1 ms v cos^2 phi (sin(2t - phi) - sin phi) / 2. The effect says 0.1 ms v sin(2t) / 2: first order in phi too.
    """
    late, tau = 1e-4, 1 / (2 * KV)
    nominal = mill(gain=1 / tau, acceleration=3000.0, jerk=50_000.0)
    x = replace(nominal.axes["X"], dynamics={**nominal.axes["X"].dynamics, "gain": 1 / (tau + late)})
    departed = replace(nominal, axes={**nominal.axes, "X": x})
    moves = [circle(25.0, 3000.0, turns=3)]
    path, other = toolpath(moves, nominal), toolpath(moves, departed)
    rows = steady(path, 0.3)
    effect = nominal.with_effect(ServoLag("X", lag=late)).tip_error(path.run())
    across = path.tip[rows] / 25.0
    exact = np.einsum("ni,ni->n", (other.deviation - path.deviation)[rows], across)
    first = np.einsum("ni,ni->n", effect[rows], across)
    angle, phi = np.arctan2(across[:, 1], across[:, 0]), math.atan(50 / 25 * tau)
    assert first == pytest.approx(late * 50 / 2 * np.sin(2 * angle), abs=1e-8)  # 2.5 um
    by_hand = late * 50 / 2 * math.cos(phi) ** 2 * (np.sin(2 * angle - phi) - math.sin(phi))
    assert exact == pytest.approx(by_hand, abs=1e-2 * 2.5e-3)  # second order in 0.1 ms of 30 ms: 0.3 %
    assert (
        np.abs(exact - first).max() < 2.02 * phi * 2.5e-3
    )  # 12 % at F3000: the order that the effect leaves out


def test_lag_of_a_ramp_by_hand():
    """x = v t from rest, lag tau: e = tau v (1 - exp(-t/tau)); 10 mm/s, 20 ms: 0.2 mm, at 20 ms 0.12642 mm."""
    time = np.array([0.0, 0.02, 0.1, 1.0])
    speed = np.tile([10.0, 0, 0], (4, 1))
    begins = np.array([True, False, False, False])
    f = following(time, begins, speed, np.zeros((4, 3)), np.array([0.02, 0.0, 0.02]))
    assert f.error[:, 0] == pytest.approx(0.2 * (1 - np.exp(-time / 0.02)), abs=1e-12)
    assert f.error[1, 0] == pytest.approx(0.126424, abs=1e-6)
    assert not f.error[:, 1:].any()


def test_lag_of_a_cubic_speed_is_exact_however_it_is_divided():
    time = np.linspace(0, 0.3, 301)
    v = 5 + 20 * time - 300 * time**2 + 800 * time**3
    a = 20 - 600 * time + 2400 * time**2
    errors = []
    for every in (1, 60, 300):
        t = time[::every]
        columns = [np.stack([x[::every]] * 3, axis=1) for x in (v, a)]
        begins = np.arange(len(t)) == 0
        errors.append(following(t, begins, columns[0], columns[1], np.array([0.01, 0.03, 0.2])).error[-1])
    assert errors[1] == pytest.approx(errors[0], abs=1e-10)
    assert errors[2] == pytest.approx(errors[0], abs=1e-10)
