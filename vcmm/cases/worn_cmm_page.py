"""The report of the twin worn_cmm: what was concealed beside what was found, and what that does to a measuring job."""

from __future__ import annotations

from vcmm import __version__
from vcmm import report as r
from vcmm.cases.worn_cmm import AIR, CONCEALED, Result, answer_to
from vcmm.pages.diagnosis import fit_rows, sentences
from vcmm.pages.tables import Shown, html

WHAT = (
    "A ball plate is touched 400 times in six hours, in five placements, on a bridge CMM with a worn Y drive and a ram that "
    "follows the room. The machine file knows neither. The recording is put to the diagnosis; here its answer stands beside "
    "what was concealed."
)
CAUTION = (
    "One recording is an example and no proof: how often concealed effects are named rightly is counted in the blind exam. "
    "Play and ram are simulated by code that shares no line with the effects of the catalogue."
)


def tables(result: Result) -> list[Shown]:
    """The same in terminal, report and documentation."""
    return [_found(result), _folds(result), _job(result)]


def _found(result: Result) -> Shown:
    rows = []
    for hidden in CONCEALED:
        answer = answer_to(result.diagnosis, hidden)
        for name, (true, unit) in hidden.parameters.items():
            one = answer.parameters.get(name) if answer else None
            said = (
                (f"{one.value:.2f}", f"{one.interval95[0]:.2f} … {one.interval95[1]:.2f}")
                if one
                else ("not found", "–")
            )
            chance = f"{answer.probability:.3f}" if answer else "–"
            place = " ".join(hidden.where.values())
            rows.append((hidden.effect, place, f"{name} / {unit}", f"{true:.2f}", *said, chance))
    columns = ("concealed", "where", "parameter", "true", "found", "95 % coverage interval", "probability")
    more = [
        a.effect
        for a in result.diagnosis.answer
        if all(answer_to(result.diagnosis, h) is not a for h in CONCEALED)
    ]
    caption = f"Verdict: {result.diagnosis.verdict}. " + (
        f"Also named: {', '.join(more)}." if more else "Nothing else is named."
    )
    return Shown("What was concealed, and what was found", columns, tuple(rows), caption, (0, 1, 2))


def _folds(result: Result) -> Shown:
    columns = ("rows left out of the fit", "rms before", "rms after", "effect energy left", "log score gain")
    caption = (
        "Each line fits the named effects on the other rows and predicts these; the first line is fitted."
    )
    rows = tuple(tuple(row) for row in fit_rows(result.diagnosis))
    return Shown("The prediction on rows never fitted", columns, rows, caption)


def _job(result: Result) -> Shown:
    rows = tuple(
        (
            m.name,
            *(f"{(v - m.true) * 1e3:+.2f}" for v in (m.before[0], m.after[0])),
            f"{m.before[1] * 1e3:.2f}",
            f"{m.after[1] * 1e3:.2f}",
        )
        for m in result.job
    )
    columns = ("characteristic", "file - true", "diagnosed - true", "U, file", "U, diagnosed")
    caption = (
        f"What the scenario plate would indicate in a room at {AIR:g} °C, predicted from the machine file and from the improved one, "
        "less what the machine with its concealed faults does indicate, µm. An improved file knows the new parameters only "
        "as well as the recording showed them. U contains this for sizes (gap, k), not for a time constant or another scanned "
        "parameter, nor their correlation."
    )
    return Shown("A measuring job predicted with the improved machine file", columns, rows, caption)


def twin_page(result: Result) -> str:
    """One self-contained HTML file."""
    blocks = [r.paragraph(WHAT), r.note(CAUTION, "warning"), r.heading("What the diagnosis says")]
    blocks += [r.paragraph(s) for s in sentences(result.diagnosis)]
    for shown in tables(result):
        blocks += html(shown)
    footer = f"vcmm {__version__}. Measuring error = indicated - true."
    return r.page(
        "Two faults concealed in the log of a CMM", blocks, subtitle=result.machine.name, footer=footer
    )
