"""Order of touches: short ways, and drift that does not look like the measurand.

The touches stand in legs, one visit to a feature with one stylus. Within a leg the way is shortened by 2-opt moves (Croes,
Operations Research 6 (1958) 791). Drift reads sum s_i d_i t_i; moves that lower time + drift are kept, also the division of
a leg into two visits, there and back, which takes a linear drift out of differences.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.pose import Array

Ints = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Visit:
    """What the order needs of n touches. seconds: one touch; way (n, n) s between two; change (n, n) s for another stylus.

    pull (R, n, D): u of each weighted output per second of drift at each touch: its drift is |sum pull t|.
    """

    group: Ints
    seconds: float
    way: Array
    pull: Array

    def times(self, order: Ints) -> Array:
        """(n,) s at which touches are made, in order."""
        steps = np.concatenate([[0.0], self.way[order[:-1], order[1:]]])
        return np.cumsum(steps + self.seconds)

    def drift(self, order: Ints) -> float:
        """Sum of squares of what a unit of every drift makes of the weighted outputs."""
        if not self.pull.size:
            return 0.0
        return float(np.sum(np.einsum("rnd,n->rd", self.pull[:, order], self.times(order)) ** 2))

    def cost(self, order: Ints, price: float) -> float:
        """s; price: seconds per unit of drift."""
        return float(self.times(order)[-1]) + price * self.drift(order)


def ordered(visit: Visit, price: float = 0.0, rounds: int = 30, seed: int = 0) -> Ints:
    """An order of the touches: nearest neighbour group by group, then 2-opt and moves of single touches while cost falls.

    With drift that matters, a there-and-back order of all groups is tried as a start too.
    """
    start = _greedy(visit)
    starts = [start]
    if visit.pull.size and price > 0.0:
        starts.append(_there_and_back(visit, start))
    found = [_improved(visit, s, price, rounds, seed) for s in starts]
    return min(found, key=lambda o: visit.cost(o, price))


def _greedy(visit: Visit) -> Ints:
    left, order = set(range(len(visit.group))), [0]
    left.discard(0)
    while left:
        here = order[-1]
        same = [i for i in left if visit.group[i] == visit.group[here]] or list(left)
        following = min(same, key=lambda i: (visit.way[here, i], i))
        order.append(following)
        left.discard(following)
    return np.array(order, dtype=np.intp)


def _there_and_back(visit: Visit, order: Ints) -> Ints:
    """Every second touch of each group on the way there, the others on the way back."""
    there, back = [], []
    for group in dict.fromkeys(visit.group[order].tolist()):
        mine = [int(i) for i in order if visit.group[i] == group]
        there += mine[::2]
        back += mine[1::2]
    return np.array(there + back[::-1], dtype=np.intp)


def _improved(visit: Visit, order: Ints, price: float, rounds: int, seed: int) -> Ints:
    """2-opt: a stretch reversed; or-opt: one touch elsewhere; random pairs, so many rounds of n."""
    rng, n = np.random.default_rng(seed), len(order)
    best = visit.cost(order, price)
    for _ in range(rounds * n if n > 2 else 0):
        i, j = sorted(rng.choice(n, 2, replace=False).tolist())
        trial = order.copy()
        if rng.random() < 0.6:
            trial[i : j + 1] = trial[i : j + 1][::-1]
        else:
            trial = np.insert(np.delete(order, i), j, order[i])
        cost = visit.cost(trial, price)
        if cost < best - 1e-12:
            order, best = trial, cost
    return order


def ways(tips: Array, group: Ints, stylus: Ints, speed: float, over: float, change: float) -> Array:
    """(n, n) s between touches: straight on one feature; `over` mm up and down between features; a stylus change."""
    way = np.linalg.norm(tips[:, None] - tips[None], axis=2)
    way = way + np.where(group[:, None] != group[None], 2.0 * over, 0.0)
    return way / speed + np.where(stylus[:, None] != stylus[None], change, 0.0)
