"""vcmm calibrate face: a scan of a turned or milled face, its map, and the program corrected for it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vcmm.core.errors import UsageError


@dataclass(frozen=True)
class FaceProgram:
    """The program that cut the face, as it was asked for. lines: "FIRST-LAST", or "" for all that pass over the scan."""

    path: Path | None
    setup: Path | None
    lines: str
    tolerance: str
    decimals: int | None


def face_command(scan: Path, machine: Path | None, program: FaceProgram, out: Path | None, json: bool) -> int:
    """Map the face, write what was asked for, show the figures."""
    from vcmm.face.public.faces import load_face_scan, map_face
    from vcmm.files.own.machine import load_machine
    from vcmm.show.console.documents import document, json_text, print_json, sources
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import say, say_warnings, show_table
    from vcmm.show.pages.faces import face_page
    from vcmm.show.tables import faces as tables

    found = map_face(load_face_scan(scan), None if machine is None else load_machine(machine))
    better = _correction(found, program)
    body, notes = tables.face_json(found), [*found.warnings]
    if better is not None:
        body |= {"program": _program(better)}
        notes += better.warnings
    read = [p for p in (scan, _data(scan), machine, program.path, program.setup) if p is not None]
    files = list(dict.fromkeys(f for p in read for f in ([p] if p.suffix != ".toml" else sources(p))))
    content = document("vcmm.face/1", body, files=files, warnings=notes)
    if out is not None:
        texts = {
            "face.json": json_text(content),
            "face.html": face_page(found),
            "map.csv": tables.map_csv(found),
        }
        if found.r is not None:
            texts["profile.csv"] = tables.profile_csv(found)
        write_files(output_folder(out), texts)
        if better is not None:
            texts[_write_program(better, program.path, out)] = ""
        say(f"wrote {out}/" + ", ".join(texts))
    elif better is not None:
        raise UsageError("--program writes a corrected program: name a folder for it with --out")
    if json:
        print_json(content)
        return 0
    show_table(tables.figures(found))
    if better is not None:
        before, after = (d.largest * 1e3 for d in (better.before, better.after))
        print(
            f"program: up to {before:.3g} µm beside its path before, {after:.3g} µm after; {better.blocks.changed} blocks changed, {better.blocks.added} added"
        )
    say_warnings(notes)
    return 0


def _data(scan: Path) -> Path:
    from vcmm.files.toml import read_toml

    return scan.parent / str(read_toml(scan).data["data"])


def _correction(found: Any, program: FaceProgram) -> Any:
    """The corrected program; None where none was named."""
    from vcmm.core.units import quantity
    from vcmm.face.public.faces import correct_face

    if program.path is None:
        if program.setup is not None or program.lines:
            raise UsageError("--setup and --lines belong to --program; name the program that cut the face")
        return None
    if program.setup is None:
        raise UsageError("--program takes --setup setup.toml as well (machine, work offsets, tools)")
    largest = quantity(program.tolerance, "length", "--tolerance", "1 um")
    return correct_face(
        program.path,
        program.setup,
        found,
        lines=_lines(program.lines),
        tolerance=largest,
        decimals=program.decimals,
    )


def _lines(text: str) -> tuple[int, int] | None:
    if not text:
        return None
    first, dash, last = text.partition("-")
    if not (first.strip().isdigit() and (last.strip().isdigit() or not dash)):
        raise UsageError(
            f'--lines "{text}": write the first and the last line of the program that cut the face, such as "12-20"'
        )
    return int(first), int(last or first)


def _program(better: Any) -> dict[str, Any]:
    from vcmm.show.tables.compensation import departure_json

    made = {"before": departure_json(better.before), "after": departure_json(better.after)}
    return {
        "name": better.name,
        "dialect": better.dialect,
        "deviation": made,
        "changed": better.blocks.changed,
    }


def _write_program(better: Any, program: Path | None, out: Path) -> str:
    from vcmm.compensation.source import write_source

    assert program is not None
    target = out / f"{program.stem}-compensated{program.suffix}"
    if target.exists() and target.samefile(program):
        raise UsageError(f"{target} is the program itself; choose another folder with --out")
    write_source(target, better.data)
    return target.name
