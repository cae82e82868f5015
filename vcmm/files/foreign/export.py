"""Results written for other systems, by the ending of the file: .qif (QIF 3.0), .dfq (Q-DAS), .xml (results of a DCC)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vcmm.core.errors import UsageError, choose_from
from vcmm.files.foreign.dcc import dcc_results
from vcmm.files.foreign.dfq import dfq_text
from vcmm.files.foreign.exported_values import handed_over
from vcmm.files.foreign.qif_results import qif_text
from vcmm.part.part import Part

ENDINGS = (".qif", ".dfq", ".xml")


def check_ending(path: str | Path) -> None:
    """UsageError for a file whose ending names no system."""
    if Path(path).suffix.lower() not in ENDINGS:
        given = Path(path).suffix
        raise UsageError(
            f'--export {path}: the ending "{given}" names no format.{choose_from(given, ENDINGS)}'
        )


def export_text(
    path: str | Path, name: str, part: Part, document: Mapping[str, Any]
) -> tuple[str, tuple[str, ...]]:
    """Text of the file and notes on what it cannot say. name: of the task; document: what `evaluate --json` prints."""
    check_ending(path)
    values = handed_over(document)
    ending = Path(path).suffix.lower()
    if ending == ".qif":
        return qif_text(part, values, json.dumps(document, sort_keys=True))
    return (dfq_text(name, values) if ending == ".dfq" else dcc_results(name, values)), ()
