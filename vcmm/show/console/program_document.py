"""Write the document vcmm.nc/1 move by move, so that a program of a million lines need not be held; whole or not at all."""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from vcmm.program.moves import ORIGIN, Move, MoveFlow
from vcmm.program.summary import SummaryBuilder


def move_text(move: Move, axes: str = "ABC") -> str:
    """Return one move as JSON, as tables.program.move_json returns it."""
    from vcmm.show.tables.program import move_json

    turned = (
        move.rotary_end != ORIGIN
        or move.rotary_start != ORIGIN
        or move.is_tip_led
        or move.tool_axis_end is not None
    )
    if turned or move.work_spindle != 1 or move.kind not in ("rapid", "line"):
        return json.dumps(move_json(move, axes), separators=(",", ":"), allow_nan=False)
    (a, b, c), (x, y, z) = move.start, move.end
    feed = "null" if move.feed is None else repr(move.feed)
    side = "null" if move.compensation is None else f'"{move.compensation}"'
    return (
        f'{{"type":"{move.kind}","line":{move.source.line},"start_mm":[{a!r},{b!r},{c!r}],"end_mm":[{x!r},{y!r},{z!r}],'
        f'"plane":"{move.plane}","centre_mm":null,"turns":{move.turns},"clockwise":null,"feed_mm_min":{feed},'
        f'"spindle_rpm":{move.spindle!r},"tool":{move.tool},"compensation":{side}}}'
    )


class MoveFile(MoveFlow):
    """The moves as a piece of JSON in a temporary file, and their totals."""

    def __init__(self, setup: Any, axes: str = "ABC") -> None:
        super().__init__()
        self.axes = axes
        self.setup = setup
        self.file = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115 (it lives as long as this)
        self.builder = SummaryBuilder(setup)

    def __enter__(self) -> MoveFile:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()

    def take(self, moves: Sequence[Move]) -> None:
        if not moves:
            return
        text = ",\n".join(move_text(m, self.axes) for m in moves)
        self.file.write((",\n" if self.count else "") + text)
        self.builder.add(moves)
        super().take(moves)

    def restart(self) -> None:
        super().restart()
        self.file.seek(0)
        self.file.truncate()
        self.builder = SummaryBuilder(self.setup)


def print_stream(head: dict[str, Any], moves: MoveFile) -> None:
    """Print the document on stdout: `head` with the moves behind its other keys."""
    text = json.dumps(head, indent=1, ensure_ascii=False, allow_nan=False)
    sys.stdout.write(text.rstrip()[:-1].rstrip() + ',\n "moves": [\n')
    moves.file.seek(0)
    shutil.copyfileobj(moves.file, sys.stdout, 1 << 20)
    sys.stdout.write("\n ]\n}\n")


def json_job(program: Path, dialect: str | None, setup: Any) -> int:
    """Read and print in one go. setup: with its level."""
    from vcmm.program.interpret import read_program

    with MoveFile(setup) as moves:
        read = read_program(program, dialect, setup, flow=moves)
        print_read(read, moves, [program], {})
    return 0


def print_read(read: Any, moves: MoveFile, files: Sequence[Path], more: dict[str, Any]) -> None:
    """Print a program whose moves have been written; more: further keys."""
    from vcmm.show.console.documents import document

    body = nc_json(read, moves.builder.total()) | more
    print_stream(document("vcmm.nc/1", {}, files=files) | body, moves)


def nc_json(read: Any, total: Any) -> dict[str, Any]:
    """Return the body of the JSON document but for the moves."""
    from vcmm.show.report.notices import notice

    warnings: list[dict[str, Any]] = [
        notice(w.text).document() | {"where": f"line {w.line}", "line": w.line, "column": w.column}
        for w in read.warnings
    ]
    if read.dialect_reason:
        text = f"the dialect {read.dialect} was guessed: {read.dialect_reason}"
        warnings.insert(0, notice(text).document() | {"where": "line 1", "line": 1, "column": 1})
    return {
        "dialect": read.dialect,
        "summary": total.as_json(),
        "tools": {str(number): name for number, name in read.tools.items()},
        "assumed": [{"line": a.line, "what": a.what, "value": a.value} for a in read.assumed],
        "unused": [{"line": u.line, "word": u.word, "text": u.text} for u in read.unused],
        "touches": [
            {
                "line": t.line,
                "tip_mm": list(t.tip),
                "along": list(t.along),
                "normal": list(t.normal),
                "tool": t.tool,
            }
            for t in read.touches
        ],
        "warnings": warnings,
        "warning_texts": [w["text"] for w in warnings],
    }


def time_json(path: Any) -> dict[str, Any]:
    """Return cycle time, by mode and by tool, and assumptions."""
    return {
        "seconds": path.seconds, "by_mode": path.seconds_by("mode"), "by_tool": path.seconds_by("tool"),
        "assumptions": list(path.assumptions),
    }  # fmt: skip
