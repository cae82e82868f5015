"""A machine that is followed, as tables: its recordings, its alarms, its numbers of the day."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vcmm.files.learned.track_result import NumberOverTime, Track, last_good
from vcmm.learn.tracking.dates import date_of
from vcmm.show.tables.quantities import value_text
from vcmm.show.tables.table import NUMBER_TEXT, Column, ResultTable

if TYPE_CHECKING:
    from vcmm.learn.tracking.doubtful import CharacteristicShift, DoubtfulParts
    from vcmm.learn.tracking.follow import FollowedCheck
    from vcmm.learn.tracking.next_check import CheckPlan, NextCheck
    from vcmm.learn.tracking.task_limits import TaskLimit

    Planned = tuple[tuple[TaskLimit, ...], tuple[NextCheck, ...], CheckPlan]

MOST_NUMBERS = 12  # numbers that people see; all stand in the document


def _change_in_words(c: FollowedCheck) -> str:
    names = [f"{name} {p:.2f}" for name, p in c.suspects[:3] if p >= 0.01]
    return ", ".join(names) or "–"


def _tenth(value: float) -> str:
    return f"{value:.2f}"


CHECKS: tuple[Column[FollowedCheck], ...] = (
    Column("recording", lambda c: c.name, csv="recording"),
    Column("date", lambda c: c.date, csv="date"),
    Column("rows", lambda c: str(c.rows), NUMBER_TEXT, csv="rows"),
    Column("file unchanged", lambda c: _tenth(c.rms_unchanged), NUMBER_TEXT),
    Column("predicted", lambda c: _tenth(c.rms_predicted), NUMBER_TEXT),
    Column("over its u", lambda c: _tenth(c.spread), NUMBER_TEXT),
    Column("chance", lambda c: f"{c.chance:.2g}", NUMBER_TEXT),
    Column("may spend", lambda c: f"{c.level:.2g}", NUMBER_TEXT),
    Column("", lambda c: "ALARM" if c.alarm else ""),
    Column("changed, probability", _change_in_words),
    Column(None, lambda c: c.rms_unchanged, csv="rms_unchanged"),
    Column(None, lambda c: c.rms_predicted, csv="rms_predicted"),
    Column(None, lambda c: c.spread, csv="innovation_over_u"),
    Column(None, lambda c: c.chance, csv="chance"),
    Column(None, lambda c: c.level, csv="level"),
    Column(None, lambda c: c.change, csv="probability_of_change"),
    Column(None, lambda c: c.noise, csv="noise_scale"),
)
CHECK_CAPTION = (
    "file unchanged, predicted: rms of what the recording differs by from the machine file and from the prediction, over the noise of a reading; over its"
    " u: that of the prediction over its own standard uncertainty, near 1 where that is right"
)


def checks(track: Track) -> ResultTable[FollowedCheck]:
    shown = track.checks
    return ResultTable(
        f"{len(shown)} recordings of {track.followed.tracked.machine.name}", CHECKS, shown, CHECK_CAPTION
    )


def alarms(track: Track) -> ResultTable[FollowedCheck]:
    columns: Sequence[Column[FollowedCheck]] = (
        Column("date", lambda c: c.date),
        Column("recording", lambda c: c.name),
        Column("as predicted until", lambda c: last_good(c, track.checks) or "–"),
        Column("changed, probability", _change_in_words),
        Column("diagnosis", lambda c: c.answer or "–"),
    )
    note = "what was measured or cut between the two dates is doubtful"
    return ResultTable("alarms", columns, track.alarms, note)


def _shift(s: CharacteristicShift) -> str:
    unit, factor = ("µm", 1e3) if s.unit == "mm" else ("µrad", 1e6)
    return f"{s.name} {s.shift * factor:+.3g} ± {s.u * factor:.2g} {unit}"


def doubtful(parts: Sequence[DoubtfulParts]) -> ResultTable[DoubtfulParts]:
    """Return parts that were measured or cut while a change was not yet known."""
    columns: Sequence[Column[DoubtfulParts]] = (
        Column("after", lambda d: d.since or "the date of the machine file"),
        Column("until", lambda d: d.alarm),
        Column("parts", lambda d: ", ".join(f"{p.name} ({p.date})" for p in d.parts) or "none"),
        Column("shift, if the machine had changed", lambda d: ", ".join(_shift(s) for s in d.shifts)),
    )
    note = "indicated values moved by this, ± standard uncertainty, or not at all: on which day the machine changed is not known"
    return ResultTable("doubtful parts", columns, list(parts), note)


NUMBERS: tuple[Column[NumberOverTime], ...] = (
    Column("number", lambda c: c.name, csv="input"),
    Column("", lambda c: c.what),
    Column("first", lambda c: value_text((float(c.value[0]), float(c.u[0])), c.unit), NUMBER_TEXT),
    Column("last", lambda c: value_text((float(c.value[-1]), float(c.u[-1])), c.unit), NUMBER_TEXT),
    Column("in 30 d", lambda c: value_text(c.ahead[1][1:], c.unit), NUMBER_TEXT),
    Column(None, lambda c: float(c.value[-1]), csv="value"),
    Column(None, lambda c: float(c.u[-1]), csv="u"),
    Column(None, lambda c: c.ahead[1][2], csv="u_in_30_d"),
    Column(None, lambda c: c.unit, csv="unit"),
)


def numbers(track: Track, most: int = MOST_NUMBERS) -> ResultTable[NumberOverTime]:
    every = sorted(track.courses, key=lambda c: -c.change_over_u)
    more = f"; {len(every) - most} more stand in numbers.csv" if len(every) > most else ""
    return ResultTable(
        "numbers that are followed, those that moved most first",
        NUMBERS,
        every[:most],
        f"± standard uncertainty{more}",
    )


def _date(track: Track, day: int) -> str:
    return date_of(track.dated.when + day)


def _u_after(check: NextCheck, limits: Sequence[TaskLimit]) -> str:
    return ", ".join(f"{x.name} {_u_of(check, x)}" for x in limits)


def _u_of(check: NextCheck, limit: TaskLimit) -> str:
    return _small(check.u_after[limit.name], limit)


def _small(value: float, limit: TaskLimit) -> str:
    return f"{value * 1e3:.3g} µm" if limit.unit == "mm" else f"{value * 1e6:.3g} µrad"


def _columns(limits: Sequence[TaskLimit], track: Track) -> tuple[Column[NextCheck], ...]:
    return (
        Column("check", lambda n: n.check.name),
        Column("when", lambda n: _date(track, n.day)),
        Column("U after it", lambda n: _u_after(n, limits)),
        Column(
            "holds", lambda n: "a year" if n.holds is None else f"{n.holds} d" if n.holds >= 0 else "not met"
        ),
        Column("cost", lambda n: f"{n.check.cost:g}", NUMBER_TEXT),
        Column("minutes", lambda n: f"{n.check.minutes:g}", NUMBER_TEXT),
    )


def next_checks(planned: Planned, track: Track) -> ResultTable[NextCheck]:
    limits, each, _ = planned
    note = "each by itself, on the last day on which all limits hold; the longest for its cost first; U = 2 u, a known bias apart"
    return ResultTable(
        "which check next",
        _columns(limits, track),
        each,
        "; ".join([note, *map(_beyond, beyond_checks(limits))]),
    )


def beyond_checks(limits: Sequence[TaskLimit]) -> list[TaskLimit]:
    """Return limits that no check of the machine can keep: the other uncertainties exceed them alone."""
    return [x for x in limits if 2.0 * x.rest >= x.limit]


def _beyond(limit: TaskLimit) -> str:
    return (
        f"U of {limit.name} is {_small(2.0 * limit.rest, limit)} without any error of the machine, so no check of it keeps {_small(limit.limit, limit)}: "
        "vcmm uncertainty says what else counts"
    )


def why_not_kept(planned: Planned) -> str:
    """Return why the plan does not keep every limit, for each limit that is to blame; "" where it keeps them."""
    limits, each, advised = planned
    if advised.kept:
        return ""
    beyond = beyond_checks(limits)
    reasons = [_beyond(x) for x in beyond]
    for x in (x for x in limits if x not in beyond):
        best = min(each, key=lambda n: n.u_after[x.name])
        if best.u_after[x.name] > x.limit:
            reasons.append(
                f"the best check by itself ({best.check.name}) leaves U of {x.name} at {_u_of(best, x)}, above {_small(x.limit, x)}"
            )
    return "; ".join(reasons) or "no order of these checks that was searched keeps all limits on every day"


def plan(planned: Planned, track: Track) -> ResultTable[NextCheck]:
    limits, _, schedule = planned
    kept = "keeps every limit" if schedule.kept else f"does NOT keep the limits: {why_not_kept(planned)}"
    fixed = (
        f"; at a fixed interval: {schedule.fixed[0]} every {schedule.fixed[1]} d, cost {schedule.fixed[2]:g}"
        if schedule.fixed
        else ""
    )
    title = f"plan of {schedule.days} days from {_date(track, 0)}, cost {schedule.cost:g}"
    title = (
        title
        if schedule.kept or schedule.checks
        else f"no plan of {schedule.days} days from {_date(track, 0)}"
    )
    return ResultTable(title, _columns(limits, track), schedule.checks, f"{kept}{fixed}")


def plan_document(planned: Planned, track: Track) -> dict[str, object]:
    """Return the keys next_checks and plan of vcmm.track/1; U in mm, of angles in rad."""
    limits, each, schedule = planned
    beyond = beyond_checks(limits)
    return {
        "limits": [
            {"name": x.name, "limit": x.limit, "u_rest": x.rest, "unit": x.unit, "can_be_kept": x not in beyond} for x in limits
        ],
        "next_checks": [_next_document(n, track) for n in each],
        "plan": {
            "days": schedule.days, "cost": schedule.cost, "kept": schedule.kept, "because": why_not_kept(planned) or None, "checks": [_next_document(n, track) for n in schedule.checks],
            "fixed_interval": schedule.fixed and {"check": schedule.fixed[0], "days": schedule.fixed[1], "cost": schedule.fixed[2]},
        },
    }  # fmt: skip


def _next_document(check: NextCheck, track: Track) -> dict[str, object]:
    return {
        "check": check.check.name, "when": _date(track, check.day), "U_after": dict(check.u_after), "holds_days": check.holds,
        "cost": check.check.cost, "minutes": check.check.minutes,
    }  # fmt: skip
