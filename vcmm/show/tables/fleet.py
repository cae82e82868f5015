"""A folder of recordings as tables: findings of each, every number that was found, and changes of a machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vcmm.files.learned.fleet import Change, name_of
from vcmm.learn.diagnosis.trend import ALWAYS, DRIFT, IRREGULAR, STEADY, STEP
from vcmm.show.tables.quantities import value_text
from vcmm.show.tables.table import NUMBER_TEXT, Column, ResultTable

Record = Mapping[str, Any]
CHANGE_COLUMNS = (
    "first and last recording of every machine, their difference over its standard uncertainty (independent; beyond 3 it is no chance, 1 of"
    " 370), and how the number went through all of them: a drift is that of the whole time, a step lies between the two named"
)
WORDS = {DRIFT: "drifts", STEP: "steps", STEADY: "steady", IRREGULAR: "up and down", "": ""}


def _found_answers(record: Record) -> list[Any]:
    return (
        [] if record["problem"] else [a for a in record["answer"] if not a["doubtful"] and not a["alias_of"]]
    )


def _names(record: Record) -> str:
    if record["problem"]:
        return str(record["problem"])
    unknown = record["unknown"]
    names = [f"{name_of(a)} ({_values(a)})" for a in _found_answers(record)]
    names += [f"something without a name over {', '.join(unknown['covariates'])}"] if unknown else []
    return "; ".join(names) or "–"


def _values(answer: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{k} {value_text((e['value'], e['u']), e['unit'])}" for k, e in answer["parameters"].items()
    )


def _rms(record: Record, which: str) -> float | None:
    """Return the rms in um, or urad of angles."""
    return None if record["problem"] else record["fit"][f"rms_{which}_um"]


def _unit(record: Record) -> str:
    return "" if record["problem"] else record["fit"].get("unit", "um")


RECORDINGS: tuple[Column[Record], ...] = (
    Column("recording", lambda r: r["file"]),
    Column("machine", lambda r: r["machine"] or "–"),
    Column("date", lambda r: r["date"] or "–"),
    Column("verdict", lambda r: "not diagnosed" if r["problem"] else r["verdict"]),
    Column("found", _names),
    Column("rms before", lambda r: _rms_text(r, "before"), NUMBER_TEXT),
    Column("as written", lambda r: _rms_text(r, "after"), NUMBER_TEXT),
)


def _rms_text(record: Record, which: str) -> str:
    value = _rms(record, which)
    return "–" if value is None else f"{value:.3g} {_unit(record)}"


def recordings(folder: str, records: Sequence[Record]) -> ResultTable[Record]:
    return ResultTable(f"{folder}: {len(records)} recordings", RECORDINGS, records)


@dataclass(frozen=True)
class NumberRow:
    """A number of a name in a recording; without a name one line states the verdict, or the problem."""

    record: Record
    answer: Mapping[str, Any] | None = None
    parameter: str = ""

    def of(self, key: str) -> Any:
        return None if self.answer is None else self.answer["parameters"][self.parameter][key]


NUMBERS: tuple[Column[NumberRow], ...] = (
    Column(None, lambda n: n.record["file"], csv="recording"),
    Column(None, lambda n: n.record["machine"], csv="machine"),
    Column(None, lambda n: n.record["date"], csv="date"),
    Column(None, lambda n: n.record.get("verdict"), csv="verdict"),
    Column(None, lambda n: n.answer and n.answer["effect"], csv="effect"),
    Column(None, lambda n: n.answer and " ".join(map(str, n.answer["where"].values())), csv="where"),
    Column(None, lambda n: n.answer and n.answer["probability"], csv="probability"),
    Column(None, lambda n: n.parameter or None, csv="parameter"),
    Column(None, lambda n: n.of("value"), csv="value"),
    Column(None, lambda n: n.of("u"), csv="u"),
    Column(None, lambda n: n.of("unit"), csv="unit"),
    Column(
        None, lambda n: " ".join((n.record.get("unknown") or {}).get("covariates", ())), csv="unknown_over"
    ),
    Column(None, lambda n: _rms(n.record, "before"), csv="rms_before"),
    Column(None, lambda n: _rms(n.record, "after"), csv="rms_as_written"),
    Column(None, lambda n: _unit(n.record), csv="rms_unit"),
    Column(None, lambda n: n.record["problem"], csv="problem"),
)


def numbers(records: Sequence[Record]) -> ResultTable[NumberRow]:
    """Return one line for every number that was found, for a spreadsheet; one for a recording without any."""
    rows: list[NumberRow] = []
    for record in records:
        number_rows = [NumberRow(record, a, p) for a in _found_answers(record) for p in a["parameters"]]
        rows += number_rows or [NumberRow(record)]
    return ResultTable("", NUMBERS, rows)


CHANGES: tuple[Column[Change], ...] = (
    Column("machine", lambda c: c.machine, key="machine", csv="machine"),
    Column("name", lambda c: c.name, key="name", csv="name"),
    Column("", lambda c: c.parameter, key="parameter", csv="parameter"),
    Column("found in", lambda c: f"{c.occurrences} of {c.recordings_total}", key="found_in", csv="found_in"),
    Column("first", lambda c: value_text(c.before, c.unit)),
    Column("in", lambda c: c.first[1] or c.first[0]),
    Column(None, lambda c: _when(c.first), key="first", csv="first"),
    Column("last", lambda c: value_text(c.after, c.unit)),
    Column("in", lambda c: c.last[1] or c.last[0]),
    Column(None, lambda c: _when(c.last), key="last", csv="last"),
    Column("difference", lambda c: "–" if c.change is None else f"{c.change:+.3g} {c.unit}", NUMBER_TEXT),
    Column("over its u", lambda c: "–" if c.deviations is None else f"{c.deviations:+.1f}", NUMBER_TEXT),
    Column("trend", lambda c: trend_text(c)),
    Column(None, lambda c: c.before and c.before[0], key="first_value", csv="first_value"),
    Column(None, lambda c: c.before and c.before[1], key="first_u", csv="first_u"),
    Column(None, lambda c: c.after and c.after[0], key="last_value", csv="last_value"),
    Column(None, lambda c: c.after and c.after[1], key="last_u", csv="last_u"),
    Column(None, lambda c: c.unit, key="unit", csv="unit"),
    Column(None, lambda c: c.change, key="change", csv="change"),
    Column(None, lambda c: c.deviations, key="deviations", csv="deviations"),
    Column(None, lambda c: c.trend.kind or None, key="trend", csv="trend"),
    Column(None, lambda c: c.trend.amount, key="trend_amount", csv="trend_amount"),
    Column(None, lambda c: c.trend.u, key="trend_u", csv="trend_u"),
    Column(None, lambda c: c.at(c.trend.first), key="trend_from", csv="trend_from"),
    Column(None, lambda c: c.at(c.trend.last), key="trend_to", csv="trend_to"),
    Column(None, lambda c: c.presence[0], key="presence", csv="presence"),
    Column(None, lambda c: c.at(c.presence[1]), key="presence_from", csv="presence_from"),
    Column(None, lambda c: c.at(c.presence[2]), key="presence_to", csv="presence_to"),
)


def trend_text(c: Change) -> str:
    """Return a trend as 'drifts by +1.62 ± 0.05 um', 'appears between 2026-07-15 and 2026-08-15; steady'."""
    phrases = [c.presence[0] + _between(c, *c.presence[1:])] if c.presence[0] != ALWAYS else []
    went = WORDS[c.trend.kind]
    if c.trend.amount is not None and c.trend.u is not None:
        size = value_text((c.trend.amount, c.trend.u), c.unit)
        went += f" by {'' if size.startswith('-') else '+'}{size}"
        went += _between(c, c.trend.first, c.trend.last) if c.trend.kind == STEP else ""
    return "; ".join(part for part in (*phrases, went) if part)


def _between(c: Change, first: int | None, last: int | None) -> str:
    return "" if first is None else f" between {c.at(first)} and {c.at(last)}"


def _when(end: tuple[str, str]) -> str:
    return f"{end[1]} ({end[0]})" if end[1] else end[0]


def changes_table(changed: Sequence[Change]) -> ResultTable[Change]:
    return ResultTable("what changed", CHANGES, changed, CHANGE_COLUMNS)
