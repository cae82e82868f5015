"""Several recordings diagnosed together as tables: the size of every name in each, and the result of each alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vcmm.core.units import significant_text
from vcmm.show.tables.diagnosis import values_text
from vcmm.show.tables.table import NUMBER_TEXT, Column, ResultTable

if TYPE_CHECKING:
    from vcmm.learn.diagnosis.result import Answer, Diagnosis
    from vcmm.learn.diagnosis.several import Several, SharedAnswer, Size

NOT_SEEN_TEXT = "not seen"


def _name(a: Answer) -> str:
    return " ".join((a.effect.replace("_", " "), *(str(v) for v in a.where.values())))


def _size(s: Size) -> str:
    """Return 0.98 ± 0.03, times the size that the name has in all."""
    return (
        NOT_SEEN_TEXT
        if s.times is None or s.u is None
        else f"{s.times:.2f} ± {significant_text(float(f'{s.u:.1g}'))}"
    )


SIZES: tuple[Column[SharedAnswer], ...] = (
    Column("name", lambda s: _name(s.answer)),
    Column("is", lambda s: "common" if s.common else "each one's own"),
    Column("size 1.00", lambda s: values_text(s.answer)),
    Column("in each", lambda s: "; ".join(f"{z.recording}: {_size(z)}" for z in s.sizes)),
    Column("p", lambda s: f"{s.p:.2g}", NUMBER_TEXT),
)


def sizes(several: Several) -> ResultTable[SharedAnswer]:
    note = "sizes as multiples, every recording fitted by itself with all names; p: chance of such differences if they were one"
    return ResultTable("what is common and what is each one's own", SIZES, several.shared, note)


@dataclass(frozen=True)
class AloneRow:
    """One recording by itself."""

    recording: str
    verdict: str
    names: str


ALONE: tuple[Column[AloneRow], ...] = (
    Column("recording", lambda r: r.recording),
    Column("by itself", lambda r: r.verdict),
    Column("names", lambda r: r.names),
)


def by_itself(several: Several) -> ResultTable[AloneRow]:
    rows = [AloneRow(name, d.verdict, _names(d)) for name, d in several.alone]
    return ResultTable("each recording by itself", ALONE, rows)


def _names(d: Diagnosis) -> str:
    names = [f"{_name(a)} {a.probability:.2f}" for a in d.found]
    return ", ".join([*names, *(["something without a name"] if d.unknown else [])]) or "–"
