"""Smooth courses of time without a name, and what names pay against them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis.test_field import UM, searched
from vcmm.learn.diagnosis.field import rival_field
from vcmm.learn.diagnosis.kernels import clock_bumps, find_departure, scale_courses
from vcmm.learn.diagnosis.select import SelectedTerm, fit_jointly


def course(run) -> np.ndarray:
    """A heat source that runs through the middle of the recording, felt smoothly; -1 to 1."""
    z = (run.column("time_s") - run.column("time_s").min()) / np.ptp(run.column("time_s"))
    return np.tanh((z - 0.25) / 0.08) - np.tanh((z - 0.6) / 0.12) - 1.0


def breathing(run, direction):
    """The scale of Y held at its zero: 4 um over the travel."""
    q = run.position["Y"]
    return 4.0 * UM * course(run) * q / np.abs(q).max() * direction[:, 1]


def growing(run, direction):
    """The part larger and smaller about its middle, 3 um at its farthest point."""
    away = (run.part_point * direction).sum(axis=1)
    return 3.0 * UM * course(run) * away / np.abs(away).max()


def test_bumps_over_the_clock_are_half_their_width_apart():
    """Width 0.4 of 1000 s: centres each 200 s; one width (400 s) away exp(-1/2) = 0.6065, half a width 0.8825."""
    bumps = clock_bumps(np.array([0.0, 200.0, 400.0, 1000.0]), 0.4)
    assert bumps.shape == (4, 6)
    assert bumps[:3, 0] == pytest.approx([1.0, 0.8825, 0.6065], abs=1e-4)
    assert bumps[3, 5] == 1.0


def test_scales_and_part_are_felt_through_the_chain():
    """A scale that is 1 at the farthest place moves the tip by q / |q|max along its axis; a touch reads n_y of it.

    Every bump of a width added up, times the factor: the ratio to the sum of the bumps is the factor itself.
    """
    problem, *_ = searched((), 0.0, 11)
    q, n = problem.run.position["Y"], problem.recording.direction
    total = problem.per_observation(clock_bumps(problem.run.column("time_s"), 0.15)).sum(axis=1)
    found = [c for c in scale_courses(problem) if c.names == ("time", "Y")]
    factor = (
        found[2].columns.sum(axis=1) / total
    )  # widths 0.06, 0.15, 0.4, of each about the zero and about anywhere
    assert np.abs(factor) == pytest.approx(np.abs(q / np.abs(q).max() * n[:, 1]), abs=1e-9)
    (_, part, _) = (c for c in scale_courses(problem) if c.names == ("time",))
    away = (problem.run.part_point * n).sum(axis=1)
    assert np.abs(part.columns.sum(axis=1) / total) == pytest.approx(
        np.abs(away) / np.abs(away).max(), abs=1e-9
    )


@pytest.mark.parametrize(("hidden", "what"), [(breathing, "a scale of Y"), (growing, "a size of the part")])
@pytest.mark.thorough
def test_a_course_without_a_name_is_seen_and_takes_the_place_of_names(hidden, what):
    problem, white, null, selection, setting = searched((), 0.0, 7, hidden)
    alone = find_departure(problem, fit_jointly((), setting), white, null)
    assert alone is not None
    assert "time" in alone.covariates
    assert selection.terms  # sensors follow it, or a load
    field = rival_field(problem, selection, setting, null)
    assert field is not None
    assert field.replaces_names
    assert field.superfluous == tuple(range(len(selection.terms)))
    assert field.unknown.description.startswith(f"{what} that changes with time")


@pytest.mark.thorough
def test_a_right_course_of_a_sensor_keeps_its_name():
    problem, _white, null, selection, setting = searched(("thermal_drift",), 12.0, 23)
    assert {t.family.name for t in selection.terms} == {"thermal_drift"}
    field = rival_field(problem, selection, setting, null)
    assert field is None or not field.replaces_names


@pytest.mark.thorough
def test_names_pay_their_priors_and_each_beyond_the_first_the_threshold():
    """Two names against one field: with priors 2 nats lower the lead rises by 2 each, with the threshold 1 nat higher by 1."""
    problem, white, null, selection, setting = searched((), 0.0, 7, growing)
    play = next(f for f in setting.candidates.families if f.id == "backlash[X]")
    option = play.options[0]
    selection = fit_jointly(
        (*selection.terms, SelectedTerm(play, option, white.apply(option.columns), 1.0)), setting
    )
    terms = selection.terms
    assert len(terms) == 2

    def lead(less: float, more: float) -> float:
        dearer = tuple(
            replace(t, option=replace(t.option, log_prior=t.option.log_prior - less)) for t in terms
        )
        asked = replace(setting, threshold=setting.threshold + more)
        field = rival_field(problem, replace(selection, terms=dearer), asked, null)
        assert field is not None
        assert field.superfluous == tuple(range(len(terms)))
        return field.lead

    assert lead(2.0, 0.0) - lead(0.0, 0.0) == pytest.approx(2.0 * len(terms))
    assert lead(0.0, 1.0) - lead(0.0, 0.0) == pytest.approx(len(terms) - 1.0)
