"""A calibrated arm put to poses that it was not made from."""

from __future__ import annotations

from dataclasses import dataclass

from vcmm.core.machine import Machine
from vcmm.core.rigid import Frame
from vcmm.learn.calibration.result import rms
from vcmm.task.response.poses import PoseReadings, TrackerPlacement, departures, settle_placement, tool_frames

MOVED = 100.0  # times what placing anew leaves: then the tracker or the target was moved


@dataclass(frozen=True)
class PoseTest:
    """What a machine leaves of poses that it was not made from: rms per coordinate, mm (and rad) before with the nominal machine and after, tracker
    and target found from these poses; `held`: both as in the calibration, None where the tracker plainly stands elsewhere.
    """

    name: str
    n: int
    before: float
    after: float
    held: float | None
    before_turn: float
    after_turn: float


def put_to_poses(test: PoseReadings, nominal: Machine, machine: Machine, known: TrackerPlacement) -> PoseTest:
    """The machine file, read back, asked for poses."""
    left = [_left(test, tool_frames(m, test.run), None) for m in (nominal, machine)]
    frames = tool_frames(machine, test.run)
    held = _left(test, frames, known)[0]
    return PoseTest(
        test.name,
        test.n,
        left[0][0],
        left[1][0],
        held if held < MOVED * max(left[1][0], 1e-3) else None,
        left[0][1],
        left[1][1],
    )


def _left(test: PoseReadings, frames: Frame, place: TrackerPlacement | None) -> tuple[float, float]:
    position, turn = departures(test, frames, place or settle_placement(test, frames))
    return rms(position), 0.0 if turn is None else rms(turn)
