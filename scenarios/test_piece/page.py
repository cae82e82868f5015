"""The report of the test piece: errors x features, and the circle under each error."""

from __future__ import annotations

from functools import partial

from vcmm import Array, CutScenario, __version__
from vcmm import charts as draw
from vcmm import report as r
from vcmm import tables as tb

from .twin import CIRCLE, PieceTwin

WHAT = (
    "The piece is cut virtually with one error of the machine at a time, of a round unit size. The table shows what each "
    "feature of the finished part departs from nominal: so a bad feature points to its cause, and a cause to the features "
    "that must be looked at."
)
CAUTION = (
    "Finishing passes only; no stock is stated, so no cutting force bends the tool. The work zero was set on the machine, "
    "which takes its error there away. Form is what the stated inspection points find: 24 round the circle miss a reversal "
    "spike that a scan of 1° sees."
)
SMALL = 0.005  # um, shown as a dot
ErrorRow = tuple[str, Array]  # an error, and what each feature departs under it, um
CELL = tb.Writing(lambda value, unit: "·" if abs(value) < SMALL else f"{value:+.2f}")
DRAWN = (0, 2, 7, 9, 11, 6)  # rows of the errors whose circles are drawn


def tables(result: PieceTwin) -> list[tb.ResultTable[ErrorRow]]:
    """Round and flat features apart; the same in terminal, report and documentation."""
    circle = [i for i, n in enumerate(result.features) if n in CIRCLE or "circle" in n]
    flat = [i for i in range(len(result.features)) if i not in circle]
    half = [i for i in flat if result.features[i].startswith("diamond")]
    square = [i for i in flat if i not in half]
    caption = "µm. Sizes and lengths: departure from nominal. Form and orientation: width of the zone. Ovals: amplitude of cos 2a and sin 2a."
    return [
        _columns(result, circle, "Errors x circle and bore", caption),
        _columns(result, square, "Errors x square", "µm, as above."),
        _columns(
            result, half, "Errors x diamond", "µm, as above. NE: between the sides south-west and north-east."
        ),
    ]


def _columns(result: PieceTwin, of: list[int], title: str, caption: str) -> tb.ResultTable[ErrorRow]:
    columns: list[tb.Column[ErrorRow]] = [tb.Column("error", lambda row: row[0])]
    columns += [tb.Column(_short(result.features[i]), partial(_departure, i), CELL) for i in of]
    return tb.ResultTable(title, columns, list(zip(result.errors, result.um)), caption)


def _departure(feature: int, row: ErrorRow) -> float:
    return float(row[1][feature])


def _short(feature: str) -> str:
    """The title of the table says which shape it is."""
    return (
        feature.removeprefix("circle, ")
        .removeprefix("circle ")
        .removeprefix("square ")
        .removeprefix("diamond ")
    )


def answers(result: PieceTwin) -> list[r.AnswerLine]:
    """Where each error shows most."""
    most = [int(abs(um).argmax()) for um in result.um]
    return [
        r.AnswerLine(error, f"{um[i]:+.2f} µm", because=result.features[i], labels=("", "shows most in", ""))
        for error, um, i in zip(result.errors, result.um, most)
    ]


def twin_page(scenario: CutScenario, result: PieceTwin) -> str:
    """One self-contained HTML file."""
    blocks = [r.paragraph(WHAT), r.note(CAUTION, "warning")]
    for table in tables(result):
        blocks += tb.titled_html(table)
    blocks.append(r.heading("The circle under single errors"))
    circles = [
        draw.on_page(draw.polar, result.angle, result.circle[i], title=result.errors[i]) for i in DRAWN
    ]
    blocks += [r.columns(*circles[i : i + 2]) for i in range(0, len(circles), 2)]
    footer = f"vcmm {__version__}. Machining error = actual - commanded; departures along the outward normal, plus is material left."
    return r.page(
        "Which error shows in which feature",
        blocks,
        subtitle=scenario.name,
        footer=footer,
        answers=answers(result),
    )
