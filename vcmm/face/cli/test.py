"""vcmm test: figures of acceptance tests, predicted for a machine or evaluated from a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from cyclopts.validators import Number

from vcmm.face.cli.options import Seed

DrawsOption = Annotated[
    int, Parameter(validator=Number(gte=40, lte=10**6))
]  # 40: one draw in either tail of 2.5 %


def test_command(
    file: Path,
    *more: Path,
    iso: str,
    limit: Annotated[list[str] | None, Parameter(name="--limit", negative=())] = None,
    seed: Seed = 0,
    trials: DrawsOption = 1000,
    report: Path | None = None, json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:  # fmt: skip
    """Predict the figures of an acceptance test with uncertainty, or evaluate a recorded one.

    Parameters
    ----------
    file
        Machine file (machine/1), or a scenario with its machine: predict. Recording file (recording/1): evaluate what was recorded (230-7: with [reversal]).
    more
        Further recordings of the same test: axes, planes, diagonals.
    iso
        The test: 230-2, 230-4, 230-6, 230-7 or 10360-2.
    limit
        A limit: "A = 8 um", "B X = 2 um", "E0 = 1.9 um + L/300" (L in mm gives um), "synchronous tilt B = 1 urad"; may be repeated.
    seed
        Seed of the drawn machines.
    trials
        Number of drawn machines.
    report
        File for the HTML report of recorded tests of 230-2 and 230-4: band charts, or traces of circles.
    json
        Print one JSON document.
    """
    from vcmm.face.acceptance import find_figures, table_of_figures
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.terminal import show_answers, show_table
    from vcmm.show.tables.answers_runs import acceptance_answers
    from vcmm.show.tables.calibration import figure_columns
    from vcmm.show.tables.table import records

    _check_report(report, iso, [file, *more])
    figures, warnings, drawn = find_figures([file, *more], iso, limit or [], seed, trials)
    _write_report(report, [file, *more], iso, figures, warnings)
    read = [f for one in (file, *more) for f in sources(one)]
    body = {"test": f"ISO {iso}", "figures": records(figure_columns(iso), figures)}
    content = document("vcmm.test/1", body, seed=seed, files=read, warnings=warnings)
    if json:
        print_json(content)
    else:
        if iso != "230-7":  # whose table is no longer than an answer
            show_answers(acceptance_answers(figures))
        show_table(table_of_figures(iso, figures))
        for warning in warnings:
            print(f"note: {warning}")
    return int(not drawn and any(f.p_pass is not None and f.p_pass < 0.5 for f in figures))


def _check_report(report: Path | None, iso: str, files: list[Path]) -> None:
    """UsageError where there is nothing to draw."""
    if report is None:
        return
    from vcmm.core.errors import UsageError
    from vcmm.files.toml import read_toml

    recorded = all(str(read_toml(f).data.get("vcmm", "")).startswith("recording/") for f in files)
    if iso not in ("230-2", "230-4") or not recorded:
        raise UsageError(
            "--report draws recorded tests of ISO 230-2 and 230-4; leave it out, or give recordings of them"
        )


def _write_report(
    report: Path | None, files: list[Path], iso: str, figures: Any, warnings: list[str]
) -> None:
    if report is None:
        return
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.calibration.deviations import RecordedTest
    from vcmm.show.console.files import output_folder, write_text
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.acceptance import acceptance_page

    output_folder(report.parent)
    tests = [RecordedTest(*load_recording(f)) for f in files]
    write_text(report, acceptance_page(tests, iso, figures, warnings))
    say(f"wrote {report}")
