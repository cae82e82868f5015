"""Explain an answer at the machine: what is seen, what usually causes it, what confirms it.

The declaration of the effect holds the words.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from vcmm.core.axes import axis_of, is_component
from vcmm.core.declaration import Words, reported_name
from vcmm.core.effect import Effect, place_fields
from vcmm.core.run import Run
from vcmm.core.units import significant_text
from vcmm.learn.diagnosis.estimates import Estimate
from vcmm.learn.diagnosis.log_mistakes import LOG, MISTAKE
from vcmm.learn.diagnosis.periods import alias_words
from vcmm.physics import ALL

# what no effect explains but a wrong table does
OF_MISTAKE = Words(
    seen="the stored table of {where} is not what the machine does",
    causes="a wrong sign, unit or column when the table was entered",
    confirm="compare the table with the calibration sheet; a corrected table is written",
)

OF_LOG = Words(
    seen="the log is mistaken: {where}",
    causes="columns, signs, units or directions that were mixed up when the recording was written down",
    confirm="look at the wiring and the export of the log, correct it and diagnose it again; nothing is written for it",
)


def plain_words(effect: str, where: Mapping[str, str], parameters: Mapping[str, Estimate]) -> str:
    """Return one sentence for the operator: what is seen; what usually causes it; what confirms it. "" for unknown families."""
    words = _words_of(effect, set(where))
    if words is None:
        return ""
    place = ", ".join(str(v) for v in where.values() if v) or "the machine"
    shown = {k: _value(e, k in words.signed) for k, e in parameters.items()}
    values = _Values({**{k: str(v) for k, v in where.items()}, "where": place, **shown})
    observation, cause, confirm = (text.format_map(values) for text in _in_its_sense(words, parameters))
    observation = re.sub(r", after (?=\))", "", observation)  # what an answer does not have leaves no trace
    observation = re.sub(r" ?\([, ]*\)", "", re.sub(r"[, ]+\)", ")", observation.replace("(, ", "("))).strip()
    return f"{observation[:1].upper()}{observation[1:]}; usually {cause}; confirm by: {confirm}."


def cause_and_cure(
    effect: str, where: Mapping[str, str], parameters: Mapping[str, Estimate]
) -> tuple[str, str]:
    """Return what usually causes it, and what confirms it, separately; both empty for unknown families."""
    words = plain_words(effect, where, parameters)
    _, usually, rest = words.partition("; usually ")
    cause, confirm, cure = rest.partition("; confirm by: ")
    return (cause, cure.rstrip(".")) if usually and confirm else ("", "")


def _words_of(effect: str, places: set[str]) -> Words | None:
    """Return the words of the shape for such places: a step along one direction, or one of several at once."""
    if effect == MISTAKE:
        return OF_MISTAKE
    if effect == LOG:
        return OF_LOG
    shapes = [k for k in ALL if reported_name(k) == effect and k.about.words is not None]
    same = [k for k in shapes if {f.name for f in place_fields(k) if not f.metadata["quiet"]} == places]
    return next((k.about.words for k in (*same, *shapes)), None)


def _in_its_sense(words: Words, parameters: Mapping[str, Estimate]) -> tuple[str, str, str]:
    """Return symptom, causes and confirmation, in the words of the opposite sense where the effect has that."""
    other = words.opposite
    if other is None or other.parameter not in parameters or parameters[other.parameter].value >= 0:
        return words.seen, words.causes, words.confirm
    return other.seen or words.seen, other.causes or words.causes, other.confirm or words.confirm


class _Values(dict[str, str]):
    """Values for a text; parameters that an answer does not have leave no trace."""

    def __missing__(self, key: str) -> str:
        return ""


def _value(e: Estimate, signed: bool = False) -> str:
    return significant_text(e.value if signed else abs(e.value)) + (f" {e.unit}" if e.unit != "1" else "")


def answer_remark(effect: Effect | None, run: Run, kind: str = "probe") -> str:
    """Return the remark beside an answer: that of the effect itself, the alias of a period, or that the instrument (kind
    displacement or angle) may be to blame.
    """
    if effect is None:
        return ""
    component = str(getattr(effect, "component", ""))
    along = is_component(component) and component[1] == axis_of(component)[0]
    if kind in ("displacement", "angle") and along and effect.diagnosis.is_free_curve:
        return (
            "or the instrument itself: a departure that depends on the position alone, the same in both directions, looks"
            " the same when the scale or sensor that measured is at fault; repeat it with another instrument"
        )
    return "; ".join(s for s in (effect.diagnosis.remark(effect, run), alias_words(effect, run)) if s)
