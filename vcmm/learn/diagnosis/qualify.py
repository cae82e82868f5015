"""Lower what is claimed where the recording itself is in doubt, and say what a sign over everything may mean."""

from __future__ import annotations

from dataclasses import replace

from vcmm.learn.diagnosis.constants import EVEN_ODDS
from vcmm.learn.diagnosis.log_mistakes import LOG
from vcmm.learn.diagnosis.machine_match import noise_warning
from vcmm.learn.diagnosis.physical_limits import shared_with_instrument
from vcmm.learn.diagnosis.result import Diagnosis

DOUBT_REASON = "the recording itself is in doubt; see the warnings"


def qualify(d: Diagnosis, doubtful: bool, scale: float, only_table: bool = False) -> Diagnosis:
    """The diagnosis with its warnings, and with its claim lowered where there is doubt.

    scale: noise over what was stated; only_table: the machine has a single table, whose sign is the sign of everything.
    """
    units = noise_warning(scale)
    warnings = [w for w in (*d.warnings, units, _sign(d, only_table)) if w]
    d = replace(
        d, warnings=tuple(dict.fromkeys(warnings)), answer=tuple(map(shared_with_instrument, d.answer))
    )
    if not (doubtful or units):
        return d
    answer = tuple(
        replace(
            a,
            probability=min(a.probability, EVEN_ODDS),
            alias_probability=min(a.alias_probability, EVEN_ODDS),
            kin=a.kin.times(min(1.0, EVEN_ODDS / a.kin.probability))
            if a.kin and a.kin.probability
            else a.kin,
        )
        for a in d.answer
    )
    verdict = {"explained": "partly explained", "nothing missing": "unexplained"}.get(d.verdict, d.verdict)
    return replace(d, answer=answer, verdict=verdict, reasons=(*d.reasons, DOUBT_REASON))


def _sign(d: Diagnosis, only_table: bool) -> str | None:
    """All tables reversed is what a recording with the wrong sense of observation looks like."""
    if d.mistake is None or d.mistake.what != "sign" or d.mistake.effect == LOG:
        return None
    if d.mistake.component != "all" and not only_table:
        return None
    return (
        "the recording holds minus what the machine predicts, in all components: either the tables have the wrong sign,"
        ' or the sense of the observation does ("indicated - true" against "actual - commanded"); look at `observed` first'
    )
