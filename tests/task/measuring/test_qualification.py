"""Simulated qualification: covariance by an independent least squares, what is systematic cancels."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.effect import basis
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal, StudentT
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.part.part import Feature
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.probe import ProbeLobing, StylusBending, TriggerDelay
from vcmm.physics.structure.scatter import Scatter
from vcmm.physics.structure.tip import TipRadius
from vcmm.task.measuring.plan import Plan, Step, Stylus, Touch
from vcmm.task.measuring.qualification import Qualification, qualified_machine
from vcmm.task.measuring.strategies import Iso10360, plan_points

DOWN = Stylus("down", np.array([0.0, 0.0, -100.0]), 2.0, 100.0)
NORMAL = np.array([[0.0, 0.0, 1.0]])
PLAN = Plan((Step("a", "down", np.zeros((1, 3)), NORMAL),), {"down": DOWN}, Touch(speed=5.0))


SIDE = Stylus("side", np.array([0.0, 80.0, -60.0]), 1.0, 60.0)
BOTH = Plan(PLAN.steps, {"down": DOWN, "side": SIDE}, PLAN.touch)


def qualify(machine: Machine, plan: Plan, how: Qualification):
    """The qualified machine and the only Input that qualification leaves (None where nothing is uncertain)."""
    out, inputs = qualified_machine(machine, plan, {"down": how})
    assert len(inputs) <= 1
    return out, inputs[0] if inputs else None


def _normals() -> np.ndarray:
    ball = Feature("ball", "sphere", np.zeros(3), np.zeros(3), np.array([12.5]))
    return plan_points(ball, Iso10360(pole=(0.0, 0.0, 1.0)))[1]


def _scatter(law) -> dict:
    return {"inputs": (Input("scatter", "", "value", law, "touch"),)}


def test_scatter_becomes_the_covariance_of_a_sphere_fit():
    # readings delta_i = c . n_i + r + noise: cov(c, r) = s^2 (A^T A)^-1 with A = [n 1], 25 touches of ISO 10360-5
    _, known = qualify(machine(Scatter(), **_scatter(Normal(1e-3))), PLAN, Qualification())
    a = np.column_stack([_normals(), np.ones(25)])
    assert known.law.covariance == pytest.approx(1e-6 * np.linalg.inv(a.T @ a), rel=1e-6, abs=1e-13)
    assert (known.id, known.redraw) == ("stylus_qualification[down].d by repeatability", "stylus")


def test_offset_and_radius_are_correlated():
    # touches on one half only: a ball that seems larger seems lower
    _, known = qualify(machine(Scatter(), **_scatter(Normal(1e-3))), PLAN, Qualification())
    c = known.law.covariance
    correlation = c[2, 3] / np.sqrt(c[2, 2] * c[3, 3])
    assert correlation < -0.5
    assert c[0, 3] == pytest.approx(0.0, abs=1e-12)


def test_the_calibration_of_the_sphere_counts_by_its_radius():
    # u(diameter) = 0.2 um: u(radius) = 0.1 um, nothing in the offset
    _, known = qualify(machine(), PLAN, Qualification(25.0, 0.2e-3))
    assert known.law.u == pytest.approx([0.0, 0.0, 0.0, 0.1e-3], abs=1e-12)


def test_form_of_the_sphere_is_uniform_over_its_range():
    # form 0.6 um peak to valley: as a scatter of 0.6 / sqrt(12) = 0.173 um per touch
    _, form = qualify(machine(), PLAN, Qualification(form=0.6e-3))
    _, same = qualify(machine(Scatter(), **_scatter(Normal(0.6e-3 / np.sqrt(12)))), PLAN, Qualification())
    assert form.law.covariance == pytest.approx(same.law.covariance, rel=1e-9, abs=1e-16)


def _left(effect, speed: float = 5.0) -> np.ndarray:
    """Reading along n at the 25 touches of the qualification, after qualification, mm."""
    qualified, _ = qualify(machine(effect), PLAN, Qualification())
    normals = _normals()
    columns = {f"n{c}": normals[:, i] for i, c in enumerate("xyz")}
    columns |= {f"speed_{a}_mm_s": -speed * normals[:, i] for i, a in enumerate("XYZ")}
    columns |= {
        "probe_angle_rad": np.arctan2(normals[:, 1], normals[:, 0]),
        "stylus_length_mm": np.full(25, DOWN.length),
        "probe_lateral": np.hypot(normals[:, 0], normals[:, 1]),
    }
    position = {a: np.zeros(25) for a in "XYZ"}
    run = Run(position, np.zeros((25, 3)), columns, {"stylus": np.array(["down"] * 25)})
    return (qualified.reading(run) * normals).sum(axis=1)


def test_a_constant_delay_is_qualified_away():
    # 2 ms at 5 mm/s: every touch reads -10 um, and the qualified radius is 10 um too small: nothing is left.
    # Measured at 8 mm/s: -16 um + 10 um = -6 um is left on every touch
    assert _left(TriggerDelay("", 2e-3)) == pytest.approx(0.0, abs=1e-9)
    assert _left(TriggerDelay("", 2e-3), speed=8.0) == pytest.approx(-6e-3, abs=1e-9)


def test_what_looks_like_no_ball_is_left():
    # bending follows the lateral share squared, a sphere fit takes its mean and its slope along the stylus
    effect = StylusBending("", 0.6e-3)
    left = _left(effect)
    assert np.abs(left).max() > 0.1e-3
    assert left.mean() == pytest.approx(0.0, abs=1e-9)
    assert (left @ _normals()) == pytest.approx(np.zeros(3), abs=1e-9)


def test_three_lobes_are_left_almost_whole():
    left = _left(ProbeLobing("", 0.4e-3))
    assert np.abs(left).max() > 0.3e-3


def test_only_the_named_stylus_is_qualified():
    # both styli read -10 um; "down" is qualified and reads 0, "side" keeps its -10 um
    qualified, _ = qualified_machine(machine(TriggerDelay("", 2e-3)), BOTH, {"down": Qualification()})
    columns = {"nx": np.ones(2), "ny": np.zeros(2), "nz": np.zeros(2), "speed_X_mm_s": np.full(2, -5.0)}
    columns |= {"speed_Y_mm_s": np.zeros(2), "speed_Z_mm_s": np.zeros(2)}
    run = Run(
        {a: np.zeros(2) for a in "XYZ"}, np.zeros((2, 3)), columns, {"stylus": np.array(["down", "side"])}
    )
    assert qualified.reading(run)[:, 0] == pytest.approx([0.0, -10e-3], abs=1e-9)


def test_other_effects_do_not_take_part():
    plain = machine(Backlash("X", 1.0), TipRadius("", 1e-3))
    qualified, known = qualify(plain, PLAN, Qualification())
    assert known is None
    columns = {"nx": np.ones(1), "ny": np.zeros(1), "nz": np.zeros(1)}
    run = Run({a: np.zeros(1) for a in "XYZ"}, np.zeros((1, 3)), columns, {"stylus": np.array(["down"])})
    assert qualified.reading(run)[0] == pytest.approx([1e-3, 0.0, 0.0])


def test_styli_on_one_sphere_share_its_diameter():
    # u(diameter) = 0.2 um: one Input for both, 0.1 um in the radius; scatter is each stylus's own
    how = Qualification(25.0, 0.2e-3)
    _, inputs = qualified_machine(
        machine(Scatter(), **_scatter(Normal(1e-3))), BOTH, {"down": how, "side": how}
    )
    shared = [i for i in inputs if i.where == "down,side"]
    assert len(inputs) == 3
    assert len(shared) == 1
    assert shared[0].redraw == "machine"
    assert shared[0].law.u == pytest.approx([0.0, 0.0, 0.0, 0.1e-3], abs=1e-12)
    assert {i.redraw for i in inputs if i.where != "down,side"} == {"stylus"}


def test_a_third_stylus_on_its_own_sphere_does_not_part_the_others():
    far = Stylus("far", np.array([0.0, 50.0, -100.0]), 2.0, 100.0)
    three = Plan(BOTH.steps, {**BOTH.styli, "far": far}, BOTH.touch)
    one, two = Qualification(25.0, 1e-3), Qualification(30.0, 1e-3)
    found, inputs = qualified_machine(machine(), three, {"down": one, "side": one, "far": two})
    assert [i.where for i in inputs] == ["far", "down,side"]
    shared = next(e for e in found.effects if e.where == "down,side")
    columns = {"nx": np.ones(3), "ny": np.zeros(3), "nz": np.zeros(3)}
    run = Run({}, np.zeros((3, 3)), columns, {"stylus": np.array(["down", "far", "side"])})
    # the common diameter acts on the first and the third touch only
    assert basis(shared, "d", run)[:, 0, 3].tolist() == [1.0, 0.0, 1.0]


def test_styli_on_two_spheres_are_independent():
    how = {"down": Qualification(25.0, 0.2e-3), "side": Qualification(20.0, 0.2e-3)}
    _, inputs = qualified_machine(machine(), BOTH, how)
    assert [i.where for i in inputs] == ["down", "side"]
    assert all(i.law.u[3] == pytest.approx(0.1e-3) for i in inputs)


@pytest.mark.parametrize("dof", [1.0, 2.0])
def test_a_scatter_without_variance_cannot_qualify(dof):
    with pytest.raises(UsageError, match="infinite variance"):
        qualify(machine(Scatter(), **_scatter(StudentT(1e-3, dof))), PLAN, Qualification())
