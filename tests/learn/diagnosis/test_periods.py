"""Periods that the spacing and the range of the rows can show, and their aliases."""

from __future__ import annotations

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from tests.learn.diagnosis.test_kinds import laser
from vcmm.answer.evaluation.gaussian import whitener
from vcmm.core.laws import Normal
from vcmm.core.run import Run
from vcmm.learn.diagnosis.candidates import Family, Option, build_catalogue
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.holdout import Fold, is_own_zone
from vcmm.learn.diagnosis.periods import (
    alias_words,
    aliases,
    can_show_harmonic,
    can_show_period,
    lattice_frequency,
    nearest_alias,
    whole_fractions,
)
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.refine import Refiner, scanned_names
from vcmm.learn.diagnosis.scans import trials
from vcmm.learn.diagnosis.select import SelectedTerm, Setting, select
from vcmm.learn.diagnosis.sharpen import sharpen
from vcmm.physics.catalogue.pitch import ScrewPitch
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.task.response.recording import Recording

EVERY_4 = np.arange(0, 201, 4.0)  # 51 places
ANYWHERE = np.random.default_rng(1).uniform(0, 200, 51)


def test_lattice_is_found_and_its_parts():
    assert 1 / lattice_frequency(EVERY_4, 10.0) == pytest.approx(4.0, rel=2e-3)
    jitter = np.random.default_rng(2).normal(size=51) * 0.05
    assert 1 / lattice_frequency(EVERY_4 + jitter, 10.0) == pytest.approx(4.0, rel=0.01)
    uneven = np.tile([0.0, 100.0, 250.0, 350.0], 5)  # a common step of 50 mm
    assert 1 / lattice_frequency(uneven, 1.0) == pytest.approx(50.0, rel=0.02)
    assert lattice_frequency(ANYWHERE, 50.0) == np.inf


def test_where_an_axis_stands_while_others_move_it_is_in_step_with_anything_and_says_nothing():
    """A laser runs along Y at uneven places, then along X and Z with Y at 60 and -120 mm: 400 rows in step with 20 mm."""
    places = np.arange(-240.0, 241.0, 20.0) + np.random.default_rng(3).uniform(-4.0, 4.0, 25)
    stands = np.repeat([60.0, -120.0], 200)
    assert np.abs(np.exp(2j * np.pi * np.concatenate([np.repeat(places, 8), stands]) / 20.0).mean()) > 0.85
    assert lattice_frequency(np.concatenate([np.repeat(places, 8), stands]), 1.0) == np.inf
    assert can_show_period(np.concatenate([places, stands]), 20.0)
    lattice = np.arange(-240.0, 241.0, 20.0)
    assert 1 / lattice_frequency(np.concatenate([lattice, stands]), 1.0) == pytest.approx(20.0, rel=2e-3)


def test_no_period_shorter_than_two_steps_nor_longer_than_the_range_carries():
    assert can_show_period(EVERY_4, 8.0)
    assert not can_show_period(EVERY_4, 7.9)
    assert not can_show_period(EVERY_4, 0.02)
    assert can_show_period(EVERY_4, 130.0)
    assert not can_show_period(EVERY_4, 140.0)  # 200 / 140 = 1.43 periods
    assert can_show_period(ANYWHERE, 5.0)  # irregular places have no alias
    assert not can_show_period(np.repeat(np.arange(5) * 100.0, 20), 8.0)  # five targets carry no period
    assert not can_show_period(None, 8.0)


def test_the_alias_has_the_same_numbers():
    # 1 / (1/4 - 1/20) = 1 / 0.2 = 5
    assert nearest_alias(EVERY_4, 20.0) == pytest.approx(5.0, rel=0.01)
    wave = np.cos(2 * np.pi * EVERY_4 / 20.0)
    assert np.allclose(wave, np.cos(2 * np.pi * EVERY_4 / 5.0))
    # at two rows per period the twin at 1/h - f is itself: 1 / (1/4 + 1/8) = 8/3
    assert nearest_alias(EVERY_4, 8.0) == pytest.approx(8 / 3, rel=0.01)
    assert nearest_alias(ANYWHERE, 20.0) is None


def test_lobes_need_more_than_two_directions_each():
    assert not can_show_harmonic(3, np.arange(4) * np.pi / 2)
    assert can_show_harmonic(3, np.arange(12) * np.pi / 6)
    assert not can_show_harmonic(4, np.arange(8) * np.pi / 4)


def two_ends(period, phase, seed):
    """A wave of 0.8 um read at 60 places in the first and last quarter of 500 mm: side lobes 1 / 380 mm apart."""
    rng = np.random.default_rng(seed)
    q = np.sort(np.r_[rng.uniform(0, 120, 30), rng.uniform(380, 500, 30)])
    along, zero = np.tile([1.0, 0.0, 0.0], (60, 1)), np.zeros(60)
    columns = {"nx": np.ones(60), "ny": zero, "nz": zero}
    run = Run({"X": q, "Y": zero, "Z": zero}, np.zeros((60, 3)), columns)
    value = 0.8e-3 * np.sin(2 * np.pi * q / period + phase) + 0.6e-3 * rng.standard_normal(60)
    rows, none = np.arange(60), np.full(60, -1)
    noise = Normal(0.6e-3)
    return Recording("laser", "displacement", run, value, False, rows, along, none, None, {"zero": ""}, noise)


def test_of_a_spectrum_several_lines_are_searched():
    """24.027 mm lies between two lines of the grid (20.8 periods in 500 mm, of a grid of 20.5 and 21); a side lobe near 25.5 mm stands on
    one (19.5) and is higher there. At their best the true line is."""
    problem = make_problem(two_ends(24.027, 0.094, 1), make.machine())
    white = problem.whitener()
    waves = [f for f in build_catalogue(problem).families if f.id == "screw_pitch[X]"]
    setting = Setting(
        dictionary(waves, white), white, white.apply(problem.residual), np.inf, 3.0, Refiner(problem, white)
    )
    first = select(setting)
    (found,) = select(sharpen(setting, first)).terms
    assert first.terms[0].option.effect.period == pytest.approx(25.5, abs=0.2)
    assert found.option.effect.period == pytest.approx(24.027, abs=0.1)


def test_periods_of_an_axis_that_turns_are_whole_fractions_of_a_turn():
    """A sweep of 300 deg asked for 2.1 and 1.3 rad: 2 pi / 3 and 2 pi / 5; over a turn also the turn itself."""
    part, whole = np.linspace(0, np.radians(300), 90), np.linspace(0, 2 * np.pi, 90)
    assert whole_fractions([2.1, 2.05, 1.3], part) == pytest.approx([2 * np.pi / 3, 2 * np.pi / 5])
    assert whole_fractions([2.1], whole) == pytest.approx([2 * np.pi, 2 * np.pi / 3])
    run = Run({"C": whole}, np.zeros((90, 3)), {})
    tried = {
        round(2 * np.pi / c["period"] * c.get("harmonic", 1), 9) for c, _ in trials(ScrewPitch("C"), run)
    }
    assert {1.0, 2.0, 3.0} <= tried
    assert all(k == round(k) for k in tried)
    assert (
        scanned_names(
            Option(ScrewPitch("C", sine=1.0, period=np.pi), np.ones((2, 1)), np.ones(1), ("sine",), 0.0)
        )
        == []
    )


def test_harmonics_of_a_turn_are_not_asked_for_a_part_of_the_turn_that_was_not_fitted():
    def term(effect, **where):
        option = Option(effect, np.ones((2, 1)), np.ones(1), ("c",), 0.0)
        return SelectedTerm(Family(effect.name, where, (option,)), option, option.columns)

    def fold(name):
        plain = whitener(np.ones(5), np.zeros((5, 0)), np.zeros((5, 0)))
        return Fold(name, np.zeros(5, dtype=bool), plain, plain)

    of_turn = term(RotaryCyclic("ECC"), component="ECC")
    assert is_own_zone(of_turn, fold("far zone C"))
    assert not is_own_zone(of_turn, fold("later time"))
    assert not is_own_zone(of_turn, fold("far zone B"))
    assert not is_own_zone(term(ScrewPitch("X"), axis="X"), fold("far zone X"))


def test_a_positioning_run_offers_no_period_that_it_cannot_show():
    problem = make_problem(laser(lambda q, s: 0 * q), make.machine())  # 11 places, 50 mm apart
    found = build_catalogue(problem)
    assert "screw_pitch" in found.invisible
    assert "encoder_interpolation" in found.invisible
    assert not {"screw_pitch", "encoder_interpolation"} & {f.name for f in found.families}


def test_the_alias_is_said():
    def recording():
        from dataclasses import replace

        made = laser(lambda q, s: 0 * q)
        q = np.tile(np.r_[EVERY_4, EVERY_4[::-1]], 3)
        n = len(q)
        from vcmm.core.run import Run

        run = Run({"X": q, "Y": np.zeros(n), "Z": np.zeros(n)}, np.zeros((n, 3)), {})
        noise = 0.6e-3 * np.random.default_rng(5).standard_normal(n)
        return replace(
            made,
            run=run,
            value=1.5e-3 * np.sin(2 * np.pi * q / 20.0 + 0.4) + noise,
            row=np.arange(n),
            direction=np.tile([1.0, 0.0, 0.0], (n, 1)),
            other=np.full(n, -1),
        )

    found = diagnose_recording(recording(), make.machine(), 1, 500)
    assert found.answer[0].effect == "screw_pitch"
    assert "20" in found.answer[0].remark
    words = found.answer[0].remark.split()
    assert float(words[words.index("alias") + 1]) == pytest.approx(5.0, rel=0.02)


def test_all_aliases_down_to_usual_leads_are_listed():
    # steps of 23.7 mm: 1 / (1/10 - 2/23.7) = 237 / 3.7 = 64.05 mm; 1 / (1/23.7 - 1/64.05) = 37.6 mm
    q = np.arange(0, 800, 23.7)
    found = aliases(q, 64.05)
    assert found[0] == pytest.approx(37.6, rel=0.01)
    assert min(abs(p - 10.0) for p in found) < 0.05
    wave = ScrewPitch("X", 1e-3, 0.0, 64.05)
    said = alias_words(wave, Run({"X": q}, np.zeros((len(q), 3))))
    assert "its alias 37.6" in said
    assert " 10" in said
    assert "unequal steps" in said


def test_a_screw_has_no_lead_of_half_a_metre():
    q = np.random.default_rng(1).uniform(0, 800, 200)  # nothing has a twin at such places
    screw = Run({"X": q}, np.zeros((200, 3)))
    periods = [c["period"] for c, _ in trials(ScrewPitch("X"), screw)]
    assert 35.0 < max(periods) <= 40.0
    # every 12.5 mm a lead of 10 mm has the numbers of 50 mm, 1 / (1/10 - 1/12.5): this stays
    steps = np.arange(0, 801, 12.5)
    long = [
        c["period"]
        for c, _ in trials(ScrewPitch("X"), Run({"X": steps}, np.zeros((65, 3))))
        if c["period"] > 40
    ]
    assert min(abs(p - 50.0) for p in long) < 2.0
    assert not [p for p in long if p > 250.0]


def test_at_two_steps_only_one_phase_is_seen():
    q = np.arange(0, 800, 25.0)
    said = alias_words(ScrewPitch("X", 1e-3, 0.0, 50.0), Run({"X": q}, np.zeros((len(q), 3))))
    assert "cannot be separated" in said
    assert " 10" in said  # 1 / (3/25 - 1/50)
