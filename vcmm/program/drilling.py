"""A hole, drilled at the position of the tool, for the cycles of all languages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from vcmm.program.faults import BlockFault
from vcmm.program.moves import PLANES
from vcmm.program.recorder import Recorder

COARSE = {  # pitch of coarse metric threads, mm: ISO 261
    3: 0.5, 4: 0.7, 5: 0.8, 6: 1.0, 8: 1.25, 10: 1.5, 12: 1.75, 14: 2.0, 16: 2.0, 18: 2.5, 20: 2.5, 22: 2.5, 24: 3.0, 27: 3.0, 30: 3.5, 33: 3.5,
    36: 4.0, 39: 4.0, 42: 4.5, 45: 4.5, 48: 5.0,
}  # fmt: skip

NO_MOTION_MM = 1e-12  # mm
MOST_CYCLE_STEPS = 100_000  # holes of a pattern, infeeds of a hole


@dataclass(frozen=True, eq=False)
class Hole:
    """Heights along the axis of the tool, mm in work coordinates: clearance, from which it is fed; bottom; retract, where it ends.

    idle: whether a move that goes nowhere is made all the same.
    """

    recorder: Recorder
    clearance: float
    bottom: float
    retract: float
    idle: bool = False

    def to(self, height: float, rapid: bool) -> None:
        """Move along the axis of the tool."""
        point, normal = list(self.recorder.p), PLANES[self.recorder.plane][2]
        if not self.idle and abs(point[normal] - height) < NO_MOTION_MM:
            return
        point[normal] = height
        self.recorder.straight((point[0], point[1], point[2]), rapid)

    def across(self, a: float, b: float) -> None:
        """Move at rapid in the plane, to its coordinates."""
        point, (first, second, _) = list(self.recorder.p), PLANES[self.recorder.plane]
        if not self.idle and (point[first], point[second]) == (a, b):
            return
        point[first], point[second] = a, b
        self.recorder.straight((point[0], point[1], point[2]), True)

    def wait(self, seconds: float) -> None:
        """Dwell for the given seconds, if any."""
        if seconds:
            self.recorder.dwell(seconds)

    def feed_in(self, seconds: float = 0.0) -> None:
        """Feed to the bottom, and dwell there."""
        self.to(self.bottom, False)
        self.wait(seconds)

    def leave(self) -> None:
        """Move out at rapid."""
        self.to(self.retract, True)

    def leave_higher(self) -> None:
        """Move out from the clearance, at rapid, where it ends higher."""
        if self.retract > self.clearance:
            self.leave()

    def pecks(
        self, depths: Sequence[float], again: Callable[[float], float], *, out: bool = True, wait: float = 0.0, pause: float = 0.0,
        back_at_feed: bool = False, before: Callable[[int], None] = lambda k: None, last: float | None = None,
    ) -> None:  # fmt: skip
        """Feed to each of the depths, with a dwell of `wait` seconds there. Between them the tool goes out to the clearance and stays
        there for `pause` seconds (where `out`), and then to the height `again`(depth), at rapid unless `back_at_feed`.
        before: called before each stroke, with its number from 0. last: the dwell at the last depth, s; `wait` where it is left out.
        """
        for k, depth in enumerate(depths):
            before(k)
            self.to(depth, False)
            ended = k == len(depths) - 1
            self.wait(wait if last is None or not ended else last)
            if ended:
                return
            if out:
                self.to(self.clearance, True)
                self.wait(pause)
            self.to(again(depth), not back_at_feed)


def depths_of(
    surface: float, final: float, step: float, less: float = 0.0, least: float = 0.0
) -> list[float]:
    """Return the depths of the infeeds, mm: each `less` shorter than the one before, but not below `least`."""
    if step > 0:
        whole_count((surface - final) / (min(step, least or step) if less else step))
    out, infeed = [surface], step
    while out[-1] - final > 1e-9:
        out.append(max(out[-1] - infeed, final) if infeed > 0 else final)
        infeed = max(infeed - less, least or min(step, infeed)) if less else infeed
    return out[1:]


def whole_count(number: float) -> int:
    """Return a count of holes, infeeds or repetitions as a whole number. Raises BlockFault beyond `MOST_CYCLE_STEPS`."""
    if not number <= MOST_CYCLE_STEPS:
        raise BlockFault(
            0, f"{number:.6g} repetitions are more than {MOST_CYCLE_STEPS}; check the numbers of this block"
        )
    return round(number)
