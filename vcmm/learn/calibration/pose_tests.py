"""Test a calibrated arm on poses that it was not made from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.rigid import Frame
from vcmm.learn.calibration.result import rms
from vcmm.task.response.poses import (
    PoseReadings,
    TrackerPlacement,
    departures,
    placement_at,
    settle_placement,
    stack_rows,
    tool_frames,
    weights,
)

MOVED = 100.0  # times what placing anew leaves: then the tracker or the target was moved


@dataclass(frozen=True)
class PoseTest:
    """Residuals of poses under a machine that was not calibrated from them, rms per coordinate in mm (turns in rad).

    before: nominal machine, after: calibrated machine, both with tracker and target placed by these poses. in_place: tracker and target
    as in the calibration, None where the tracker is clearly elsewhere. Turns are None where no orientations were read.
    """

    name: str
    n: int
    before: float
    after: float
    in_place: float | None
    before_turn: float | None
    after_turn: float | None


def put_to_poses(
    test: PoseReadings, nominal: Machine, machine: Machine, calibrated: TrackerPlacement
) -> PoseTest:
    """Test the machine file, read back, on poses."""
    before, after = (
        _residual_rms(test, frames, _anew(test, frames, calibrated))
        for frames in (tool_frames(m, test.run) for m in (nominal, machine))
    )
    residuals = _residual_rms(test, tool_frames(machine, test.run), calibrated)[0]
    return PoseTest(
        test.name,
        test.n,
        before[0],
        after[0],
        residuals if residuals < MOVED * max(after[0], 1e-3) else None,
        before[1],
        after[1],
    )


def _anew(test: PoseReadings, frames: Frame, calibrated: TrackerPlacement) -> TrackerPlacement:
    """Return tracker and target from these poses: without earlier knowledge, or with the target near its place in the calibration."""
    near = settle_placement(test, frames, placement_at(test, frames, calibrated.offset))
    places = (settle_placement(test, frames), near)
    u = weights(test)
    return min(places, key=lambda place: float(np.sum(stack_rows(*departures(test, frames, place), u) ** 2)))


def _residual_rms(test: PoseReadings, frames: Frame, place: TrackerPlacement) -> tuple[float, float | None]:
    position, turn = departures(test, frames, place)
    return rms(position), None if turn is None else rms(turn)
