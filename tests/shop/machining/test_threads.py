"""Threads of a lathe, by hand."""

from __future__ import annotations

import math

import pytest

import vcmm
from tests.shop.machining import lathe
from tests.shop.machining.lathe import plain
from vcmm.shop.machining.job import cut
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.threads import last_passes, threads_of

THREAD = lathe.PLAIN + "G0 X44. Z2.\nX39.\nG32 Z-18. F1.5\nG0 X44.\nZ2.\nX38.8\nG32 Z-18. F1.5\nG0 X44.\n"
LONG = lathe.effect("scale_factor", axis="Z", k="100 um/m")
OUT = lathe.effect("squareness", pair="B0Z", angle="50 urad")
KNOWN = '[[inputs]]\neffect = "scale_factor"\naxis = "Z"\nparameter = "k"\nu = "10 um/m"\n'
SCATTER = '[repeatability]\nlaw = "normal"\nu = "0.5 um"\n'


def one(folder, machine: str):
    (found,) = threads_of(set_up(vcmm.load_cut(plain(folder, machine, program=THREAD))))
    return found


def test_a_long_scale_makes_a_long_thread(tmp_path):
    # 20 mm at 100 um/m: 2.0 um +- 2 x 0.2 um; a go gauge feels 2.0 / tan 30 deg = 3.46 um
    thread = one(tmp_path, LONG + KNOWN)
    assert (thread.lead_mm, thread.length_mm, thread.after_mm) == pytest.approx((1.5, 20.0, 20.0))
    assert thread.pitch_um == pytest.approx(2.0, abs=1e-3)  # towards -Z, and longer
    assert thread.pitch_U_um == pytest.approx(0.4, abs=1e-3)
    assert thread.gauge_um == pytest.approx(2.0 / math.tan(math.radians(30.0)), abs=2e-3)
    assert thread.diameter_um == pytest.approx(0.0, abs=1e-6)


def test_a_slide_out_of_parallel_changes_the_diameter(tmp_path):
    # the trial cut was at the zero, Z 200 of the machine; the middle of the thread lies 8 mm before it: 2 x 8 x 50e-6 = 0.8 um
    thread = one(tmp_path, OUT)
    assert abs(thread.diameter_um) == pytest.approx(0.8, abs=1e-2)
    assert thread.pitch_um == pytest.approx(0.0, abs=1e-2)


def test_the_scatter_of_a_pass_is_in_the_diameter_and_not_in_the_pitch(tmp_path):
    # one draw for the pass: U of the diameter 2 x 2 x 0.5 um; the pitch moves as a whole
    thread = one(tmp_path, SCATTER)
    assert thread.diameter_U_um == pytest.approx(2.0, abs=1e-6)
    assert thread.pitch_U_um == pytest.approx(0.0, abs=1e-9)


def test_a_tool_that_bends_and_rapids_out_of_the_groove(tmp_path):
    """No force is computed of a thread; the ways out of it run where it was cut, although it is left out of the bar."""
    bends = lathe.effect("tool_deflection", compliance="0.05 um/N")
    setup = lathe.SETUP + lathe.BAR
    result = cut(vcmm.load_cut(plain(tmp_path, LONG + bends, program=THREAD, setup=setup)), trials=1000)
    assert result.threads[0].diameter_um == pytest.approx(0.0, abs=1e-6)
    assert result.blank.collisions == ()


def test_the_last_of_the_passes_is_the_thread(tmp_path):
    moves = set_up(vcmm.load_cut(plain(tmp_path, program=THREAD))).program.moves
    assert [moves[k].start[0] * 2 for k in last_passes(moves)] == pytest.approx([38.8])


def test_threads_stand_in_the_result(tmp_path):
    result = cut(vcmm.load_cut(plain(tmp_path, LONG, program=THREAD)), trials=1000)
    assert [t.line for t in result.threads] == [result.threads[0].line]
    assert cut(vcmm.load_cut(plain(tmp_path)), trials=1000).threads == ()
