"""Plan the next checks: the plan that keeps every limit at the least cost that is found.

A check is worth nothing before it is needed: it is done on the last day on which all limits still hold (later is never worse, for its
information is then more recent). All orders of checks are searched, the cheaper per day first, WIDE of them at a time (beam search), so that a
plan is shown to keep the limits at its stated cost; that none is cheaper is not shown. The future readings of a check do not matter: the
covariance of a linear Gaussian state does not depend on the readings (Kalman 1960). Jumps are no part of the plan.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.run import Array
from vcmm.learn.tracking.follow import FollowedMachine
from vcmm.learn.tracking.learn_rates import columns_for
from vcmm.learn.tracking.rates import WanderingMotion
from vcmm.learn.tracking.task_limits import K, TaskLimit

WIDE, LONGEST = 60, 366  # orders kept; days ahead
MOST_CHECKS = 60  # checks of a plan
ROUNDING = 1e-13  # of the largest: a way of going on in time below it is rounding


@dataclass(frozen=True)
class ShopCheck:
    """like: name of a recording that was followed; cost in any unit; minutes of the machine."""

    name: str
    like: str
    cost: float
    minutes: float


@dataclass(frozen=True)
class NextCheck:
    """A check done on its day: until then limits hold; U_after of every limit; holds: days from then until the next is needed (None: a year)."""

    check: ShopCheck
    day: int
    u_after: Mapping[str, float]
    holds: int | None


@dataclass(frozen=True)
class CheckPlan:
    """checks in order; cost; kept: whether every limit holds on every day; fixed: (check, days, cost) of the cheapest fixed interval."""

    checks: tuple[NextCheck, ...]
    cost: float
    days: int
    kept: bool
    fixed: tuple[str, int, float] | None


@dataclass(frozen=True, eq=False)
class _Plans:
    motion: WanderingMotion
    limits: tuple[TaskLimit, ...]
    columns: Mapping[str, Array]

    @cached_property
    def ahead(self) -> tuple[tuple[Array, Array, Array], ...]:
        """Dependence of the characteristic of every limit on each day on the state of today, (LONGEST + 1, k) @ (k, n), and (LONGEST + 1,) the variance that comes in.

        k is small: constant, trend, season and swings are few ways in which a gain develops in time.
        """
        carried = [self.motion.carry(np.eye(self.motion.size), d) for d in range(LONGEST + 1)]
        fresh = np.array([self.motion.fresh(d) for d in range(LONGEST + 1)])
        out = []
        for x in self.limits:
            days, size, ways = np.linalg.svd(np.array([x.gain @ c for c in carried]), full_matrices=False)
            kept = size > ROUNDING * max(float(size[0]), 1e-300)
            out.append((days[:, kept] * size[kept], ways[kept], fresh @ x.gain**2))
        return tuple(out)

    def after(self, covariance: Array, days: int) -> Array:
        """Return the covariance so many days later."""
        return self.motion.later(covariance, days)

    def after_check(self, covariance: Array, name: str) -> Array:
        """Return the covariance after a check, in Joseph's form."""
        h = self.columns[name]
        gain = np.linalg.solve(h @ covariance @ h.T + np.eye(len(h)), h @ covariance).T
        left = np.eye(len(covariance)) - gain @ h
        return np.asarray(left @ covariance @ left.T + gain @ gain.T)

    def expanded(self, covariance: Array) -> Array:
        """Return U of every limit."""
        square = [x.rest**2 + float(x.gain @ covariance @ x.gain) for x in self.limits]
        return K * np.sqrt(np.array(square))

    def holds(self, covariance: Array) -> int:
        """Return the days for which all limits hold without a break: 0 where they hold today only, -1 where not even today; LONGEST at most."""
        good = np.ones(LONGEST + 1, dtype=bool)
        for x, (days, ways, fresh) in zip(self.limits, self.ahead):
            square = x.rest**2 + fresh + ((days @ (ways @ covariance @ ways.T)) * days).sum(axis=1)
            good &= K * np.sqrt(np.maximum(square, 0.0)) <= x.limit
        return LONGEST if good.all() else int(np.argmin(good)) - 1


def plan_checks(
    followed: FollowedMachine,
    start: float,
    checks: Sequence[ShopCheck],
    limits: tuple[TaskLimit, ...],
    days: int,
) -> tuple[tuple[NextCheck, ...], CheckPlan]:
    """Return every check by itself as the next one, the cheapest per day first, and the plan of so many days from `start`.

    Raises UsageError for a check like a recording that was not followed.
    """
    plans = _Plans(followed.motion, limits, {c.name: _columns(followed, c) for c in checks})
    state = followed.at(start)
    covariance = state.covariance
    free = plans.holds(covariance)
    return _each(plans, covariance, max(free, 0), checks), _search(plans, covariance, checks, days)


def _columns(followed: FollowedMachine, check: ShopCheck) -> Array:
    names = [s.name for s in followed.recordings]
    if check.like not in names:
        raise UsageError(
            f'check "{check.name}": like = "{check.like}" is no recording that was followed.{choose_from(check.like, names)}'
        )
    return columns_for(followed.recordings[names.index(check.like)], followed.tracked.stated)


def _each(plans: _Plans, covariance: Array, day: int, checks: Sequence[ShopCheck]) -> tuple[NextCheck, ...]:
    """Return each check on the last day that still holds; those that hold longest for their cost first."""
    then = plans.after(covariance, day)
    checks_done = [_do_check(plans, plans.after_check(then, c.name), c, day) for c in checks]
    return tuple(sorted(checks_done, key=lambda n: n.check.cost / max(_days(n), 1e-9)))


def _days(check: NextCheck) -> float:
    return float(LONGEST if check.holds is None else max(check.holds, 0))


def _do_check(plans: _Plans, covariance: Array, check: ShopCheck, day: int) -> NextCheck:
    u = dict(zip((x.name for x in plans.limits), plans.expanded(covariance).tolist()))
    holds = plans.holds(covariance)
    return NextCheck(check, day, u, None if holds >= LONGEST else holds)


@dataclass(frozen=True, eq=False)
class _Way:
    day: int
    covariance: Array
    cost: float
    checks: tuple[NextCheck, ...]


def _search(plans: _Plans, covariance: Array, checks: Sequence[ShopCheck], days: int) -> CheckPlan:
    """Return the cheapest plan through the days that the beam finds; where none holds, the best one with kept = False."""
    ways, best, last = [_Way(0, covariance, 0.0, ())], None, None
    for _ in range(MOST_CHECKS):
        following = []
        for way in ways:
            last = way
            free = plans.holds(way.covariance)
            if free >= 0 and way.day + free >= days:
                best = way if best is None or way.cost < best.cost else best
                continue
            if best is not None and way.cost >= best.cost:
                continue
            day = way.day + max(free, 0)
            then = plans.after(way.covariance, max(free, 0))
            for check in checks:
                after = plans.after_check(then, check.name)
                gained = plans.holds(after)
                if gained > max(free, 0) - (day - way.day) and (gained > 0 or day == way.day):
                    check_done = _do_check(plans, after, check, day)
                    following.append(_Way(day, after, way.cost + check.cost, (*way.checks, check_done)))
        ways = sorted(following, key=lambda w: w.cost / (w.day + max(plans.holds(w.covariance), 0) + 1.0))[
            :WIDE
        ]
        if not ways:
            break
    fixed = _cheapest_fixed_interval(plans, covariance, checks, days)
    if best is None:
        return CheckPlan(last.checks if last else (), last.cost if last else 0.0, days, False, fixed)
    return CheckPlan(best.checks, best.cost, days, True, fixed)


def _cheapest_fixed_interval(
    plans: _Plans, covariance: Array, checks: Sequence[ShopCheck], days: int
) -> tuple[str, int, float] | None:
    """Return the cheapest single check at a fixed interval, the first today, that keeps all limits; None where none does."""
    intervals = []
    for check in checks:
        for interval in range(min(days, LONGEST), 0, -1):
            state, day, good = plans.after_check(covariance, check.name), 0, True
            while good and day < days:
                good = plans.holds(state) >= min(interval, days - day)
                day += interval
                state = plans.after_check(plans.after(state, interval), check.name)
            if good:
                intervals.append((check.name, interval, check.cost * (1 + (days - 1) // interval)))
                break
    return min(intervals, key=lambda f: f[2]) if intervals else None
