"""An NC program as tables: its moves, their number by kind, its extents, its time, and remarks."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vcmm.show.tables.quantities import fixed
from vcmm.show.tables.table import NUMBER_TEXT, Column, ResultTable, entry, listing, records

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.program.moves import Move, Program
    from vcmm.program.summary import ProgramSummary
    from vcmm.shop.motion.toolpath import Toolpath

RIGHT = NUMBER_TEXT
UPRIGHT = 1.0 - 1e-15


def _point(p: Sequence[float]) -> str:
    return " ".join(f"{v:.4f}" for v in p)


def _centre_or_dwell(m: Move) -> str:
    return _point(m.centre) if m.centre else f"{m.seconds:g} s" if m.kind == "dwell" else ""


MOVES: tuple[Column[Move], ...] = (
    entry("type", lambda m: m.kind),
    Column("line", lambda m: m.source.line, RIGHT, key="line"),
    Column("move", lambda m: {None: m.kind, True: "arc G2", False: "arc G3"}[m.clockwise]),
    Column("start", lambda m: _point(m.start), RIGHT),
    Column("end", lambda m: _point(m.end), RIGHT),
    entry("start_mm", lambda m: list(m.start)),
    entry("end_mm", lambda m: list(m.end)),
    entry("plane", lambda m: m.plane),
    Column("centre", _centre_or_dwell, RIGHT),
    entry("centre_mm", lambda m: list(m.centre) if m.centre else None),
    entry("turns", lambda m: m.turns),
    entry("clockwise", lambda m: m.clockwise),
    Column("feed", lambda m: f"{m.feed:g}" if m.feed else "", RIGHT),
    entry("feed_mm_min", lambda m: m.feed),
    entry("spindle_rpm", lambda m: m.spindle),
    Column("tool", lambda m: m.tool, RIGHT, key="tool"),
    entry("compensation", lambda m: m.compensation),
)


def moves(name: str, program: Program) -> ResultTable[Move]:
    return ResultTable(f"{name}: moves", MOVES, program.moves)


def move_json(m: Move, axes: str = "ABC") -> dict[str, Any]:
    """Return one move; rotary axes, tool axes and the time of a dwell only where there are any.

    led: the points are those of the tip in the workpiece as it lies with the rotary axes at zero. axes: those of the machine.
    """
    out = records(MOVES, [m])[0]
    if any(m.rotary_start) or any(m.rotary_end) or m.is_tip_led:
        out["rotary_start_rad"] = _angles(m.rotary_start, m.tool_axis_start, axes)
        out["rotary_end_rad"] = _angles(m.rotary_end, m.tool_axis_end, axes)
    if m.is_tip_led or m.tool_axis_end is not None:
        ways = (("tool_axis_start", m.tool_axis_start), ("tool_axis_end", m.tool_axis_end))
        out |= {name: None if way is None else list(way) for name, way in ways} | {"led": m.is_tip_led}
    if m.over_face:
        out["over_face"] = True
    if m.work_spindle != 1:
        out["work_spindle"] = m.work_spindle
    if m.kind == "dwell":
        out["seconds"] = m.seconds
    return out


def _angles(angles: Sequence[float], axis: Sequence[float] | None, axes: str) -> dict[str, float] | None:
    """Return angles by axis; None where the tool points away from Z by angles that only the machine knows (it is not in the set-up)."""
    unknown = axis is not None and axis[2] < UPRIGHT and not any(angles)
    return None if unknown else {a: angle for a, angle in zip("ABC", angles) if a in axes or angle}


def kinds(name: str, program: Program, total: ProgramSummary) -> ResultTable[Any]:
    """Return how many moves of each kind, and how long their path is."""
    rows = [[kind, str(n), f"{total.lengths[kind]:.3f} mm"] for kind, n in total.counts.items()]
    title = f"{name}: {len(program.moves)} move{'s' * (len(program.moves) != 1)}, dialect {program.dialect}"
    return listing(title, ["move", "number", "path"], rows)


def extents(program: Program, total: ProgramSummary) -> ResultTable[Any]:
    return listing("", ["", "value"], total.rows(program), words=(0, 1))


def remarks(name: str, program: Program) -> ResultTable[Any]:
    """Return the remarks that `unused_table` does not hold."""
    texts = {u.text for u in program.unused}
    rows = [[f"{name}:{w.line}:{w.column}", w.text] for w in program.warnings if w.text not in texts]
    return listing("remarks", ["where", "what"], rows, words=(0, 1))


def unused_table(name: str, program: Program) -> ResultTable[Any]:
    """Return words that nothing uses, one row for each letter: first place, as written there, and number of lines."""
    rows: dict[str, list[Any]] = {}
    for u in program.unused:
        row = rows.setdefault(u.text, [f"{name}:{u.line}:{u.column}", u.word, 0])
        row[2] += 1
    listed = [[where, word, str(n)] for where, word, n in rows.values()]
    return listing("words that nothing uses, passed over", ["first", "word", "lines"], listed, words=(0, 1))


def assumption_table(name: str, program: Program) -> ResultTable[Any]:
    """Return the data that the program lacks and that were assumed."""
    rows = [[f"{name}:{a.line}", a.what, a.value] for a in program.assumed]
    return listing("assumed", ["where", "what", "taken"], rows, words=(0, 1, 2))


def travels(program: Program, machine: Machine) -> ResultTable[Any]:
    """Return the ranges of the axes, used and available."""
    rows = []
    for letter, axis in machine.axes.items():
        turning = letter in "ABC"
        index, scale, unit = "ABC".find(letter) if turning else "XYZ".find(letter), 1.0, "mm"
        if turning:
            scale, unit = 180.0 / math.pi, "deg"
        reached = [
            (m.rotary_end[index] if turning else m.end[index] + m.tool_offset[index]) * scale
            for m in program.moves
        ]
        low, high = (limit * scale for limit in axis.limits)
        inside = "yes" if low <= min(reached) and max(reached) <= high else "no"
        text = (
            f"{min(reached):.3f} to {max(reached):.3f} {unit}",
            "endless" if axis.is_endless else f"{low:.3f} to {high:.3f} {unit}",
        )
        rows.append([letter, *text, inside])
    return listing("", ["axis", "goes", "can go", "inside"], rows, words=(0, 3))


@dataclass(frozen=True)
class FolderRow:
    """Result of one program of a folder: exit 0 or 2; reason: why it was refused."""

    file: str
    dialect: str
    exit: int
    moves: int
    assumptions: int
    reason: str


FOLDER: tuple[Column[FolderRow], ...] = (
    Column("file", lambda row: row.file, key="file", csv="file"),
    Column("dialect", lambda row: row.dialect, key="dialect", csv="dialect"),
    Column("exit", lambda row: row.exit, RIGHT, key="exit", csv="exit"),
    Column("moves", lambda row: row.moves, RIGHT, key="moves", csv="moves"),
    Column("assumed", lambda row: row.assumptions, RIGHT, key="assumed", csv="assumed"),
    Column("reason", lambda row: row.reason, key="reason", csv="reason"),
)


def folder(title: str, rows: Sequence[FolderRow]) -> ResultTable[FolderRow]:
    return ResultTable(f"{title}: {len(rows)} programs", FOLDER, rows)


def outcome(row: FolderRow) -> str:
    """Return what became of a program: read, read with assumptions, no motion, refused."""
    if row.exit:
        return "refused"
    if not row.moves:
        return "no motion"
    return "read with assumptions" if row.assumptions else "read"


def folder_counts(rows: Sequence[FolderRow]) -> ResultTable[Any]:
    """Return how many programs of each dialect were read, read with assumptions, refused."""
    kinds = ("read", "read with assumptions", "no motion", "refused")
    counted = Counter((row.dialect or "not known", outcome(row)) for row in rows)
    dialects = sorted({d for d, _ in counted})
    out = [[d, *(str(counted[d, k]) for k in kinds)] for d in dialects]
    out.append(["all", *(str(sum(counted[d, k] for d in dialects)) for k in kinds)])
    return listing("programs", ["dialect", *kinds], out)


def reason_kind(reason: str) -> str:
    """Return a reason without place and numbers, so that equal ones count together."""
    plain = re.sub(r"^.*?:\d+:\d+: ", "", reason)
    plain = re.sub(r'"[^"]*"|#?<[^>]*>|[-+]?\d+(?:\.\d+)?', "…", plain)
    return re.split(r"[;(]|\. |, as in", plain)[0].strip()[:110]


def folder_reasons(rows: Sequence[FolderRow]) -> ResultTable[Any]:
    """Return the reasons of refusals, the most frequent first, with one program of each."""
    reasons: dict[str, list[FolderRow]] = {}
    for row in rows:
        if row.reason:
            reasons.setdefault(reason_kind(row.reason), []).append(row)
    ordered = sorted(reasons.items(), key=lambda item: (-len(item[1]), item[0]))
    return listing(
        "refused",
        ["number", "reason", "for example"],
        [[str(len(v)), k, v[0].file] for k, v in ordered],
        words=(1, 2),
    )


TIMES: tuple[Column[tuple[str, float, str]], ...] = (
    Column("", lambda row: row[0]),
    Column("time", lambda row: row[1], fixed(1, "s")),
    Column("", lambda row: row[2], RIGHT),
)


def times(path: Toolpath) -> ResultTable[tuple[str, float, str]]:
    """Return the cycle time and its parts by mode and by tool, s."""
    from vcmm.shop.motion.toolpath import clock  # the time law is loaded where a time is shown

    rows = [("cycle time", path.seconds, clock(path.seconds))]
    for what in ("mode", "tool"):
        for name, seconds in path.seconds_by(what).items():
            rows.append((f"{what} {name}", seconds, f"{seconds / path.seconds:.0%}" if path.seconds else "–"))
    return ResultTable("time by the time law", TIMES, rows)
