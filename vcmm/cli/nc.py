"""vcmm nc: what an NC program means."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def nc_command(
    program: Path,
    *,
    dialect: str | None = None,
    setup: Path | None = None,
    moves: bool = False,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """What an NC program means: its moves as tool-tip positions, times, extents, remarks.

    Parameters
    ----------
    program
        NC program.
    dialect
        How it is written: fanuc, fanuc-lathe, linuxcnc ...; default: that of the set-up file, else guessed.
    setup
        Set-up file (setup/1): work offsets, tools, reference points. Without it: zero, and tools unknown.
    moves
        Print every move.
    json
        Print one JSON document.
    """
    from vcmm.cli.common import document, print_json, say
    from vcmm.files.setup import load_setup
    from vcmm.nc.interpret import read_program
    from vcmm.nc.summary import summary

    loaded = load_setup(setup) if setup else None
    found = read_program(program, dialect, loaded)
    if found.dialect_reason and not json:
        say(f"dialect {found.dialect}: {found.dialect_reason}")
    total = summary(found.moves, loaded)
    if json:
        files = [program] + ([setup] if setup else [])
        print_json(document("vcmm.nc/1", {}, files=files) | nc_json(found, total))
    else:
        _show(program, found, total, moves)
    return 0


def nc_json(found: Any, total: Any) -> dict[str, Any]:
    """The body of the JSON document."""
    warnings = [{"line": w.line, "column": w.column, "text": w.text} for w in found.warnings]
    if found.dialect_reason:
        text = f"the dialect {found.dialect} was guessed: {found.dialect_reason}"
        warnings.insert(0, {"line": 1, "column": 1, "text": text})
    return {
        "dialect": found.dialect,
        "moves": [move_json(m) for m in found.moves],
        "summary": total.as_json(),
        "tools": {str(number): name for number, name in found.tools.items()},
        "warnings": warnings,
    }


def move_json(m: Any) -> dict[str, Any]:
    """One move."""
    out: dict[str, Any] = {
        "type": m.kind, "line": m.source.line, "start_mm": list(m.start), "end_mm": list(m.end), "plane": m.plane,
        "centre_mm": list(m.centre) if m.centre else None, "turns": m.turns, "clockwise": m.clockwise,
        "feed_mm_min": m.feed, "spindle_rpm": m.spindle, "tool": m.tool, "compensation": m.compensation,
    }  # fmt: skip
    if any(m.rotary_start) or any(m.rotary_end):
        out |= {"rotary_start_rad": list(m.rotary_start), "rotary_end_rad": list(m.rotary_end)}
    if m.kind == "dwell":
        out["seconds"] = m.seconds
    return out


def _show(program: Path, found: Any, total: Any, moves: bool) -> None:
    from vcmm.cli.common import show_table

    if moves:
        rows = [_row(m) for m in found.moves]
        show_table(
            f"{program.name}: moves",
            ["line", "move", "start", "end", "centre", "feed", "tool"],
            rows,
            left=(1,),
        )
    rows = [[kind, str(n), f"{total.lengths[kind]:.3f} mm"] for kind, n in total.counts.items()]
    show_table(
        f"{program.name}: {len(found.moves)} moves, dialect {found.dialect}", ["move", "number", "path"], rows
    )
    show_table("", ["", "value"], [list(row) for row in total.rows(found)], left=(0, 1))
    if found.warnings:
        rows = [[f"{program.name}:{w.line}:{w.column}", w.text] for w in found.warnings]
        show_table("remarks", ["where", "what"], rows, left=(0, 1))


def _row(m: Any) -> list[str]:
    def point(p: Any) -> str:
        return " ".join(f"{v:.4f}" for v in p)

    kind = {None: m.kind, True: "arc G2", False: "arc G3"}[m.clockwise]
    centre = point(m.centre) if m.centre else f"{m.seconds:g} s" if m.kind == "dwell" else ""
    return [
        str(m.source.line),
        kind,
        point(m.start),
        point(m.end),
        centre,
        f"{m.feed:g}" if m.feed else "",
        str(m.tool),
    ]
