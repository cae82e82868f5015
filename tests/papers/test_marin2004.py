"""The twin of Marin (2004): the chain by hand and against vcmm's engines, regression, and the rewritten program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from vcmm_twins.marin2004 import learnt, page, rewritten, twin
from vcmm_twins.marin2004.chain import (
    carriages,
    expanded,
    in_workpiece_axes,
    orientation,
    product,
    relation,
    volumetric_error,
)
from vcmm_twins.marin2004.day import (
    GAINS,
    MINUTES,
    Day,
    day,
    lagged,
    read_before,
    regression,
)
from vcmm_twins.shared.error_tables import effects_of

import vcmm
from tests.documented import assert_documented, assert_titled
from vcmm.core.errors import UsageError
from vcmm.core.run import T0_DEG_C, Run
from vcmm.files.own.library import example, folder
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness


@pytest.fixture(scope="module")
def scenario():
    return vcmm.load_cut(example("marin2004"))


@pytest.fixture(scope="module")
def result(scenario):
    return twin.run(scenario)


def one_place(offset=(0.0, 0.0, -120.0)) -> Run:
    position = {"X": np.array([300.0]), "Y": np.array([200.0]), "Z": np.array([-100.0])}
    return Run(position, np.array([offset]))


def random_run(n: int = 200) -> Run:
    rng = np.random.default_rng(7)
    return Run({a: rng.uniform(*twin.TRAVEL[a], n) for a in "XYZ"}, np.tile([3.0, -2.0, -120.0], (n, 1)))


def machine(scenario, *effects, at=None):
    axes = {a: replace(x, measured_at=at) for a, x in scenario.machine.axes.items()}
    return replace(scenario.machine, axes=axes, effects=effects, inputs=())


def constant(component: str, value: float) -> ComponentTable:
    low, high = twin.TRAVEL[component[2]]
    return ComponentTable(component, (component[2],), (np.array([low, high]),), np.array([value, value]))


@pytest.mark.parametrize(
    ("effect", "microns"),
    [
        # carriages at x = -300, y = -200; W = T + z - x - y = (300 200 -220)
        (constant("EXX", 5e-3), (-5, 0, 0)),  # the table stands 5 um further, the tip on it that much back
        (constant("EZZ", 5e-3), (0, 0, 5)),
        (constant("ECX", 10e-6), (2, -3, 0)),  # -(ez x W) = (ez Wy, -ez Wx)
        (constant("ECY", 10e-6), (2, 0, 0)),  # acts on W + (x, 0, 0) = (0 200 -220)
        (constant("EAZ", 10e-6), (0, 1.2, 0)),  # (ex 0 0) x (0 0 -120) = (0, 120 ex, 0)
        (Squareness("C0X", 10e-6), (0, 3, 0)),  # dy2 = axy x = -3 um of the table
        (Squareness("B0X", 10e-6), (0, 0, -3)),
        (Squareness("A0Z", 10e-6), (0, 1, 0)),  # -a z with z = -100
    ],
)
def test_every_kind_of_error_by_hand(scenario, effect, microns):
    one = machine(scenario, effect)
    c = carriages(one, one_place())
    assert product(c)[0][0] * 1e3 == pytest.approx(microns, abs=1e-6)
    assert expanded(c)[0] * 1e3 == pytest.approx(microns, abs=1e-6)
    assert one.tip_error(one_place())[0] * 1e3 == pytest.approx(microns, abs=1e-6)


def test_the_arms_begin_where_the_errors_were_measured(scenario):
    one = machine(scenario, constant("ECX", 10e-6), at=(100.0, 50.0, 0.0))
    # as above with W less (100 50 0): (200 150): (1.5, -2, 0)
    assert product(carriages(one, one_place()))[0][0] * 1e3 == pytest.approx((1.5, -2, 0), abs=1e-6)


def test_expansion_and_product_and_engines(scenario):
    effects = effects_of(twin.draw_tables(3), scenario.machine.axes)
    one = replace(scenario.machine, effects=effects, inputs=())
    run = random_run()
    c = carriages(one, run)
    correction = product(c)[0]
    assert expanded(c) == pytest.approx(correction, abs=1e-11)
    exact, first = one.tip_error(run, exact=True), one.tip_error(run)
    assert np.abs(exact).max() > 10e-3  # there is something to compare
    turned = product(c, exact=True)
    assert in_workpiece_axes(*turned) == pytest.approx(exact, abs=1e-11)  # two codes, one chain
    # first-order rotation matrices: eps^2 L with eps = 60 urad in all and L = 1 m is 3.6 nm
    assert np.abs(correction - exact).max() < 4e-6
    assert np.abs(correction - first).max() < 4e-6


def test_squareness_differs_by_second_order_only(scenario):
    one = machine(scenario, Squareness("C0X", 20e-6), Squareness("A0Z", 20e-6))
    run = random_run()
    # the travel is turned, not sheared: 20e-6^2 / 2 x 800 mm = 0.16 nm
    assert np.abs(product(carriages(one, run))[0] - one.tip_error(run, exact=True)).max() < 0.17e-6


@pytest.mark.parametrize(
    ("effect", "turned"),
    [(constant("ECX", 10e-6), (0, 0, 10)), (constant("EAZ", 10e-6), (-10, 0, 0))],
    ids=["table", "head"],
)
def test_equation_20_by_hand(scenario, effect, turned):
    """The table turned by 10 urad turns the workpiece against the tool by as much, the head by the opposite; the translation is minus
    the correction vector; equation 26 of (2, -3, 0) um is sqrt(13) um.
    """
    c = carriages(machine(scenario, effect), one_place())
    found = relation(c)
    assert orientation(found)[0] * 1e6 == pytest.approx(turned, abs=1e-4)
    assert found[0, :3, 3] == pytest.approx(-product(c)[0][0], abs=1e-7)
    assert volumetric_error(np.array([[2.0, -3.0, 0.0]]))[0] == pytest.approx(13**0.5)


def test_geometry_is_learnt_from_noisy_readings(scenario):
    """Readings scatter by 0.8 um and 1.5 urad; a cubic is kept by its regression; a smoother model leaves less of the noise alone."""
    bare = machine(scenario, *(constant(f"E{d}X", 0.0) for d in "XYZABC"))
    read = [learnt.readings(bare, np.random.default_rng(k)) for k in range(300)]
    assert np.std([r["EXX"] for r in read]) == pytest.approx(0.8e-3, rel=0.1)
    assert np.std([r["EBX"] for r in read]) == pytest.approx(1.5e-6, rel=0.1)
    x = np.linspace(0, 800, 11)
    cubic = 1e-3 * (x / 800) ** 3
    table = machine(scenario, ComponentTable("EXX", ("X",), (x,), cubic))
    found = learnt.smoothed(table, {"EXX": cubic}, learnt.METHODS[1], np.random.default_rng(0))
    assert found["EXX"] == pytest.approx(cubic, abs=1e-12)
    assert learnt.with_tables(table, {"EXX": 2 * cubic}).effects[0].values == pytest.approx(2 * cubic)


@pytest.mark.thorough
def test_what_is_learnt_of_the_drawn_machine(result):
    """Noise alone: 11 readings of 0.8 um and arms to some 500 mm times 1.5 urad make about 1.5 um."""
    rms = {one.method: np.median(one.rms) for one in result.learnt}
    assert 0.7 < rms[learnt.METHODS[0]] < 2.5
    assert result.volume.largest == pytest.approx(result.largest_um, rel=0.01)
    assert result.volume.moved < 5.0


def test_what_the_chain_cannot_hold_is_refused(scenario):
    other = replace(scenario.machine, chain=replace(scenario.machine.chain, structure="w X' b Y Z t"))
    with pytest.raises(UsageError, match='not "w X\' b Y Z t"'):
        carriages(other, one_place())
    slack = machine(scenario, Backlash("X", 3e-3))
    with pytest.raises(UsageError, match="backlash"):
        carriages(slack, one_place().with_columns({"sense_X": np.ones(1)}))


def test_the_files_of_the_scenario_are_what_the_twin_makes(scenario):
    assert (folder() / "marin2004" / "part.nc").read_text() == twin.program()
    assert (folder() / "marin2004" / "errors.csv").read_text() == twin.errors_csv()


def test_a_node_warms_as_a_first_order_lag():
    minute = np.arange(MINUTES + 1.0)
    heated = np.where(minute >= 10, T0_DEG_C + 12.0, T0_DEG_C)
    found = lagged(minute, heated, 25.0)
    # the step is a ramp over the minute before 10; 50 minutes on: 12 (1 - exp(-2)) = 10.376 K, half a minute early
    assert found[60] - T0_DEG_C == pytest.approx(12 * (1 - np.exp(-50.5 / 25)), abs=2e-3)


def test_regression_finds_linear_laws():
    seen = [day(1), day(2)]
    ideal = [Day(d.minute, d.nodes, d.nodes, (d.nodes - T0_DEG_C) @ GAINS.T) for d in seen]
    model = regression(ideal)
    assert model.coefficients == pytest.approx(GAINS.T, abs=1e-6)
    assert model.at(np.array([22.0, 20, 20, 20, 20, 20]))[0] == pytest.approx(2 * -1.6)


def test_regression_on_an_unseen_day_beats_ignoring_the_heat():
    found = twin.fits(regression([day(s) for s in twin.LEARNED]), day(twin.VALIDATED))
    for fit in found:
        assert fit.rms < 0.1 * fit.span
    assert found[0].rms > 0.1  # the bent share and the lag of the sensor stay


@pytest.mark.thorough
def test_the_lag_of_the_sensors_owns_what_the_regression_leaves():
    """A node that warms with 25 min after a step of 12 K runs at first 12 / 25 = 0.48 K/min: a sensor 5 min late reads up to
    1.6 K short, times 1.6 um/K. Without the lag only noise, neighbours and 0.015 / K of curvature are left.
    """
    as_drawn, straight, prompt, earlier, net, net_earlier = (row.rms[0] for row in twin.remainders())
    assert prompt < 0.25 * as_drawn
    assert straight > 0.8 * as_drawn
    assert prompt < earlier < 0.5 * as_drawn
    assert net_earlier < net  # the past helps it too
    assert net_earlier > earlier  # and a linear law is better learnt as one


def test_readings_of_before():
    sensors = np.arange(4.0)[:, None] + np.zeros(6)
    both = read_before(sensors, (0, 2))
    assert both.shape == (4, 12)
    assert both[:, 6].tolist() == [0.0, 0.0, 0.0, 1.0]


def warm_place(**temperatures: float) -> Run:
    return one_place().with_columns({f"temp_{n}_C": np.array([v]) for n, v in temperatures.items()})


def test_thermal_parameters_as_effects(scenario):
    """The true parameters stand in the log as degrees above 20: EZZ -20 um, EYZ 3 um, EAZ 5 urad, EXX 10 um/m, EZZ 4 um/m."""
    one = machine(scenario, *rewritten.true_effects())
    run = warm_place(p0=0.0, p1=23.0, p2=25.0, p3=30.0, p4=20.0, p5=24.0)
    # z: -20 um + 4 um/m x -0.1 m; y: 3 um + (5 urad, 0, 0) x (0 0 -120) = 0.6 um; x: table scale 10 um/m x 0.3 m, taken off
    assert one.tip_error(run)[0] * 1e3 == pytest.approx((-3.0, 3.6, -20.4), abs=1e-9)


def test_the_regression_as_effects_is_the_regression(scenario):
    model = regression([day(1), day(2)], (0, 5))
    now, before = (
        np.array([31.0, 24.0, 22.0, 23.0, 20.5, 21.0]),
        np.array([30.0, 23.5, 21.5, 22.5, 20.4, 20.9]),
    )
    said = dict(zip(rewritten.sensor_names((0, 5)), np.concatenate([now, before])))
    p = model.at(np.concatenate([now, before]))
    found = machine(scenario, *rewritten.learnt_effects(model)).tip_error(warm_place(**said))[0] * 1e3
    assert found == pytest.approx((-p[3] * 0.3, p[1] + p[2] * 0.12 - p[4] * 0.2, p[0] - p[5] * 0.1), abs=1e-9)


def test_logs_of_a_cut():
    """Minute 100 is second 0; held: as then for ever, cold when the zero was set; a table every two minutes is late by up to two."""
    today = day(1)
    said, held = (rewritten.sensor_log(today, 100, (0,), h) for h in (False, True))
    assert said.zero_set == held.zero_set == -6000.0
    one = said.sensors["spindle"]
    assert np.interp(300.0, one.time, one.value) == pytest.approx(today.sensors[105, 0])
    still = held.sensors["spindle"]
    assert np.interp([-6000.0, 0.0, 300.0], still.time, still.value) == pytest.approx(
        [today.sensors[0, 0], today.sensors[100, 0], today.sensors[100, 0]]
    )
    stairs = rewritten.held_between(said, 2.0).sensors["spindle"]
    assert np.interp(239.0, stairs.time, stairs.value) == pytest.approx(today.sensors[102, 0], abs=1e-9)
    assert np.interp(-600.0, stairs.time, stairs.value) == pytest.approx(today.sensors[90, 0], abs=1e-9)


@pytest.mark.thorough
def test_rewriting_before_and_after_warm_up(result):
    by = {(c.state, c.model): c.departure for c in result.cuts}
    worst = {k: max(np.abs(v).max() for v in d.values()) for k, d in by.items()}
    cold, warm = "minute 0", f"minute {result.warm}"
    assert worst[cold, twin.GEOMETRY] < 0.4 * worst[cold, twin.PLAIN]
    assert (
        worst[warm, twin.GEOMETRY] > 0.5 * worst[warm, twin.PLAIN]
    )  # geometry alone does not help a warm machine
    assert worst[warm, twin.UPDATED] < 0.7 * worst[warm, twin.START] < 0.1 * worst[warm, twin.PLAIN]
    assert worst[warm, twin.UPDATED] < worst[warm, twin.TABLE] < worst[warm, twin.AXES]


@pytest.mark.thorough
def test_updating_is_worth_what_the_head_moves_meanwhile(result):
    """By hand from the sensors: what the regression says of the ledge's height when it is cut, less what it said at the start."""
    model = regression([day(seed) for seed in twin.LEARNED], twin.LAGS)
    view = next(v for v in result.views if v.net.feature == "ledge")
    row, _ = view.contacts.deepest(view.tool.known_error)
    minute = result.warm + view.tool.run.column("time_s")[row].mean() / 60.0
    said = model.over(result.today)
    then = np.array([np.interp(minute, result.today.minute, p) for p in said.T])
    grown = then - said[result.warm]
    # Z stands at -380 - 12 + 120 mm when the ledge at y = 94 +- is cut; the tilt acts with the tool, straight down
    expected = grown[0] + grown[5] * -0.272
    by = {c.model: c.departure["ledge"] for c in result.cuts if c.state != "minute 0"}
    assert by[twin.START].mean() - by[twin.UPDATED].mean() == pytest.approx(expected, abs=0.15)
    assert abs(expected) > 1.0


@pytest.mark.thorough
def test_documentation_shows_what_the_command_prints(scenario, result):
    assert_documented("marin2004", page.tables(result))
    assert_titled(page, scenario, result)
