"""The touches of a plan as the constraints need them: drawing frame, one row per touch, no machine yet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.pose import Array
from vcmm.measuring.plan import Plan

Ints = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Rows:
    """n touches in measuring order. tip (n, 3): centre of the tip at the touch; start: before the approach;
    left: after the retract. stylus (n,): number among `styli`. names: "point 3 on bore".
    """

    plan: Plan
    styli: tuple[str, ...]
    tip: Array
    normal: Array
    start: Array
    left: Array
    radius: Array
    offset: Array
    stylus: Ints
    names: tuple[str, ...]

    @property
    def n(self) -> int:
        return len(self.tip)

    def pairs(self) -> Ints:
        """(k, 2) numbers of touches that follow one another with one stylus."""
        first = np.flatnonzero(self.stylus[1:] == self.stylus[:-1])
        return np.stack([first, first + 1], axis=1)

    def ends(self) -> Ints:
        """Touches at which a stylus comes into play or goes out of it."""
        change = np.flatnonzero(self.stylus[1:] != self.stylus[:-1])
        return np.unique(np.concatenate([[0], change, change + 1, [self.n - 1]]))


def rows_of(plan: Plan) -> Rows:
    """The touches of a plan; approach, start and retract as `vcmm.measuring.plan.touches` makes them."""
    points = np.concatenate([s.points for s in plan.steps])
    normal = np.concatenate([s.normals for s in plan.steps])
    approach = np.concatenate([-s.normals if s.approach is None else s.approach for s in plan.steps])
    styli = tuple(dict.fromkeys(s.stylus for s in plan.steps))
    stylus = np.concatenate([np.full(len(s.points), styli.index(s.stylus)) for s in plan.steps])
    radius = np.array([plan.styli[styli[i]].tip_radius for i in stylus])
    offset = np.array([plan.styli[styli[i]].offset for i in stylus], dtype=float)
    tip, away = points + radius[:, None] * normal, plan.touch.approach
    count: dict[str, int] = {}
    names = []
    for step in plan.steps:
        for _ in range(len(step.points)):
            count[step.feature] = count.get(step.feature, 0) + 1
            names.append(f"point {count[step.feature]} on {step.feature}")
    return Rows(
        plan,
        styli,
        tip,
        normal,
        tip - away * approach,
        tip + away * normal,
        radius,
        offset,
        stylus,
        tuple(names),
    )
