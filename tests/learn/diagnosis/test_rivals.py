"""What is a rival, what holds the answer, what is an alias that the rows do not resolve; and when a name is too bold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.answer.evaluation.gaussian import whitener
from vcmm.core.run import Run
from vcmm.learn.diagnosis import noise as audits
from vcmm.learn.diagnosis.assembly import add_unresolved_names
from vcmm.learn.diagnosis.candidates import Family, Option, build_catalogue
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.mistakes import factor_fits
from vcmm.learn.diagnosis.noise import Audit, audit
from vcmm.learn.diagnosis.null_recordings import Noise
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.rivals import Standing, compare_with_rivals
from vcmm.learn.diagnosis.scans import trials, unresolved_changes
from vcmm.learn.diagnosis.select import SelectedTerm, Setting, fit_jointly
from vcmm.learn.diagnosis.unknown_shapes import find_modulation
from vcmm.learn.diagnosis.verdict import reasons_against, verdict
from vcmm.physics.catalogue.map_interpolation import MapInterpolation
from vcmm.physics.catalogue.probe import ProbeLobing
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentTable

ROWS = 200


def family(name: str, columns: np.ndarray, log_prior: float = 0.0) -> Family:
    k = columns.shape[1]
    return Family(name, {}, (Option(None, columns, np.ones(k), tuple(map(str, range(k))), 0.0),), log_prior)


def plain_white(rows: int = ROWS):
    none = np.zeros((rows, 0))
    return whitener(np.ones(rows), none, none)


def chosen(families, y):
    """Selection of the first family alone in y, and the setting it was made in."""
    white = plain_white(len(y))
    found = dictionary(families, white)
    setting = Setting(found, white, y, np.inf, 3.0, lambda option, r, basis: option)
    first = families[0]
    return fit_jointly([SelectedTerm(first, first.options[0], first.options[0].columns)], setting), setting


def test_freer_names_pay_and_near_aliases_stay():
    # Orthonormal e1 .. e6 times 10; the signal is 10 e1 in noise of 1 that has nothing along e1 .. e6: delta 10.
    rng = np.random.default_rng(5)
    q = np.linalg.qr(rng.standard_normal((ROWS, 6)))[0]
    noise = rng.standard_normal(ROWS)
    y = 10 * q[:, 0] + noise - q @ (q.T @ noise)
    tilted = (
        np.cos(0.1) * q[:, [0]] + np.sin(0.1) * q[:, [1]]
    )  # s = sin 0.1 = 0.0998, delta s = 1.0: below 2.45
    away = np.cos(0.4) * q[:, [0]] + np.sin(0.4) * q[:, [1]]  # s = 0.389, delta s = 3.9: told apart
    short = np.concatenate([10 * q[:, [0]], 0.5 * q[:, [5]]], axis=1)  # a second column of size 0.25
    families = [
        family("named", 10 * q[:, [0]]),
        family("alias", 10 * tilted, -20.0),  # its prior is e^-20: named all the same
        family("other", 10 * away),  # loses (10 x 0.389)^2 / 2 = 7.6 nats
        # four columns that nobody needs: each costs 1/2 ln(1 + s^2 100) = 2.3 nats at s = 1, together about 9
        family("freer", 10 * q[:, :5]),
        family(
            "hardly_freer", short
        ),  # one that costs 1/2 ln(1 + 0.25 s^2) = 0.1 nats at s = 1: within 3 nats
    ]
    selection, setting = chosen(families, y)
    place = compare_with_rivals(selection, setting, 0)
    assert set(place.names) == {"alias", "hardly_freer"}
    assert place.contained_in == ("freer",)


def test_a_freer_name_that_explains_more_is_a_rival_even_if_it_holds_the_answer_everywhere():
    # lost_motion holds backlash by what it is. With a signal of 2.5 along its own column it gains 2.5^2 / 2 = 3.1 nats
    # and pays about 2.3: ahead. With nothing there it pays only: behind, and stands aside.
    rng = np.random.default_rng(6)
    q = np.linalg.qr(rng.standard_normal((ROWS, 2)))[0]
    noise = rng.standard_normal(ROWS)
    noise = noise - q @ (q.T @ noise)
    families = [family("backlash", 10 * q[:, [0]]), family("lost_motion", 10 * q)]
    for own, expected in ((3.0, ("lost_motion",)), (0.0, ())):
        selection, setting = chosen(families, 30 * q[:, 0] + own * q[:, 1] + noise)
        assert compare_with_rivals(selection, setting, 0).names == expected


def test_lobes_that_four_directions_do_not_resolve_stand_as_aliases():
    angle = np.radians([0.0, 90.0, 180.0, 270.0])
    run = Run({"X": np.zeros(4)}, np.zeros((4, 3)), {"probe_angle_rad": angle})
    assert [c["lobes"] for c in unresolved_changes(ProbeLobing, run)] == [
        3,
        2,
        4,
    ]  # four places are not more than 2 x 2
    eight = Run({"X": np.zeros(8)}, np.zeros((8, 3)), {"probe_angle_rad": np.arange(8) * np.pi / 4})
    assert [c["lobes"] for c in unresolved_changes(ProbeLobing, eight)] == [4]  # 8 > 2 x 3, but not > 2 x 4
    turned = np.tile(angle, 50)
    oval = np.cos(2 * turned)[:, None]  # +1 -1 +1 -1: an oval ball, two lobes, six lobes
    y = 10 * oval[:, 0] / np.linalg.norm(oval) + np.random.default_rng(2).standard_normal(ROWS)
    selection, _ = chosen([family("tip_form", oval)], y)
    place = Standing(40.0, 0.97, (), ())
    hidden = dictionary([family("probe_lobing", np.cos(6 * turned)[:, None])], plain_white())
    assert add_unresolved_names(place, selection, 0, hidden).names == ("probe_lobing",)
    radius = dictionary([family("probe_lobing", np.cos(4 * turned)[:, None])], plain_white())  # +1 +1 +1 +1
    assert add_unresolved_names(place, selection, 0, radius).names == ()
    freer = dictionary(
        [family("probe_lobing", np.eye(4)[np.arange(ROWS) % 4])], plain_white()
    )  # holds everything
    assert add_unresolved_names(place, selection, 0, freer).names == ()


def test_every_mesh_of_a_table_may_have_its_own_height():
    nodes = np.array([0.0, 10.0, 20.0, 30.0, 40.0])
    effect = MapInterpolation.from_table(ComponentTable("EXX", ("X",), (nodes,), np.zeros(5)))
    run = Run({"X": nodes[:-1] + 5.0}, np.zeros((4, 3)), {})
    found = trials(effect, run)
    assert sum(np.exp(w) for _, w in found) == pytest.approx(1.0)
    cells = [c for c, _ in found if c["shape"] == "cells"]
    assert [len(c["coefficients"]) for c in cells] == [4]
    # heights 1, -1, 2, 0 in the middles: their third difference, 0 - 3 x 2 + 3 x (-1) - 1 = -10, is that of no parabola
    heights = np.array([1.0, -1.0, 2.0, 0.0])
    whole = replace(effect, shape="cells", coefficients=heights)
    assert whole.error_motion(run)[:, 0] == pytest.approx(heights)  # 4 u (1 - u) = 1 at u = 1/2


def test_a_play_is_taken_up_within_its_gap():
    recording = make.make((), 0.0, 3).recording
    since = np.full(recording.run.n, 5.0)
    since[:7] = 0.0004  # mm: nearer to the reversal than a typical gap of 1 um
    run = replace(recording.run, columns={**recording.run.columns, "since_reversal_X_mm": since})
    problem = make_problem(replace(recording, run=run), make.machine())
    options = {f.id: f for f in build_catalogue(problem).families}["backlash[X]"].options
    assert len(options) == 2
    assert sum(np.exp(o.log_prior) for o in options) == pytest.approx(1.0)
    assert options[1].columns[:7] == pytest.approx(
        -options[0].columns[:7]
    )  # still on the side they came from
    assert options[1].columns[7:] == pytest.approx(options[0].columns[7:])


def test_a_mistake_must_fit_with_its_own_number():
    d = np.zeros(100)
    d[0] = 10.0  # |d| = 10, sigma = 1: u(c) = 0.1
    none = np.zeros((100, 0))
    assert factor_fits(d, 0.2 * d, none, 1.0)  # c = 0.2 is 2 standard deviations
    assert not factor_fits(
        d, 0.4 * d, none, 1.0
    )  # 4 standard deviations: 1.4 times the table's error is no mistake
    assert factor_fits(10 * d, 0.4 * d, none, 1.0)  # c = 0.04: 4 standard deviations, but within 5 %
    assert factor_fits(
        d, 0.4 * d, np.eye(100)[:, :1], 1.0
    )  # the chosen terms hold the departure: nothing to compare


def test_noise_far_above_what_was_stated_or_neighbours_alike_are_not_explained():
    usual = Audit(1.1, 0.6, 0.0, Noise(), ())
    assert reasons_against(True, None, False, "", usual, 1.0) == ()
    assert verdict(True, ()) == "explained"
    assert verdict(False, ()) == "nothing missing"
    said = reasons_against(True, None, False, "", Audit(11.0, 0.95, 0.0, Noise(), ()), 1.0)
    assert len(said) == 2
    assert "11 times the noise" in said[0]
    assert "tells 90% of the next one" in said[1]  # 0.95^2 = 0.9025
    assert verdict(True, said) == "partly explained"
    assert (
        reasons_against(False, None, False, "", Audit(11.0, 0.95, 0.0, Noise(), ()), 11.0) == ()
    )  # no name, no boldness


def scaled_case(modulation: float):
    """A scale error of X of 20 um/m whose size grows by `modulation` per standard deviation of the speed."""
    recording = make.make((), 0.0, 9).recording
    run = recording.run
    speed = np.linalg.norm(run.vector("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s"), axis=1)
    z = (speed - speed.mean()) / speed.std()
    e = -20e-6 * run.position["X"] * (1 + modulation * z) * recording.direction[:, 0]
    problem = make_problem(replace(recording, value=recording.value + e), make.machine())
    white = problem.whitener()
    columns = problem.columns(ScaleFactor("X"), ["k"]) * 5e-6
    option = Option(ScaleFactor("X"), columns, np.array([5e-6]), ("k",), 0.0)
    term = Family("scale_factor", {"axis": "X"}, (option,))
    raw = white.apply(problem.residual)
    setting = Setting(dictionary([term], white), white, raw, 3.0, 3.0, lambda option, r, basis: option)
    return problem, white, fit_jointly([SelectedTerm(term, option, white.apply(columns))], setting)


def test_a_scale_that_grows_with_the_speed_is_not_the_whole_story():
    problem, white, selection = scaled_case(0.6)
    found = find_modulation(problem, selection, white, 5.0)
    assert found is not None
    assert found.covariates == ("X", "speed")
    share = float(found.description.split(": ")[1].split("%")[0]) / 100
    assert share == pytest.approx(0.6, abs=0.15)  # clipping takes a little
    problem, white, selection = scaled_case(0.0)
    assert find_modulation(problem, selection, white, 5.0) is None


def test_a_mean_that_speed_and_place_make_together_is_no_scatter(monkeypatch):
    recording = make.make((), 0.0, 12).recording
    run = recording.run
    speed = np.linalg.norm(run.vector("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s"), axis=1)
    u = (run.position["X"] - run.position["X"].mean()) / run.position["X"].std()
    value = recording.value - 1e-3 * u * speed * recording.direction[:, 0]  # 2 um at 2 mm/s, 8 um at 8 mm/s
    problem = make_problem(replace(recording, value=value), make.machine())
    white = problem.whitener()
    raw = white.apply(problem.residual)
    assert audit(problem, white, raw, 1).growth == 0.0
    monkeypatch.setattr(audits, "VERY_STRONG", np.inf)  # without the product: a scatter that depends on speed
    assert audit(problem, white, raw, 1).growth > 0.0
