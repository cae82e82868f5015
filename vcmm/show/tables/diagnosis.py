"""A diagnosis as tables: findings, improvement of the prediction, next measurement, detectable effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vcmm.core.units import significant_text
from vcmm.learn.diagnosis.constants import LEAST_PRINTED
from vcmm.learn.diagnosis.verdict import describe_probability
from vcmm.show.tables.quantities import percent
from vcmm.show.tables.table import NUMBER_TEXT, WORDS, Column, ResultTable

if TYPE_CHECKING:
    from vcmm.learn.diagnosis.estimates import Estimate
    from vcmm.learn.diagnosis.evidence import Detectable
    from vcmm.learn.diagnosis.families import Member
    from vcmm.learn.diagnosis.locate import Place
    from vcmm.learn.diagnosis.result import Answer, Diagnosis, NextStep, Transfer

FOUND_PHYSICS = "effects missing from the machine model"
CANDIDATES = "candidates, less probable than not; they are not written into the machine file"
SCALE = (
    "first row: all rows as they are, the nuisance refitted, with the machine file as it was and as it is written (vcmm compare "
    "gives the same); folds: rms of what nuisance and the uncertainty of the calibration cannot take up, weighted by the "
    "noise; own variance: of what the effect by itself does to the rows; effects overlap or cancel, so these do not add to 100 %"
)
PARAMETER_WORDS = {"1/Kv": "departure of 1/Kv"}  # parameters whose name would mislead


def values_text(a: Answer) -> str:
    """Return every parameter with its 95 % coverage interval, to the digits that its standard uncertainty supports."""
    out = [f"{PARAMETER_WORDS.get(n, n)} = {with_interval(e)}" for n, e in a.parameters.items()]
    lobes = getattr(a.fitted, "lobes", 0)
    nothing = (a.mistake and a.remark) or "no free parameter"  # of a mistake of the log: what is wrong
    return ", ".join([*([f"{lobes} lobes"] if lobes else []), *out]) or nothing


def with_interval(e: Estimate) -> str:
    """Return 1.50 µm (95 %: 1.12 to 1.87): two digits of the standard uncertainty (JCGM 100:2008, 7.2.6)."""
    low, high = e.interval95
    if not (np.isfinite([e.value, e.u, low, high]).all() and e.u > 0):
        return f"{significant_text(e.value)} {e.unit if e.unit != '1' else ''}".strip()
    digits = max(0, 1 - int(np.floor(np.log10(e.u))))
    value, low_text, high_text = (f"{round(x, digits) + 0.0:.{digits}f}" for x in (e.value, low, high))
    unit = "" if e.unit == "1" else f" {e.unit}".replace(" um", " µm").replace(" urad", " µrad")
    return f"{value}{unit} (95 %: {low_text} to {high_text})"


def micro_text(d: Diagnosis, value: float) -> str:
    if not np.isfinite(value):
        return "–"
    return f"{value * 1e6:.3g} µrad" if d.angle else f"{value * 1e3:.3g} µm"


def open_members(a: Answer) -> tuple[Member, ...]:
    """Return the shapes of its family that are open, the most probable first; none where the name is as probable as its family."""
    if a.kin is None or len(a.kin.members) < 2 or a.family_probability <= a.probability:
        return ()
    return tuple(sorted(a.kin.members, key=lambda m: -m.probability))


def probability_text(a: Answer) -> str:
    return f"{a.probability:.3f}" if a.probability >= LEAST_PRINTED else describe_probability(a.probability)


def _join_words(words: Sequence[str]) -> str:
    return ", ".join(words) or "–"


def rivals_text(a: Answer) -> str:
    """Return its rivals, and the family where it is certain and its shape is open: 'lost_motion (play 1.000)'."""
    open_shape = a.kin is not None and len(a.kin.members) > 1
    return _join_words(a.cannot_be_told_from) + (
        f" ({a.family} {a.family_probability:.3f})" if open_shape else ""
    )


ANSWERS: tuple[Column[Answer], ...] = (
    Column("missing", lambda a: a.effect, page_head="effect"),
    Column("where", lambda a: _join_words([str(v) for v in a.where.values()])),
    Column("parameters", values_text),
    Column("probability", probability_text, NUMBER_TEXT),
    Column("own variance / excess", lambda a: a.share, percent(0)),
    Column("of the rows", lambda a: a.share_of_rows, percent(0)),
    Column("cannot be told from", rivals_text),
)


def answers(d: Diagnosis) -> list[ResultTable[Answer]]:
    """Return the findings, and the candidates; parts without an answer are omitted."""
    parts = [(FOUND_PHYSICS, d.found), (CANDIDATES, d.candidates)]
    return [ResultTable(title, ANSWERS, rows) for title, rows in parts if rows]


@dataclass(frozen=True)
class FoldRow:
    """Rows that were left out of the fit, or all of them: rms before and after in words, shares as numbers."""

    name: str
    before: str
    after: str
    energy_left: str
    gain: str


FOLDS: tuple[Column[FoldRow], ...] = (
    Column("fold", lambda f: f.name),
    Column("rms before", lambda f: f.before, NUMBER_TEXT),
    Column("rms after", lambda f: f.after, NUMBER_TEXT),
    Column("effect energy left", lambda f: f.energy_left, NUMBER_TEXT),
    Column("log score gain", lambda f: f.gain, NUMBER_TEXT),
)


def folds(d: Diagnosis) -> ResultTable[FoldRow]:
    """Return all rows, fitted; then each part of them as the others predict it."""
    fit = d.fit
    noise = f"noise {micro_text(d, fit.noise)}"
    rows = [FoldRow("all rows, fitted", micro_text(d, fit.before), micro_text(d, fit.after), noise, "–")]
    if fit.candidates < fit.after:
        rows.append(
            FoldRow(
                "with candidates too", micro_text(d, fit.before), micro_text(d, fit.candidates), noise, "–"
            )
        )
    for h in fit.held_out:
        left = f"{h.effect_energy_left:.3f}" if np.isfinite(h.effect_energy_left) else "–"
        before, after = micro_text(d, h.rms_before), micro_text(d, h.rms_after)
        rows.append(FoldRow(h.fold, before, after, left, f"{h.gain:+.1f} nats"))
    return ResultTable(
        "cross-validation: prediction of rows that were left out of the fit", FOLDS, rows, SCALE
    )


NEXT: tuple[Column[NextStep], ...] = (
    Column("separates", lambda n: ", ".join(n.separates)),
    Column("do", lambda n: n.do),
    Column(
        "then right with",
        lambda n: "–" if n.expected_probability is None else f"p {n.expected_probability:.2f}",
        NUMBER_TEXT,
    ),
    Column("minutes", lambda n: f"{n.minutes:.0f}" if n.minutes >= 10 else f"{n.minutes:.2g}", NUMBER_TEXT),
)


def next_steps(d: Diagnosis) -> ResultTable[NextStep]:
    return ResultTable("measure next", NEXT, d.next_measurement)


def transfers(d: Diagnosis) -> ResultTable[Transfer]:
    """Return the residuals of the other recordings under the file from one recording."""
    columns: list[Column[Transfer]] = [
        Column("recording", lambda t: t.recording),
        Column("rms before", lambda t: micro_text(d, t.before), NUMBER_TEXT),
        Column("rms after", lambda t: micro_text(d, t.after), NUMBER_TEXT),
        Column("with the file written from", lambda t: t.source),
    ]
    return ResultTable("the file from one recording predicts another", columns, d.transfer)


PLACES: tuple[Column[Place], ...] = (
    Column("covariate", lambda p: p.covariate),
    Column("direction", lambda p: p.direction),
    Column("false-alarm p", lambda p: f"{p.p:.2g}", NUMBER_TEXT),
    Column("", lambda p: p.text),
)


def places(d: Diagnosis) -> ResultTable[Place]:
    return ResultTable("where the residual departs", PLACES, d.location)


def detectable_table(d: Diagnosis) -> ResultTable[Detectable]:
    """Return the smallest rms per effect that this recording would have shown, at the place where it shows best."""
    columns: list[Column[Detectable]] = [
        Column("effect", lambda x: x.effect),
        Column("where", lambda x: _join_words(list(x.where.values())), WORDS),
        Column("rms", lambda x: micro_text(d, x.amplitude), NUMBER_TEXT),
    ]
    return ResultTable("smallest amplitude seen per effect", columns, d.detectable)
