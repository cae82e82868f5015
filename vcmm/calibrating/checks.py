"""What is wrong with recordings before they are fitted together: each check says what, where, and what to do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.response.recording import Recording

LARGE, STEEP = 1.0, 1e-3  # mm, rad: no machine errs so much; a unit does


def check_recordings(recordings: Sequence[Recording], machine: Machine) -> tuple[str, ...]:
    """Warnings about recordings; raises UsageError for what cannot be right."""
    names = [r.name for r in recordings]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f'two recordings have the name "{name}"; give each its own name = "..."')
    for recording in recordings:
        _check_size(recording)
    return ()


def _check_size(recording: Recording) -> None:
    """Readings that vary by more than any machine errs have another unit."""
    spread = float(np.ptp(recording.value)) if recording.m else 0.0
    if recording.kind == "angle" and spread > STEEP:
        raise UsageError(
            f"{recording.name}: angles vary by {spread * 1e3:.3g} mrad; d_urad is in urad (1 arcsec = 4.848 urad, "
            "1 mm/m = 1000 urad): check the unit"
        )
    if recording.kind in ("displacement", "probe", "path") and spread > LARGE and not recording.nuisance.get("slope"):
        raise UsageError(
            f"{recording.name}: readings vary by {spread:.3g} mm, more than a machine errs; d_um is in um, and holds deviations, "
            "not positions"
        )
