"""The diagnosis as a Python call; the command line calls the same function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vcmm.answer.evaluation.sampling import Progress
from vcmm.core.effect import Effect
from vcmm.core.machine import Machine
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.known_unknowns import describe_unknown
from vcmm.learn.diagnosis.opposite_sign import other_way
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.learn.diagnosis.unread_job import diagnose_unread
from vcmm.learn.diagnosis.very_long import few_enough, thinning_notes
from vcmm.task.response.recording import Recording


def diagnose(
    recording: Recording,
    machine: Machine,
    *,
    seed: int = 0,
    extra_effects: Sequence[type[Effect]] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """What physics a recording holds that the machine lacks: causes, rivals, held-out improvement, next measurement.

    Of more than 100 000 observations some are taken, and it is said (see vcmm.learn.diagnosis.very_long).
    """
    recording = few_enough(recording)

    def ask(one: Recording) -> Diagnosis:
        return diagnose_recording(one, machine, seed=seed, extra_effects=extra_effects, progress=progress)

    found = diagnose_unread(recording, machine, ask) if recording.unread else ask(recording)
    found = describe_unknown(found, recording)
    warnings = (
        *recording.notes,
        *thinning_notes(recording),
        *found.warnings,
        *other_way(recording, machine, found),
    )
    return replace(found, warnings=warnings)
