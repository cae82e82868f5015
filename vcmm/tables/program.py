"""An NC program as tables: its moves, how many of each kind, where it goes, its time, and remarks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from vcmm.motion.toolpath import Toolpath, clock
from vcmm.nc.moves import Move, Program
from vcmm.nc.summary import ProgramSummary
from vcmm.tables.quantities import fixed
from vcmm.tables.table import NUMBER_TEXT, Column, ResultTable, entry, listing, records

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


def move_json(m: Move) -> dict[str, Any]:
    """One move; rotary axes, tool axes and the time of a dwell only where there are any.

    led: the points are those of the tip in the workpiece as it lies with the rotary axes at zero.
    """
    out = records(MOVES, [m])[0]
    if any(m.rotary_start) or any(m.rotary_end) or m.led:
        out["rotary_start_rad"] = _angles(m.rotary_start, m.tool_axis_start)
        out["rotary_end_rad"] = _angles(m.rotary_end, m.tool_axis_end)
    if m.led or m.tool_axis_end is not None:
        ways = (("tool_axis_start", m.tool_axis_start), ("tool_axis_end", m.tool_axis_end))
        out |= {name: None if way is None else list(way) for name, way in ways} | {"led": m.led}
    if m.kind == "dwell":
        out["seconds"] = m.seconds
    return out


def _angles(angles: Sequence[float], axis: Sequence[float] | None) -> dict[str, float] | None:
    """By axis; None where the tool points away from Z by angles that only the machine knows (it is not in the set-up)."""
    unknown = axis is not None and axis[2] < UPRIGHT and not any(angles)
    return None if unknown else dict(zip("ABC", angles))


def kinds(name: str, program: Program, total: ProgramSummary) -> ResultTable[Any]:
    """How many moves of each kind, and how long their path is."""
    rows = [[kind, str(n), f"{total.lengths[kind]:.3f} mm"] for kind, n in total.counts.items()]
    title = f"{name}: {len(program.moves)} moves, dialect {program.dialect}"
    return listing(title, ["move", "number", "path"], rows)


def extents(program: Program, total: ProgramSummary) -> ResultTable[Any]:
    return listing("", ["", "value"], total.rows(program), words=(0, 1))


def remarks(name: str, program: Program) -> ResultTable[Any]:
    rows = [[f"{name}:{w.line}:{w.column}", w.text] for w in program.warnings]
    return listing("remarks", ["where", "what"], rows, words=(0, 1))


def assumed(name: str, program: Program) -> ResultTable[Any]:
    """What the program lacks and was taken for granted."""
    rows = [[f"{name}:{a.line}", a.what, a.value] for a in program.assumed]
    return listing("assumed", ["where", "what", "taken"], rows, words=(0, 1, 2))


TIMES: tuple[Column[tuple[str, float, str]], ...] = (
    Column("", lambda row: row[0]),
    Column("time", lambda row: row[1], fixed(1, "s")),
    Column("", lambda row: row[2], RIGHT),
)


def times(path: Toolpath) -> ResultTable[tuple[str, float, str]]:
    """The cycle time and its parts by mode and by tool, s."""
    rows = [("cycle time", path.seconds, clock(path.seconds))]
    for what in ("mode", "tool"):
        for name, seconds in path.seconds_by(what).items():
            rows.append((f"{what} {name}", seconds, f"{seconds / path.seconds:.0%}" if path.seconds else "–"))
    return ResultTable("time by the time law", TIMES, rows)
