"""vcmm calibrate --compare-interpolations: how each predicts positions that were held out."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vcmm.face.cli.calibrate_given import CalibrationFiles


def interpolations_command(wanted: CalibrationFiles, only: list[str], json: bool) -> int:
    """Fit and score every interpolation; the document is vcmm.interpolations/1."""
    from vcmm.learn.calibration.cross_validation import compare_interpolations
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.terminal import progress, show_table
    from vcmm.show.tables.calibration import HELD_OUT, interpolations
    from vcmm.show.tables.table import records

    given = wanted.load()
    with progress() as show:
        found = compare_interpolations(given.recordings, given.machine, given.certificates, only, show)
    if json:
        body = {"interpolations": records(HELD_OUT, found)}
        print_json(document("vcmm.interpolations/1", body, seed=0, files=wanted.read()))
    else:
        show_table(interpolations(found))
    return 0
