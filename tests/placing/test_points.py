"""Choice of points: textbook designs by hand, the closed form against other routes, standards not better, files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.build import DIAMETER
from tests.build import scenario as job
from tests.plate import edited
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.files.scenario import load_scenario
from vcmm.fit import gauss
from vcmm.measuring.plan import Plan, Step, Stylus
from vcmm.measuring.strategies import Around, Levels, plan_points
from vcmm.part.form import Lobes
from vcmm.part.part import Feature
from vcmm.placing.candidates import nearest, problem_of, spots
from vcmm.placing.design import Candidates, Design, Target, exchanged, least
from vcmm.placing.formfield import form_factor, surface_grid
from vcmm.placing.motions import motions_of, outputs
from vcmm.placing.order import Visit, ordered, ways
from vcmm.placing.planfiles import plan_files, plan_json
from vcmm.placing.planning import optimise_plan

Z = np.array([0.0, 0.0, 1.0])
PLANE = Feature("top", "plane", np.zeros(3), Z, np.zeros(0), extent=(80.0, 80.0))
CIRCLE = Feature("ring", "circle", np.zeros(3), Z, np.array([10.0]))


def candidates(feature, points, shared=None, touch=1e-3, short=0.0) -> Candidates:
    """One feature with plain scatter."""
    from vcmm.part.part import normal

    n = len(points)
    normals = normal(feature, points)
    rows = motions_of(feature).rows(points, normals)
    a = np.zeros((n, 0)) if shared is None else shared
    whole = np.zeros(n, dtype=int)
    return Candidates(
        (feature.name,), whole, points, normals, (rows,), a, np.full(n, touch), np.full(n, short), np.ones(1)
    )


def on_plane(*xy):
    return np.array([[x, y, 0.0] for x, y in xy])


def test_plane_by_hand():
    """Height at the centroid: sigma / sqrt(n). Tilt about y: sigma / sqrt(sum x^2)."""
    points = on_plane((-30, -30), (30, -30), (-30, 30), (30, 30))
    c = candidates(PLANE, points)
    rows = np.array([[1.0, 0, 0], [0, 0, 1.0]])  # height; tilt about v
    design = Design(c, Target(rows, np.ones(2)), np.ones(4, dtype=int))
    u = np.sqrt(design.variances())
    assert u[0] == pytest.approx(1e-3 / 2.0)  # 1 um / sqrt(4)
    assert u[1] == pytest.approx(1e-3 / 60.0)  # sum x^2 = 4 x 900 mm^2


def test_tilt_wants_the_ends():
    """c-optimal for the tilt about v: all touches at the two edges x = +-40, as far apart as they can be."""
    c = candidates(PLANE, surface_grid(PLANE, 9))
    design = Design(c, Target(np.array([[0.0, 0, 1.0]]), np.ones(1)), least(c, 5))
    exchanged(design, passes=10)
    used = c.points[design.counts > 0]
    assert np.allclose(np.abs(used[:, 0]), 40.0)
    # u = sigma / sqrt(8 x 1600) = 1 um / 113.137 mm
    assert np.sqrt(design.variances()[0]) == pytest.approx(1e-3 / np.sqrt(8 * 1600.0))


def white_noise_bound(
    rows: np.ndarray, outputs: np.ndarray, weight: np.ndarray, steps: int = 2000
) -> tuple[float, np.ndarray]:
    """No n touches with independent scatter sigma do better than bound sigma^2 / n; also the shares (N,) of the best.

    For psi(x) = sum weight b^T M(x)^-1 b over shares x (convex), psi(best) >= 2 psi(x) - max_j sum weight (b^T M^-1 J_j)^2.
    Multiplicative gradient steps: Silvey, Titterington & Torsney, Commun. Stat. A7 (1978) 1379.
    """
    share = np.full(len(rows), 1.0 / len(rows))
    bound = 0.0
    for _ in range(steps):
        read = np.linalg.solve((rows.T * share) @ rows, outputs.T).T @ rows.T
        slope = weight @ read**2
        psi = float(share @ slope)
        bound = max(bound, 2.0 * psi - float(slope.max()))
        share = share * np.sqrt(slope / psi)
        share /= share.sum()
        if psi - bound < 1e-6 * psi:
            break
    return bound, share


def test_no_design_beats_the_bound_and_the_exchange_reaches_it():
    c = candidates(PLANE, surface_grid(PLANE, 9))
    rows, weight = np.array([[0.0, 0, 1.0], [0, 1.0, 0]]), np.ones(2)
    bound, share = white_noise_bound(c.rows[0], rows, weight)
    # both tilts: the four corners, 1/1600 each
    assert bound == pytest.approx(2.0 / 1600.0, rel=1e-3)
    assert share.sum() == pytest.approx(1.0)
    design = exchanged(Design(c, Target(rows, weight), least(c, 5)), passes=10)
    assert design.value() >= bound * 1e-6 / design.n * (1 - 1e-9)
    assert design.value() <= 1.001 * bound * 1e-6 / design.n


def test_d_optimal_plane_is_the_corners():
    c = candidates(PLANE, surface_grid(PLANE, 9))
    design = exchanged(Design(c, Target(np.zeros((0, 3)), np.zeros(0), "D"), least(c, 1)), passes=10)
    used = c.points[design.counts > 0]
    assert np.allclose(np.abs(used[:, :2]), 40.0)
    # det = 4 x (4 x 1600)^2
    assert design.log_det == pytest.approx(np.log(4 * 6400.0**2))


def lobed(n: int, lobes: int) -> float:
    """u of the diameter (mm) from n equally spaced touches, form of 1 um amplitude and unknown phase, no scatter."""
    points = plan_points(CIRCLE, Around(n))[0]
    reference = surface_grid(CIRCLE, 96)
    there = (reference, reference / 10.0)
    shared, _ = form_factor(motions_of(CIRCLE), points, 0.0, Lobes(lobes, 1e-3), there)
    c = candidates(CIRCLE, points, shared, touch=0.0)
    return float(
        np.sqrt(Design(c, Target(np.array([[0, 0, 2.0]]), np.ones(1)), np.ones(n, dtype=int)).variances()[0])
    )


def test_three_touches_take_three_lobes_for_diameter():
    # three equally spaced touches all see cos(3 theta - phase): radius off by 1 um cos(phase): u_d = 2 x 1 um / sqrt 2
    assert lobed(3, 3) == pytest.approx(2e-3 / np.sqrt(2.0))
    assert lobed(4, 3) == pytest.approx(0.0, abs=1e-12)
    assert lobed(4, 4) == pytest.approx(2e-3 / np.sqrt(2.0))
    assert lobed(5, 3) == pytest.approx(0.0, abs=1e-12)


def test_the_exchange_leaves_the_aliased_three():
    points = plan_points(CIRCLE, Around(24))[0]
    shared, _ = form_factor(motions_of(CIRCLE), points, 0.0, Lobes(3, 1e-3), (points, points / 10.0))
    c = candidates(CIRCLE, points, shared, touch=1e-4)
    counts = np.zeros(24, dtype=int)
    counts[[0, 8, 16]] = 1
    counts[0] = 2
    design = Design(c, Target(np.array([[0, 0, 2.0]]), np.ones(1)), counts)
    assert np.sqrt(design.variances()[0]) > 1.3e-3
    exchanged(design, passes=6)
    # four touches 90 deg apart (or as good): only scatter is left, 2 x 0.1 um / sqrt 4 = 0.1 um
    assert np.sqrt(design.variances()[0]) == pytest.approx(1e-4, rel=0.01)


def test_repeats_average_scatter_but_not_the_surface():
    points = on_plane((-30, -30), (30, -30), (-30, 30), (30, 30))
    c = candidates(PLANE, points, touch=1e-3, short=2e-3)
    rows = np.array([[1.0, 0.0, 0.0]])
    once = Design(c, Target(rows, np.ones(1)), np.ones(4, dtype=int)).variances()[0]
    twice = Design(c, Target(rows, np.ones(1)), 2 * np.ones(4, dtype=int)).variances()[0]
    assert once == pytest.approx((1.0 + 4.0) * 1e-6 / 4)  # mean of four: (1^2 + 2^2) / 4
    assert twice == pytest.approx((0.5 + 4.0) * 1e-6 / 4)


def test_one_touch_more_or_less_by_rank_one_update():
    rng = np.random.default_rng(5)
    c = candidates(PLANE, surface_grid(PLANE, 7), rng.normal(size=(49, 6)) * 1e-3, short=4e-4)
    counts = rng.integers(0, 3, 49)
    for target in (
        Target(rng.normal(size=(2, 3)), np.array([1.0, 3.0])),
        Target(np.zeros((0, 3)), np.zeros(0), "D"),
    ):
        design = Design(c, target, counts)
        for sign in (1, -1):
            change = design.changes(0, sign)
            for i in np.flatnonzero(np.isfinite(change))[:12]:
                other = design.copy()
                other.counts[i] += sign
                other.refresh()
                assert other.value() - design.value() == pytest.approx(change[i], rel=1e-6, abs=1e-18)


def test_u_agrees_with_the_evaluation_of_the_same_plan(tmp_path: Path):
    """Without form the closed form is that of `vcmm uncertainty`: another route, through q and its operator."""
    from vcmm.api import uncertainty

    scenario = load_scenario(edited(tmp_path))
    styli = {s.feature: s.stylus for s in scenario.plan.steps}
    problem = problem_of(scenario, styli, spots(scenario, styli), dict.fromkeys(styli, 0.0))
    found = outputs(
        scenario.part.characteristics, scenario.part.features, problem.motions, scenario.plan.alignment
    )
    counts = np.zeros(len(problem.candidates.feature), dtype=int)
    for step in scenario.plan.steps:
        counts[nearest(problem.candidates, step.feature, step.points)] += 1
    rows = found["bore diameter"].rows
    ours = np.sqrt(Design(problem.candidates, Target(rows, np.ones(1)), counts).variances()[0])
    theirs = uncertainty(scenario).characteristics[0].u
    assert ours == pytest.approx(theirs, rel=1e-3)  # products of inputs are left out


def test_form_agrees_with_draws_and_fits():
    """A cylinder whose form is drawn from the field and fitted: the spread of its diameter is that of the closed form."""
    bore = Feature("bore", "cylinder", np.zeros(3), Z, np.array([15.0]), inside=True, extent=(20.0,))
    points, normals = plan_points(bore, Levels((5.0, 15.0), 5))
    reference = surface_grid(bore, 48)
    from vcmm.part.part import normal

    factor, short = form_factor(motions_of(bore), points, 1e-3, None, (reference, normal(bore, reference)))
    z = np.random.default_rng(8).normal(size=(4000, factor.shape[1]))
    noise = short * np.random.default_rng(9).normal(size=(4000, len(points)))
    fitted = gauss("cylinder", points + (z @ factor.T + noise)[..., None] * normals)
    c = candidates(bore, points, factor, touch=0.0, short=short)
    rows = np.zeros((1, 5))
    rows[0, 4] = 2.0
    u = np.sqrt(Design(c, Target(rows, np.ones(1)), np.ones(10, dtype=int)).variances()[0])
    assert np.std(2.0 * fitted.sizes[:, 0]) == pytest.approx(u, rel=0.05)  # 4000 draws: 1.1 %
    assert np.sqrt(np.mean(np.sum(factor**2, axis=1)) + short**2) == pytest.approx(1e-3, rel=0.3)


def test_a_dense_measurement_sees_no_error_of_form():
    """The measurand is the fit to the whole surface: touching all of it leaves nothing but the short part."""
    reference = surface_grid(CIRCLE, 48)
    factor, _ = form_factor(motions_of(CIRCLE), reference, 1e-3, None, (reference, reference / 10.0))
    c = candidates(CIRCLE, reference, factor, touch=0.0)
    rows = np.eye(3)
    assert np.allclose(
        Design(c, Target(rows, np.ones(3)), np.ones(48, dtype=int)).variances(), 0.0, atol=1e-20
    )


def test_there_and_back_takes_drift_out_of_a_distance():
    """Two faces, four touches each, drift along the distance: A B ... A again leaves less than a tenth of A A A A B B B B."""
    group = np.repeat([0, 1], 4)
    tips = np.concatenate(
        [on_plane(*((0, y) for y in range(0, 40, 10))), on_plane(*((100, y) for y in range(0, 40, 10)))]
    )
    pull = np.where(group == 0, -0.25, 0.25)[None, :, None]
    visit = Visit(group, 1.2, ways(tips, group, group * 0, 100.0, 20.0, 0.0), pull)
    plain, careful = ordered(visit, 0.0), ordered(visit, 1e3)
    assert visit.drift(careful) < 0.01 * visit.drift(plain)
    assert sorted(careful) == list(range(8))
    assert visit.times(plain)[-1] <= visit.times(careful)[-1]


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    scenario = load_scenario(edited(tmp_path_factory.mktemp("plan")))
    return scenario, optimise_plan(scenario, 30.0)


def test_the_curve_falls_and_beats_the_present_plan(planned):
    _, result = planned
    seconds = [p.seconds for p in result.pareto]
    worth = [p.objective for p in result.pareto]
    assert seconds == sorted(seconds)
    assert worth == sorted(worth, reverse=True)
    assert result.chosen.seconds <= 30.0
    quicker = [p for p in result.pareto if p.seconds <= result.present.seconds]
    assert min(p.objective for p in quicker) < result.present.objective


def test_the_chosen_plan_reads_back_and_takes_the_time_it_says(planned, tmp_path: Path):
    scenario, result = planned
    for name, text in plan_files(result.plan, scenario.qualifications).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    source = edited(tmp_path).read_text(encoding="utf-8")
    head, rest = source.split("[plan]\n")
    tail = rest[rest.index("[environment]") :]
    lines = head.splitlines()
    at = lines.index("[machine]")
    (tmp_path / "again.toml").write_text(
        "\n".join([*lines[:at], 'plan = "plan.toml"', *lines[at:]]) + "\n" + tail
    )
    again = load_scenario(tmp_path / "again.toml")
    assert [s.feature for s in again.plan.steps] == [s.feature for s in result.plan.steps]
    for ours, theirs in zip(result.plan.steps, again.plan.steps):
        assert np.allclose(ours.points, theirs.points, atol=1e-8)
    assert again.plan.touch == scenario.plan.touch
    assert again.plan.alignment == scenario.plan.alignment
    time = again.task().touches.run.column("time_s")[-1]
    assert time == pytest.approx(result.chosen.seconds, rel=1e-6)  # one stylus: no changes


def test_json_says_what_was_found(planned):
    scenario, result = planned
    body = plan_json(scenario, result)
    assert body["chosen"]["minutes"] == pytest.approx(result.chosen.seconds / 60.0)
    assert sum(body["chosen"]["points"].values()) == body["chosen"]["touches"]
    assert body["pareto"][0]["characteristics"][0]["U_mm"] > 0


def test_bad_input_is_named():
    scenario = job(characteristics=(DIAMETER,))
    with pytest.raises(UsageError, match='unknown characteristic "diametre"'):
        optimise_plan(scenario, 60.0, weights={"diametre": 1.0})
    with pytest.raises(UsageError, match="criterion"):
        optimise_plan(scenario, 60.0, criterion="E")
    with pytest.raises(ModelLimit, match=r"the shortest plan takes .* s, the budget is 1 s"):
        optimise_plan(scenario, 1.0)


def test_a_feature_that_no_stylus_reaches_is_named():
    scenario = job()
    side = Stylus("side", np.array([0.0, 0.0, 100.0]), 2.0, 100.0)  # points up
    steps = tuple(Step(s.feature, "side", s.points, s.normals) for s in scenario.plan.steps)
    with pytest.raises(ModelLimit, match=r"can be touched|no stylus"):
        optimise_plan(replace(scenario, plan=Plan(steps, {"side": side})), 60.0)


def test_a_second_stylus_is_taken_where_it_serves_better():
    """One stylus is too short to go down the bore (its head of 60 mm does not): the long one takes over."""
    scenario = job(characteristics=(DIAMETER,))
    short = Stylus("short", np.array([0.0, 0.0, -4.0]), 2.0, 4.0)
    plan = scenario.plan
    steps = tuple(replace(s, stylus="short") for s in plan.steps if s.feature == "bore")
    found = optimise_plan(replace(scenario, plan=Plan(steps, {"short": short, **plan.styli})), 20.0, most=10)
    assert found.styli == {"bore": "down"}
    assert {s.stylus for s in found.plan.steps} == {"down"}
