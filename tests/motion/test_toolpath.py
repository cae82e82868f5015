"""Toolpath: rows that do not depend on their density, frames, history, the nominal servo and its departure."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.programs import AT, circle, corner, line, mill, random_moves
from vcmm.core.errors import UsageError
from vcmm.effects.backlash import Backlash
from vcmm.effects.lag import ServoLag
from vcmm.files.machine import load_machine
from vcmm.motion.servo import following
from vcmm.motion.toolpath import clock, naive_seconds, summary, toolpath
from vcmm.nc.limits import Control
from vcmm.nc.moves import Move

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


@pytest.mark.parametrize("seed", range(4))
def test_rows_do_not_depend_on_their_density(seed):
    """Columns at the same place and time are equal, sampled coarsely or finely; time increases."""
    moves, machine = random_moves(np.random.default_rng(seed), 60), mill(gain=40.0)
    coarse = toolpath(moves, machine, plays=(0.005,))
    fine = toolpath(moves, machine, step=0.1, chord=1e-4, plays=(0.005,))
    assert fine.n > 2 * coarse.n
    assert (np.diff(coarse.time) > 0).all()
    near = np.clip(np.searchsorted(fine.time, coarse.time - 2e-9), 0, fine.n - 1)
    same = np.abs(fine.time[near] - coarse.time) < 4e-9
    assert same.sum() > 100
    for name, column in coarse.columns.items():
        if name == "time_since_accel_s":  # resolved to the spacing of the rows
            continue
        scale = max(1.0, np.abs(column).max())
        assert np.abs(column[same] - fine.columns[name][near[same]]).max() < 1e-6 * scale, name
    for name, label in coarse.labels.items():
        assert (label[same] == fine.labels[name][near[same]]).all(), name


def test_chord_and_step_are_kept():
    path = toolpath([circle(25.0, 3000.0)], mill(), step=50.0, chord=1e-3)
    angle = np.unwrap(np.arctan2(path.tip[:, 1], path.tip[:, 0]))
    assert (25.0 * (1 - np.cos(np.diff(angle) / 2))).max() <= 1e-3 * 1.001
    assert np.diff(toolpath([line((0, 0, 0), (10, 0, 0))], mill(), step=0.5).tip[:, 0]).max() <= 0.5 + 1e-9


def test_reversals_stand_in_the_rows():
    """A circle turns X back at 0 and 180 deg, Y at 90 and 270 deg: rows are there, and distances count from them."""
    path = toolpath([circle(25.0, 3000.0)], mill(), step=7.0, chord=1.0)
    for i, places in ((0, (-25.0,)), (1, (25.0, -25.0))):
        for place in places:
            assert np.abs(path.tip[:, i] - place).min() < 1e-9
    end = path.run().column("since_reversal_Y_mm")[-1]
    assert end == pytest.approx(25.0, abs=1e-9)
    assert path.run().column("travel_X_mm")[-1] == pytest.approx(100.0, abs=1e-9)


def test_nominal_tip_is_the_tool_tip_on_primed_axes():
    """Tool of 80 mm: Z stands 80 mm above the tip, the Run takes it off again; X' and Y' are tool-relative."""
    moves = [line((1, 2, 3), (11, 2, 3), tool=4, tool_offset=(0.0, 0.0, 80.0))]
    path, machine = toolpath(moves, mill()), mill()
    run = machine.prepare(path.run())
    assert path.axes["Z"] == pytest.approx(83.0)
    assert run.tip[[0, -1]] == pytest.approx(np.array([[1, 2, 3], [11, 2, 3]]), abs=1e-12)
    assert run.tip == pytest.approx(path.tip, abs=1e-12)


def test_effects_accept_the_run():
    """X forward, then back: half a gap of 10 um short of the target, on the side it came from."""
    moves = [line((0, 0, 0), (10, 0, 0)), line((10, 0, 0), (0, 0, 0))]
    path = toolpath(moves, mill())
    error = mill().with_effect(Backlash("X", gap=0.010)).tip_error(path.run())
    out, back = path.move == 0, path.move == 1
    assert error[out, 0][1:] == pytest.approx(-0.005)
    assert error[back, 0][1:] == pytest.approx(0.005)


def test_followed_moves_the_positions():
    path = toolpath([circle(25.0, 3000.0)], mill(gain=2 * KV))
    shift = path.run(followed=True).q("X") - path.run().q("X")
    assert shift == pytest.approx(path.deviation[:, 0])
    assert np.abs(shift).max() > 0.01
    assert path.run().column("follow_x_mm") == pytest.approx(path.deviation[:, 0])


def test_spindle_tool_and_cut_length():
    """600 rpm = 10 turns/s for 1.2 s of the first line: 24 pi rad; 100 mm cut by tool 1, then tool 2 starts at 0."""
    moves = [
        line((0, 0, 0), (100, 0, 0), spindle=600.0, tool=1),
        Move("rapid", AT, (100, 0, 0), (100, 0, 5), spindle=600.0, tool=1),
        line((100, 0, 5), (90, 0, 5), tool=2),
        line((90, 0, 5), (80, 0, 5), tool=1),
    ]
    path = toolpath(moves, mill(), control=Control(tool_change=2.0))
    end = np.flatnonzero(path.move == 0)[-1]
    assert path.columns["spindle_angle_rad"][end] == pytest.approx(24 * math.pi, rel=1e-9)
    on = path.columns["spindle_on_s"]
    assert on[end] == pytest.approx(1.2)
    assert on[path.labels["tool"] == "2"] == pytest.approx(0.0)
    cut, tool = path.columns["cut_length_mm"], path.columns["tool_number"]
    assert cut[tool == 2].max() == pytest.approx(10.0)
    assert cut[-1] == pytest.approx(110.0)
    assert cut[path.move == 1] == pytest.approx(100.0)
    assert path.labels["event"][[0, -1]].tolist() == ["tool call 1", "tool call 3"]
    assert path.seconds_by("mode")["dwell"] == pytest.approx(4.0)
    assert sum(path.seconds_by("tool").values()) == pytest.approx(path.seconds)


def test_summary_says_what_was_assumed():
    path = toolpath(corner(), mill())
    text = summary(path)
    assert f"cycle time {path.seconds:.1f} s" in text
    assert "assumed: control: corners are rounded within 10 um (not stated)" in text
    stated = toolpath(corner(), mill(), control=Control(0.02, stated=("tolerance",)))
    assert "corners are rounded" not in summary(stated)
    assert naive_seconds(path.timing) == pytest.approx(2.0)  # 100 mm at 50 mm/s
    assert clock(3725.4) == "1:02:05"


def test_pauses_alone_and_wrong_calls():
    dwell = Move("dwell", AT, (0, 0, 0), (0, 0, 0), seconds=3.0)
    assert toolpath([dwell], mill()).seconds == 3.0
    assert toolpath([], mill()).n == 0
    with pytest.raises(UsageError, match="step = 0"):
        toolpath([dwell], mill(), step=0.0)
    with pytest.raises(UsageError, match="allowed are"):
        toolpath([dwell], mill()).seconds_by("axis")


def test_dynamics_of_rotary_axes_in_files(tmp_path):
    """20 rpm = 2 pi 20/60 = 2.0944 rad/s; a linear unit on a rotary axis is refused with its line."""
    text = 'vcmm = "machine/1"\nkind = "machine-tool"\nstructure = "w C\' b Z t"\n[axes.Z]\ntravel = ["0 mm", "1 m"]\n'
    text += 'dynamics = { speed = "30 m/min", gain = "2 m/min/mm", feed_forward = 0.9 }\n'
    text += (
        '[axes.C]\ntravel = ["-360 deg", "360 deg"]\ndynamics = { speed = "SPEED", jerk = "50 rad/s^3" }\n'
    )
    path = tmp_path / "m.toml"
    path.write_text(text.replace("SPEED", "20 rpm"))
    machine = load_machine(path)
    assert machine.axes["C"].dynamics == pytest.approx({"speed": 2 * math.pi / 3, "jerk": 50.0})
    assert machine.axes["Z"].dynamics == pytest.approx({"speed": 500.0, "gain": 2 * KV, "feed_forward": 0.9})
    path.write_text(text.replace("SPEED", "20 mm/s"))
    with pytest.raises(Exception, match=r'dynamics\.speed of axis C = "20 mm/s" is not an angular speed'):
        load_machine(path)
    path.write_text(text.replace("SPEED", "20"))
    with pytest.raises(Exception, match=r'speed = "20" has no unit'):
        load_machine(path)
