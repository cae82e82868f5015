"""May all readings have the opposite sign? Said, never decided: the sense of `observed` is known to the operator only.

A recording of the other sign holds minus what the machine's file predicts, so that its residual holds minus twice:

    c = d . r / d . d -> -2,    u(c) = sigma / |d|      d: white prediction of all known effects, r: white residual
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.learn.diagnosis.constants import FAR, OUTLYING, VANISHING_SHARE
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.physics import ALL
from vcmm.task.response.observe import baseline
from vcmm.task.response.recording import Recording

LOOK = 'look at `observed` ("indicated - true" against "actual - commanded")'


def other_way(recording: Recording, machine: Machine, d: Diagnosis) -> tuple[str, ...]:
    """Sentences about a sign over everything; none where a mistake of the table says so already."""
    if d.mistake is not None and d.mistake.what == "sign":
        return ()
    c, u = against_known(recording, machine)
    if abs(c) > OUTLYING * u and abs(c + 2.0) < FAR * u:
        return (
            f"the residual holds {c:.1f} times what the machine file predicts (standard uncertainty {u:.1f}; -2 where all"
            f" readings have the opposite sign): `observed` may be the wrong way round; {LOOK}",
        )
    for kind in ALL:
        opposite = kind.about.words.opposite if kind.about.words else None
        if opposite is None or not opposite.rare:
            continue
        own = [a for a in d.answer if a.effect == kind.name]
        places = [
            str(v) for a in own if _negative(a.parameters.get(opposite.parameter)) for v in a.where.values()
        ]
        if places:
            return (
                f"{', '.join(places)} {opposite.rare}, which is rare: if all readings had the opposite sign, it would be an"
                f" ordinary {kind.name}, and every other sign of the answers would turn too; {LOOK}",
            )
    return ()


def _negative(number: object) -> bool:
    return float(getattr(number, "value", 0.0)) < 0.0


def against_known(recording: Recording, machine: Machine) -> tuple[float, float]:
    """c and u(c) of the head of this file; (0, inf) where the machine file predicts nothing that is seen."""
    try:
        problem = make_problem(recording, machine)
        blank = baseline(problem.recording, replace(machine, effects=(), inputs=()))
        known = baseline(problem.recording, machine) - blank
        white = problem.whitener()
    except ModelLimit:
        return 0.0, float("inf")
    d, r = white.apply(known[:, None])[:, 0], white.apply(problem.residual)
    size = float(np.linalg.norm(d))
    if size < VANISHING_SHARE:
        return 0.0, float("inf")
    sigma = float(np.sqrt(r @ r / white.dof))
    return float(d @ r) / size**2, sigma / size
