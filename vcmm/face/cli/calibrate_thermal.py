"""vcmm calibrate --thermal: what temperatures do to the tip, added to a machine file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from vcmm.face.cli.calibrate_given import CalibrationFiles


def thermal_command(
    wanted: CalibrationFiles, sensors: list[str], json: bool, report: Path | None = None
) -> int:
    """Fit the terms, write the file, tell what it predicts; the document is vcmm.thermal/1."""
    from vcmm.files.learned.thermal_terms import thermal_text, written_terms
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.calibration.thermal import thermal_model
    from vcmm.learn.calibration.thermal_terms import warm_readings
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.files import output_folder, write_text
    from vcmm.show.console.terminal import say, show_answers, show_table
    from vcmm.show.tables.answers_runs import thermal_answers
    from vcmm.show.tables.calibration import TESTS, independent_tests
    from vcmm.show.tables.table import records
    from vcmm.show.tables.thermal import TERMS, term_rows, terms

    given, out = wanted.load(), wanted.out
    assert wanted.machine is not None
    for file in (out, report):
        if file is not None:
            output_folder(file.parent)
    asked = [load_recording(path, given.machine)[0] for path in wanted.test]
    for one in asked:
        warm_readings(one, given.machine)  # refused before anything is written
    found = thermal_model(given.recordings, given.machine, sensors)
    rows = term_rows(found, written_terms(found))
    if out is not None:
        files = [f.name for f in wanted.files]
        write_text(out, thermal_text(found, given.machine, wanted.machine, out, files))
        say(f"wrote {out}")
    if report is not None:
        from vcmm.show.pages.thermal import thermal_page

        write_text(report, thermal_page(found, given.machine, rows))
        say(f"wrote {report}")
    tests, nets = wanted.tests(), _nets(asked, given, list(found.trained))
    if json:
        body = {
            "machine": None if out is None else str(out),
            "terms": records(TERMS, rows),
            **_figures(found),
        }
        body |= {"tests": [t | {"net_rms": n} for t, n in zip(records(TESTS, tests), nets)]}
        print_json(document("vcmm.thermal/1", body, files=wanted.read()))
        return 0
    show_answers(thermal_answers(found, len(rows)))
    show_table(terms(rows))
    _show(found)
    if tests:
        show_table(independent_tests(tests))
    for test, left in zip(tests, nets):
        print(f"a net from the same sensors leaves {left:.3f} µm of {test.name} (compared, not written)")
    return 0


def _nets(asked: list[Any], given: Any, sensors: list[str]) -> list[float]:
    """um that a net from the same sensors leaves of every test."""
    from vcmm.learn.calibration.thermal_net import net_left

    return [net_left(given.recordings, one, given.machine, sensors) * 1e3 for one in asked]


def _figures(found: Any) -> dict[str, Any]:
    before, after = found.held_out
    return {
        "rms_before_um": found.before * 1e3,
        "rms_after_um": found.after * 1e3,
        "held_out": {"rms_before_um": before * 1e3, "rms_after_um": after * 1e3},
        "outliers": found.outliers,
        "trained_degC": {s: list(r) for s, r in found.trained.items()},
        "not_used": found.unused,
    }


def _show(found: Any) -> None:
    before, after = found.held_out
    print(f"all readings: {found.before * 1e3:.2f} -> {found.after * 1e3:.2f} µm rms")
    print(f"blocks of time predicted from the others: {before * 1e3:.2f} -> {after * 1e3:.2f} µm rms")
    if found.outliers:
        print(f"{found.outliers} single readings stand out from their neighbours and were left out")
    for sensor, why in found.unused.items():
        print(f"not used: {sensor}: {why}")
