"""What a mismatch goes with, on numbers made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.shop.machining.mismatch import LEAST_SCATTER, ObservedPoints, locate_mismatch

SCATTER = 0.5e-3


def observed(rest: np.ndarray, known: float = 0.0) -> ObservedPoints:
    """Two walls, 30 points each, cut along +X by line 5 and along -X by line 7; `known`: u of a radius common to all, mm."""
    n = len(rest)
    sense, half = np.where(np.arange(n) < n // 2, 1.0, -1.0), np.arange(n) % (n // 2)
    normals = np.column_stack([np.zeros(n), sense, np.zeros(n)])
    x = 10.0 + half
    columns = {
        "sense_X": sense, "sense_Y": np.ones(n), "time_s": np.arange(n) * 1.0, "across_tool": np.ones(n), "line": np.where(sense > 0, 5.0, 7.0),
    }  # fmt: skip
    run = Run(
        {"X": x, "Y": 20.0 * sense, "Z": np.zeros(n)}, np.zeros((n, 3)), columns, {"tool": np.full(n, "1")}
    )
    return ObservedPoints(
        rest, known**2 * np.ones((n, n)), normals, np.column_stack([x, 20.0 * sense, half % 5]),
        np.where(sense > 0, "front", "back"), columns["line"].astype(int), run,
    )  # fmt: skip


def noise(seed: int = 0) -> np.ndarray:
    return SCATTER * np.random.default_rng(seed).standard_normal(60)


def test_scatter_alone_says_nothing_and_is_measured():
    at = locate_mismatch(observed(noise()))
    found, scatter = at.entries, at.scatter
    assert found == ()
    assert scatter == pytest.approx(SCATTER, rel=0.2)


def test_false_alarms_are_as_rare_as_promised():
    """One in a thousand at most: 60 parts as predicted, none is accused (probability 0.94 and more)."""
    assert sum(bool(locate_mismatch(observed(noise(seed))).entries) for seed in range(1, 61)) == 0


def test_a_radius_that_is_known_to_be_uncertain_is_no_mismatch():
    """5 um of radius: nothing where u = 3 um is stated for it, 1.7 times; all of it where nothing is stated."""
    rest = noise() + 5e-3
    assert locate_mismatch(observed(rest, known=3e-3)).entries == ()
    (first, *_) = locate_mismatch(observed(rest)).entries
    assert (first.covariate, round(first.rms * 1e3)) == ("tool radius", 5)


def test_what_bends_along_the_path_goes_with_time_and_names_feature_and_line():
    """Nothing on the front, up to 6 um on the back where line 7 cuts, growing with x: the part as it was aligned may turn by it."""
    rest = noise()
    rest[30:] += 6e-3 * (np.arange(30) / 29.0) ** 2
    (first, *_) = locate_mismatch(observed(rest)).entries
    assert (first.feature, first.line) == ("back", 7)
    assert first.p < 1e-3


def test_a_stated_scatter_is_taken_as_it_is():
    """Chi-squared instead of F: 5 um against 0.5 um / sqrt 60 are 77 standard deviations."""
    at = locate_mismatch(observed(noise() + 5e-3), u_point=SCATTER)
    found, scatter = at.entries, at.scatter
    assert scatter == SCATTER
    assert found[0].p < 1e-100


def test_too_few_points_are_told():
    with pytest.raises(UsageError, match=r"8 measured points are too few .* measure at least \d+"):
        locate_mismatch(observed(np.zeros(8)))


def test_points_without_scatter_of_their_own_are_not_held_to_the_least_one():
    """40 parts drawn from a known pass of 2 um that is alike over 5 mm of each wall, read without any error: nothing is accused.

    The least scatter leaves a hundredth of what 60 free points would: against that, every chance of the pass looked significant.
    """
    known = observed(np.zeros(60))
    along, wall = known.place[:, 0], known.normals[:, 1]
    covariance = 4e-6 * np.exp(-((along[:, None] - along) ** 2) / 50.0) * (wall[:, None] == wall)
    rng = np.random.default_rng(3)
    for rest in rng.multivariate_normal(np.zeros(60), covariance, 40):
        at = locate_mismatch(replace(known, rest=rest, covariance=covariance))
        found, scatter = at.entries, at.scatter
        assert (found, scatter) == ((), LEAST_SCATTER)


def test_a_significance_beyond_all_numbers_still_tells_which_is_more():
    """chi-squared of 3: ln Q = ln sqrt(2 x / pi) - x / 2 for large x; at x = 5000 that is 4.032 - 2500."""
    from vcmm.shop.machining.mismatch import _p

    rest = np.array([np.sqrt(5000.0), 0.0, 0.0, 0.0])
    found = _p(np.eye(4), np.zeros((4, 0)), np.eye(4)[:, :3], rest, None)
    assert found == pytest.approx(0.5 * np.log(2.0 * 5000.0 / np.pi) - 2500.0, abs=1e-3)
    near = _p(np.eye(4), np.zeros((4, 0)), np.eye(4)[:, :3], rest / 2.0, None)
    assert near == pytest.approx(0.5 * np.log(2.0 * 1250.0 / np.pi) - 625.0, abs=2e-3)


def test_a_wave_that_nothing_else_follows_leads_and_is_handed_on():
    """4 um every 7.3 s across both walls, 0.5 um of scatter: the unknown is first, with its period."""
    rest = noise()
    points = observed(rest)
    shaken = 4e-3 * np.sin(2 * np.pi * points.run.column("time_s") / 7.3) * points.normals[:, 1]
    found = locate_mismatch(observed(rest + shaken), u_point=SCATTER)
    assert found.entries[0].covariate == "wave in time"
    assert found.wave is not None
    assert found.wave.period == pytest.approx(7.3, rel=0.02)
    assert locate_mismatch(points, u_point=SCATTER).wave is None


def test_what_goes_with_nothing_is_told_where_the_scatter_is_stated():
    """Points that scatter by 1 um where 0.5 um are stated: 60 points, chi-square four times its freedom."""
    found = locate_mismatch(observed(2.0 * noise(3)), u_point=SCATTER)
    assert found.entries[-1].covariate == "nothing that was asked"
    assert "times what is known to be uncertain" in found.entries[-1].text
    assert locate_mismatch(observed(noise(3)), u_point=SCATTER).entries == ()
