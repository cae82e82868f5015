"""The machine that a diagnosis writes: which answers go into its file, and the residual of all rows under it.

The residual is that of the rows as they are, those of several recordings each with a nuisance of its own; `vcmm compare` gives the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.learn.diagnosis.comparison import misfit_without_covariates
from vcmm.learn.diagnosis.delivery import OWN_ROWS
from vcmm.learn.diagnosis.families import open_members_text
from vcmm.learn.diagnosis.improve import improve_machine, repair_machine
from vcmm.learn.diagnosis.result import Answer, Diagnosis
from vcmm.learn.diagnosis.table_renewal import RenewedTables, with_tables
from vcmm.learn.diagnosis.verdict import doubt_remarks
from vcmm.task.response.recording import Recording


def answers_to_write(answers: Sequence[Answer]) -> tuple[Answer, ...]:
    """Return the answers with a crisp number that belong to the machine and are more probable than not, their rivals included."""
    return tuple(a for a in answers if a.fitted is not None and not _reason_not_written(a))


def tables_to_write(answers: Sequence[Answer]) -> RenewedTables | None:
    """Return the renewed tables; None where they stay."""
    return next(
        (a.renewed_tables for a in answers if a.renewed_tables is not None and not _reason_not_written(a)),
        None,
    )


def writing_remarks(answers: Sequence[Answer]) -> tuple[str, ...]:
    """Return one sentence per answer that is not written, and why; and per answer that has rivals."""
    out = []
    for a in answers:
        why = _reason_not_written(a)
        if a.fitted is not None and why:
            place = ", ".join(str(v) for v in a.where.values() if v)
            out.append(
                f"{a.effect}{f' {place}' if place else ''} is not written into the machine file: {why}"
            )
        elif a.fitted is not None and a.cannot_be_told_from:
            rivals = ", ".join(a.cannot_be_told_from)
            shape = f"; {open_members_text(a.kin)}" if a.kin and open_members_text(a.kin) else ""
            out.append(
                f"{a.effect} {' '.join(str(v) for v in a.where.values())}: these rows cannot tell it from {rivals}{shape}"
            )
    return tuple(out)


def _reason_not_written(a: Answer) -> str:
    if a.fitted is not None and a.fitted.per == "instrument":
        return "it is an error of the instrument that recorded, not of the machine"
    if a.of_instrument:
        return f"it may as well be an error of the instrument that recorded ({', '.join(a.of_instrument)}), which repeats it exactly"
    if a.withheld_because:
        return a.withheld_because
    if a.impossible_because:
        return a.impossible_because
    if a.is_undetermined:
        return "its size is not known: the standard uncertainty exceeds half of it, or it spans orders of magnitude"
    if a.doubtful:
        return f"a candidate only, probability {a.probability:.3f}"
    return ""


def written_machine(d: Diagnosis, machine: Machine) -> Machine:
    """Return the machine with the changes that are written into its file: a corrected table, and the answers that are found."""
    with suppress(UsageError, KeyError):  # a mistake that no table can hold
        machine = repair_machine(machine, d.mistake)
    new = tables_to_write(d.answer)
    if new is not None:
        machine = with_tables(machine, new)
    return improve_machine(machine, tuple((a.fitted, a.inputs) for a in answers_to_write(d.answer)))


def changes_machine(d: Diagnosis) -> bool:
    """Return whether the diagnosis changes the machine file."""
    return bool(answers_to_write(d.answer) or tables_to_write(d.answer)) or d.mistake is not None


def rms_under(recordings: Sequence[Recording], machine: Machine) -> float:
    """Return the rms of all rows under a machine, mm or rad."""
    left = [misfit_without_covariates(r, machine).residual for r in recordings]
    return float(np.sqrt(np.mean(np.concatenate(left) ** 2)))


def add_written_fit(d: Diagnosis, recordings: Sequence[Recording], machine: Machine) -> Diagnosis:
    """Return the diagnosis with rms before and after of the rows of recordings; nothing is written that makes them worse."""
    before = rms_under(recordings, machine)
    after = rms_under(recordings, written_machine(d, machine))
    if after > before and (answers_to_write(d.answer) or tables_to_write(d.answer)):
        kept = [id(a) for a in d.answer if a in answers_to_write(d.answer) or a.renewed_tables]
        answer = tuple(replace(a, withheld_because=OWN_ROWS) if id(a) in kept else a for a in d.answer)
        verdict = {"explained": "unexplained", "partly explained": "unexplained"}.get(d.verdict, d.verdict)
        reasons = tuple(dict.fromkeys((*d.reasons, *doubt_remarks(answer))))
        return add_written_fit(
            replace(d, answer=answer, verdict=verdict, reasons=reasons), recordings, machine
        )
    return replace(d, fit=replace(d.fit, before=before, after=after))
