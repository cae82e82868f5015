"""The far zone of an axis alone does not refuse what predicts held-out blocks along it."""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import legvander

from tests.learn.diagnosis import generator as make
from vcmm.answer.evaluation.gaussian import posterior
from vcmm.core.declaration import UM
from vcmm.core.run import Run
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.holdout import make_fold, predicts_blocks, worsened_folds
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.select import SelectedTerm, Selection
from vcmm.task.response.folds import fold_masks
from vcmm.task.response.recording import Recording


def judged(true: np.ndarray, columns: np.ndarray) -> tuple[tuple[str, ...], tuple[str, ...], bool]:
    """Folds that a term of these columns (300, k) makes worse: with the zone alone, and with blocks; and what the blocks say."""
    n = len(true)
    x = np.linspace(0.0, 300.0, n)
    value = UM * (true + 0.3 * np.random.default_rng(3).standard_normal(n))
    run = Run({"X": x, "Y": np.zeros(n), "Z": np.zeros(n)}, np.zeros((n, 3)))
    recording = Recording(
        "one",
        "displacement",
        run,
        value=value,
        u=np.full(n, 0.3 * UM),
        measuring=False,
        row=np.arange(n),
        direction=np.tile([1.0, 0, 0], (n, 1)),
        other=np.full(n, -1),
    )
    problem = make_problem(recording, make.machine())
    noise = (problem.u, 0.0)
    white = problem.whitener()
    columns = UM * columns
    term = SelectedTerm(
        Family("shape", {}, ()),
        Option(None, columns, np.ones(columns.shape[1]), ("k",) * columns.shape[1], 0.0),
        white.apply(columns),
        100.0,
    )
    y = white.apply(problem.residual)
    fit = posterior(term.white, y, white.dof, np.full(columns.shape[1], 100.0))
    selection = Selection((term,), fit, y, y - term.white @ fit.mean)
    parts = [make_fold(problem, *noise, name, rows) for name, rows in fold_masks(run, recording.row)]
    return (
        worsened_folds(problem, parts, selection),
        worsened_folds(problem, parts, selection, noise),
        predicts_blocks(problem, noise, selection, "X"),
    )


def test_a_shape_that_goes_astray_beyond_its_rows_and_holds_within_them_stands():
    # a guide that dips at its middle, 2 |s|, by a parabola: fitted from -1 to 0.4, where it mostly falls, it misses what rises beyond;
    # blocks lie between rows that were fitted
    s = np.linspace(-1.0, 1.0, 300)
    alone, beside, within = judged(2.0 * np.abs(s), legvander(s, 2)[:, 1:])
    assert alone == ("far zone X",)
    assert within
    assert beside == ()


def test_a_shape_that_is_astray_in_held_out_blocks_too_is_refused():
    # degree 4 through the same: free enough to swing in the blocks that were held out
    s = np.linspace(-1.0, 1.0, 300)
    alone, beside, within = judged(2.0 * np.abs(s), legvander(s, 4)[:, 1:])
    assert alone == ("far zone X",)
    assert not within
    assert beside == ("far zone X",)


def test_a_level_of_which_blocks_tell_nothing_is_refused():
    # +2 and -2 in turn, block by block, 0 in the last three: a level fitted to every second block is wrong by 4 in the others
    block = np.arange(300) // 30
    true = np.where(block < 7, 2.0, 0.0) * np.where(block % 2, 1.0, -1.0)
    alone, beside, within = judged(true, np.ones((300, 1)))
    assert not within
    assert beside == alone
