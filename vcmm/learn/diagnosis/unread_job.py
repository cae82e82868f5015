"""The diagnosis of a recording whose sensors have gaps (see unread)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from vcmm.core.machine import Machine
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.learn.diagnosis.unread import for_effects, rows_read, sensors_of
from vcmm.task.response.recording import Recording


def diagnose_unread(
    recording: Recording, machine: Machine, ask: Callable[[Recording], Diagnosis]
) -> Diagnosis:
    """The diagnosis of a recording whose sensors have gaps. ask: that of one without."""
    first = ask(rows_read(recording))
    fitted = [a.fitted for a in first.found if a.fitted is not None]
    needed = sensors_of(recording, (*machine.effects, *fitted))
    whole = for_effects(recording, (*machine.effects, *fitted))
    told = _told(recording, whole, needed)
    if whole.m == rows_read(recording).m:
        return replace(first, warnings=(*first.warnings, *told))
    second = ask(whole)
    untested = {n: c for n, c in second.not_testable.items() if n in first.not_testable}
    return replace(second, not_testable=untested, warnings=(*second.warnings, *told))


def _told(recording: Recording, whole: Recording, needed: tuple[str, ...]) -> tuple[str, ...]:
    read = rows_read(recording).m
    out = []
    for name, rows in recording.unread:
        lost = int(recording.touching(rows).sum())
        if name in needed:
            out.append(
                f"{lost} observations without a reading of {name} are set aside: what stands in the machine or was found depends on it"
            )
        else:
            out.append(
                f"what depends on {name} was looked for in the {read} observations that have its reading and was not found; all other"
                f" names were looked for in {whole.m}"
            )
    return tuple(out)
