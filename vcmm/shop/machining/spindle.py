"""The turning spindle of a lathe: the times at which the tool passes each side of the part.

A part of revolution is cut along a helix: the meridian section at the angle phi meets the tool once per turn,

    t_k :  psi(t_k) = phi (mod 2 pi),   psi(t) = - integral of the spindle speed (signed, M3 plus)

psi is the angle of the tool as seen from the part. M3 turns the part in the positive sense about Z (ISO 841: clockwise seen
along +Z from the spindle), so the tool runs round it in the negative sense. The angle of the spindle at the start of a program is
unknown on a real lathe; here psi = 0 then. It shifts the feed marks along the part and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.motion.timing import Timing
from vcmm.shop.motion.toolpath import Toolpath

TURN = 2 * np.pi
Ints = np.typing.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Spindle:
    """time (n,) s, increasing; psi (n,) rad of the tool about the part; turns (n,) rad passed in whatever sense."""

    time: Array
    psi: Array
    turns: Array

    def angle(self, time: Array) -> Array:
        """Return psi at times (...), rad."""
        return np.interp(time, self.time, self.psi)

    def passes(self, time: Array, phi: Array, count: int) -> Array:
        """Return the times (n, 2 count) at which the tool passes the angle phi (n,) nearest to `time` (n,); nan where it never does.

        `count` before and as many after, in order. A pass beyond a standstill or a change of sense of the spindle does not count.
        """
        edge = np.searchsorted(self.time, time, side="right")
        row = np.clip(edge, 1, len(self.time) - 1)
        sense = np.sign(self.psi[row] - self.psi[row - 1])
        here = np.interp(time, self.time, self.turns)
        ahead = np.mod(sense * (phi - self.angle(time)), TURN)  # still to turn until the next pass
        turned = here[:, None] + ahead[:, None] + TURN * np.arange(-count, count)
        seconds = np.interp(turned, self.turns, self.time, left=np.nan, right=np.nan)
        away = np.mod(self.angle(np.nan_to_num(seconds)) - phi[:, None] + np.pi, TURN) - np.pi
        good = (sense != 0)[:, None] & np.isfinite(seconds) & (np.abs(away) < 1e-6)
        return np.where(good, seconds, np.nan)


def spindle_of(path: Toolpath) -> Spindle:
    """Return the spindle while a program runs: its speed holds from row to row of the toolpath."""
    rate = path.columns["spindle_rpm"] * TURN / 60.0
    length = np.diff(path.time, prepend=path.time[:1])
    return Spindle(path.time, -np.cumsum(rate * length), np.cumsum(np.abs(rate) * length))


def moves_at(timing: Timing, time: Array) -> tuple[Ints, Array]:
    """Return (index of the move, share of it) that runs at times (n,); during a pause the move before it."""
    s = timing.state(time).s
    place = np.clip(np.searchsorted(timing.ends, s - 1e-9, side="left"), 0, len(timing.ends) - 1)
    length = np.diff(timing.ends, prepend=0.0)[place]
    share = np.clip(1.0 - (timing.ends[place] - s) / length, 0.0, 1.0)
    return timing.moving[place].astype(np.intp), share
