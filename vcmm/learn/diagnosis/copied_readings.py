"""Mistakes of the log: a stretch of readings that occurs twice, at other rows.

Successive readings that equal earlier ones to the last digit, row after row, were copied. How many it takes depends on the display: two
readings are equal by chance with the probability q that any two of the recording are, two steps from one to the next likewise; a drift that
is shown coarsely has many equal steps. Among n (n - 1) / 2 pairs of places a stretch of length L is expected

    n (n - 1) / 2  max(q of readings, q of steps)^L

times. Places that are measured again may give the same readings again, so a stretch at the same places is no mistake.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import CHANCE, FEWEST
from vcmm.learn.diagnosis.periods import DIGITS
from vcmm.learn.diagnosis.sanity import Mask, series_of
from vcmm.task.response.recording import Ints, Recording

STRETCH = "stretch_repeated"


@dataclass(frozen=True, eq=False)
class CopiedStretch:
    """A repeated stretch. where: which lines repeat which; is_copy (m,): observations of the later stretch; expected_count: such stretches by chance."""

    where: str
    is_copy: Mask
    expected_count: float


def find_copied_stretch(recording: Recording) -> CopiedStretch | None:
    """Return the longest stretch of readings that occurs twice; None where chance makes one as long."""
    repeats = [_copied_in_series(recording, s) for s in series_of(recording.row) if len(s) >= FEWEST]
    sure = [f for f in repeats if f is not None and f.expected_count < 1.0 - CHANCE]
    return min(sure, key=lambda f: f.expected_count) if sure else None


def _copied_in_series(recording: Recording, series: Ints) -> CopiedStretch | None:
    value = recording.value[series]
    alike = max(_equal_share(value), _equal_share(np.round(np.diff(value), DIGITS)))
    n = len(value)
    if alike >= 1.0:
        return None
    least = int(np.ceil(np.log((1.0 - CHANCE) / (n * (n - 1) / 2)) / np.log(alike))) if alike > 0 else 2
    if 2 * least > n:
        return None
    pair = _longest(value, least)
    if pair is None:
        return None
    first, second, length = pair
    rows = recording.row[series]
    first_rows, second_rows = rows[first : first + length], rows[second : second + length]
    if _same_places(recording, first_rows, second_rows):
        return None
    copied = np.zeros(recording.m, dtype=bool)
    copied[series[second : second + length]] = True
    again = np.zeros(recording.m, dtype=bool)
    again[series[first : first + length]] = True
    where = f"the readings of {recording.places(copied)} are those of {recording.places(again)}"
    return CopiedStretch(where, copied, n * (n - 1) / 2 * alike**length)


def _equal_share(values: Array) -> float:
    """Return the probability that two of some values are equal; of values that all differ, less than one pair."""
    count = np.unique(values, return_counts=True)[1].astype(float)
    n = len(values)
    pairs = n * (n - 1) / 2
    return float(max(np.sum(count * (count - 1) / 2), 1.0) / pairs)


def _longest(value: Array, least: int) -> tuple[int, int, int] | None:
    """Return (first, second, length) of the longest pair of equal stretches of at least `least`, which do not overlap."""
    code = np.unique(value, return_inverse=True)[1]
    windows = np.lib.stride_tricks.sliding_window_view(code, least)
    kind = np.unique(windows, axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(kind, kind="stable")
    again = np.flatnonzero(np.diff(kind[order]) == 0)
    best: tuple[int, int, int] | None = None
    covered = -1
    for first, second in sorted(zip(order[again], order[again + 1])):
        if second - first < least or second <= covered:
            continue
        length = least
        while (
            second + length < len(code)
            and first + length < second
            and code[first + length] == code[second + length]
        ):
            length += 1
        covered = second + length - least
        if best is None or length > best[2]:
            best = (int(first), int(second), length)
    return best


def _same_places(recording: Recording, first: Ints, second: Ints) -> bool:
    """Return whether both stretches lie at the same places, of axes that move at all."""
    moving = [q for q in recording.run.position.values() if np.ptp(q[recording.row]) > 0]
    return bool(moving) and all(np.array_equal(q[first], q[second]) for q in moving)
