"""Scatter per move and per pass, found in a part: against the analysis of variance by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.shop.machining.scatter_sizes import scatter_notes, scatter_sizes

MOVES, EACH = 60, 6
MOVE = np.repeat(np.arange(MOVES), EACH)
UP = np.tile([0.0, 0.0, 1.0], (MOVES * EACH, 1))
POINT, STATED = 0.3e-3, 0.5e-3
NONE = np.zeros((MOVES * EACH, 0))


def found(rest, groups, *, shapes=NONE, u=STATED, stated=NONE):
    other = POINT**2 * np.eye(len(rest))
    return scatter_sizes(rest, other, shapes, stated, UP[: len(rest)], groups, u, POINT)


@pytest.mark.parametrize("size", [0.5e-3, 1.5e-3])
def test_a_draw_per_move_is_found_as_the_analysis_of_variance_finds_it(size):
    """Mean square between moves = POINT^2 + EACH u^2 (one-way analysis of variance): u of these very draws. Known to 1/sqrt(2 x 60) = 9 %."""
    rng = np.random.default_rng(4)
    rest = rng.normal(0.0, size, MOVES)[MOVE] + rng.normal(0.0, POINT, len(MOVE))
    between = EACH * np.var(rest.reshape(MOVES, EACH).mean(axis=1), ddof=1)
    by_hand = np.sqrt((between - POINT**2) / EACH)
    sizes = found(rest, (MOVE, MOVE // 10))
    assert np.hypot(sizes.per_move, sizes.per_pass) == pytest.approx(by_hand, rel=0.2)
    assert sizes.per_move > 2.0 * sizes.per_pass
    assert sizes.is_larger == (size > np.sqrt(2.0) * STATED)
    assert ("[repeatability]" in "".join(scatter_notes(sizes))) == sizes.is_larger


def test_a_draw_per_pass_is_told_from_one_per_move():
    rng = np.random.default_rng(5)
    whole = MOVE // 4
    rest = rng.normal(0.0, STATED, MOVES // 4)[whole] + rng.normal(0.0, POINT, len(MOVE))
    sizes = found(rest, (MOVE, whole))
    assert sizes.per_pass == pytest.approx(STATED, rel=0.5)
    assert sizes.per_pass > 2.0 * sizes.per_move


def test_what_has_the_form_of_an_error_of_the_machine_is_no_scatter():
    """A step of 5 um between the halves of the part, which one of the shapes has: the sizes are the same with and without it."""
    rng = np.random.default_rng(6)
    rest = rng.normal(0.0, STATED, MOVES)[MOVE] + rng.normal(0.0, POINT, len(MOVE))
    step = np.where(MOVE < MOVES // 2, 1.0, -1.0)[:, None]
    with_it = found(rest + 5e-3 * step[:, 0], (MOVE, MOVE // 10), shapes=step)
    without = found(rest, (MOVE, MOVE // 10), shapes=step)
    assert with_it.per_move == pytest.approx(without.per_move, rel=1e-6)
    taken = found(rest + 5e-3 * step[:, 0], (MOVE, MOVE // 10))
    assert np.hypot(taken.per_move, taken.per_pass) > 3.0 * without.total


def test_where_nothing_can_be_learnt_the_statement_holds_in_equal_shares():
    """Shapes that have every point: u^2 = u_move^2 + u_pass^2 + u_along^2 with a third for each."""
    n = 12
    sizes = scatter_sizes(
        np.ones(n),
        np.eye(n),
        np.eye(n),
        STATED * np.eye(n),
        UP[:n],
        (MOVE[:n], MOVE[:n]),
        STATED,
        POINT,
    )
    assert sizes.total == pytest.approx(STATED, rel=0.1)  # the grid goes in steps of 1.4, farther upwards
    assert sizes.per_move == pytest.approx(sizes.per_pass)
    assert sizes.per_move == pytest.approx(sizes.along * STATED)
    assert sizes.per_move == pytest.approx(STATED / np.sqrt(3.0), rel=0.1)


def test_the_covariance_handed_on_has_the_sizes():
    rng = np.random.default_rng(7)
    rest = rng.normal(0.0, STATED, MOVES)[MOVE] + rng.normal(0.0, POINT, len(MOVE))
    sizes = found(rest, (MOVE, MOVE // 10))
    columns = dict(sizes.columns)
    assert set(columns) == {"scatter.per_move", "scatter.per_pass"}
    cov = columns["scatter.per_move"] @ columns["scatter.per_move"].T
    assert cov[0, 1] == pytest.approx(sizes.per_move**2)  # two points of one move
    assert cov[0, EACH] == 0.0  # and of two
