"""The fit that a diagnosis reports: of the machine that is written, against all rows as they are, those of several recordings
each with a nuisance of its own. `vcmm compare` gives the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.learn.diagnosis.acceptance import anew, answers_to_write
from vcmm.learn.diagnosis.comparison import left_by
from vcmm.learn.diagnosis.delivery import OWN_ROWS
from vcmm.learn.diagnosis.improve import improve_machine
from vcmm.learn.diagnosis.repair import repair_machine
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.learn.diagnosis.table_renewal import with_tables
from vcmm.learn.diagnosis.verdict import doubts
from vcmm.task.response.recording import Recording


def handed_over(d: Diagnosis, machine: Machine) -> Machine:
    """Return the machine with the changes that are written into its file: a corrected table, and the answers that are found."""
    with suppress(UsageError, KeyError):  # a mistake that no table can hold
        machine = repair_machine(machine, d.mistake)
    new = anew(d.answer)
    if new is not None:
        machine = with_tables(machine, new)
    return improve_machine(machine, tuple((a.fitted, a.inputs) for a in answers_to_write(d.answer)))


def written(d: Diagnosis) -> bool:
    """Does anything of it stand in the machine file that is written?"""
    return bool(answers_to_write(d.answer) or anew(d.answer)) or d.mistake is not None


def rms_left(recordings: Sequence[Recording], machine: Machine) -> float:
    """Return the rms of all rows under a machine, mm or rad."""
    left = [left_by(r, machine).residual for r in recordings]
    return float(np.sqrt(np.mean(np.concatenate(left) ** 2)))


def with_written_fit(d: Diagnosis, recordings: Sequence[Recording], machine: Machine) -> Diagnosis:
    """Return the diagnosis with rms before and after of the rows of recordings; nothing is written that makes them worse."""
    before = rms_left(recordings, machine)
    after = rms_left(recordings, handed_over(d, machine))
    if after > before and (answers_to_write(d.answer) or anew(d.answer)):
        kept = [id(a) for a in d.answer if a in answers_to_write(d.answer) or a.renewed]
        answer = tuple(replace(a, withheld=OWN_ROWS) if id(a) in kept else a for a in d.answer)
        verdict = {"explained": "unexplained", "partly explained": "unexplained"}.get(d.verdict, d.verdict)
        reasons = tuple(dict.fromkeys((*d.reasons, *doubts(answer))))
        return with_written_fit(
            replace(d, answer=answer, verdict=verdict, reasons=reasons), recordings, machine
        )
    return replace(d, fit=replace(d.fit, before=before, after=after))
