"""Order of touches: short ways, and drift that does not look like the measurand.

The touches form legs, each one visit to a feature with one stylus. Within a leg the way is shortened by 2-opt moves (Croes,
Operations Research 6 (1958) 791). Drift reads sum s_i d_i t_i; moves that lower time + drift are kept, also the division of
a leg into two visits, there and back, which takes a linear drift out of differences.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vcmm.answer.placing.candidates import TouchProblem
from vcmm.answer.placing.design import Design, Target
from vcmm.core.pose import Array
from vcmm.part.fit.elements import MINIMUM_POINTS
from vcmm.task.measuring.plan import Ints, Plan, Step, touches


@dataclass(frozen=True, eq=False)
class Visit:
    """Data for the order of n touches. seconds: one touch; way (n, n) s between two; change (n, n) s for another stylus.

    pull (R, n, D): u of each weighted output per second of drift at each touch: its drift is |sum pull t|.
    """

    group: Ints
    seconds: float
    way: Array
    pull: Array

    def times(self, order: Ints) -> Array:
        """Return the times (n,) s of the touches, in order."""
        steps = np.concatenate([[0.0], self.way[order[:-1], order[1:]]])
        return np.cumsum(steps + self.seconds)

    def drift(self, order: Ints) -> float:
        """Sum of squares of what a unit of every drift makes of the weighted outputs."""
        if not self.pull.size:
            return 0.0
        return float(np.sum(np.einsum("rnd,n->rd", self.pull[:, order], self.times(order)) ** 2))

    def cost(self, order: Ints, price: float) -> float:
        """Return the cost in s; price: seconds per unit of drift."""
        return float(self.times(order)[-1]) + price * self.drift(order)


ROUNDS = 30  # random changes of an order, per touch


def order_touches(visit: Visit, price: float = 0.0, seed: int = 0) -> Ints:
    """Return an order of the touches: nearest neighbour group by group, then 2-opt and moves of single touches while cost falls.

    With drift that matters, a there-and-back order of all groups is tried as a start too.
    """
    start = _greedy(visit)
    starts = [start]
    if visit.pull.size and price > 0.0:
        starts.append(_there_and_back(visit, start))
    improved = [_improve_order(visit, s, price, seed) for s in starts]
    return min(improved, key=lambda o: visit.cost(o, price))


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
    """Return an order with every second touch of each group on the way there, the others on the way back."""
    there, back = [], []
    for group in dict.fromkeys(visit.group[order].tolist()):
        mine = [int(i) for i in order if visit.group[i] == group]
        there += mine[::2]
        back += mine[1::2]
    return np.array(there + back[::-1], dtype=np.intp)


def _improve_order(visit: Visit, order: Ints, price: float, seed: int) -> Ints:
    """Improve an order by 2-opt: a stretch reversed; or-opt: one touch elsewhere; random pairs, ROUNDS of n."""
    rng, n = np.random.default_rng(seed), len(order)
    best = visit.cost(order, price)
    for _ in range(ROUNDS * n if n > 2 else 0):
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
    """Return the ways between touches (n, n) s: straight on one feature; `over` mm up and down between features; a stylus change."""
    way = np.linalg.norm(tips[:, None] - tips[None], axis=2)
    way = way + np.where(group[:, None] != group[None], 2.0 * over, 0.0)
    return way / speed + np.where(stylus[:, None] != stylus[None], change, 0.0)


@dataclass(frozen=True, eq=False)
class OrderedPlan:
    """plan in measuring order; seconds as vcmm.task.measuring.plan reckons, with stylus changes; drift: variance by characteristic;
    penalty: what drift adds to the objective."""

    plan: Plan
    seconds: float
    drift: Mapping[str, float]
    penalty: float


def ordered_plan(
    problem: TouchProblem,
    design: Design,
    rows: Mapping[str, slice],
    target: Target,
    change_s: float,
    seed: int,
) -> OrderedPlan:
    """Put the touches of a design into order and time them."""
    c = problem.candidates
    which = np.repeat(np.arange(len(design.counts)), design.counts)
    visit = _visit(problem, design, which, target, change_s)
    price = 0.0
    base = visit.times(np.arange(len(which)))[-1]
    if visit.pull.size and target.criterion == "U":
        price = float(base) / max(
            design.value(), 1e-300
        )  # drift as bad as all else costs as much as the whole time
    order = readable(problem, which[order_touches(visit, price, seed=seed)])
    plan = replace(problem.scenario.plan, steps=_steps(problem, order))
    placed = touches(plan, problem.scenario.pose, problem.scenario.machine, problem.scenario.constants)
    styli = [s.stylus for s in plan.steps]
    changes = sum(a != b for a, b in pairwise(styli))
    time = placed.run.column("time_s")
    read = design.sensitivities(target.rows)[:, order]
    moved = np.einsum(
        "rn,nd,n->rd",
        read,
        problem.drift[order],
        time + change_s * _changes_before(c.feature[order], problem),
    )
    square = np.sum(moved**2, axis=1)
    drift = {name: float(square[s].sum()) for name, s in rows.items()}
    penalty = float(target.weight @ square) if target.criterion == "U" else 0.0
    return OrderedPlan(plan, float(time[-1]) + change_s * changes, drift, penalty)


def readable(problem: TouchProblem, order: Ints) -> Ints:
    """Return the order with visits joined that are too short for a step of a plan file: each step holds enough for a fit."""
    c = problem.candidates
    for f, name in enumerate(c.names):
        fewest = MINIMUM_POINTS.get(problem.motions[name].feature.kind, 1)
        visits = np.split(np.arange(len(order)), np.flatnonzero(np.diff(c.feature[order])) + 1)
        mine = [v for v in visits if c.feature[order[v[0]]] == f]
        if len(mine) > 1 and min(len(v) for v in mine) < fewest:
            others = [v for v in visits if c.feature[order[v[0]]] != f]
            place = sum(v[0] < mine[0][0] for v in others)
            order = order[np.concatenate([*others[:place], *mine, *others[place:]])]
    return order


def _changes_before(feature: Ints, problem: TouchProblem) -> Array:
    """Return the number of stylus changes before each touch (n,)."""
    styli = np.array([problem.styli[name] for name in problem.candidates.names])[feature]
    return np.concatenate([[0], np.cumsum(styli[1:] != styli[:-1])]).astype(float)


def _visit(problem: TouchProblem, design: Design, which: Ints, target: Target, change_s: float) -> Visit:
    c, scenario = problem.candidates, problem.scenario
    touch = scenario.plan.touch
    names = [problem.styli[n] for n in c.names]
    stylus = np.array([names.index(names[f]) for f in range(len(names))])[c.feature[which]]
    tips = c.points[which] + c.normals[which] * touch.approach
    way = ways(tips, c.feature[which], stylus, touch.positioning, touch.clearance, change_s)
    read = np.sqrt(target.weight)[:, None] * design.sensitivities(target.rows)[:, which]
    pull = read[:, :, None] * problem.drift[which][None]
    return Visit(c.feature[which], 2.0 * touch.approach / touch.speed, way, pull)


def _steps(problem: TouchProblem, order: Ints) -> tuple[Step, ...]:
    """Return consecutive touches of one feature as one step."""
    c = problem.candidates
    cuts = np.flatnonzero(np.diff(c.feature[order])) + 1
    out = []
    for stretch in np.split(order, cuts):
        name = c.names[int(c.feature[stretch[0]])]
        out.append(Step(name, problem.styli[name], c.points[stretch], c.normals[stretch]))
    return tuple(out)
