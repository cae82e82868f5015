"""Figures of a test from its recordings, with the uncertainty of the instrument: ISO 230-2, 230-4, 230-6, 10360-2.

ISO 10360-2 from a recording of lengths on a step gauge, gauge blocks or ball bars: E0, E150 (or another L), R0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.run import Array
from vcmm.learn.calibration.acceptance import TESTS, Figure, Limit, against_limits
from vcmm.learn.calibration.deviations import Limits, RecordedTest, figure_of, limit_of
from vcmm.learn.calibration.recorded_circles import recorded_circles
from vcmm.learn.calibration.recorded_lines import recorded_diagonals, recorded_positioning
from vcmm.task.response.recording import Ints

STEP = 2  # decimals of mm: repeats have one nominal place
LENGTHS, TIMES = 35, 3  # five lengths in seven positions, each three times
SHARE = 0.66  # of the diagonal of the volume: the longest length


def recorded_lengths(
    tests: Sequence[RecordedTest], limits: Limits | None = None
) -> tuple[list[Figure], list[str]]:
    """Return figures of ISO 10360-2:2009, 6.3 to 6.5: largest |error| per offset L of the stylus from the ram, range of repeats for L = 0.

    Errors are indicated - calibrated. A limit may grow with the length ("1.9 um + L/300"): then the figure is that of the length
    nearest to its limit. Raises UsageError for recordings that are no lengths with two ends touched by the machine.
    """
    limits = limits or {}
    out: list[Figure] = []
    notes: list[str] = []
    by_offset: dict[int, str] = {}
    for test in tests:
        _check(test)
        length, ram = _geometry(test)
        for offset in np.unique(ram):
            which = np.flatnonzero(ram == offset)
            if offset in by_offset:
                raise UsageError(
                    f"{test.recording.name}: lengths with the offset {offset} mm are in {by_offset[offset]} too; put them into one file"
                )
            by_offset[int(offset)] = test.recording.name
            out.append(_largest(test, f"E{offset}", which, length, limits))
            if offset == 0:
                ranges, more = _ranges(test, which, limits)
                out, notes = [*out, *ranges], [*notes, *more, *_short(test, which, length)]
    return out, notes


def _check(test: RecordedTest) -> None:
    recording = test.recording
    if recording.kind != "length" or (recording.other < 0).any():
        what = "lengths from a fixed end" if recording.kind == "length" else f'of kind "{recording.kind}"'
        raise UsageError(
            f'{recording.name} is {what}; ISO 10360-2 takes kind = "length" with both ends on one artefact (from_x_mm ..., no [nuisance] '
            "centre or station)"
        )


def _geometry(test: RecordedTest) -> tuple[Array, Ints]:
    """Return lengths (m,) mm, and offsets of the stylus from the ram (m,) in whole mm."""
    recording = test.recording
    run = test.machine.prepare(recording.run)
    length = np.linalg.norm(run.tip[recording.row] - run.tip[recording.other], axis=1)
    linear = [a for a in test.machine.chain.tool if a in "XYZ"]
    ram = "XYZ".index(linear[-1]) if linear else 2
    across = np.delete(run.offset[recording.row], ram, axis=1)
    return length, np.rint(np.linalg.norm(across, axis=1)).astype(np.intp)


def _errors(test: RecordedTest, which: Ints) -> tuple[Array, Array | None]:
    """Return indicated - calibrated (k,), and as sampled (trials, k)."""
    drawn = test.draws
    return -test.value[which], None if drawn is None else -drawn[:, which]


def _largest(test: RecordedTest, name: str, which: Ints, length: Array, limits: Limits) -> Figure:
    error, drawn = _errors(test, which)
    spread = None if drawn is None else np.abs(drawn).max(axis=1)
    limit = limit_of(limits, name, "")
    if limit is None:
        return figure_of(name, float(np.abs(error).max()), spread)
    allowed = np.array([limit(float(v)) for v in length[which]])
    worst = int((np.abs(error) / allowed).argmax())
    comparison = against_limits(name, np.abs(error[None] if drawn is None else drawn), allowed, length[which])
    return replace(
        comparison, value_um=float(np.abs(error[worst])) * 1e3, u_um=None if drawn is None else float(drawn[:, worst].std()) * 1e3,
        limit_um=float(allowed[worst]) * 1e3, ratio=float(np.abs(error[worst]) / allowed[worst]),
        u_ratio=None if drawn is None else comparison.u_ratio, at_mm=float(length[which][worst]),
    )  # fmt: skip


def _ranges(test: RecordedTest, which: Ints, limits: Limits) -> tuple[list[Figure], list[str]]:
    """Return R0: largest range of the repeats of one length."""
    recording = test.recording
    run = test.machine.prepare(recording.run)
    ends = [np.round(run.tip[rows[which]], STEP) for rows in (recording.row, recording.other)]
    _, code = np.unique(np.column_stack(ends), axis=0, return_inverse=True)
    groups = [g for c in np.unique(code) if len(g := np.flatnonzero(code.ravel() == c)) > 1]
    if not groups:
        return [], [
            f"{recording.name}: every length was measured once, so there is no R0 (three times are usual)"
        ]

    def compute(errors: Array) -> Array:
        return np.asarray(np.max([np.ptp(errors[..., g], axis=-1) for g in groups], axis=0))

    error, drawn = _errors(test, which)
    limit = limit_of(limits, "R0", "")
    spread = None if drawn is None else compute(drawn)
    return [figure_of("R0", float(compute(error)), spread, limit and limit(0.0))], []


def _short(test: RecordedTest, which: Ints, length: Array) -> list[str]:
    """Return requirements of ISO 10360-2 that this recording does not meet."""
    recording, out = test.recording, []
    if len(which) < LENGTHS * TIMES:
        out.append(
            f"{recording.name}: {len(which)} readings; ISO 10360-2 takes {LENGTHS * TIMES}: five lengths in seven positions, each three times"
        )
    spans = [x.travel[1] - x.travel[0] for a, x in test.machine.axes.items() if a in "XYZ"]
    diagonal = float(np.linalg.norm(spans))
    if float(length[which].max()) < SHARE * diagonal:
        out.append(
            f"{recording.name}: the longest length is {length[which].max():.0f} mm; ISO 10360-2 takes {SHARE:.0%} of the longest diagonal, "
            f"here {SHARE * diagonal:.0f} mm"
        )
    return out


def evaluate_recordings(
    tests: Sequence[RecordedTest], iso: str, limits: Mapping[str, Limit] | None = None
) -> tuple[list[Figure], list[str]]:
    """Return (figures of a test "230-2", "230-4", "230-6", "10360-2", notes) from its recordings.

    u_um: standard deviation of a figure when the instrument's own errors are sampled; None without a certificate. Raises
    UsageError for another test, and for recordings that are none of this test, saying why.
    """
    makers: Mapping[str, Callable[..., tuple[list[Figure], list[str]]]] = {
        "230-2": recorded_positioning, "230-4": recorded_circles,
        "230-6": recorded_diagonals, "10360-2": recorded_lengths,
    }  # fmt: skip
    if iso not in makers:
        raise UsageError(f'there is no test "{iso}" here.{choose_from(iso, TESTS)}')
    return makers[iso](tests, limits or {})
