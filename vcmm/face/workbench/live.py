"""Value and U while a knob moves: the part of the whole evaluation that needs no trials.

What is shown at once is a preview and says so. Once the knobs rest, the whole evaluation follows and replaces it.

    sizes, distances, angles   the closed form: u^2 = sum of (gradient gain u)^2, U from the inverted characteristic function
                               (the same number, or where the whole evaluation takes trials the same within their error)
    extreme values             the addition of the machine to sampled parts that are off or rough: the same draws, the same number;
where no parts can be sampled the spread of PREVIEW draws of the model
    a known bias left in       U + |bias|, as in the whole evaluation
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel, build
from vcmm.answer.evaluation.montecarlo import Term
from vcmm.answer.evaluation.preview import at_once
from vcmm.answer.evaluation.result import CharacteristicResult
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.task.measuring.scenario import Scenario

PREVIEW = 400  # draws: the standard deviation they give is known to 3.5 %
COVERAGE = 2.0  # k of a preview
OWNERS = 4  # lines of a budget


def preview(scenario: Scenario, seed: int = 0) -> dict[str, Any]:
    """Return every characteristic with value, U and its largest owners; lengths in um, angles in urad. Raises what a task raises."""
    task = scenario.task()
    results = at_once(task, scenario.settings)
    model = build(task)
    spread = _preview_spread(model, model.terms(), seed) if None in results else np.zeros(len(results))
    rows = []
    for i, c in enumerate(model.characteristics):
        result, unit = results[i], gps.unit(c)
        scale = 1e3 if unit == "mm" else 1e6
        value = float(model.at_estimates[i]) if result is None else _value(result)
        half = COVERAGE * float(spread[i]) if result is None else result.expanded
        lines = sorted(() if result is None else result.budget, key=lambda line: -line.u)[:OWNERS]
        rows.append({
            "name": c.name, "type": c.type, "unit": "um" if unit == "mm" else "urad", "value": value,
            "u": scale * (float(spread[i]) if result is None else result.u), "U": scale * half,
            "budget": [{"input": b.input, "what": b.what, "share": b.share} for b in lines if b.share > 0],
        })  # fmt: skip
    return {"preview": True, "characteristics": rows}


def _value(c: CharacteristicResult) -> float:
    return c.indicated if c.extreme else c.value


def _root(term: Term) -> Array:
    """Return a root (L, m): the draws of the lanes are about this times m independent standard draws. Lanes of one copy of a joint law go
    together."""
    u = np.asarray(term.law.u, float)
    if u.ndim == 0:
        return float(u) * np.eye(len(term.lanes)) if np.isfinite(u) else np.zeros((len(term.lanes), 1))
    covariance = np.asarray(term.law.covariance)  # type: ignore[union-attr]
    component, copy = term.lanes[:, 0].astype(int), term.lanes[:, 1]
    whole = covariance[np.ix_(component, component)] * (copy[:, None] == copy)
    value, vector = np.linalg.eigh(whole)
    return np.asarray(vector * np.sqrt(value.clip(0.0)))


def _preview_spread(model: LinearModel, terms: tuple[Term, ...], seed: int) -> Array:
    """Return the standard deviation of every characteristic over PREVIEW draws."""
    draws = np.random.default_rng(seed)
    q = np.tile(model.q0, (PREVIEW, 1))
    for term in terms:
        root = _root(term)
        q += draws.standard_normal((PREVIEW, root.shape[1])) @ (term.gain @ root).T
    return np.asarray(np.std(model.values(q), axis=0))
