"""Probe and stylus: readings, indicated - true along the outward normal."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.run import Run
from vcmm.physics.catalogue.probe import ProbeLobing, StylusBending, TriggerDelay
from vcmm.physics.structure.tip import TipOffset, TipRadius


def _run(n: int = 1, normal: tuple[float, float, float] = (1.0, 0.0, 0.0), **columns: object) -> Run:
    values = {f"n{c}": np.full(n, normal[i]) for i, c in enumerate("xyz")}
    values |= {k: np.broadcast_to(np.asarray(v, dtype=float), n).copy() for k, v in columns.items()}
    return Run({}, np.zeros((n, 3)), values, {"stylus": np.array(["down"] * n)})


def _along(effect, run: Run) -> np.ndarray:
    """Reading along the normal, mm."""
    return (effect.error_motion(run)[:, :3] * run.normal).sum(axis=1)


def test_lobing_has_three_peaks_per_turn():
    # 0.4 um cos(3 theta): +0.4 at 0, 120, 240 deg, -0.4 at 60, 180, 300 deg
    angle = np.radians([0.0, 120.0, 240.0, 60.0, 180.0, 300.0])
    run = _run(6, probe_angle_rad=angle, probe_lateral=1.0)
    assert _along(ProbeLobing("", 0.4e-3), run) == pytest.approx([0.4e-3] * 3 + [-0.4e-3] * 3, abs=1e-15)
    turn = _run(360, probe_angle_rad=np.radians(np.arange(360.0)), probe_lateral=1.0)
    wave = _along(ProbeLobing("", 0.4e-3), turn)
    peaks = (wave > np.roll(wave, 1)) & (wave > np.roll(wave, -1))
    assert peaks.sum() == 3
    # the sine part peaks 30 deg later: 3 x 30 = 90 deg
    assert _along(ProbeLobing("", 0.0, 0.4e-3), turn).argmax() == 30


def test_lobing_fades_towards_the_pole():
    # lateral share 0.5: half of 0.4 um; 0 along the stylus: nothing
    run = _run(2, probe_angle_rad=0.0, probe_lateral=[0.5, 0.0])
    assert _along(ProbeLobing("", 0.4e-3), run) == pytest.approx([0.2e-3, 0.0], abs=1e-15)


def test_a_larger_ball_makes_shafts_larger():
    # a ball 0.3 um larger than believed touches 0.3 um early on every side: +0.3 um along n everywhere
    for normal in ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.6, 0.8)):
        reading = TipRadius("", 0.3e-3).error_motion(_run(1, normal))[0, :3]
        assert reading == pytest.approx(0.3e-3 * np.array(normal), abs=1e-18)


def test_tip_offset_shifts_all_touches_alike():
    # qualified - actual = (1, 2, 3) um: every point is indicated that far off, whatever n
    for normal in ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0)):
        reading = TipOffset("", np.array([1e-3, 2e-3, 3e-3])).error_motion(_run(1, normal))[0, :3]
        assert reading == pytest.approx([1e-3, 2e-3, 3e-3], abs=1e-18)


def test_bending_grows_with_the_cube_of_the_length():
    # -0.6 um x (length / 50)^3: -0.6 at 50, -4.8 at 100, -0.075 at 25 mm
    run = _run(3, stylus_length_mm=[50.0, 100.0, 25.0], probe_lateral=1.0)
    assert _along(StylusBending("", 0.6e-3), run) == pytest.approx([-0.6e-3, -4.8e-3, -0.075e-3], abs=1e-15)


def test_bending_counts_the_lateral_share_twice():
    # once for the force, once for the projection on n: 0.5^2 x 0.6 = 0.15 um; along the stylus nothing
    run = _run(2, stylus_length_mm=50.0, probe_lateral=[0.5, 0.0])
    assert _along(StylusBending("", 0.6e-3), run) == pytest.approx([-0.15e-3, 0.0], abs=1e-15)


def test_trigger_delay_is_negative_while_approaching():
    # v . n = -5 mm/s, 2 ms late: -10 um: the tip has gone 10 um into the material before it is latched
    run = _run(2, speed_X_mm_s=[-5.0, 5.0], speed_Y_mm_s=3.0, speed_Z_mm_s=0.0)
    assert _along(TriggerDelay("", 2e-3), run) == pytest.approx([-10e-3, 10e-3], abs=1e-15)


@pytest.mark.parametrize("effect", [TipRadius("down", 1e-3), TipRadius("", 1e-3)])
def test_acts_on_its_own_stylus(effect):
    assert _along(effect, _run(1))[0] == pytest.approx(1e-3)


def test_leaves_other_styli_alone():
    assert _along(TipRadius("side", 1e-3), _run(1))[0] == 0.0
    bare = Run({}, np.zeros((1, 3)), _run(1).columns)
    assert _along(TipRadius("down", 1e-3), bare)[0] == 0.0  # a run without styli
