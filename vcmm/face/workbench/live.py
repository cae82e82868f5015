"""U, decision and budget while a knob moves: the linear model, and a few hundred draws of it where a value is extreme.

What is shown at once is a preview and says so. Once the knobs rest, the whole evaluation follows and replaces it.

    sizes, distances, angles   u^2 = sum of (gradient gain u)^2, U = 2 u
    extreme values             standard deviation of PREVIEW draws of q through the model, Inputs taken as normal
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vcmm.answer.evaluation.budget import words
from vcmm.answer.evaluation.linear import LinearModel, build
from vcmm.answer.evaluation.montecarlo import Term
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.task.measuring.scenario import Scenario

PREVIEW = 400  # draws: the standard deviation they give is known to 3.5 %
COVERAGE = 2.0  # k of a preview
OWNERS = 4  # lines of a budget


def preview(scenario: Scenario, seed: int = 0) -> dict[str, Any]:
    """Every characteristic with value, U and its largest owners; lengths in um, angles in urad. Raises what a task raises."""
    model = build(scenario.task())
    terms = model.terms()
    gradient, value = model.gradient(), model.at_estimates
    extreme = [not gps.is_linear(c, model.task.part.features) for c in model.characteristics]
    spread = _drawn(model, terms, seed) if any(extreme) else np.zeros(len(value))
    said = {i.input.id: words(model.world, i.input) for i in model.influences}
    rows = []
    for i, c in enumerate(model.characteristics):
        shares = {t.name: _variance(gradient[i], t) for t in terms}
        total = sum(shares.values())
        u = float(spread[i]) if extreme[i] else float(np.sqrt(total))
        largest = sorted(shares, key=lambda n: -shares[n])[:OWNERS] if total > 0 and not extreme[i] else []
        rows.append({
            "name": c.name, "type": c.type, "unit": "um" if gps.unit(c) == "mm" else "urad",
            "value": float(value[i]), "U": 1e3 * COVERAGE * u if gps.unit(c) == "mm" else 1e6 * COVERAGE * u,
            "budget": [{"input": n, "what": said.get(n, n), "share": shares[n] / total} for n in largest],
        })  # fmt: skip
    return {"preview": True, "characteristics": rows}


def _variance(gradient: Array, term: Term) -> float:
    """Variance of gradient @ gain @ z, z the draws of a term; laws without a variance count nothing here."""
    moved = gradient @ term.gain @ _root(term)
    return float(moved @ moved)


def _root(term: Term) -> Array:
    """(L, m): the draws of the lanes are about this times m independent standard draws. Lanes of one copy of a joint law go together."""
    u = np.asarray(term.law.u, float)
    if u.ndim == 0:
        return float(u) * np.eye(len(term.lanes)) if np.isfinite(u) else np.zeros((len(term.lanes), 1))
    covariance = np.asarray(term.law.covariance)  # type: ignore[union-attr]
    component, copy = term.lanes[:, 0].astype(int), term.lanes[:, 1]
    whole = covariance[np.ix_(component, component)] * (copy[:, None] == copy)
    value, vector = np.linalg.eigh(whole)
    return np.asarray(vector * np.sqrt(value.clip(0.0)))


def _drawn(model: LinearModel, terms: tuple[Term, ...], seed: int) -> Array:
    """Standard deviation of every characteristic over PREVIEW draws."""
    draws = np.random.default_rng(seed)
    q = np.tile(model.q0, (PREVIEW, 1))
    for term in terms:
        root = _root(term)
        q += draws.standard_normal((PREVIEW, root.shape[1])) @ (term.gain @ root).T
    return np.asarray(np.std(model.values(q), axis=0))
