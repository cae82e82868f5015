"""The answers of frequent jobs: recordings of a folder, a machine over time, acceptance tests, audits, thermal models, plans."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vcmm.learn.tracking.dates import date_of
from vcmm.show.report.answers import FINE_UNITS, AnswerLine, K, Kind, percent, signed_value
from vcmm.show.report.text import micro, unit_word
from vcmm.show.tables.audit import verdict as audit_verdict
from vcmm.show.tables.calibration import LEAST_U_UM

if TYPE_CHECKING:
    from vcmm.answer.inference.audit import AuditResult
    from vcmm.files.learned.fleet import Change
    from vcmm.files.learned.track_result import NumberOverTime, Track
    from vcmm.learn.calibration.acceptance import Figure
    from vcmm.learn.calibration.design import Proposal
    from vcmm.learn.calibration.thermal import ThermalModel
    from vcmm.show.tables.track import Planned

MOST_LINES = 5  # lines of figures without a limit, numbers that moved
NO_U = "u of the readings not in it"
NOTHING_MISSING = "nothing missing"  # verdict of a diagnosis


def folder_answers(records: Sequence[Mapping[str, Any]], changes: Sequence[Change]) -> list[AnswerLine]:
    """Return, for a folder of recordings, the changes per machine with their dates; then recordings that could not be diagnosed."""

    good = [r for r in records if not r["problem"]]
    lines = [_machine_line(m, good, changes) for m in dict.fromkeys(r["machine"] for r in good)]
    bad = [r for r in records if r["problem"]]
    if bad:
        lines.append(
            AnswerLine(
                "Not diagnosed",
                f"{len(bad)} of {len(records)} recordings",
                verdict="cannot be read or diagnosed",
                kind="warning",
                because=f"{bad[0]['file']}: {bad[0]['problem']}",
                link="What each holds",
                numbers={"not_diagnosed": len(bad)},
                labels=("", "first:", ""),
            )
        )
    return lines


def _machine_line(
    machine: str, records: Sequence[Mapping[str, Any]], changes: Sequence[Change]
) -> AnswerLine:
    from vcmm.show.tables.fleet import trend_text  # with all that diagnoses a folder

    of_machine = [r for r in records if r["machine"] == machine]
    lacking = sum(r["verdict"] != NOTHING_MISSING for r in of_machine)
    moved = sorted(
        (c for c in changes if c.machine == machine and not c.steady), key=lambda c: -abs(c.deviations or 0.0)
    )
    verdict, kind = ("changed", "warning") if moved else ("one recording", "muted")
    if len(of_machine) > 1 and not moved:
        verdict, kind = "no change shown", "good"
    first = moved[0] if moved else None
    return AnswerLine(
        machine or "machine without a name",
        f"{lacking} of {len(of_machine)} recordings",
        coverage="hold what the machine file lacks",
        verdict=verdict,
        kind=kind,  # type: ignore[arg-type]
        because=f"{first.name} {first.parameter}: {micro(trend_text(first))}" if first else "",
        change=f"vcmm diagnose {first.last[0]}" if first else "",
        link="What changed" if moved else "What each holds",
        numbers={
            "machine": machine,
            "recordings": len(of_machine),
            "lacking": lacking,
            "changed": len(moved),
        },
        labels=("", "most:", "to confirm:"),
    )


def track_answers(track: Track, planned: Planned | None = None) -> list[AnswerLine]:
    """Return whether the last recording agrees with its prediction; the numbers that moved most, as of the day; which check next."""
    last = track.checks[-1]
    suspect = next(iter(last.suspects), None) if last.alarm else None
    earlier = [c for c in track.checks[:-1] if c.alarm]
    past = (
        f"; alarm before: {', '.join(f'{c.name} ({c.date})' for c in earlier[:MOST_LINES])}"
        if earlier
        else ""
    )
    past += f" and {len(earlier) - MOST_LINES} more" if len(earlier) > MOST_LINES else ""
    state = AnswerLine(
        track.followed.tracked.machine.name,
        f"{len(track.checks)} recordings",
        coverage=f"{track.checks[0].date} … {last.date}",
        verdict=("the last: alarm, not as predicted" if last.alarm else "the last is as predicted") + past,
        kind="bad" if last.alarm else "warning" if earlier else "good",
        because=f"{suspect[0]}, {percent(suspect[1])}" if suspect else "",
        change=(last.answer or "vcmm diagnose on this recording") if last.alarm else "",
        link="Recordings",
        numbers={
            "recordings": len(track.checks),
            "alarm": last.alarm,
            "alarms_before": [c.name for c in earlier],
            "innovation_over_u": last.spread,
        },
        labels=("", "changed:", "diagnosis:"),
    )
    ranked = sorted(track.courses, key=lambda c: -c.change_over_u)[:MOST_LINES]
    day = track.at if track.dated.when > last.when else ""
    return [
        state,
        *(_number_line(c, day) for c in ranked),
        *([] if planned is None else [_next_line(track, planned)]),
    ]


def _number_line(c: NumberOverTime, day: str) -> AnswerLine:
    """Return a number on the day for which the machine is written. day: that day where it is later than the last recording."""
    unit = "" if c.unit == "1" else unit_word(c.unit)
    value, u = c.of_day
    return AnswerLine(
        f"{c.name} {c.what}".strip(),
        signed_value(value, K * u, unit),
        coverage=f"k = {K:.0f}, forecast of {day}" if day else f"k = {K:.0f}",
        because=f"by {signed_value(value - float(c.value[0]), 0.0, unit, '+')} since the first recording",
        link="Numbers over time",
        numbers={"name": c.name, "value": value, "U": K * u, "unit": c.unit},
        labels=("", "moved", ""),
    )


def _next_line(track: Track, planned: Planned) -> AnswerLine:
    """The first check of the plan; where no plan keeps the limits, why, and no check is advised."""
    from vcmm.show.tables.track import beyond_checks, why_not_kept

    limits, each, plan = planned
    first, why = plan.checks[0] if plan.checks else each[0], why_not_kept(planned)
    cost = f"plan of {plan.days} days, cost {plan.cost:g}"
    return AnswerLine(
        "Next check",
        f"{first.check.name}, {date_of(track.dated.when + first.day)}" if plan.kept else "none of the list",
        verdict="every limit is kept" if plan.kept else "limits are not kept",
        kind="good" if plan.kept else "bad",
        limits=cost if plan.kept else f"plan of {plan.days} days",
        because=why,
        link="What to check next",
        numbers={
            "check": first.check.name,
            "kept": plan.kept,
            "cost": plan.cost,
            "because": why or None,
            "never_kept": [x.name for x in beyond_checks(limits)],
        },
        labels=("", "", ""),
    )


def acceptance_answers(figures: Sequence[Figure], recorded: bool = False) -> list[AnswerLine]:
    """Return figures that have a limit, worst first; without limits the first of those over both directions, as in the standard.

    recorded: from readings, whose u is that of the instrument alone; where it brings none there is no U to state.
    """
    limited = sorted((f for f in figures if f.p_pass is not None), key=lambda f: f.p_pass or 0.0)
    evaluated = [f for f in figures if f.value_um is not None]
    whole = [f for f in evaluated if not set("+-") & set(f.name)]  # of both directions, before those of one
    rest = (whole or evaluated)[:MOST_LINES]
    return [_figure_line(f, recorded) for f in limited or rest]


def _figure_line(f: Figure, recorded: bool) -> AnswerLine:
    u = f.u_um if f.u_um is not None and f.u_um >= LEAST_U_UM else 0.0
    value = "not known from this file" if f.value_um is None else signed_value(f.value_um, K * u, "µm")
    kind: Kind = "muted" if f.p_pass is None else "good" if f.p_pass >= 0.95 else "bad" if f.p_pass < 0.5 else "warning"  # fmt: skip
    at = "" if f.at_mm is None else f" at {f.at_mm:g} mm"
    ratio = (
        "" if f.ratio is None else f", E/MPE = {signed_value(f.ratio, K * (f.u_ratio or 0.0), '').strip()}"
    )
    return AnswerLine(
        f.name,
        value + ratio,
        coverage=f"k = {K:.0f}" if u else NO_U if recorded and f.value_um is not None else "",
        limits="" if f.limit_um is None else f"at most {f.limit_um:.3g} µm{at}",
        verdict="" if f.p_pass is None else f"{'passes' if f.p_pass >= 0.5 else 'fails'}, probability to pass {percent(f.p_pass)}",
        kind=kind,
        link="Figures",
        numbers={"name": f.name, "value_um": f.value_um, "u_um": f.u_um, "limit_um": f.limit_um, "p_pass": f.p_pass},
    )  # fmt: skip


def audit_answers(rows: Sequence[AuditResult]) -> list[AnswerLine]:
    """Return, per characteristic, the count that lies furthest below its band."""
    return [
        _audit_line(min((r for r in rows if r.name == name), key=lambda r: r.attained - r.least))
        for name in dict.fromkeys(r.name for r in rows)
    ]


def _audit_line(a: AuditResult) -> AnswerLine:
    low, high = a.interval95
    verdict = audit_verdict(a)
    kinds: Mapping[str, Kind] = {"outside": "bad", "not claimed": "muted"}
    word, scale = FINE_UNITS[a.unit]
    return AnswerLine(
        a.name,
        f"true value held in {percent(a.attained)} of {a.parts} parts",
        coverage=f"{100 * low:.1f} to {100 * high:.1f}\u00a0% by counting",
        limits=f"{a.least:.2f} … {a.most:.2f}",
        verdict=verdict,
        kind=kinds.get(verdict, "good"),
        because=f"{a.kind}; mean length {a.width * scale:.2f} {word}",
        link="coverage, counted",
        numbers={"name": a.name, "attained": a.attained, "parts": a.parts, "kind": a.kind},
        labels=("band", "parts drawn from", ""),
    )


def thermal_answers(model: ThermalModel, terms: int) -> list[AnswerLine]:
    """Return whether temperatures explain the readings, by held-out rows."""
    before, after = (1e3 * rms for rms in model.held_out)
    helps = after < before
    return [
        AnswerLine(
            "What temperatures do",
            f"{before:.2f} to {after:.2f} µm rms",
            coverage="blocks of time predicted from the others",
            limits=f"all readings {model.before * 1e3:.2f} to {model.after * 1e3:.2f} µm",
            verdict=f"{terms} numbers found" if helps else "prediction is not better",
            kind="good" if helps else "warning",
            numbers={"held_out_before_um": before, "held_out_after_um": after},
            labels=("", "", ""),
        )
    ]


def design_answers(
    everything: Proposal, best: Proposal | None, cheapest: Proposal | None
) -> list[AnswerLine]:
    """Return which set-ups to make: the cheapest that identify everything, else the errors that all of them leave open; and the best
    within a budget."""
    left = [c.text for c in everything.identified.combinations]
    proposal = cheapest or everything
    lines = [
        AnswerLine(
            "Set-ups to make",
            f"{len(proposal.names)} of {len(everything.names)}, {proposal.minutes:.0f} min",
            coverage="nothing stays open" if cheapest else f"{len(left)} open, even by all",
            verdict="complete" if cheapest else "not complete",
            kind="good" if cheapest else "bad",
            because=", ".join(proposal.names),
            change="" if cheapest else left[0] if left else "",
            labels=("limits", "these:", "not identified:"),
            numbers={"setups": len(proposal.names), "minutes": proposal.minutes, "open": len(left)},
        )
    ]
    if best is not None:
        rest = len(best.identified.combinations)
        lines.append(
            AnswerLine(
                "Best within the budget",
                f"{len(best.names)} of {len(everything.names)}, {best.minutes:.0f} min",
                coverage=f"{rest} open" if rest else "nothing stays open",
                because=", ".join(best.names),
                labels=("limits", "these:", "to improve:"),
                numbers={"setups": len(best.names), "minutes": best.minutes, "open": rest},
            )
        )
    return lines
