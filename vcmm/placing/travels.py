"""What keeps a pose from being used: the travels of the axes and the ranges in which the machine's errors are known.

`Feasibility` is the interface of all constraints; `Travels` is the one that every machine has. For a given orientation
the travels leave an interval of shifts along each axis, which `intervals` gives in closed form.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import numpy.typing as npt

from vcmm.core.declaration import KnownRange
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.measuring.fixture import six_of
from vcmm.placing.rows import Rows

EDGE = 1e-9  # mm of rounding


@dataclass(frozen=True)
class Problem:
    """Why a pose cannot be used. amount: mm by which the constraint is missed."""

    name: str
    constraint: str
    point: str
    amount: float

    @property
    def text(self) -> str:
        where = f" at {self.point}" if self.point else ""
        return f"{self.constraint}{where}: {self.amount:.3g} mm too far"


class Hindrance(Protocol):
    """What stands in the way of a pose, whichever constraint names it."""

    @property
    def name(self) -> str: ...
    @property
    def constraint(self) -> str: ...
    @property
    def point(self) -> str: ...
    @property
    def amount(self) -> float: ...
    @property
    def text(self) -> str: ...


class Feasibility(Protocol):
    """A constraint on poses: which of (m, 6) can be used, and what is wrong with one."""

    def problems(self, pose: Pose) -> Sequence[Hindrance]: ...

    def feasible(self, poses: Array) -> npt.NDArray[np.bool_]: ...


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
            out += effect.known_range()
        return tuple(out)

    def intervals(self, six: Array) -> tuple[Array, Array]:
        """Shifts (m, 3) low and high that all limits allow for the orientations of poses (m, 6); low > high: none."""
        turned = np.array(six, dtype=float)
        turned[:, :3] = 0.0
        axis = self.rows.wanted(turned)
        both = {"axis": axis, "tip": axis + self.rows.zero}
        low, high = np.full((len(six), 3), -np.inf), np.full((len(six), 3), np.inf)
        for limit in self.limits:
            at = both[limit.of][..., limit.direction]
            i = limit.direction
            low[:, i] = np.maximum(low[:, i], limit.low - at.min(axis=1))
            high[:, i] = np.minimum(high[:, i], limit.high - at.max(axis=1))
        return low, high

    def feasible(self, poses: Array) -> npt.NDArray[np.bool_]:
        """Which of the poses (m, 6) keep all limits."""
        low, high = self.intervals(poses)
        shift = poses[:, :3]
        return np.asarray(((shift >= low - EDGE) & (shift <= high + EDGE)).all(axis=1))

    def problems(self, pose: Pose) -> list[Problem]:
        """Every limit that the pose misses, with the point that misses it most."""
        axis = self.rows.wanted(six_of(pose)[None])[0]
        both = {"axis": axis, "tip": axis + self.rows.zero}
        out = []
        for limit in self.limits:
            at = both[limit.of][:, limit.direction]
            miss = np.maximum(limit.low - at, at - limit.high)
            worst = int(miss.argmax())
            if miss[worst] > EDGE:
                label = str(self.rows.placed.run.labels["touch"][worst])
                out.append(
                    Problem(
                        "travel" if limit.of == "axis" else "range", limit.what, label, float(miss[worst])
                    )
                )
        return out
