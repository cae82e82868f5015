"""A size that the physics does not have: then what recorded it is as good an explanation as the machine.

An effect declares how large it usually is, and where that is known the most that a machine has; the widest prior of the search
is SCALES[-1] = 64 times the usual size, which counts where no most is declared. A number beyond it (an axis that errs by 8 mm/m, a cyclic error of a degree) is more often a wrong unit, gain or sensor than a machine. There is no
model of such a mistake that could be weighed, so name and instrument share the probability evenly.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES
from vcmm.core.effect import Effect, parameter_fields, typical
from vcmm.learn.diagnosis.result import Answer

INSTRUMENT, SENSOR = "instrument", "sensor"  # rivals that are no effects


def within(effect: Effect) -> bool:
    """Has every parameter of a fitted effect a size that machines have?"""
    for f in parameter_fields(effect):
        usual = f.metadata["typical"]
        if usual is not None:
            most = usual.most or SCALES[-1] * typical(effect, f.name)
            if np.abs(np.asarray(getattr(effect, f.name), dtype=float)).max(initial=0.0) > most:
                return False
    return True


def shared_with_instrument(a: Answer) -> Answer:
    """The answer, where it is too large, with what recorded it as a rival of the same weight and a remark."""
    if not a.implausible or (a.fitted is not None and within(a.fitted)):
        return a
    rival = (
        SENSOR
        if a.fitted is not None and any(c.startswith("temp_") for c in a.fitted.required())
        else INSTRUMENT
    )
    said = (
        f"far more than such an effect usually has: look first at unit, gain and mounting of the {rival} that recorded it,"
        " and repeat it with another one"
    )
    half = a.probability / 2
    return replace(
        a,
        probability=half,
        kin=None if a.kin is None else a.kin.times(0.5),
        rival_probability=a.rival_probability + half,
        cannot_be_told_from=(*a.cannot_be_told_from, rival),
        remark="; ".join(s for s in (a.remark, said) if s),
    )
