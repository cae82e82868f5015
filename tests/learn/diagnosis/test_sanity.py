"""Rubbish is named with its rows and never becomes a confident story."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Run, Series
from vcmm.learn.diagnosis.candidates import build_catalogue
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.machine_match import noise_warning
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.sanity import check_recording, copied_rows, duration_text, without_gaps
from vcmm.physics.structure.component import ComponentTable
from vcmm.task.response.recording import Recording

UM = 1e-3


@pytest.fixture(scope="module")
def good():
    return make.make((), 0.0, 3, replace(make.RICH, n=200)).recording


def with_columns(recording, **columns):
    return replace(recording, run=recording.run.with_columns(columns))


def appended(recording, rows):
    """Some rows once more at the end, as a careless copy makes them."""
    n = recording.run.n
    both = np.concatenate([np.arange(n), rows])
    return replace(
        recording,
        run=recording.run.take(both),
        value=recording.value[both],
        row=np.arange(len(both)),
        direction=recording.direction[both],
        other=recording.other[both],
        lines=np.arange(len(both)) + 2,
    )


def test_a_healthy_recording_raises_no_word(good):
    found = check_recording(good, make.machine())
    assert found.warnings == ()
    assert not found.doubtful
    assert found.recording is good


def test_copied_rows_count_once_and_are_named_by_line(good):
    found = check_recording(appended(good, np.arange(60)), make.machine())
    assert found.recording.m == 200
    assert "lines 202, 203" in found.warnings[0]
    assert "copies" in found.warnings[0]
    whole = check_recording(appended(good, np.arange(200)), make.machine())  # even all of them
    assert whole.recording.m == 200


def test_equal_readings_of_a_coarse_dial_are_no_copies(good):
    # 20 places, 10 touches each, readings in steps of 1 um with a scatter of 1 um: a repeat says nothing
    n = good.m
    place = {a: q[np.arange(n) % 20] for a, q in good.run.position.items()}
    same = {
        c: np.full(n, 20.0) if c.startswith("temp_") else v
        for c, v in good.run.columns.items()
        if c != "time_s"
    }
    run = Run(place, good.run.offset[np.arange(n) % 20], same, {})
    value = np.round(np.random.default_rng(1).normal(0, 1 * UM, n), 3)
    direction = good.direction[np.arange(n) % 20]
    coarse = replace(good, run=run, value=value, direction=direction, nuisance={})
    assert not copied_rows(coarse)[0].any()
    slow = replace(coarse, run=run.with_columns({"time_s": np.floor(np.arange(n) / 50)}))  # 50 rows a second
    assert not copied_rows(slow)[0].any()
    fine = replace(coarse, value=np.random.default_rng(1).normal(0, 1 * UM, n))
    once = replace(fine, value=np.where(np.arange(n) == 120, fine.value[100], fine.value))
    assert not copied_rows(once)[0].any()  # a place was touched again and read the same: a repeat
    rows = np.arange(n)
    three = replace(fine, value=np.where((rows >= 120) & (rows < 123), fine.value[rows - 20], fine.value))
    assert np.flatnonzero(copied_rows(three)[0]).tolist() == [120, 121, 122]


def test_a_column_that_is_impossible_everywhere_goes_and_the_rows_stay(good):
    run = good.run.with_columns(
        {"pressure_hPa": np.zeros(good.m), "temp_air_C": good.run.columns["temp_air_C"]}
    )
    found = check_recording(replace(good, run=run), make.machine())
    assert found.recording.m == good.m
    assert "pressure_hPa" not in found.recording.run.columns
    assert "pressure_hPa = 0 in 200 of 200 observations" in found.warnings[0]
    assert "not testable" in found.warnings[0]


def test_what_depends_on_a_thermometer_that_stands_still_is_no_candidate(good):
    n = good.m
    moving = {"temp_air_C": 20 + np.linspace(0, 2, n), "temp_scale_x_C": np.full(n, 22.5)}
    still = replace(good, run=replace(good.run, columns={**good.run.columns, **moving}, series={}))
    known = build_catalogue(make_problem(still, make.machine()))
    assert not [f for f in known.families if f.name == "scale_expansion" and f.where["axis"] == "X"]
    assert not [f for f in known.families if f.where.get("sensor") == "scale_x"]


def test_a_dead_sensor_is_refused(good):
    with pytest.raises(ModelLimit, match="dead sensor"):
        check_recording(replace(good, value=np.full(good.m, 3 * UM)), make.machine())


def test_a_sensor_that_hangs_and_one_at_its_stop_lose_these_rows(good):
    value = good.value.copy()
    value[50:70] = value[50]
    found = check_recording(replace(good, value=value), make.machine())
    assert found.recording.m == 180
    assert "51, 52" in found.warnings[0]
    limit = np.quantile(good.value, 0.93)
    stopped = check_recording(replace(good, value=np.minimum(good.value, limit)), make.machine())
    assert "saturated" in stopped.warnings[0]
    assert stopped.recording.m == int((good.value < limit).sum())
    assert stopped.doubtful is bool((good.value >= limit).mean() > 0.1)


def test_coarse_readings_are_no_fault(good):
    coarse = replace(good, value=np.round(good.value, 3))  # 1 um steps
    assert check_recording(coarse, make.machine()).recording.m == 200


def test_impossible_conditions_are_named(good):
    warm = good.run.columns["temp_part_C"].copy()
    warm[7] = 850.0
    found = check_recording(with_columns(good, temp_part_C=warm), make.machine())
    assert found.recording.m == 199
    assert "row 8" in found.warnings[0]
    assert "850" in found.warnings[0]
    with pytest.raises(ModelLimit, match="since_reversal_X_mm"):
        check_recording(with_columns(good, since_reversal_X_mm=np.full(200, -1.0)), make.machine())
    log = good.run.series["air"]
    broken = Series(log.time, np.where(np.arange(len(log.time)) == 5, -273.0, log.value))
    bad = replace(good, run=replace(good.run, series={**good.run.series, "air": broken}))
    with pytest.raises(ModelLimit, match="log of air"):
        check_recording(bad, make.machine())


def test_dead_thermometer_fahrenheit_and_gap(good):
    dead = check_recording(with_columns(good, temp_part_C=np.full(200, 20.0)), make.machine()).warnings
    assert any("temp_part_C never changes" in w for w in dead)
    names = [c for c in good.run.columns if c.startswith("temp_") and c != "temp_gradient_C"]
    hot = with_columns(good, **{c: 1.8 * good.run.columns[c] + 32 for c in names})
    assert any("degF" in w for w in check_recording(hot, make.machine()).warnings)
    time = good.run.columns["time_s"] + np.where(np.arange(200) >= 120, 50000.0, 0.0)
    found = check_recording(with_columns(good, time_s=time), make.machine())
    assert any("rows 120 and 121" in w for w in found.warnings)
    before = without_gaps(np.arange(200) - 1, time)
    assert before[120] == -1
    assert (before[1:120] == np.arange(119)).all()


def test_reversed_speeds_and_senses_are_said(good):
    speeds = {f"speed_{a}_mm_s": -good.run.columns[f"speed_{a}_mm_s"] for a in "XYZ"}
    found = check_recording(with_columns(good, **speeds), make.machine()).warnings
    assert any("away from the surface" in w for w in found)
    sense = {f"sense_{a}": -np.sign(good.run.columns[f"speed_{a}_mm_s"]) for a in "XYZ"}
    assert any(
        "opposite signs" in w for w in check_recording(with_columns(good, **sense), make.machine()).warnings
    )


def tables():
    grid = np.linspace(-1000, 1000, 41)
    rng = np.random.default_rng(4)
    return [ComponentTable(f"E{a}{a}", (a,), (grid,), rng.normal(size=41) * 2 * UM) for a in "XYZ"]


@pytest.mark.thorough
def test_a_recording_of_the_other_sign_is_recognised():
    case = make.make((), 0.0, 9, replace(make.RICH, n=300)).recording
    machine = make.machine(*tables())
    from vcmm.task.response.observe import baseline

    flipped = replace(
        case, value=case.value - baseline(case, machine)
    )  # value = noise - what the machine predicts
    found = diagnose_recording(flipped, machine, 1, 300)
    assert found.mistake is not None
    assert (found.mistake.component, found.mistake.what) == ("all", "sign")
    assert any("observed" in w for w in found.warnings)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda p: np.diag([1.0, 1.0, -1.0]) @ p - p, "axis Z counted the other way"),
        (lambda p: 25.4 * p - p, "inches"),
        (lambda p: p[[1, 0, 2]] - p, "X and Y exchanged"),
    ],
)
def test_residuals_of_millimetres_are_refused_and_explained(good, change, word):
    tip = (np.stack([good.run.position[a] for a in "XYZ"], axis=1) + good.run.offset).T
    moved = change(tip).T
    bad = replace(good, value=good.value - (moved * good.direction).sum(axis=1), nuisance={})
    with pytest.raises(ModelLimit, match=word):
        diagnose_recording(bad, make.machine(), 1, 100)


@pytest.mark.parametrize(
    ("factor", "word"),
    [(1000.0, "readings in um for mm"), (1 / 25.4, "readings in inches for mm"), (0.0, "deviations already")],
)
def test_readings_of_one_axis_in_another_unit_are_explained(factor, word):
    """A line along Y: 40 readings that should be near the commanded 0 to 100 mm are given in um, in inches, or are the deviations."""
    q = np.linspace(0.0, 100.0, 40)
    run = Run({"X": np.zeros(40), "Y": q, "Z": np.zeros(40)}, np.zeros((40, 3)))
    recording = Recording(
        name="line", kind="displacement", run=run, value=(factor - 1.0) * q, measuring=False, row=np.arange(40),
        direction=np.tile([0.0, 1.0, 0.0], (40, 1)), other=np.full(40, -1, dtype=np.intp), nuisance={"zero": ""},
        u=np.full(40, 1e-3),
    )  # fmt: skip
    with pytest.raises(ModelLimit, match=word):
        diagnose_recording(recording, make.machine(), 1, 100)


def test_a_missing_alignment_is_named(good):
    turn = np.array([0.0, 0.0, 0.02])
    tip = np.stack([good.run.position[a] for a in "XYZ"], axis=1) + good.run.offset
    moved = np.cross(turn, tip) + [3.0, -2.0, 1.0]
    bad = replace(good, value=good.value - (moved * good.direction).sum(axis=1), nuisance={})
    with pytest.raises(ModelLimit, match="alignment"):
        diagnose_recording(bad, make.machine(), 1, 100)


@pytest.mark.thorough
def test_single_wild_rows_are_named_and_do_not_decide(good):
    value = good.value.copy()
    value[[10, 90]] += 12.0
    found = diagnose_recording(replace(good, value=value), make.machine(), 1, 300)
    assert any("rows 11 and 91" in w for w in found.warnings)
    assert found.answer == ()


@pytest.mark.thorough
def test_units_of_the_observation_are_suspected(good):
    found = diagnose_recording(replace(good, value=good.value / 1000), make.machine(), 1, 300)
    assert any("units" in w for w in found.warnings)
    assert found.verdict == "unexplained"
    assert noise_warning(1.3) is None


def test_more_nuisance_than_rows_is_refused(good):
    few = good.take(np.arange(0, 200, 10))
    with pytest.raises(ModelLimit, match="nuisance"):
        diagnose_recording(
            replace(few, nuisance={"rigid": "pose", "offset": "event"}), make.machine(), 1, 100
        )


def test_one_thermometer_in_fahrenheit_and_one_that_stands_still_are_told(good):
    names = [c for c in good.run.columns if c.startswith("temp_") and c != "temp_gradient_C"]
    one = with_columns(good, temp_air_C=1.8 * good.run.columns["temp_air_C"] + 32)  # 20 degC are 68 degF
    said = [w for w in check_recording(one, make.machine()).warnings if "degF" in w]
    assert len(said) == 1
    assert said[0].startswith("temp_air_C: about")
    calm = {c: 20.0 + 0.2 * (good.run.columns[c] - good.run.columns[c].mean()) for c in names}
    dead = check_recording(
        with_columns(good, **{**calm, "temp_air_C": np.full(200, 20.99)}), make.machine()
    ).warnings
    assert any("temp_air_C never changes" in w for w in dead)  # the others move by 0.5 K or so
    motor = with_columns(good, temp_air_C=good.run.columns["temp_air_C"] + 65.0)  # 85 is no workshop in degF
    assert not any("degF" in w for w in check_recording(motor, make.machine()).warnings)


def test_positions_in_inches_are_told_where_something_disagrees(good):
    run = good.run
    position = {a: q / 25.4 for a, q in run.position.items()}
    small = replace(good, run=replace(run, position=position))  # the points of the part stay in mm
    assert any("inches" in w for w in check_recording(small, make.machine()).warnings)
    few = {k: v for k, v in run.columns.items() if not k.startswith("part_")}
    small = replace(good, run=replace(run, position=position, columns=few))
    assert not any(
        "inches" in w for w in check_recording(small, make.machine()).warnings
    )  # a small artefact looks so
    digits = {a: np.round(q, 4) / 25.4 for a, q in run.position.items()}
    small = replace(good, run=replace(run, position=digits, columns=few))
    assert any("inches" in w for w in check_recording(small, make.machine()).warnings)


def test_a_time_is_told_in_its_unit():
    assert duration_text(0.336) == "0.336 s"
    assert duration_text(40.0) == "40 s"
    assert duration_text(720.0) == "12 min"
    assert duration_text(7200.0) == "2 h"


def test_a_residual_of_minus_twice_the_known_errors_is_told():
    from vcmm.learn.diagnosis.job import multiple_of_prediction
    from vcmm.physics.structure.squareness import Squareness
    from vcmm.task.response.observe import baseline

    case = make.make((), 0.0, 9, replace(make.RICH, n=200)).recording
    machine = make.machine(Squareness("C0Y", 60e-6))
    known = baseline(case, machine)
    c, u = multiple_of_prediction(replace(case, value=case.value - known), machine)  # r = -known - known
    assert abs(c + 2.0) < 3 * u < 0.5
    c, u = multiple_of_prediction(replace(case, value=case.value + known), machine)
    assert abs(c) < 3 * u


def at_one_place(value_um: np.ndarray) -> Recording:
    """Readings of one place, um, without a clock."""
    n = len(value_um)
    run = Run({"X": np.full(n, 50.0)}, np.zeros((n, 3)))
    return Recording(
        "place", "displacement", run, value=value_um * 1e-3, measuring=False, row=np.arange(n),
        direction=np.tile([1.0, 0, 0], (n, 1)), other=np.full(n, -1),
    )  # fmt: skip


def test_identical_repeats_of_a_place_that_was_reached_from_two_sides_are_no_copies():
    """Two sides 60 um apart, scatter 2 um, display 1 um: of two readings of one side 1 / (2 sqrt(pi) 2) = 14 % are equal; of a scatter
    of 30 um, which both sides together seem to have, 1 % would be.
    """
    rng = np.random.default_rng(8)
    both = np.round(np.concatenate([rng.normal(30, 2, 20), rng.normal(-30, 2, 20)]))
    assert len(np.unique(both)) < 25  # many are equal
    assert not copied_rows(at_one_place(both))[0].any()


def test_rows_of_a_fine_display_that_stand_twice_are_copies():
    rng = np.random.default_rng(9)
    fine = np.round(np.concatenate([rng.normal(10, 1, 20), rng.normal(-10, 1, 20)]), 4)
    twice = np.concatenate([fine, fine[:7]])
    assert np.flatnonzero(copied_rows(at_one_place(twice))[0]).tolist() == list(range(40, 47))
