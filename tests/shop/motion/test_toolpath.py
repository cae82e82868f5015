"""The toolpath as a Run: rows, labels, columns, cycle time."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.programs import AT, circle, corner, line, mill
from vcmm.core.errors import UsageError
from vcmm.files.own.machine import load_machine
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.program.limits import Control
from vcmm.program.moves import Move
from vcmm.shop.motion.toolpath import clock, naive_seconds, summary, toolpath

KV = 1000.0 / 60.0  # 1 m/min/mm in 1/s


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
    assert path.seconds_by("mode")["tool change"] == pytest.approx(4.0)  # 1 -> 2 -> 1, 2 s each: no dwell
    assert "dwell" not in path.seconds_by("mode")
    assert sum(path.seconds_by("tool").values()) == pytest.approx(path.seconds)


def test_a_tool_change_is_no_dwell_and_the_first_tool_none():
    """Tool 1 from the beginning, one change of 5 s to tool 2, a dwell of 2 s: 5 s of tool change and 2 s of dwell."""
    moves = [
        line((0, 0, 0), (100, 0, 0), tool=1),
        line((100, 0, 0), (50, 0, 0), tool=2),
        Move("dwell", AT, (50, 0, 0), (50, 0, 0), seconds=2.0, tool=2),
        line((50, 0, 0), (0, 0, 0), tool=2),
    ]
    path = toolpath(moves, mill(), control=Control(tool_change=5.0))
    times = path.seconds_by("mode")
    assert (times["tool change"], times["dwell"]) == (pytest.approx(5.0), pytest.approx(2.0))
    assert sum(times.values()) == pytest.approx(path.seconds)
    assert any("tool 1 is in the spindle when the program begins" in text for text in path.assumptions)
    bare = toolpath([line((0, 0, 0), (100, 0, 0)), *moves[1:]], mill(), control=Control(tool_change=5.0))
    assert not any("is in the spindle" in text for text in bare.assumptions)  # no tool before the first move


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
