"""vcmm calibrate on files with [reversal]: artefact and machine separated, a machine file of what is known."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def reversal_command(
    files: list[Path], structure: str | None, out: Path | None, json: bool, others: list[Any]
) -> int:
    """Separate every file; others: options that a reversal does not take, given or not."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.reversal import load_reversal
    from vcmm.learn.calibration.reversal import separate_all
    from vcmm.show.console.documents import document, print_json, sources

    if any(others):
        raise UsageError(
            "reversals alone take --structure, --out and --json; leave out --errors and --report"
        )
    found = separate_all([load_reversal(path) for path in files])
    _write(found, structure, out, [f.name for f in files])
    if json:
        read = [one for path in files for one in sources(path)]
        print_json(document("vcmm.calibration/1", _body(found, out), files=read))
    else:
        _show(found)
    return 0


def _write(found: Any, structure: str | None, out: Path | None, names: list[str]) -> None:
    from vcmm.core.errors import UsageError
    from vcmm.core.kinematics import parse_structure
    from vcmm.files.learned.reversed_machine import reversed_texts
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import say

    chain = None if structure is None else parse_structure(structure)
    if out is None:
        return
    if chain is None:
        raise UsageError(
            "a machine file needs the structure of the machine; write for example --structure \"w C' X' b Z t\""
        )
    output_folder(out.parent)
    texts = reversed_texts(found, chain, out, names)
    write_files(out.parent, texts)
    say(f"wrote {', '.join(str(out.parent / name) for name in texts)}")


def _body(found: Any, out: Path | None) -> dict[str, Any]:
    """The keys of a calibration; `reversals` holds every curve. residual_um, condition: of the worst file."""
    return {
        "machine": None if out is None else str(out),
        "identified": [row for one in found for row in one.rows()],
        "not_identified": [
            {"combination": list(c.names), "text": c.text} for one in found for c in one.combinations
        ],
        "condition": max(one.condition for one in found),
        "residual_um": max(one.scatter for one in found if one.file.kind != "half-turn") * 1e3
        if any(one.file.kind != "half-turn" for one in found)
        else None,
        "reversals": [one.document() for one in found],
    }


def _show(found: Any) -> None:
    from vcmm.show.console.terminal import show_table
    from vcmm.show.tables.reversal import reversals

    show_table(reversals(found))
    for one in found:
        for c in one.combinations:
            print(f"not identified: {c.text}")
