"""A size that the physics does not have: then what recorded it is as good an explanation as the machine.

An effect declares how large it usually is; the widest prior of the search is SCALES[-1] = 64 times that. A number beyond it
(an axis that errs by 8 mm/m, a cyclic error of a degree) is more often a wrong unit, gain or sensor than a machine. There is no
model of such a mistake that could be weighed, so name and instrument share the probability evenly.
"""

from __future__ import annotations

from dataclasses import replace

from vcmm.diagnosis.result import Answer
from vcmm.evaluation.gaussian import SCALES

INSTRUMENT, SENSOR = "instrument", "sensor"  # rivals that are no effects


def shared_with_instrument(a: Answer) -> Answer:
    """The answer, where it is too large, with what recorded it as a rival of the same weight and a remark."""
    if not a.implausible:
        return a
    rival = (
        SENSOR
        if a.fitted is not None and any(c.startswith("temp_") for c in a.fitted.required())
        else INSTRUMENT
    )
    said = (
        f"more than {SCALES[-1]:.0f} times what is usual: look first at unit, gain and mounting of the {rival} that recorded it,"
        " and repeat it with another one"
    )
    half = a.probability / 2
    return replace(
        a,
        probability=half,
        rival_probability=a.rival_probability + half,
        cannot_be_told_from=(*a.cannot_be_told_from, rival),
        remark="; ".join(s for s in (a.remark, said) if s),
    )
