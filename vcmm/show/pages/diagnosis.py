"""The report of a diagnosis: missing effects, their certainty, rivals, and the next measurement; and that of a folder of recordings."""

from __future__ import annotations

from collections.abc import Sequence
from inspect import cleandoc
from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__
from vcmm.learn.diagnosis.acceptance import answers_to_write
from vcmm.learn.diagnosis.comparison import left_by
from vcmm.learn.diagnosis.constants import LEAST_TOLD
from vcmm.learn.diagnosis.log_mistakes import LOG
from vcmm.learn.diagnosis.plain_words import plain_words
from vcmm.learn.diagnosis.row_order import as_in_the_file
from vcmm.learn.diagnosis.very_long import few_enough
from vcmm.learn.diagnosis.written_fit import handed_over
from vcmm.physics import BY_NAME
from vcmm.show import charts as draw
from vcmm.show import report as r
from vcmm.show.pages.diagnosis_pictures import (
    AFTER,
    BEFORE,
    arrows,
    bar_traces,
    location_bars,
    unknown_picture,
    zone_maps,
)
from vcmm.show.pages.header import OF_MACHINES, facts
from vcmm.show.tables import fleet as tables
from vcmm.show.tables.answers_machine import diagnosis_answers
from vcmm.show.tables.answers_runs import folder_answers
from vcmm.show.tables.diagnosis import (
    answers,
    detectable_table,
    folds,
    micro_text,
    next_steps,
    open_members,
    places,
    probability_text,
    values_text,
)
from vcmm.show.tables.several import by_itself, sizes
from vcmm.show.tables.table import ResultTable, html

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.core.run import Array
    from vcmm.files.learned.fleet import Change
    from vcmm.learn.diagnosis.result import Answer, Diagnosis
    from vcmm.learn.diagnosis.several import Several
    from vcmm.task.response.recording import Recording

VERDICT = {
    "nothing missing": "Nothing is missing: the residual is what the stated noise and calibration predict.",
    "explained": "Effects missing from the machine model explain the departure.",
    "partly explained": "Part of the departure is explained; something is left that the catalogue does not hold.",
    "named, not modelled": "What is missing has a name, but no machine file that these rows support holds it: nothing of it is written.",
    "unexplained": "Something is missing that is not in the catalogue: where and what shape is shown, a name is not claimed.",
}
CLEARLY_LESS = 0.95  # times the rms of what is written, from which candidates are worth a word
AXES = ("x", "y", "z")
LEAST_ALONG = 20  # readings along a direction that are drawn by themselves
MOST_DRAWN = 10_000  # observations in pictures: some MB of a page
NOTHING_FOUND = "Something does not fit, and neither a name nor a place for it is found."


def sentences(d: Diagnosis) -> list[str]:
    """Return the verdict in plain words."""
    out = [
        NOTHING_FOUND if d.verdict == "unexplained" and d.unknown is None else VERDICT[d.verdict],
        *(f"{r[:1].upper()}{r[1:]}." for r in d.reasons if d.unknown is None or r[:9] != "something"),
    ]
    if d.mistake is not None and d.mistake.effect == LOG:
        out.append(
            f"The log looks mistaken: {d.mistake.component}, {d.mistake.what.replace('_', ' ')}. Correct the recording and diagnose it"
            " again; nothing of it is the machine's."
        )
    elif d.mistake is not None:
        out.append(f"The stored table looks mistaken: {d.mistake.component}, {d.mistake.what}.")
    out += [_answer_text(d, a) for a in d.found] + _of_unknown(d)
    out += [_answer_text(d, a) for a in d.candidates if a.with_rivals >= LEAST_TOLD]
    out += [f"Where, before any name was fitted: {p.text}." for p in d.location[:1]]
    return out


def _answer_text(d: Diagnosis, a: Answer) -> str:
    """Return one answer: the behaviour of the machine, its numbers, its alternatives."""
    opened = open_members(a)
    foreign = [n for n in a.cannot_be_told_from if n.split("[")[0] not in {m.effect for m in opened}]
    rivals = (
        f" It cannot be told from {', '.join(foreign)} here; probability of either: {a.with_rivals:.3f}."
        if foreign
        else ""
    )
    words = plain_words(a.effect, a.where, a.parameters)
    if a.probability < LEAST_TOLD:  # it has the shape that was fitted, not the name
        words = f"Most probably {' or '.join(a.cannot_be_told_from)}; what was fitted has the shape of"
    elif a.doubtful:
        words = f"Perhaps, less probable than not: {words[:1].lower()}{words[1:]}"
    remark = f" {a.remark[:1].upper()}{a.remark[1:]}." if a.remark else ""
    sure = f"probability {probability_text(a)}"
    if opened:
        sure = f"probability of the family {a.family} {a.family_probability:.3f}, of this shape of it {probability_text(a)}"
    return f"{words} {_name(a)}: {values_text(a)}; its own variance is {a.share:.0%} of the excess; {sure}.{rivals}{remark}".strip()


def _of_unknown(d: Diagnosis) -> list[str]:
    """Return the departure without a name: its place, its size, and its formula where there is one."""
    if d.unknown is None:
        return []
    size = f" (rms {micro_text(d, d.unknown.rms)})" if d.unknown.rms > 0 else ""
    out = [
        f"Unknown, over {', '.join(d.unknown.covariates)}: {d.unknown.description}{size}. A proposal, not a name."
    ]
    if d.unknown.formula:
        unit = "urad" if d.angle else "um"
        out.append(
            f"A formula that also predicts held-out rows (proposal, not physics), {unit}: {d.unknown.formula}."
        )
    return out


def _name(a: Answer) -> str:
    where = ", ".join(str(v) for v in a.where.values())
    return a.effect.replace("_", " ") + (f" {where}" if where else "")


def least_seen(d: Diagnosis) -> str:
    """Return the smallest rms per effect that this recording would have shown, at the place where it shows best."""
    shown = (
        f"{x.effect} {' '.join(x.where.values())}".strip() + f" {micro_text(d, x.amplitude)}"
        for x in d.detectable
    )
    return ", ".join(shown)


def diagnosis_page(
    recording: Recording, machine: Machine, d: Diagnosis, several: Several | None = None
) -> str:
    """Return one self-contained HTML file. several: where d was found from several recordings together."""
    blocks = [
        r.heading("Verdict"),
        *(r.paragraph(s) for s in sentences(d)),
        *r.notices(d.warnings),
    ]
    for table in answers(d):
        blocks += [r.heading(table.title[:1].upper() + table.title[1:]), *_answers(table)]
    if several is not None:
        blocks += [r.heading("What is common and what is each one's own"), html(sizes(several))]
        blocks += [r.heading("Each recording by itself"), html(by_itself(several))]
    if d.unknown is not None and d.unknown.shape is not None:
        blocks += [r.heading("What is not in the catalogue"), r.columns(*unknown_picture(d))]
    drawn = few_enough(recording, MOST_DRAWN)
    blocks += [r.heading("Residual before and after")]
    if drawn is not recording:
        blocks += [r.paragraph(f"Drawn are {drawn.m} of {recording.m} observations, evenly over the rows.")]
    blocks += _residuals(drawn, machine, d)
    blocks += [r.heading("Cross-validation"), html(folds(d))]
    if d.location:
        blocks += [r.heading("Where the residual departs"), html(places(d))]
    blocks += location_bars(d)
    if d.noise_findings:
        blocks += [r.heading("Noise"), *(r.paragraph(t) for t in d.noise_findings)]
    blocks += [
        r.heading("What to measure next"),
        _next(d),
        r.heading("What this recording could have shown"),
        *_power(d),
    ]
    footer = f"vcmm {__version__}, seed {d.seed}. Threshold {d.threshold:.1f} nats from the simulator's own null recordings."
    return r.page(
        f"Diagnosis report: {recording.name}",
        blocks,
        footer=footer,
        answers=diagnosis_answers(d),
        facts=facts(
            "",
            machine.name,
            {**machine.record, **recording.record},
            d.seed,
            [("observations", f"{recording.m:,}")],
            OF_MACHINES,
        ),
    )


def without_pictures(recording: Recording, d: Diagnosis, why: str) -> str:
    """Return the verdict alone, and why nothing could be drawn."""
    blocks = [r.heading("Verdict"), *(r.paragraph(s) for s in sentences(d)), r.note(why, "warning")]
    return r.page(f"Diagnosis report: {recording.name}", blocks, answers=diagnosis_answers(d))


def _answers(table: ResultTable[Answer]) -> list[str]:
    out = [html(table)]
    items = [(_name(a), 100 * a.share) for a in table.rows]
    out.append(
        draw.on_page(
            draw.bars,
            items,
            unit="%",
            title="Own variance of each effect over the excess (they overlap, and do not add up)",
            share="none",
        )
    )
    for a in table.rows:
        kind = BY_NAME.get(a.effect)
        if kind is not None:
            out.append(
                r.details(
                    f"{_name(a)}: what it is",
                    r.paragraph(cleandoc(kind.__doc__ or "")),
                    r.paragraph(f"Source: {kind.about.cites}"),
                )
            )
    return out


def _residuals(recording: Recording, machine: Machine, d: Diagnosis) -> list[str]:
    """Return the residuals by order and over the covariate that tells most, nuisances removed by least squares; after: the residuals with the
    written machine, and in words those with the candidates.
    """
    before, after = residuals(recording, machine, d)
    explained = bool(answers_to_write(d.answer)) or d.mistake is not None
    scale, unit = (1e6, "µrad") if d.angle else (1e3, "µm")
    charts = [
        _scatter(
            np.arange(1.0, len(before) + 1),
            before * scale,
            after * scale,
            "observation, in the order made",
            unit,
            explained,
        )
    ]
    charts += _over_what_named_it(recording, before * scale, after * scale, d, unit, explained)
    charts.append(_histogram(before * scale, after * scale, unit))
    maps = zone_maps(recording, before * scale, after * scale, unit)
    shown = [r.columns(*maps)] if maps else []
    bar = bar_traces(recording, machine, before, after)
    return [
        r.paragraph(after_text(d)),
        *bar,
        r.columns(*charts),
        *shown,
        *([] if bar else arrows(recording, machine.prepare(recording.run).tip, before, after)),
    ]


def _over_what_named_it(
    recording: Recording, before: Array, after: Array, d: Diagnosis, unit: str, explained: bool
) -> list[str]:
    """Return pictures before and after over the covariate that showed most, along the direction in which it did: of readings within 45
    degrees of it."""
    place = next((p for p in d.location if _covariate(recording, p.covariate) is not None), None)
    if place is None:
        return []
    x = _covariate(recording, place.covariate)
    assert x is not None
    label, along = place.covariate, np.ones(recording.m)
    if place.direction in AXES and recording.kind != "angle":
        share = recording.direction[:, AXES.index(place.direction)]
        mine = np.abs(share) >= np.sqrt(0.5)
        if mine.sum() >= LEAST_ALONG:
            label, along = f"{place.covariate}, of readings along {place.direction}", np.where(mine, np.sign(share), np.nan)  # fmt: skip
    kept = np.isfinite(along)
    before, after = (v[kept] * along[kept] for v in (before, after))
    return [_scatter(x[kept], before, after, label, unit, explained)]


def residuals(recording: Recording, machine: Machine, d: Diagnosis) -> tuple[Array, Array]:
    """Return residuals (m,) mm or rad before and after, observation by observation as the recording has them."""
    written = handed_over(d, machine)
    before, after = (as_in_the_file(recording, m, left_by(recording, m).residual) for m in (machine, written))
    return before, after


def after_text(d: Diagnosis) -> str:
    """Return the sentence about "after": all rows as they are, with the written machine; and further candidates."""
    fit = d.fit
    text = (
        f"All rows as they are, the nuisance refitted: rms {micro_text(d, fit.before)} with the machine file as it was,"
        f" {micro_text(d, fit.after)} with the one that is written"
    )
    if fit.candidates < CLEARLY_LESS * fit.after:
        text += (
            f", {micro_text(d, fit.candidates)} if the candidates and what belongs to the instrument or to single events were"
            " taken off too"
        )
    return f"{text}; the scatter found is {micro_text(d, fit.noise)}."


def _covariate(recording: Recording, name: str) -> Array | None:
    """Return a column or axis position at each observation; None for names that are no single column."""
    run = recording.run
    for key in (name, f"{name}_s", f"{name}_mm", f"{name}_C", f"{name}_rad", f"{name}_mm_s"):
        if key in run.columns:
            return run.columns[key][recording.row]
    return run.position[name][recording.row] if name in run.position else None


def _scatter(x: Array, before: Array, after: Array, label: str, unit: str, explained: bool) -> str:
    both = [("before", before, BEFORE), *([("after", after, AFTER)] if explained else [])]
    if draw.is_grouped(x):
        title = f"Residual over {label}"
        return draw.on_page(draw.boxes, x, both, label=label, y_label=f"residual / {unit}", title=title)
    series = [
        draw.PlotSeries(x, values, name, marker=True, line=False, colour=colour) for name, values, colour in both
    ]  # fmt: skip
    return draw.on_page(
        draw.curve,
        series,
        x_label=label,
        y_label=f"residual / {unit}",
        title=f"Residual over {label.removesuffix(', in the order made')}",
    )


def _histogram(before: Array, after: Array, unit: str) -> str:
    edges = np.histogram_bin_edges(np.concatenate([before, after]), bins=40)
    return draw.on_page(
        draw.distribution,
        edges,
        np.histogram(after, edges)[0],
        unit=unit,
        label=f"residual after / {unit}",
        title="Residual after",
    )


def _next(d: Diagnosis) -> str:
    if not d.next_measurement:
        return r.paragraph("No add-on of the list would tell more.")
    return html(next_steps(d))


def _power(d: Diagnosis) -> list[str]:
    out = [
        r.details(
            "Smallest amplitude seen per effect, at the place where it shows best (rms over the recording)",
            html(detectable_table(d)),
        )
    ]
    if d.invisible:
        out.append(r.paragraph("Invisible in this recording: " + ", ".join(d.invisible) + "."))
    if d.not_testable:
        lacking = "; ".join(
            f"{name} ({', '.join(columns)})" for name, columns in sorted(d.not_testable.items())
        )
        out.append(r.paragraph(f"Not testable, columns missing: {lacking}."))
    return out


def fleet_page(folder: str, records: Sequence[tables.Record], changes: Sequence[Change]) -> str:
    """Return one self-contained HTML file."""
    far = [i for i, c in enumerate(changes) if not c.steady]
    blocks = (
        [r.heading("What changed"), html(tables.changes_table(changes), emphasise=far)] if changes else []
    )
    blocks += [r.heading("What each holds"), html(tables.recordings(folder, records))]
    return r.page(
        f"Recordings of {folder}",
        blocks,
        footer=f"vcmm {__version__}",
        answers=folder_answers(records, changes),
        facts=facts(more=[("recordings", f"{len(records)}")]),
    )
