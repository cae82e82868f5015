"""Result of tracking a machine: its parameters over time, its alarms, its forecast, and the machine of a day."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.effect import parameter, unit_of
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.units import in_unit
from vcmm.core.views import draw
from vcmm.core.whole_files import write_files
from vcmm.files.learned.dated_machine import machine_files
from vcmm.learn.tracking.dates import moment
from vcmm.learn.tracking.follow import FollowedCheck, FollowedMachine, course
from vcmm.learn.tracking.kalman import GaussianState
from vcmm.learn.tracking.machine_at import DatedMachine, as_machine, is_single, machine_on
from vcmm.learn.tracking.quantities import TrackedQuantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.files.learned.track_questions import CheckAdvice
    from vcmm.learn.tracking.doubtful import DoubtfulParts

DAYS = 30  # that a plan of checks covers
AHEAD = (7.0, 30.0, 90.0)  # days of the forecast
ROUND = {"mm": "um", "rad": "urad"}  # how small lengths and angles are written
MOST_NAMED_NUMBERS = 4  # numbers that a warning names
WEEK = 7.0  # days after a check from which its age is reported
BANDS = (
    "on 24 drawn machines with a season and wear the 95 % bands held 0.92 up to 30 days after a check and 0.91 (0.88 to 0.94) after 90 "
    "(docs/track.md)"
)


@dataclass(frozen=True, eq=False)
class NumberOverTime:
    """One number over time: name, unit; when (n,) days, value, u (n,) in that unit; ahead: days of the forecast beside value and u; of_day: value and
    u on the day for which the machine is written.

    what: "" for a number by itself; "end less start" of a table over its travel.
    """

    name: str
    unit: str
    what: str
    when: Array
    value: Array
    u: Array
    ahead: tuple[tuple[float, float, float], ...]
    of_day: tuple[float, float]

    @property
    def change_over_u(self) -> float:
        """The largest change over the root of the sum of the squared uncertainties of its two ends."""
        start, u0 = self.value[0], self.u[0]
        away = np.abs(self.value - start) / np.maximum(np.hypot(self.u, u0), 1e-300)
        return float(away.max())


@dataclass(frozen=True, eq=False)
class Track:
    """followed: recordings, checks, rates and state. dated: the machine on the day `at`. added: recordings that this call took in.

    original: the machine file that was followed; folder: of the recordings.
    """

    followed: FollowedMachine
    dated: DatedMachine
    at: str
    new_recordings: int
    original: Path
    folder: Path

    def __repr__(self) -> str:
        return (
            f"Track({self.followed.tracked.machine.name}: {len(self.checks)} recordings until {self.checks[-1].date}, "
            f"{len(self.alarms)} alarms, as of {self.at})"
        )

    @property
    def checks(self) -> tuple[FollowedCheck, ...]:
        return self.followed.checks

    @property
    def alarms(self) -> tuple[FollowedCheck, ...]:
        return tuple(c for c in self.checks if c.alarm)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Assumptions that were not shown, where they matter here."""
        days = self.dated.when - self.checks[-1].when
        age = f"{self.at} is {days:.0f} days after the last check: " if days > WEEK else ""
        least = "; the line time since calibration is the least that time has brought" if days > WEEK else ""
        return (*self._taken_as_exact, f"{age}{BANDS}{least}")

    @property
    def _taken_as_exact(self) -> tuple[str, ...]:
        """Numbers of which the machine file states no uncertainty, in words; nothing where it states that of all."""
        tracked = self.followed.tracked
        open_ = [q.id for q in tracked.quantities if not tracked.factor[tracked.rows[q.id]].any()]
        if not open_:
            return ()
        more = f" and {len(open_) - MOST_NAMED_NUMBERS} more" if len(open_) > MOST_NAMED_NUMBERS else ""
        return (
            f"the machine file states no uncertainty of {', '.join(open_[:MOST_NAMED_NUMBERS])}{more}: taken as exactly right on the day of the first recording; "
            "state u in [[inputs]], or calibrate the machine first",
        )

    @property
    def machine(self) -> Machine:
        """The machine of the day, as read from the files that `write` makes."""
        return as_machine(self.dated)

    def machine_on(self, when: str) -> DatedMachine:
        """Return the machine on another day, not before the last recording."""
        day = moment(when)
        if self.followed.last is not None and day < self.followed.last:
            raise UsageError(f"{when} is before the last recording, {self.checks[-1].date}")
        return machine_on(self.followed, day)

    @cached_property
    def courses(self) -> tuple[NumberOverTime, ...]:
        """Every number that is followed, with the present rates."""
        picked = [p for q in self.followed.tracked.quantities for p in _numbers_of(q)]
        rows = self.followed.tracked.rows
        pick = np.zeros((len(picked), self.followed.tracked.factor.shape[0]))
        start = np.zeros(len(picked))
        for i, number in enumerate(picked):
            pick[i, rows[number.quantity.id]] = number.weights
            start[i] = number.weights @ number.quantity.value
        ways, states = pick @ self.followed.ways, self._states
        values = np.array([start + ways @ s.mean for s in states])
        us = np.array([np.sqrt(((ways @ s.factor) ** 2).sum(axis=1)) for s in states])
        last = float(self.followed.last or 0.0)
        beyond = max(self.dated.when - last, 0.0)
        future = [(d, self.followed.at(last + d)) for d in (*AHEAD, beyond)]
        when = np.array([c.when for c in self.checks])
        out = []
        for i, number in enumerate(picked):
            size = 1.0 / in_unit(1.0, number.unit) if number.unit not in ("", "1") else 1.0
            ahead = tuple(
                (
                    d,
                    float(start[i] + ways[i] @ s.mean) / size,
                    float(np.linalg.norm(ways[i] @ s.factor)) / size,
                )
                for d, s in future
            )
            out.append(
                NumberOverTime(
                    number.name,
                    number.unit,
                    number.what,
                    when,
                    value=values[:, i] / size,
                    u=us[:, i] / size,
                    ahead=ahead[:-1],
                    of_day=ahead[-1][1:]
                    if beyond
                    else (float(values[-1, i]) / size, float(us[-1, i]) / size),
                )
            )
        return tuple(out)

    @cached_property
    def _states(self) -> list[GaussianState]:
        return course(self.followed)

    def states_before(self, number: int) -> tuple[Array, Array]:
        """Return mean and factor of the state on the day of a recording, before it was processed."""
        now = self.checks[number].when
        if not number:
            start = self.followed.start
            return start.mean, start.factor
        earlier = self.followed.motion.step(self._states[number - 1], now - self.checks[number - 1].when)
        return earlier.mean, earlier.factor

    def course(self, name: str) -> NumberOverTime:
        """Return one number by its name. Raises KeyError with the closest names."""
        for number in self.courses:
            if number.name == name:
                return number
        raise KeyError(f'no "{name}" is followed.{choose_from(name, [c.name for c in self.courses])}')

    def plot(self, name: str | None = None, ax: Any = None) -> Axes:
        """Plot one number over the days with its 95 % band, checks, alarms and forecast; default: the one that moved most.

        Of a recording's name ("345_bar.toml YZ"): the check beside what was forecast of it, round or along its axis.
        """
        drawn: Axes = draw(self, name, ax)
        return drawn

    def next_checks(
        self, task: str | Path, limits: str | Sequence[str], checks: str | Path, days: int = DAYS
    ) -> CheckAdvice:
        """Return which check of a list (checks/1) keeps the limits of a task longest for its cost, and a plan from `at` on.

        limits: such as "bore to front = 2 um", U = 2 u.
        """
        stated = [limits] if isinstance(limits, str) else limits
        from vcmm.files.learned.track_questions import (
            advise_checks,  # a plain recording does not wait for tasks
        )

        return advise_checks(self.followed, self.dated, Path(task), stated, Path(checks), days)

    def doubtful_parts(self, task: str | Path, parts: str | Path) -> tuple[DoubtfulParts, ...]:
        """Return, of a list (part,date), those between a good check and an alarm, and the shift of the characteristics of a task."""
        from vcmm.files.learned.track_questions import parts_in_doubt

        return parts_in_doubt(self.followed, self.dated, Path(task), Path(parts))

    def to_dict(self) -> dict[str, Any]:
        """Return the document vcmm.track/1."""
        return {
            "machine": self.followed.tracked.machine.name,
            "at": self.at,
            "last_check": self.checks[-1].date,
            "added": self.new_recordings,
            "alpha": self.followed.alpha,
            "rates": [
                {"group": g, "model": r.words, "log_prior": r.log_prior}
                for g, r in zip(self.followed.tracked.groups, self.followed.rates)
            ],
            "parameters": [_document(c, self.checks) for c in self.courses],
            "checks": [_check_document(c) for c in self.checks],
            "alarms": [_alarm_document(c, self.checks) for c in self.alarms],
            "forecast": [
                {"input": c.name, "days": d, "value": v, "u": u, "unit": c.unit}
                for c in self.courses
                for d, v, u in c.ahead
            ],
            "not_followed": list(self.followed.tracked.apart),
        }

    def files(self, target: Path) -> dict[str, str]:
        """Return the machine of the day as files: see vcmm.files.learned.dated_machine."""
        return machine_files(self.dated, self.original, target, self.at, self.checks[-1].date)

    def write(self, folder: str | Path) -> Path:
        """Write machine.toml with its table and covariances into a folder; return its path."""
        target = Path(folder) / "machine.toml"
        target.parent.mkdir(parents=True, exist_ok=True)
        write_files(target.parent, self.files(target))
        return target


@dataclass(frozen=True, eq=False)
class _ShownNumber:
    """A displayed number: weights (size,) on the elements of a quantity."""

    quantity: TrackedQuantity
    name: str
    unit: str
    what: str
    weights: Array


def _numbers_of(q: TrackedQuantity) -> list[_ShownNumber]:
    """Return the displayed numbers: a single number; a table by its end less its start; of another array every element."""
    unit = parameter(q.effect, q.parameter).metadata["show"]
    unit = unit_of(q.effect, q.parameter) if unit == "mm or rad" or unit not in ROUND.values() else unit
    if unit == "mm or rad" or unit in ROUND:
        unit = ROUND.get(unit, "um")
    if is_single(q):
        return [_ShownNumber(q, q.id, unit, "", np.ones(1))]
    if q.effect.about.table_parameter == q.parameter:
        weights = np.zeros(q.size)
        weights[0], weights[-1] = -1.0, 1.0
        return [_ShownNumber(q, q.id, unit, "end less start", weights)]
    return [_ShownNumber(q, f"{q.id}@{i}", unit, "", np.eye(q.size)[i]) for i in range(q.size)]


def _document(c: NumberOverTime, checks: tuple[FollowedCheck, ...]) -> dict[str, Any]:
    return {
        "input": c.name,
        "unit": c.unit,
        "of": c.what or "number",
        "time": [k.date for k in checks],
        "value": c.value.tolist(),
        "u": c.u.tolist(),
    }


def _check_document(c: FollowedCheck) -> dict[str, Any]:
    return {
        "recording": c.name, "date": c.date, "rows": c.rows, "combinations_seen": c.rank, "noise_scale": c.noise,
        "outliers": c.outliers, "chance": c.chance, "level": c.level, "alarm": c.alarm, "rms_predicted": c.rms_predicted,
        "rms_unchanged": c.rms_unchanged, "innovation_over_u": c.spread, "probability_of_change": c.change,
        "changed": [{"name": n, "probability": p} for n, p in c.suspects],
    }  # fmt: skip


def _alarm_document(c: FollowedCheck, checks: tuple[FollowedCheck, ...]) -> Mapping[str, Any]:
    return {
        "recording": c.name,
        "date": c.date,
        "since": last_good(c, checks),
        "chance": c.chance,
        "level": c.level,
        "probability_of_change": c.change,
        "changed": [{"name": n, "probability": p} for n, p in c.suspects],
        "diagnosis": c.answer or None,
    }


def last_good(alarm: FollowedCheck, checks: tuple[FollowedCheck, ...]) -> str | None:
    """Return the date of the last recording before an alarm that agreed with its prediction; None where there was none."""
    before = [c for c in checks[: checks.index(alarm)] if not c.alarm]
    return before[-1].date if before else None
