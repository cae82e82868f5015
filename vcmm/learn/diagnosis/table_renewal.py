"""Renew the stored tables of a calibration that is stale as a whole, as far as the rows determine them.

    theta = stored + F z,   z ~ N(0, s^2),   F F' the stated covariance of the tables,   s from the evidence

The posterior of z given the rows (linear Gaussian, nuisance free, the other Inputs at what they state) moves the tables and gives their
uncertainty; where there are no rows, s^2 times the stated covariance stays. It is handed over where it predicts rows that
were not fitted: every second row from the others, both ways. Rasmussen & Williams, Gaussian Processes (2006), 2.2 and 5.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES, Ints, Posterior, posterior
from vcmm.core.effect import Effect, own_nodes, with_parameter
from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.constants import FEWEST, STRONG
from vcmm.learn.diagnosis.holdout import Fold, HeldOut, make_fold, predict_fold
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import SelectedTerm, Selection
from vcmm.physics.structure.component import CalibrationModes

WIDER = tuple(
    2.0**k for k in range(len(SCALES))
)  # times the stated uncertainty: a calibration that is worse is none
HALVES = ("even rows", "odd rows")


@dataclass(frozen=True, eq=False)
class RenewedTables:
    """errors, position (k,): error name and node of each number (nan: one number, a squareness); change (k,) mm or rad, to be added
    to what is stored; covariance (k, k); wider: s; held_out: every second row as the others predict it.
    """

    errors: tuple[str, ...]
    position: Array
    change: Array
    covariance: Array
    wider: float
    held_out: tuple[HeldOut, ...]

    @property
    def holds(self) -> bool:
        """Whether it predicts rows that were not fitted better than the stored tables do, in both halves and beyond chance."""
        gains = [h.gain for h in self.held_out]
        better = all(h.rms_after < h.rms_before and h.gain > 0 for h in self.held_out)
        return len(gains) == len(HALVES) and better and sum(gains) > STRONG

    def of(self, error: str) -> Ints:
        """Return the numbers (j,) of `change` that belong to one error."""
        return np.flatnonzero([e == error for e in self.errors])


@dataclass(frozen=True, eq=False)
class _TableInput:
    """One Input on stored tables: its columns (m, r) per draw of unit variance, and factor (k, r) of its k numbers."""

    name: str
    columns: Array
    errors: tuple[str, ...]
    position: Array
    factor: Array


def renew_tables(problem: Problem, stage: Stage, selection: Selection, stale: int) -> RenewedTables | None:
    """Return the renewed tables, from the residual of the other terms of a selection; stale: number of the term of the stale calibration. None where
    no Input acts on a table over one axis, or rows are too few.
    """
    blocks = [b for item in problem.machine.inputs if (b := _block(problem, item)) is not None]
    if not blocks:
        return None
    assert selection.fit is not None
    rest = problem.residual.copy()
    for i, term in enumerate(selection.terms):
        if i != stale:
            rest -= term.option.columns @ selection.fit.mean[selection.span(i)]
    bare = replace(problem.without_statements([b.name for b in blocks]), residual=rest)
    white = bare.whitener(stage.u, stage.noise.rho)
    columns = np.concatenate([b.columns for b in blocks], axis=1)
    x, y = white.apply(columns), white.apply(rest)
    width, fit = _best_posterior(x, y, white.dof)
    y = _limit_outliers(x, y, fit, stage)
    width, fit = _best_posterior(x, y, white.dof)
    term = SelectedTerm(
        Family("calibration", {}, ()),
        Option(None, columns, np.ones(x.shape[1]), ("calibration",) * x.shape[1], 0.0),
        x,
        width,
    )
    alone = Selection((term,), fit, y, y - x @ fit.mean)
    held_out = tuple(predict_fold(bare, fold, alone, (term,)) for fold in _halves(bare, stage))
    return _numbers(blocks, fit, width, held_out)


def _best_posterior(x: Array, y: Array, dof: int) -> tuple[float, Posterior]:
    """Return the width of highest evidence, and the posterior there."""
    fits = [(float(s), posterior(x, y, dof, np.full(x.shape[1], s))) for s in WIDER]
    return max(fits, key=lambda pair: pair[1].log_evidence)


def _limit_outliers(x: Array, y: Array, fit: Posterior, stage: Stage) -> Array:
    """Return outliers pulled towards the fit."""
    signal = x @ fit.mean
    limit = stage.noise.noise.clip * fit.sigma
    return np.asarray(signal + np.clip(y - signal, -limit, limit))


def _halves(problem: Problem, stage: Stage) -> list[Fold]:
    """Return every second run row, and the others."""
    even = problem.recording.row % 2 == 0
    if min(even.sum(), (~even).sum()) < FEWEST:
        return []
    return [make_fold(problem, stage.u, stage.noise.rho, n, rows) for n, rows in zip(HALVES, (even, ~even))]


def _block(problem: Problem, item: Input) -> _TableInput | None:
    """Return an Input with one draw for all rows that acts on numbers of stored tables; None for another."""
    if item.members or item.is_channel or item.redraw != "machine":
        return None
    effects, columns = problem.observer.of_input(item)
    if not effects or not np.any(columns):
        return None
    if item.effect == CalibrationModes.name:
        numbers = [_numbers_of(e, str(getattr(e, "component", ""))) for e in effects]
        factor = np.concatenate([np.asarray(getattr(e, "loadings"), dtype=float) for e in effects])  # noqa: B009
    else:
        (effect,) = effects
        if not effect.about.table_parameter or item.parameter != effect.about.table_parameter:
            return None
        numbers = [_numbers_of(effect, effect.where)]
        _, factor = item.spread(np.size(getattr(effect, effect.about.table_parameter)))
        law = item.law
        factor = factor * (law.u if not isinstance(law, MultivariateNormal) else 1.0)
    if any(n is None for n in numbers):
        return None
    present = [n for n in numbers if n is not None]
    errors = tuple(e for names, _ in present for e in names)
    return _TableInput(item.id, columns, errors, np.concatenate([q for _, q in present]), factor)


def _numbers_of(effect: Effect, error: str) -> tuple[tuple[str, ...], Array] | None:
    """Return the names and nodes of the numbers of one error; None for a table over several axes."""
    nodes = effect.nodes if isinstance(effect, CalibrationModes) else own_nodes(effect)
    if error[:1] != "E":
        return (error,), np.full(1, np.nan)
    return None if nodes is None else ((error,) * len(nodes), np.asarray(nodes, dtype=float))


def _numbers(
    blocks: Sequence[_TableInput], fit: Posterior, width: float, held_out: tuple[HeldOut, ...]
) -> RenewedTables:
    """Return the renewed tables: change and covariance are linear in the fitted numbers of unit variance."""
    k, r = sum(len(b.errors) for b in blocks), sum(b.factor.shape[1] for b in blocks)
    factor, row, column = np.zeros((k, r)), 0, 0
    for b in blocks:
        n, p = b.factor.shape
        factor[row : row + n, column : column + p] = b.factor
        row, column = row + n, column + p
    covariance = factor @ fit.covariance @ factor.T
    return RenewedTables(
        tuple(e for b in blocks for e in b.errors),
        np.concatenate([b.position for b in blocks]),
        factor @ fit.mean,
        (covariance + covariance.T) / 2.0,
        width,
        held_out,
    )


def with_tables(machine: Machine, new: RenewedTables) -> Machine:
    """Return the machine with its renewed tables, each error with an Input of its own covariance in place of the stated one."""
    effects, inputs, gone = [], [], set()
    for e in machine.effects:
        rows = new.of(e.where) if e.about.table_parameter else np.zeros(0, dtype=np.intp)
        if len(rows):
            stored = np.asarray(getattr(e, e.about.table_parameter), dtype=float)
            value = stored + np.reshape(new.change[rows], stored.shape)
            e = with_parameter(e, e.about.table_parameter, float(value) if value.ndim == 0 else value)
            block = new.covariance[np.ix_(rows, rows)]
            law = Normal(float(np.sqrt(block[0, 0]))) if value.ndim == 0 else MultivariateNormal(block)
            inputs.append(
                Input(e.name, e.where, e.about.table_parameter, law, "machine", "diagnosis of a recording")
            )
            gone.add(inputs[-1].id)
        if not isinstance(e, CalibrationModes):
            effects.append(e)
    kept = [i for i in machine.inputs if i.id not in gone and i.effect != CalibrationModes.name]
    return replace(machine, effects=tuple(effects), inputs=(*kept, *inputs))
