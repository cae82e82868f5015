"""The constraint that every machine has: the travels of its axes, and the ranges in which its errors are known.

For a given orientation the travels leave an interval of shifts along each axis, which `intervals` gives in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vcmm.answer.placing.hindrances import Hindrance
from vcmm.answer.placing.rows import Rows
from vcmm.core.declaration import KnownRange
from vcmm.core.effect import known_range
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.task.measuring.fixture import six_of

EDGE = 1e-9  # mm of rounding


@dataclass(frozen=True, eq=False)
class Travels:
    """Travels and known ranges of a machine for a plan."""

    rows: Rows

    @cached_property
    def limits(self) -> tuple[KnownRange, ...]:
        machine = self.rows.machine
        out = [
            KnownRange(f"travel of axis {a}", "XYZ".index(a), *machine.axes[a].travel)
            for a in machine.chain.letters
            if a in "XYZ"
        ]
        for i, letter in enumerate("XYZ"):
            if letter not in machine.chain.letters:
                out.append(KnownRange(f"no axis {letter}", i, 0.0, 0.0))
        for effect in machine.effects:
            out += known_range(effect)
        return tuple(out)

    def intervals(self, six: Array) -> tuple[Array, Array]:
        """Return shifts (m, 3) low and high that all limits allow for the orientations of poses (m, 6); low > high: none."""
        turned = np.array(six, dtype=float)
        turned[:, :3] = 0.0
        axis = self.rows.axis_positions(turned)
        both = {"axis": axis, "tip": axis + self.rows.zero}
        low, high = np.full((len(six), 3), -np.inf), np.full((len(six), 3), np.inf)
        for limit in self.limits:
            at = both[limit.of][..., limit.direction]
            i = limit.direction
            low[:, i] = np.maximum(low[:, i], limit.low - at.min(axis=1))
            high[:, i] = np.minimum(high[:, i], limit.high - at.max(axis=1))
        return low, high

    def feasible(self, poses: Array) -> npt.NDArray[np.bool_]:
        """Return which of the poses (m, 6) keep all limits."""
        low, high = self.intervals(poses)
        shift = poses[:, :3]
        return np.asarray(((shift >= low - EDGE) & (shift <= high + EDGE)).all(axis=1))

    def problems(self, pose: Pose) -> list[Hindrance]:
        """Return every limit that the pose misses, with the point that misses it most."""
        axis = self.rows.axis_positions(six_of(pose)[None])[0]
        both = {"axis": axis, "tip": axis + self.rows.zero}
        out = []
        for limit in self.limits:
            at = both[limit.of][:, limit.direction]
            miss = np.maximum(limit.low - at, at - limit.high)
            worst = int(miss.argmax())
            if miss[worst] > EDGE:
                point, amount = str(self.rows.touches.run.labels["touch"][worst]), float(miss[worst])
                text = f"{limit.what} at {point}: {amount:.3g} mm too far"
                kind = "travel" if limit.of == "axis" else "range"
                out.append(Hindrance(kind, limit.what, point, amount, text))
        return out
