"""Confirm the gain: measure both poses with the same random numbers (paired), from a seed the search never saw.

The closed form chose the pose, so that it may flatter its choice. The Monte Carlo of the linear model has the true
laws, the products and the extreme values; batches of trials give the gain its own standard error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.montecarlo import simulate
from vcmm.answer.evaluation.sampling import with_products
from vcmm.answer.evaluation.streams import key
from vcmm.answer.placing.objective import Uncertain, process, width
from vcmm.core.blocks import Progress
from vcmm.core.run import Array
from vcmm.part.gps.risk import guard_band
from vcmm.task.measuring.fixture import pose_of

BATCHES, TRIALS = 20, 5000


@dataclass(frozen=True)
class Confirmation:
    """Objective by Monte Carlo at the present and at the best pose, the gain (present - best) and its standard error."""

    seed: int
    trials: int
    present: float
    best: float
    gain: float
    u_gain: float

    @property
    def is_confirmed(self) -> bool:
        """Whether the gain exceeds twice its standard error."""
        return self.gain > 2 * self.u_gain


def fresh_seed(seed: int) -> int:
    """Return a seed for the confirmation that no other use of `seed` shares."""
    return int(key(seed, "placement confirmation")[0])


def confirm(
    objective: Uncertain,
    present: Array,
    best: Array,
    seed: int,
    progress: Progress,
    batches: int = BATCHES,
) -> Confirmation:
    """Run paired batches of trials at two poses (6,)."""
    chosen = fresh_seed(seed)
    values = []
    for k, six in enumerate((present, best)):
        progress("confirming the gain", k / 2)
        values.append(_batches(objective, six, chosen, batches))
    before, after = values
    gain = before - after
    return Confirmation(
        chosen, batches * TRIALS, float(before.mean()), float(after.mean()), float(gain.mean()),
        float(gain.std(ddof=1) / np.sqrt(batches)),
    )  # fmt: skip


def _batches(objective: Uncertain, six: Array, seed: int, batches: int) -> Array:
    """Return the objective of every batch (batches,), trials numbered alike at every pose."""
    task = objective.scenario.at(pose_of(six)).task()
    model = build(task)
    terms, values = with_products(model, model.terms())
    rows = terms[0].gain.shape[0] if terms else len(model.q0)
    start = np.concatenate([model.q0, np.zeros(rows - len(model.q0))])
    perfect = objective.closed.model.at_estimates
    out = []
    for b in range(batches):
        blocks = simulate(
            start, terms, seed=seed, trials=TRIALS, first=b * TRIALS, fold=False, of=2 * batches * TRIALS
        )
        y = np.concatenate([values(block) for block in blocks])
        out.append(_value(objective, y, perfect, np.random.default_rng([seed, b])))
    return np.array(out)


def _value(objective: Uncertain, y: Array, perfect: Array, rng: np.random.Generator) -> float:
    """Return the objective of a sample of indicated values (trials, C)."""
    p, total = objective.scenario.settings.p, 0.0
    ends = np.quantile(y, [(1 - p) / 2, (1 + p) / 2], axis=0)
    expanded, u = (ends[1] - ends[0]) / 2, y.std(axis=0)
    standard = rng.standard_normal(len(y))
    for i, c in enumerate(objective.characteristics):
        weight = objective.weights[c.name]
        for kind, share in objective.goal.mixture.items():
            if not weight * share:
                continue
            if kind in ("U", "U/T"):
                value = expanded[i] / (width(c) if kind == "U/T" else 1.0)
            else:
                error = y[:, i] - perfect[i]
                value = _count_risk(
                    objective, i, kind, error=error, u=u[i], expanded=expanded[i], standard=standard
                )
            total += weight * share * float(value)
    return total


def _count_risk(
    objective: Uncertain, i: int, kind: str, *, error: Array, u: float, expanded: float, standard: Array
) -> float:
    """Return risk or cost by counting: parts sampled from the process, each indicated with one error."""
    from vcmm.part.gps import characteristics as gps

    c, scenario = objective.characteristics[i], objective.scenario
    nominal = gps.nominal(c, scenario.part.features)
    limits = gps.tolerance(c, nominal)
    assert limits is not None
    low, high = (-np.inf if gps.is_one_sided(c) else limits[0] - nominal), limits[1] - nominal
    mean, spread = process(c, objective.goal, nominal)
    true = mean + spread * standard
    indicated = true + error - (0.0 if objective.needs_bias else error.mean())
    guard = float(guard_band(scenario.settings.rule, np.array([u]), np.array([expanded]))[0])
    good = (true >= low) & (true <= high)
    accepted = (indicated >= low + guard) & (indicated <= high - guard)
    rejected = (indicated < low - guard) | (indicated > high + guard)
    shares = {
        "accept_bad": (accepted & ~good).mean(),
        "reject_good": (rejected & good).mean(),
        "undecided": (~accepted & ~rejected).mean(),
    }
    if kind == "risk":
        return float(sum(shares.values()))
    return float(sum(price * shares[name] for name, price in objective.goal.costs.items()))
