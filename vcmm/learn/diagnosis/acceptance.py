"""Choose the answers of a diagnosis that go into the machine's file, and the remarks beside them."""

from __future__ import annotations

from collections.abc import Sequence

from vcmm.learn.diagnosis.families import open_text
from vcmm.learn.diagnosis.result import Answer
from vcmm.learn.diagnosis.table_renewal import RenewedTables


def answers_to_write(answers: Sequence[Answer]) -> tuple[Answer, ...]:
    """Return the answers with a crisp number that belong to the machine and are more probable than not, their rivals included."""
    return tuple(a for a in answers if a.fitted is not None and not _why_not(a))


def anew(answers: Sequence[Answer]) -> RenewedTables | None:
    """Return the renewed tables; None where they stay."""
    return next((a.renewed for a in answers if a.renewed is not None and not _why_not(a)), None)


def notes(answers: Sequence[Answer]) -> tuple[str, ...]:
    """Return one sentence per answer that is not written, and why; and per answer that has rivals."""
    out = []
    for a in answers:
        why = _why_not(a)
        if a.fitted is not None and why:
            place = ", ".join(str(v) for v in a.where.values() if v)
            out.append(
                f"{a.effect}{f' {place}' if place else ''} is not written into the machine file: {why}"
            )
        elif a.fitted is not None and a.cannot_be_told_from:
            rivals = ", ".join(a.cannot_be_told_from)
            shape = f"; {open_text(a.kin)}" if a.kin and open_text(a.kin) else ""
            out.append(
                f"{a.effect} {' '.join(str(v) for v in a.where.values())}: these rows cannot tell it from {rivals}{shape}"
            )
    return tuple(out)


def _why_not(a: Answer) -> str:
    if a.fitted is not None and a.fitted.per == "instrument":
        return "it is an error of the instrument that recorded, not of the machine"
    if a.of_instrument:
        return f"it may as well be an error of the instrument that recorded ({', '.join(a.of_instrument)}), which repeats it exactly"
    if a.withheld:
        return a.withheld
    if a.beyond:
        return a.beyond
    if a.undetermined:
        return "its size is not known: the standard uncertainty exceeds half of it, or it spans orders of magnitude"
    if a.doubtful:
        return f"a candidate only, probability {a.probability:.3f}"
    return ""
