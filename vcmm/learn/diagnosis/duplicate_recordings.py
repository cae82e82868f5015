"""One recording given twice in one call is no second witness: every interval would come out too narrow by sqrt(2).

Two recordings are the same where all rows of the smaller stand in the other: same places, same readings to the last digit, in
whatever order. Repeats that a coarse display shows alike are no copies: two readings of one place agree with probability
q / (2 sqrt(pi) s), q the step of the display, s the scatter; copies are rows that would all agree by chance in less than CHANCE.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.learn.diagnosis.constants import NOTHING
from vcmm.learn.diagnosis.sanity import CHANCE, display_step, usual_u
from vcmm.task.response.recording import Recording


def refuse_copies(recordings: Sequence[Recording], machine: Machine) -> None:
    """Raises UsageError with both names where one recording holds another."""
    for one, two in itertools.combinations(recordings, 2):
        few, many = sorted((one, two), key=lambda r: r.m)
        if few.m and _rows(few) <= _rows(many) and _surely(few, machine):
            raise UsageError(
                f"all {few.m} readings of {few.name} stand in {many.name} too, to the last digit: a copy is no second witness;"
                f" give only {many.name}"
            )


def _rows(recording: Recording) -> set[bytes]:
    """Every observation: reading, direction, where the machine stood and with what offset."""
    run = recording.run
    parts = [recording.value[:, None], recording.direction, run.offset[recording.row]]
    parts += [run.position[a][recording.row][:, None] for a in sorted(run.position)]
    table = np.concatenate(parts, axis=1) + 0.0  # -0 is 0
    return {row.tobytes() for row in table}


def _surely(recording: Recording, machine: Machine) -> bool:
    """Would its readings not all repeat by chance?"""
    u, step = usual_u(recording, machine), display_step(recording.value)
    chance = min(step / (2.0 * np.sqrt(np.pi) * u), 1.0) if u > 0 else 1.0
    return bool(recording.m * np.log(max(chance, NOTHING)) < np.log(CHANCE))
