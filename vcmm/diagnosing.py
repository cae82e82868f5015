"""The diagnosis as a Python call; the command line calls the same function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vcmm.diagnosis.engine import diagnose_recording
from vcmm.diagnosis.other_way import other_way
from vcmm.diagnosis.result import Diagnosis
from vcmm.effect import Effect
from vcmm.machine import Machine
from vcmm.recording import Recording
from vcmm.sampling import Progress


def diagnose(
    recording: Recording,
    machine: Machine,
    *,
    seed: int = 0,
    extra_effects: Sequence[type[Effect]] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """What physics a recording holds that the machine lacks: causes, rivals, held-out improvement, next measurement."""
    found = diagnose_recording(recording, machine, seed=seed, extra_effects=extra_effects, progress=progress)
    return replace(found, warnings=(*found.warnings, *other_way(recording, machine, found)))
