"""The report of a diagnosis: what was left out, how sure, what it cannot be told from, what to measure next."""

from __future__ import annotations

from collections.abc import Sequence
from inspect import cleandoc

import numpy as np

from vcmm import __version__
from vcmm import report as r
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.units import plain
from vcmm.diagnosis.estimates import Estimate
from vcmm.diagnosis.improve import improved
from vcmm.diagnosis.plain_words import plain_words
from vcmm.diagnosis.repair import repaired
from vcmm.diagnosis.result import Answer, Diagnosis
from vcmm.diagnosis.verdict import LEAST_TOLD, told
from vcmm.effects import BY_NAME
from vcmm.pages.diagnosis_pictures import arrows, location_bars, unknown_picture, zone_maps
from vcmm.response.nuisance import nuisance_columns
from vcmm.response.observe import baseline
from vcmm.response.recording import Recording

FOUND = "physics that the machine file lacks"
CANDIDATES = "candidates, less probable than not; they are not written into the machine file"
SCALE = (
    "rms of what nuisance parameters and the uncertainty of the calibration cannot take up, weighted by the noise: less "
    "than the rms of the rows where an artefact's placement takes up most; shares are of the same energy and may overlap"
)
SHOWN = {"1/Kv": "departure of 1/Kv"}  # parameters whose name would mislead
VERDICT = {
    "nothing missing": "Nothing is missing: the residual is what the stated noise and calibration predict.",
    "explained": "The departure is explained by physics that the machine file lacks.",
    "partly explained": "Part of the departure is explained; something is left that the catalogue does not hold.",
    "unexplained": "Something is missing that is not in the catalogue: where and what shape is shown, a name is not claimed.",
}
NOT_SHOWN = "Something does not fit, and neither a name nor a place for it is found."


def sentences(d: Diagnosis) -> list[str]:
    """The verdict in plain words."""
    out = [
        NOT_SHOWN if d.verdict == "unexplained" and d.unknown is None else VERDICT[d.verdict],
        *(f"{r[:1].upper()}{r[1:]}." for r in d.reasons if d.unknown is None or r[:9] != "something"),
    ]
    if d.mistake is not None:
        out.append(f"The stored table looks mistaken: {d.mistake.component}, {d.mistake.what}.")
    out += [_said(d, a) for a in d.found] + _of_unknown(d) + [_said(d, a) for a in d.candidates]
    out += [f"Where, before any name was fitted: {p.text}." for p in d.location[:1]]
    return out


def _said(d: Diagnosis, a: Answer) -> str:
    """One answer: what the machine does, its numbers, what it may be instead."""
    rivals = (
        f" It cannot be told from {', '.join(a.cannot_be_told_from)} here; with them {a.with_rivals:.3f}."
        if a.cannot_be_told_from
        else ""
    )
    said = plain_words(a.effect, a.where, a.parameters)
    own = f" {a.remark[:1].upper()}{a.remark[1:]}." if a.remark else ""
    said = f"Perhaps, less probable than not: {said[:1].lower()}{said[1:]}" if a.doubtful else said
    return (
        f"{said} {_name(a)}: {_values(a)}; {a.share:.0%} of the excess energy, probability"
        f" {_probability(a)}.{rivals}{own}".strip()
    )


def _probability(a: Answer) -> str:
    return f"{a.probability:.3f}" if a.probability >= LEAST_TOLD else told(a.probability)


def _of_unknown(d: Diagnosis) -> list[str]:
    """What has no name: where, how large, and its formula where there is one."""
    if d.unknown is None:
        return []
    size = f" (rms {_micro(d, d.unknown.rms)})" if d.unknown.rms > 0 else ""
    out = [
        f"Unknown, over {', '.join(d.unknown.covariates)}: {d.unknown.description}{size}. A proposal, not a name."
    ]
    if d.unknown.formula:
        unit = "urad" if d.angle else "um"
        out.append(
            f"A formula that also predicts rows never fitted (proposal, not physics), {unit}: {d.unknown.formula}."
        )
    return out


def _name(a: Answer) -> str:
    where = ", ".join(str(v) for v in a.where.values())
    return a.effect.replace("_", " ") + (f" {where}" if where else "")


def _values(a: Answer) -> str:
    """Every parameter with its 95 % coverage interval, to the digits that its standard uncertainty supports."""
    out = [f"{SHOWN.get(n, n)} = {with_interval(e)}" for n, e in a.parameters.items()]
    lobes = getattr(a.fitted, "lobes", 0)
    return ", ".join([*([f"{lobes} lobes"] if lobes else []), *out]) or "no free parameter"


def with_interval(e: Estimate) -> str:
    """1.50 um (95 %: 1.12 to 1.87): two digits of the standard uncertainty (JCGM 100:2008, 7.2.6)."""
    low, high = e.interval95
    if not (np.isfinite([e.value, e.u, low, high]).all() and e.u > 0):
        return f"{plain(e.value)} {e.unit if e.unit != '1' else ''}".strip()
    digits = max(0, 1 - int(np.floor(np.log10(e.u))))
    value, low_text, high_text = (f"{round(x, digits) + 0.0:.{digits}f}" for x in (e.value, low, high))
    unit = "" if e.unit == "1" else f" {e.unit}"
    return f"{value}{unit} (95 %: {low_text} to {high_text})"


def _micro(d: Diagnosis, value: float) -> str:
    return f"{value * 1e6:.3g} urad" if d.angle else f"{value * 1e3:.3g} um"


def answer_parts(d: Diagnosis) -> list[tuple[str, tuple[Answer, ...]]]:
    """Title and answers: what was found, and what is only a candidate; parts without an answer are left away."""
    parts = [(FOUND, d.found), (CANDIDATES, d.candidates)]
    return [(title, answers) for title, answers in parts if answers]


def answer_rows(answers: Sequence[Answer]) -> list[list[str]]:
    return [
        [
            a.effect,
            ", ".join(str(v) for v in a.where.values()) or "–",
            _values(a),
            _probability(a),
            f"{a.share:.0%}",
            ", ".join(a.cannot_be_told_from) or "–",
        ]
        for a in answers
    ]


def least_seen(d: Diagnosis) -> str:
    """The smallest rms per effect that this recording would have shown, at the place where it shows best."""
    shown = (
        f"{x.effect} {' '.join(x.where.values())}".strip() + f" {_micro(d, x.amplitude)}"
        for x in d.detectable
    )
    return ", ".join(shown)


def fit_rows(d: Diagnosis) -> list[list[str]]:
    rows = [
        [
            "all rows, fitted",
            _micro(d, d.fit.before),
            _micro(d, d.fit.after),
            f"noise {_micro(d, d.fit.noise)}",
            "–",
        ]
    ]
    for h in d.fit.held_out:
        rows.append(
            [
                h.fold,
                _micro(d, h.rms_before),
                _micro(d, h.rms_after),
                f"{h.effect_energy_left:.3f}" if np.isfinite(h.effect_energy_left) else "–",
                f"{h.gain:+.1f} nats",
            ]
        )
    return rows


def next_rows(d: Diagnosis) -> list[list[str]]:
    return [
        [", ".join(n.separates), n.do, f"{n.minutes:.0f}" if n.minutes >= 10 else f"{n.minutes:.2g}"]
        for n in d.next_measurement
    ]


def diagnosis_page(recording: Recording, machine: Machine, d: Diagnosis) -> str:
    """One self-contained HTML file."""
    blocks = [
        r.heading("Verdict"),
        *(r.paragraph(s) for s in sentences(d)),
        *(r.note(w, "warning") for w in d.warnings),
    ]
    for title, answers in answer_parts(d):
        blocks += [r.heading(title[:1].upper() + title[1:]), *_answers(answers)]
    if d.unknown is not None and d.unknown.shape is not None:
        blocks += [r.heading("What is not in the catalogue"), r.columns(*unknown_picture(d))]
    blocks += [r.heading("Residual before and after"), *_residuals(recording, machine, d)]
    columns = ["fold", "rms before", "rms after", "effect energy left", "log score gain"]
    blocks += [
        r.heading("On rows never fitted"),
        r.table(columns, fit_rows(d), numeric=(1, 2, 3, 4)),
        r.paragraph(SCALE),
    ]
    if d.location:
        rows = [[p.covariate, p.direction, f"{p.p:.2g}", p.text] for p in d.location]
        blocks += [
            r.heading("Where the residual departs"),
            r.table(["covariate", "direction", "false-alarm p", ""], rows, numeric=(2,)),
        ]
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
    return r.page(f"Diagnosis of {recording.name}", blocks, subtitle=machine.name, footer=footer)


def _answers(answers: Sequence[Answer]) -> list[str]:
    columns = ["effect", "where", "parameters", "probability", "share", "cannot be told from"]
    out = [r.table(columns, answer_rows(answers), numeric=(3, 4))]
    items = [(_name(a), 100 * a.share) for a in answers]
    out.append(r.bars(items, unit="%", title="Share of the excess energy", share="none"))
    for a in answers:
        kind = BY_NAME.get(a.effect)
        if kind is not None:
            out.append(
                r.details(
                    f"{_name(a)}: what it is",
                    r.paragraph(cleandoc(kind.__doc__ or "")),
                    r.paragraph(f"Source: {kind.cites}"),
                )
            )
    return out


def _residuals(recording: Recording, machine: Machine, d: Diagnosis) -> list[str]:
    """Residuals by order and over the covariate that tells most, nuisances taken off by least squares."""
    found = tuple((a.fitted, a.inputs) for a in d.answer if a.fitted is not None)
    explained = bool(found) or d.mistake is not None
    nuisance, _ = nuisance_columns(recording, machine)
    before = _rest(recording.value - baseline(recording, machine), nuisance)
    better = improved(_repaired(machine, d), found)
    after = _rest(recording.value - baseline(recording, better), nuisance)
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
    place = next((p for p in d.location if _covariate(recording, p.covariate) is not None), None)
    if place is not None:
        x = _covariate(recording, place.covariate)
        assert x is not None
        charts.append(_scatter(x, before * scale, after * scale, place.covariate, unit, explained))
    charts.append(_histogram(before * scale, after * scale, unit))
    maps = zone_maps(recording, before * scale, after * scale, unit)
    shown = [r.columns(*maps)] if maps else []
    return [r.columns(*charts), *shown, *arrows(recording, machine.prepare(recording.run).tip, before, after)]


def _repaired(machine: Machine, d: Diagnosis) -> Machine:
    """The machine with its mistaken table corrected, where that can be written as a table."""
    try:
        return repaired(machine, d.mistake)
    except (UsageError, KeyError):
        return machine


def _rest(values: Array, nuisance: Array) -> Array:
    """What least squares over the nuisance columns leaves."""
    if not nuisance.shape[1]:
        return values - values.mean()
    return np.asarray(values - nuisance @ np.linalg.lstsq(nuisance, values, rcond=None)[0])


def _covariate(recording: Recording, name: str) -> Array | None:
    """A column or axis position at each observation; None for names that are no single column."""
    run = recording.run
    for key in (name, f"{name}_s", f"{name}_mm", f"{name}_C", f"{name}_rad", f"{name}_mm_s"):
        if key in run.columns:
            return run.columns[key][recording.row]
    return run.position[name][recording.row] if name in run.position else None


def _scatter(x: Array, before: Array, after: Array, label: str, unit: str, found: bool) -> str:
    series = [r.Series(x, before, "before", marker=True, line=False)]
    if found:
        series.append(r.Series(x, after, "after", marker=True, line=False))
    return r.curve(
        series, x_label=label, y_label=f"residual / {unit}", title=f"Residual over {label.split(',')[0]}"
    )


def _histogram(before: Array, after: Array, unit: str) -> str:
    edges = np.histogram_bin_edges(np.concatenate([before, after]), bins=40)
    return r.histogram(
        edges, np.histogram(after, edges)[0], x_label=f"residual after / {unit}", title="Residual after"
    )


def _next(d: Diagnosis) -> str:
    if not d.next_measurement:
        return r.paragraph("No add-on of the list would tell more.")
    return r.table(["separates", "do", "minutes"], next_rows(d), numeric=(2,))


def _power(d: Diagnosis) -> list[str]:
    rows = [[x.effect, ", ".join(x.where.values()) or "–", _micro(d, x.amplitude)] for x in d.detectable]
    out = [
        r.details(
            "Smallest amplitude seen per effect, at the place where it shows best (rms over the recording)",
            r.table(["effect", "where", "rms"], rows, numeric=(2,)),
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
