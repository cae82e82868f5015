"""Figures of a test from its recordings, with the uncertainty that the instrument brings: ISO 230-2, 230-4, 230-6, 10360-2."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from vcmm.core.errors import UsageError, choose_from
from vcmm.learn.calibration.acceptance import TESTS, Figure, Limit
from vcmm.learn.calibration.deviations import RecordedTest
from vcmm.learn.calibration.recorded_circles import recorded_circles
from vcmm.learn.calibration.recorded_lengths import recorded_lengths
from vcmm.learn.calibration.recorded_lines import recorded_diagonals, recorded_positioning


def evaluate_recordings(
    tests: Sequence[RecordedTest], iso: str, limits: Mapping[str, Limit] | None = None
) -> tuple[list[Figure], list[str]]:
    """(figures of a test "230-2", "230-4", "230-6", "10360-2", notes) from its recordings.

    u_um: standard deviation of a figure when the instrument's own errors are drawn; None without a certificate. Raises
    UsageError for another test, and for recordings that are none of this test, saying why.
    """
    makers: Mapping[str, Callable[..., tuple[list[Figure], list[str]]]] = {
        "230-2": recorded_positioning, "230-4": recorded_circles,
        "230-6": recorded_diagonals, "10360-2": recorded_lengths,
    }  # fmt: skip
    if iso not in makers:
        raise UsageError(f'there is no test "{iso}" here.{choose_from(iso, TESTS)}')
    return makers[iso](tests, limits or {})
