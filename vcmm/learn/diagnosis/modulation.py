"""Does the size of a named term depend on a condition that its law does not know?

A change of geometry is the same at every speed; a screw's pitch error is the same in the morning. If the fitted signal of
such a term grows with the speed, the time, a temperature or a load, what was found is half of a product: the place is
right, the name is not the whole story. One column is tried per term and condition,

    signal of the term x (condition - mean) / standard deviation,

outside the span of all terms, and the number of columns tried is paid for.
"""

from __future__ import annotations

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, blocks, log_evidence, without_span
from vcmm.core.axes import axis_of, is_axis
from vcmm.core.effect import required
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import first_place
from vcmm.learn.diagnosis.constants import UNSEEN
from vcmm.learn.diagnosis.evidence import orthonormal
from vcmm.learn.diagnosis.locate import path_speed, short
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.select import Selection, Term, mismatch

CONDITIONS = (
    "time_s",
    "load_kg",
    "pressure_hPa",
    "spindle_rpm",
)  # beside temperatures and the speed on the way
OF_TIME = ("sensor", "tau", "t1", "time", "start")  # fields of effects that follow a log or the clock


def conditions(problem: Problem) -> dict[str, Array]:
    """Name -> values (m,) of what is the same for every place and direction, as far as it varies."""
    run = problem.run
    out = {short(c): run.columns[c] for c in run.columns if c in CONDITIONS or c.startswith("temp_")}
    speed = path_speed(run)
    if speed is not None:
        out["speed"] = speed
    return {name: problem.of_rows(v) for name, v in out.items() if float(np.ptp(v)) > UNSEEN}


def knows(term: Term, condition: str) -> bool:
    """Does the law of the term hold this condition, or is it not the kind of law that could be held to it?"""
    effect = term.option.effect
    if effect is None or effect.per in ("event", "clamp") or any(hasattr(effect, f) for f in OF_TIME):
        return True
    needed = {short(c) for c in required(effect)}
    if condition == "speed":
        return any(n.startswith(("speed_", "accel_")) for n in needed)
    clock = condition == "time" or condition.startswith("temp_")
    return condition in needed or (clock and any(n == "time" or n.startswith("temp_") for n in needed))


def find_modulation(
    problem: Problem, selection: Selection, white: Whitener, threshold: float
) -> Unknown | None:
    """The term and condition of highest evidence, where it exceeds the threshold of shapes without a name."""
    varied = conditions(problem)
    tried = [(i, name) for i, term in enumerate(selection.terms) for name in varied if not knows(term, name)]
    if not tried or selection.fit is None:
        return None
    basis = orthonormal(np.concatenate([t.white for t in selection.terms], axis=1))
    columns = np.stack([_signal(selection, i) * _standard(varied[name]) for i, name in tried], axis=1)
    x = without_span(white.apply(columns), basis)
    dof = white.dof - basis.shape[1]
    scores = log_evidence(blocks(x, np.arange(len(tried))), selection.rest[:, None], dof)[:, 0]
    best = int(np.argmax(scores))
    if scores[best] - np.log(len(tried)) <= threshold + mismatch(selection):
        return None
    term, name = selection.terms[tried[best][0]], tried[best][1]
    share = float(x[:, best] @ selection.rest) / float(x[:, best] @ x[:, best])
    words = (
        f"the size of {term.family.id} depends on {name}, which its law does not hold: {share:+.0%} of it per standard"
        f" deviation of {name}"
    )
    rms = abs(share) * float(np.sqrt(np.mean(columns[:, best] ** 2)))
    return Unknown(_covariates(problem, term, name), words, rms)


def _signal(selection: Selection, i: int) -> Array:
    """What term i does to the observation (m,), mm or rad."""
    assert selection.fit is not None
    return np.asarray(selection.terms[i].option.columns @ selection.fit.mean[selection.span(i)])


def _standard(values: Array) -> Array:
    return np.asarray((values - values.mean()) / values.std())


def _covariates(problem: Problem, term: Term, name: str) -> tuple[str, ...]:
    """The axis of the term's place, where it has one, and the condition."""
    place = first_place(term.family)
    axis = axis_of(place) or (place if is_axis(place) else place[-1:].upper())
    return (axis, name) if axis in problem.run.position else (name,)
