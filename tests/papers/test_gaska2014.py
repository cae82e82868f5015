"""The twin of Gaska et al. 2014: tables by hand, the tests of the readings, one figure recomputed by other means, what page and command show."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from math import comb
from pathlib import Path

import numpy as np
import pytest
from vcmm_twins.gaska2014 import maps, nodes, page, placement, readings, tracer, twin
from vcmm_twins.gaska2014.nodes import NODES, NU, PUBLISHED, SHOWN, draw_deviations
from vcmm_twins.gaska2014.readings import SHOWN_READING, Reading, ReadingResult

from vcmm.core import residual_weights as residual
from vcmm.core.laws import StudentT
from vcmm.face.cli import run as command
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.learn.calibration import multilateration
from vcmm.learn.calibration import nodes as calibrated_nodes
from vcmm.show.tables.table import in_terminal
from vcmm.task.measuring.fixture import six_of

DOCS = Path(__file__).resolve().parents[2] / "docs"
DOC = (DOCS / "gaska2014.md").read_text(encoding="utf-8")


@cache
def scenario():
    return load_scenario(example("gaska2014"))


@cache
def over_machines(draws=200):
    """The reading that is shown, at five places."""
    return readings.matrix(scenario(), twin.machines(draws), [SHOWN_READING])[0]


def test_table_2_by_hand():
    """d(X): (0.63 + 0.20 + 0.23 + 0.25 + 2.12 + 1.01 + 1.18 + 1.29) / 8 = 6.91 / 8 = 0.864; r of d(X) and d(Y) 0.94; F of the columns of
    log d(X) from means -1.2319 and 0.2954 and variances 0.2719 and 0.1027: 4 * 1.1663 / 0.1873 = 24.9.
    """
    assert nodes.TABLE2.mean(axis=0) == pytest.approx([0.864, 0.736, 0.705], abs=5e-4)
    assert nodes.correlation_of(nodes.TABLE2) == pytest.approx(0.941, abs=5e-4)
    assert nodes.column_ratio(nodes.TABLE2) == pytest.approx([24.9, 6.6, 0.99], abs=0.05)


def test_draws_meet_every_published_figure_and_have_its_structure():
    drawn = twin.machines(200)
    rows = np.array([k - 1 for k in PUBLISHED])
    assert (drawn[:, rows] == nodes.TABLE2).all()
    assert drawn.max(axis=1) == pytest.approx(np.tile([2.6, 1.8, 1.5], (200, 1)))
    assert drawn.mean(axis=1) == pytest.approx(np.tile([0.9, 0.8, 0.7], (200, 1)), abs=0.003)
    r = [nodes.correlation_of(d) for d in drawn]
    assert 0.7 < np.median(r) < 0.95
    logs = np.log(drawn).reshape(200, 13, 4, 3)
    ratio = 4 * logs.mean(axis=2).var(axis=1, ddof=1) / logs.var(axis=2, ddof=1).mean(axis=1)
    assert np.median(ratio[:, 0]) > 10  # columns of X; without them it is about 1
    assert np.median(ratio[:, 2]) < 3


def test_the_scenario_is_the_draw_that_is_told():
    one = next(i for i in scenario().machine.inputs if i.effect == "residual_field")
    d = one.scale.reshape(52, 3) * 1e3 / readings.AMOUNTS[SHOWN_READING.amount]
    assert d == pytest.approx(draw_deviations(SHOWN), abs=1e-3)
    field = next(e for e in scenario().machine.effects if e.name == one.effect)
    assert (field.nodes == NODES).all()
    assert (field.interpolation, field.curve, one.redraw, one.law.dof) == (
        "columns-linear",
        "control",
        "touch",
        13,
    )
    assert readings.AMOUNTS["deviation"] == pytest.approx(np.sqrt(11 / 13))  # 0.920


def test_senses_of_fourteen_approaches_by_hand():
    """+X -X +Y -Y +Z -Z and eight diagonals. X is left at -1 by the second approach; Y stands at its first sense until the third."""
    sense = tracer.senses()
    assert tracer.DIRECTIONS.shape == (14, 3)
    assert np.abs(tracer.DIRECTIONS).sum(axis=1).tolist() == [1] * 6 + [3] * 8
    assert sense[:6, 0].tolist() == [1, -1, -1, -1, -1, -1]
    assert sense[:6, 1].tolist() == [1, 1, 1, -1, -1, -1]
    assert (sense[6:] == tracer.DIRECTIONS[6:]).all()


def test_hysteresis_has_the_share_that_is_asked_for():
    d = draw_deviations(1) * 1e-3
    fixed = tracer.hysteresis_of(tracer.Approached(d, 0.25))
    assert fixed.std(axis=1, ddof=1) == pytest.approx(0.5 * d)
    assert fixed.mean(axis=1) == pytest.approx(0.0, abs=1e-15)


def test_the_lasertracer_tells_d_and_what_of_it_is_its_own():
    """A machine without scatter: eq. 2 leaves u = 0.1 um of 1442 degrees of freedom, d is all the instrument's."""
    still = tracer.found_by(tracer.Approached(np.zeros((52, 3)), 0.0), 1)
    assert still.multilateration.freedom == 3640 - 3 * 728 - 4 * 5 + 6
    assert still.u == pytest.approx(0.1e-3, rel=0.05)
    assert np.sqrt((still.d**2).mean()) == pytest.approx(np.sqrt((still.instrument**2).mean()), rel=0.05)
    whole = tracer.found_by(tracer.Approached(np.zeros((52, 3)), 0.0, "length"), 1)
    assert np.sqrt((whole.d**2).mean()) == pytest.approx(np.sqrt((whole.instrument**2).mean()), rel=0.05)
    assert whole.instrument.mean() > 1.7 * still.instrument.mean()


def test_rows_of_the_title_procedure_stand_in_the_documentation():
    drawn = twin.machines(twin.CLOSE_RUNS)
    followed = tuple(twin.follow(drawn, share, "station") for share in (0.0, 1.0))
    assert (
        followed[0].found < 0.9 < followed[1].found
    )  # what does not come back is averaged over the stations
    assert all(f.single == pytest.approx(1.0, abs=0.03) for f in followed)
    assert (
        followed[1].quiet < 0.01 < followed[0].quiet
    )  # all hysteresis would have been seen by the paper's own test
    table = page.followed_table(twin.GaskaTwin(0, (), (), followed, (), (0, 0), {}))
    assert_in_documentation(table)


def assert_in_documentation(table):
    for cells in in_terminal(table).rows:
        wanted = r"\s+".join(re.escape(c) for c in cells if c)
        assert re.search(wanted, DOC), cells


def test_ten_quiet_nodes_by_hand():
    """Of 52 nodes 2 have a test below 5 %: C(50, 10) / C(52, 10) = 42 41 / (52 51) = 0.649."""

    class Found:
        place = np.zeros((52, 3))
        test = np.ones((52, 3))

    Found.test[[3, 40], [0, 2]] = 0.01
    assert tracer.untold(Found) == pytest.approx(42 * 41 / (52 * 51))
    assert comb(50, 10) / comb(52, 10) == pytest.approx(42 * 41 / (52 * 51))


def test_the_shown_reading_stands_in_the_documentation():
    shown = over_machines()
    assert shown.against() == ()
    assert sum(shown.hits()) == 9
    assert np.median(shown.form.mean(axis=1)) == pytest.approx(0.79e-3, abs=0.02e-3)
    assert np.median(shown.distance.mean(axis=1)) == pytest.approx(0.42e-3, abs=0.02e-3)
    assert_in_documentation(page.readings_table(twin.GaskaTwin(200, (), (shown,), (), (), (0, 0), {})))


def test_the_machine_that_is_shown_is_from_the_middle():
    shown = over_machines()
    assert readings.central(shown) == SHOWN - 1
    ranks = readings.rank(shown.form, SHOWN - 1), readings.rank(shown.distance, SHOWN - 1)
    assert all(abs(r - 100.5) < 10 for r in ranks)
    assert f"ranks {ranks[0]} of 200, by that of the distance {ranks[1]}" in DOC


def test_shares_of_best_places_stand_in_the_documentation_of_place():
    shown = over_machines()
    one = placement.Ranking("touch", tuple(scenario().places), shown.form, shown.distance)
    by = [" ".join(f"{100 * share[i]:.0f}" for share in one.shares().values()) for i in range(2)]
    both = " | ".join(f"{100 * v:.0f} %" for v in one.both_best())
    assert f"| touch | {by[0]} % | {by[1]} % | {both} |" in (DOCS / "place.md").read_text(encoding="utf-8")


def test_u_of_the_distance_by_other_means():
    """Place 2 recomputed without the package's field, fit or budget: Bernstein polynomials by hand, barycentric shares from linear systems, nine
    touches of a face averaged; the distance of two face centres has a gain of 1/9 per touch.
    """
    one = scenario().at(scenario().places["2"])
    touches = one.task().touches
    faces = np.concatenate([touches.rows["left"], touches.rows["right"]])
    d, variance = draw_deviations(SHOWN), 0.0
    columns = np.array(nodes.COLUMNS, dtype=float)
    from scipy.spatial import Delaunay

    corners = Delaunay(columns)
    for tip in touches.run.tip[faces]:
        t = (tip[2] - 50) / 450
        bezier = np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
        mine = corners.simplices[int(corners.find_simplex(tip[:2]))]
        share = np.linalg.solve(np.vstack([columns[mine].T, np.ones(3)]), [*tip[:2], 1.0])
        for c, w in zip(mine, share):
            variance += sum((w * b * d[4 * c + k, 0] / 9) ** 2 for k, b in enumerate(bezier))
        variance += (0.15 / 9) ** 2  # the probe's repeatability, um
    alone = readings.matrix(
        replace(scenario(), places={"2": scenario().places["2"]}), d[None], [SHOWN_READING]
    )[0]
    assert alone.distance[0, 0] * 1e3 == pytest.approx(
        2 * np.sqrt(variance), rel=0.05
    )  # lobing of the probe, 0.05 um, is left out


@cache
def evaluated():
    """The full evaluation at place 4."""
    one = scenario().at(scenario().places["4"])
    return twin.measuring.evaluate(one.task(), replace(one.settings, trials=4000, certify=50))


@pytest.mark.thorough
def test_the_matrix_agrees_with_the_evaluation_of_the_scenario():
    form, distance = (
        next(c for c in evaluated().characteristics if c.type == t) for t in ("cylindricity", "distance")
    )
    one = replace(scenario(), places={"4": scenario().places["4"]})
    alone = readings.matrix(one, draw_deviations(SHOWN)[None], [SHOWN_READING])[0]
    assert alone.distance[0, 0] == pytest.approx(distance.expanded, rel=0.03)
    assert alone.form[0, 0] == pytest.approx(twin.by_recipe(form, one.settings.rule).expanded, rel=0.1)
    assert alone.form_sd[0, 0] == pytest.approx(form.summary.u, rel=0.05)


def test_the_three_tests_of_a_reading_by_hand():
    """Machines whose U go from 0 to 2 um evenly: their central 95 % is 0.05 to 1.95 um and holds all ten. Of each the ratio is 2, and results that
    scatter by 0.28 um (distance) or 0.16 um (form) spread as the paper's do; ten times that, and they do not.
    """
    steps = np.linspace(0.0, 2e-3, 101)[:, None] * np.ones(5)
    sd = np.full((101, 5), 0.16e-3), np.full((101, 5), 0.28e-3)
    one = ReadingResult(SHOWN_READING, steps, steps / 2 + 1e-9, *sd)
    assert one.hits() == (5, 5)
    assert one.ratio()[0] == pytest.approx(2.0, abs=0.01)
    assert min(one.spread) > 0.5
    assert one.against() == ()
    far = replace(one, form=steps / 10, form_sd=10 * sd[0])
    assert far.hits()[0] == 0
    assert far.spread[0] < 0.01
    assert far.ratio()[1] == 0.0
    assert far.against() == ("U", "ratio", "spread")


def test_fields_drawn_per_run_contradict_table_3():
    """Neighbouring touches move together: the distance becomes more uncertain than the form, which the paper has at no place."""
    one = readings.matrix(scenario(), twin.machines(12), [replace(SHOWN_READING, redraw="run")])[0]
    assert "ratio" in one.against()
    assert "U" in one.against()


def test_more_touches_of_a_face_average_per_touch():
    """16 touches against 4, no field: the distance of two faces has u = 0.15 um sqrt(2 / n), and less lobing of the probe."""
    still = np.zeros((1, 52, 3))
    one = replace(scenario(), places={"3": scenario().places["3"]})
    u = [
        readings.matrix(readings.with_touches(one, k, 8), still, [SHOWN_READING], 200)[0].distance_sd[0, 0]
        for k in (2, 4)
    ]
    assert readings.with_touches(one, 4, 8).task().touches.run.n == 2 * 16 + 24
    apart = u[0] ** 2 - u[1] ** 2
    assert apart == pytest.approx((0.15e-3) ** 2 * (2 / 4 - 2 / 16), rel=0.15)


def test_maps_at_a_node_show_its_d():
    """At a node all readings through the nodes give its d; z = 200 mm is no end of a column, so control points mix their neighbours."""
    d = draw_deviations(SHOWN)
    x, y = maps.grid()
    at = int(np.flatnonzero(y == 50)[0]), int(np.flatnonzero(x == 475)[0])
    node = 4 * nodes.COLUMNS.index((475, 50)) + 1
    for _, axis, plane in maps.PANELS:
        assert maps.field_map(d, axis, plane, 200.0, "through")[at] == pytest.approx(d[node, axis])
    mixed = maps.field_map(d, 0, "linear", 200.0, "control")[at]
    assert mixed == pytest.approx(
        np.sqrt(((np.array([8, 12, 6, 1]) / 27 * d[node - 1 : node + 3, 0]) ** 2).sum())
    )


def poses_for_subsets():
    """Gains and kernel of 60 drawn sets of six touches."""
    rng = np.random.default_rng(3)
    ends = ((150, 800), (50, 600), (50, 500))
    tips = np.stack([rng.uniform(*e, 60)[:, None] + rng.uniform(-20, 20, (60, 6)) for e in ends], axis=2)
    squared = ((tips[:, :, None] - NODES) ** 2).sum(axis=3)
    return np.ones((60, 6, 3)), np.exp(-squared / (2 * placement.LENGTH**2))


def test_variance_and_loss_of_a_subset_by_hand():
    gains, kernel = poses_for_subsets()
    field, every = draw_deviations(5) * 1e-3, np.arange(52)
    full = placement._variances(gains, kernel, field[None], every)[0]
    near = kernel[7] / kernel[7].sum(axis=1, keepdims=True)
    assert full[7] == pytest.approx(((near @ field) ** 2).sum())
    assert placement._loss(gains, kernel, field, full, every) == 0.0
    only = np.array([0])  # one node says the same of every pose: the first is taken
    assert placement._loss(gains, kernel, field, full, only) == pytest.approx(
        np.sqrt(full[0] / full.min()) - 1
    )


def test_optimised_subsets_beat_random_ones(monkeypatch):
    """20 nodes of 52, on machines that the subset was not found on."""
    monkeypatch.setattr(placement, "TRAINED", 12)
    monkeypatch.setattr(placement, "TRAIN_POSES", 60)
    monkeypatch.setattr(placement, "SUBSETS", (20,))
    gains, kernel = poses_for_subsets()
    best = placement.optimised(gains, kernel, 1, lambda text, share: None)
    assert {len(kept) for kept in best.values()} == set(range(20, 53))
    fields = twin.machines(40) * 1e-3
    full = placement._variances(gains, kernel, fields, np.arange(52))
    rng = np.random.default_rng(1)
    found = placement._mean_loss(gains, kernel, fields, full, best[20])
    drawn = [
        placement._mean_loss(gains, kernel, fields, full, np.sort(rng.permutation(52)[:20]))
        for _ in range(20)
    ]
    assert found < 0.6 * np.mean(drawn)


def test_pose_and_places_are_one_order():
    six = [six_of(p) for p in scenario().places.values()]
    assert list(scenario().places) == ["1", "2", "3", "4", "5"] == list(readings.PAPER_FORM_U)
    assert len(six) == len(readings.PAPER_FORM) == len(readings.PAPER_DISTANCE)


def test_every_step_stands_in_the_documentation_and_every_place_exists():
    rooms = {
        "tracer": tracer, "nodes": nodes, "readings": readings, "twin": twin, "maps": maps, "placement": placement,
        "multilateration": multilateration, "calibrating.nodes": calibrated_nodes, "residual": residual,
    }  # fmt: skip
    for theirs, ours in page.STEPS:
        assert f"| {theirs} | {ours} |" in DOC
        for room, name in re.findall(r"`([a-z.]+)\.([A-Za-z_0-9]+)`", ours):
            assert hasattr(rooms[room], name), f"{room}.{name}"


def test_readings_are_sixteen_and_named_apart():
    assert len({one.words for one in readings.READINGS}) == 16
    assert Reading("through", "nearest", "scale", "run").words == "through, nearest, scale, run"
    assert StudentT(1.0, NU).u == pytest.approx(np.sqrt(13 / 11))


def drawn_results(scenario, deviations, asked=readings.READINGS, trials=0, progress=None):
    """U of every reading out of a hat."""
    rng = np.random.default_rng(1)
    shape = len(deviations), len(scenario.places)
    return [ReadingResult(one, *(1e-3 * rng.uniform(0.3, 1, shape) for _ in range(4))) for one in asked]


@pytest.mark.thorough
def test_command(tmp_path, capsys, monkeypatch):
    """One place evaluated and shown at all five; the files are read by the next command."""
    result = evaluated()
    monkeypatch.setattr(twin.measuring, "evaluate", lambda task, settings, read: result)
    monkeypatch.setattr(twin, "HYSTERESIS", (0.5,))
    monkeypatch.setattr(twin, "matrix", drawn_results)
    assert command(["demo", "--twin", "gaska2014", "--draws", "8", "--out", str(tmp_path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [row["place"] for row in found["rows"]] == ["1", "2", "3", "4", "5"]
    assert len(found["readings"]) == 16
    assert [one["lengths"] for one in found["tracer"]] == ["station", "length"]
    assert found["machine"]["draw"] == SHOWN
    assert [(p["touches_face"], p["touches_bore"]) for p in found["plans"][::4]] == [
        (4, 24),
        (9, 36),
        (16, 60),
    ]
    assert sum(row["form_best_share"] for row in found["rows"]) == pytest.approx(1.0)
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert all(f"{letter}: " in report for letter in "abcde")
    assert (tmp_path / "demo.csv").read_text().startswith("place,form_um")
    files = [str(tmp_path / n) for n in ("tracer.toml", "cmm.toml")]
    assert command(["calibrate", files[0], "--machine", files[1], "--nodes", "--json"]) == 0
    seen = json.loads(capsys.readouterr().out)
    d = np.array([n["single_um"] for n in seen["nodes"]])
    order = np.lexsort(NODES.T[::-1])
    assert np.sqrt((d**2).mean()) == pytest.approx(np.sqrt((draw_deviations(SHOWN) ** 2).mean()), rel=0.1)
    assert np.corrcoef(d.ravel(), draw_deviations(SHOWN)[order].ravel())[0, 1] > 0.9
