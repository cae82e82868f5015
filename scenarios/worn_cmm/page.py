"""The report of the twin worn_cmm: what was concealed beside what was found, and what that does to a measuring job."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from vcmm import __version__, diagnosis
from vcmm import report as r
from vcmm import tables as tb

from .twin import AIR, CONCEALED, Concealed, Moved, WornTwin, answer_to

WHAT = (
    "A ball plate is touched 400 times in six hours, in five placements, on a bridge CMM with a worn Y drive and a ram that "
    "follows the room. The machine file knows neither. The recording is put to the diagnosis; here its answer stands beside "
    "what was concealed."
)
CAUTION = (
    "One recording is an example and no proof: how often concealed effects are named rightly is counted in the blind exam. "
    "Play and ram are simulated by code that shares no line with the effects of the catalogue."
)


def tables(result: WornTwin) -> list[tb.ResultTable[Any]]:
    """The same in terminal, report and documentation."""
    return [_concealed(result), _folds(result), _job(result)]


@dataclass(frozen=True)
class ConcealedParameter:
    """A parameter that was concealed, and what the diagnosis says of it; None where it was not found."""

    fault: Concealed
    name: str
    true: float
    unit: str
    said: diagnosis.Estimate | None
    probability: float | None


def _interval(p: ConcealedParameter) -> str:
    return "–" if p.said is None else f"{p.said.interval95[0]:.2f} … {p.said.interval95[1]:.2f}"


CONCEALED_COLUMNS: tuple[tb.Column[ConcealedParameter], ...] = (
    tb.Column("concealed", lambda p: p.fault.effect),
    tb.Column("where", lambda p: " ".join(p.fault.where.values())),
    tb.Column("parameter", lambda p: f"{p.name} / {p.unit}"),
    tb.Column("true", lambda p: p.true, tb.fixed(2)),
    tb.Column("found", lambda p: "not found" if p.said is None else f"{p.said.value:.2f}", tb.NUMBER_TEXT),
    tb.Column("95 % coverage interval", _interval, tb.NUMBER_TEXT),
    tb.Column("probability", lambda p: p.probability, tb.fixed(3)),
)


def _concealed(result: WornTwin) -> tb.ResultTable[ConcealedParameter]:
    rows = []
    for hidden in CONCEALED:
        answer = answer_to(result.diagnosis, hidden)
        for name, (true, unit) in hidden.parameters.items():
            said = answer.parameters.get(name) if answer else None
            rows.append(
                ConcealedParameter(hidden, name, true, unit, said, answer.probability if answer else None)
            )
    more = [
        a.effect
        for a in result.diagnosis.answer
        if all(answer_to(result.diagnosis, h) is not a for h in CONCEALED)
    ]
    caption = f"Verdict: {result.diagnosis.verdict}. " + (
        f"Also named: {', '.join(more)}." if more else "Nothing else is named."
    )
    return tb.ResultTable("What was concealed, and what was found", CONCEALED_COLUMNS, rows, caption)


def _folds(result: WornTwin) -> tb.ResultTable[diagnosis.FoldRow]:
    caption = (
        "Each line fits the named effects on the other rows and predicts these; the first line is fitted."
    )
    columns = [replace(diagnosis.FOLDS[0], head="rows left out of the fit"), *diagnosis.FOLDS[1:]]
    rows = diagnosis.folds(result.diagnosis).rows
    return tb.ResultTable("Cross-validation", columns, rows, caption)


DEPARTS = tb.fixed(2, scale=1e3, signed=True)  # um
JOB: tuple[tb.Column[Moved], ...] = (
    tb.Column("characteristic", lambda m: m.name),
    tb.Column("file - true", lambda m: m.before[0] - m.true, DEPARTS),
    tb.Column("diagnosed - true", lambda m: m.after[0] - m.true, DEPARTS),
    tb.Column("U, file", lambda m: m.before[1], tb.fixed(2, scale=1e3)),
    tb.Column("U, diagnosed", lambda m: m.after[1], tb.fixed(2, scale=1e3)),
)


def _job(result: WornTwin) -> tb.ResultTable[Moved]:
    caption = (
        f"What the scenario plate would indicate in a room at {AIR:g} °C, predicted from the machine file and from the improved one, "
        "less what the machine with its concealed faults does indicate, µm. An improved file knows the new parameters only "
        "as well as the recording showed them. U contains this for sizes (gap, k), not for a time constant or another scanned "
        "parameter, nor their correlation."
    )
    return tb.ResultTable(
        "A measuring job predicted with the improved machine file", JOB, result.job, caption
    )


def answers(result: WornTwin) -> list[r.AnswerLine]:
    """What was concealed, and whether it was found."""
    return [
        r.AnswerLine(
            f"{p.fault.effect} {' '.join(p.fault.where.values())}, {p.name}",
            "not found" if p.said is None else f"{p.said.value:.2f} {p.unit}",
            coverage=f"95 %: {_interval(p)}",
            limits=f"{p.true:.2f} {p.unit}",
            verdict="" if p.probability is None else f"probability {p.probability:.3f}",
            kind="bad" if p.said is None else "good",
            link="What was concealed, and what was found",
            labels=("true", "", ""),
        )
        for p in _concealed(result).rows
    ]


def twin_page(result: WornTwin) -> str:
    """One self-contained HTML file."""
    blocks = [r.paragraph(WHAT), r.note(CAUTION, "warning"), r.heading("What the diagnosis says")]
    blocks += [r.paragraph(s) for s in diagnosis.sentences(result.diagnosis)]
    for table in tables(result):
        blocks += tb.titled_html(table)
    footer = f"vcmm {__version__}. Measuring error = indicated - true."
    return r.page(
        "Two faults concealed in the log of a CMM",
        blocks,
        subtitle=result.machine.name,
        footer=footer,
        answers=answers(result),
    )
