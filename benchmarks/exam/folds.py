"""Block J on the recording itself: how strongly the concealed effect shows in the rows of each fold that was held out.

The names of the folds are those that the command prints: a pose, later time, temperature, speed, far zone of an axis; each
but the first holds the upper 30 % of its rows. A fold tells something where the effect, known here without noise, has a
delta of at least EXCITED in its rows alone, and in the other rows alone: a slip inside one placement cannot be predicted
from the others. What the command prints of a fold is measured with noise: at a strength of 5 in 150 rows the noise of the
sums of squares (17) is as large as the effect (25). The energy left without noise is that of `heldout`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.exam import blocks
from benchmarks.exam.blocks import Case, Setting
from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array
from benchmarks.exam.observe import join, nuisance_columns
from benchmarks.exam.strength import Whitener

EXCITED = 5.0
SHARE = 0.3
Mask = npt.NDArray[np.bool_]


def rows_of(fold: str, d: Design) -> Mask | None:
    """Rows of a fold by its printed name; None for a name that is not known here."""
    if fold.startswith("pose ") and "pose" in d.labels:
        return np.array(d.labels["pose"]) == fold.removeprefix("pose ")
    if fold.startswith("far zone "):
        return _upper(d.q[fold.removeprefix("far zone ")])
    if fold == "later time":
        return _upper(d.columns["time_s"])
    if fold == "speed":
        v = np.column_stack([d.columns[f"speed_{a}_mm_s"] for a in "XYZ"])
        return _upper(np.round(np.linalg.norm(v, axis=1), 6))
    if fold == "temperature":
        logs = [d.get(name) for name in {*d.columns, *d.series} if name.startswith("temp_")]
        return _upper(max(logs, key=lambda t: float(np.ptp(t)))) if logs else None
    return None


def _upper(x: Array) -> Mask:
    return np.asarray(x > np.quantile(x, 1 - SHARE))


def strength_in(case: Case, effect: Array, rows: Mask) -> float:
    """delta of the effect in these rows alone, nuisance of these rows projected out."""
    from scipy.linalg import cholesky, solve_triangular

    mine = np.repeat(rows, len(effect) // case.design.rows)
    low = case.white.lower[mine]
    lower = cholesky(low @ low.T, lower=True)
    free = nuisance_columns(case.design)[mine]
    free = free[:, np.abs(free).max(axis=0) > 0] if free.shape[1] else free
    white = solve_triangular(lower, free, lower=True)
    u, s, _ = np.linalg.svd(white, full_matrices=False)
    return Whitener(lower, u[:, s > 1e-9 * s.max(initial=1.0)]).delta(effect[mine])


def true_effect(case: Case) -> Array:
    truth = case.truth
    s = Setting(case.design, case.machine, case.white)
    return blocks.effect_of(s, join([i.build(a) for i, a in zip(truth.items, truth.amplitudes)]))


def judged(case: Case, found: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Every held-out fold that was printed, with the strength of the truth in it; `worse`: larger rms than before."""
    printed = (found.get("fit") or {}).get("held_out") or []
    if not printed or not case.truth.items:
        return []
    effect, out = true_effect(case), []
    for fold in printed:
        rows = rows_of(fold["fold"], case.design)
        if rows is None or not rows.any():
            continue
        out.append({
            "fold": fold["fold"], "strength": strength_in(case, effect, rows),
            "known": strength_in(case, effect, ~rows), "left": fold["effect_energy_left"],
            "worse": fold["rms_after_um"] > fold["rms_before_um"], "gain": fold.get("log_score_gain_nats"),
        })  # fmt: skip
    return out
