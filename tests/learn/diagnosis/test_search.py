"""The search settles on the answer that is worth most of all rows, whatever it began with."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from vcmm.answer.evaluation.gaussian import whitener
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import Refiner
from vcmm.learn.diagnosis.search import count_extra_names, evidence_of_all_rows, search_names, settle_names
from vcmm.learn.diagnosis.select import Setting, clean_outliers, select
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.play import BacklashRamp

ROWS = 200
RNG = np.random.default_rng(3)
NOISE = RNG.standard_normal(ROWS)


def setting_of(observed, **names):
    """Rows of white noise 1 and names with their columns (m, k), nothing of them scanned."""
    white = whitener(np.ones(ROWS), np.zeros((ROWS, 0)), np.zeros((ROWS, 0)))
    families = [Family(n, {}, (_option(x),), 0.0) for n, x in names.items()]
    refine = Refiner(cast(Problem, None), white)  # with nothing to be scanned no problem is asked
    return Setting(dictionary(families, white), white, observed, 3.0, 3.5, refine)


def _option(x):
    return Option(None, x, np.ones(x.shape[1]), tuple(map(str, range(x.shape[1]))), 0.0)


def names_of(selection):
    return sorted(t.family.name for t in selection.terms)


def test_a_curve_that_explains_most_alone_does_not_hide_two_simple_names_that_explain_as_much():
    """Two signals of delta 10 and 8: together 82 nats. A curve of eight numbers that holds their sum is worth more than either
    alone, and neither adds anything beside it.
    """
    one, two = (x / np.linalg.norm(x) for x in RNG.standard_normal((2, ROWS)))
    true = 10.0 * one + 8.0 * two
    free = np.column_stack([true / np.linalg.norm(true), RNG.standard_normal((ROWS, 7)) / np.sqrt(ROWS)])
    setting = setting_of(true + NOISE, one=one[:, None], two=two[:, None], curve=free)
    assert names_of(select(setting)) == ["curve"]
    assert names_of(search_names(setting, None)[0]) == ["one", "two"]


def test_a_ramp_that_another_name_explains_is_no_part_of_a_play():
    """Play of delta 20, and a signal of delta 12 half of which looks like its ramp. Alone the play with a ramp is worth more than the
    play; beside the other name it is not, and one number is left of it.
    """
    sense, way, other = (x / np.linalg.norm(x) for x in np.random.default_rng(8).standard_normal((3, ROWS)))
    both = (way + other) / np.sqrt(2.0)
    setting = setting_of(20.0 * sense + 12.0 * both + NOISE, play=sense[:, None], other=both[:, None])
    plain = replace(_option(sense[:, None]), effect=Backlash("Y"), log_prior=-np.log(2.0))
    ramp = replace(_option(np.column_stack([sense, way])), effect=BacklashRamp("Y"), log_prior=-np.log(2.0))
    play, one = setting.candidates.families
    families = (replace(play, options=(plain, ramp)), one)
    as_it_is = cast(Refiner, lambda option, r, basis: option)
    setting = replace(setting, candidates=dictionary(families, setting.white), refine=as_it_is)
    alone = replace(setting, candidates=dictionary(families[:1], setting.white))
    assert [t.white.shape[1] for t in select(alone).terms] == [2]
    assert [(t.family.name, t.white.shape[1]) for t in select(setting).terms] == [("play", 1), ("other", 1)]


def test_two_bad_readings_are_no_step():
    """Near the end two readings are 12 standard deviations off: a step of the last six rows takes them for its own."""
    rows = NOISE.copy()
    rows[[-2, -5]] += 12.0
    late = (np.arange(ROWS) >= ROWS - 6).astype(float)[:, None]
    setting = setting_of(rows, step_of_six=late)
    assert names_of(select(clean_outliers(setting))) == ["step_of_six"]
    assert names_of(search_names(setting, None)[0]) == []
    assert names_of(search_names(setting_of(NOISE + 5.0 * late[:, 0], step_of_six=late), None)[0]) == [
        "step_of_six"
    ]


def test_a_mistake_of_the_table_is_a_name_that_pays_like_any_other():
    """Beside the same curve it is one name more; in place of two names, one less; alone against a weak name, as many."""
    curve = search_names(setting_of(10.0 * NOISE[::-1] + NOISE, it=NOISE[::-1, None]), None)[0].terms
    assert len(curve) == 1
    assert count_extra_names(curve, curve) == 1
    assert count_extra_names((), (*curve, *curve)) == -1
    assert count_extra_names((), ()) == 0


def test_one_bad_reading_is_no_name_and_a_name_of_several_readings_stays():
    """The first reading is 12 standard deviations off, and a signal that dies away over a row takes it for its own: about it the row
    is no outlier, and by the law of heavy tails that is worth 3 nats more than the name has to pay. Four such readings are worth
    more without any one of them: named, though they are outliers about nothing, where each counts as 3 standard deviations.
    """
    rows = NOISE.copy()
    rows[0] = -12.0
    dying = np.exp(-np.arange(ROWS) / 0.5)[:, None]
    setting = replace(setting_of(rows, first_reading=dying), threshold=6.0)
    about, none = clean_outliers(setting), select(setting)
    answer = select(about)
    assert (names_of(answer), names_of(none)) == (["first_reading"], [])
    assert evidence_of_all_rows(answer, about) > evidence_of_all_rows(none, setting) + 3.0
    assert names_of(search_names(setting, None)[0]) == []
    assert names_of(settle_names(answer, setting, setting, None)[0]) == []  # as beside a mistake of the table
    four = (np.arange(ROWS) < 4).astype(float)[:, None]
    setting = replace(setting_of(NOISE - 12.0 * four[:, 0], first_readings=four), threshold=16.0)
    assert names_of(select(setting)) == []
    assert names_of(search_names(setting, None)[0]) == ["first_readings"]
