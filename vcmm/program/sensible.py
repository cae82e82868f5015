"""Checks of a program on this machine with this set-up: allowed by the language, but unusual in a shop."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from vcmm.core.machine import Machine
from vcmm.program.moves import Move, Program, Remark
from vcmm.program.setup import Setup, Tool

LINEAR, ROTARY = "XYZ", "ABC"
CUTS = ("line", "arc", "thread")
SLACK = 1e-6  # mm, rad


def without_length(moves: Sequence[Move], tools: Mapping[int, Tool]) -> Move | None:
    """Return the first cut with a tool whose length the program does not take into account; G1 that only positions is none."""
    for i, move in enumerate(moves):
        tool = tools.get(move.tool)
        cuts = move.kind in CUTS and tool is not None and tool.shape != "turning"
        if (
            cuts
            and tool is not None
            and tool.length
            and not any(move.tool_offset)
            and not _positions(moves, i)
        ):
            return move
    return None


def _positions(moves: Sequence[Move], index: int) -> bool:
    """Return whether a line before G43 only positions: Z has stood still since the tool change, and once the length is in force the tip stands
    no lower than where its next move ends."""
    move = moves[index]
    k = index
    while k >= 0 and moves[k].tool == move.tool:
        if abs(moves[k].start[2] - moves[k].end[2]) > SLACK or moves[k].kind not in (
            "line",
            "rapid",
            "dwell",
        ):
            return False
        k -= 1
    later = (m for m in moves[index + 1 :] if m.tool != move.tool or any(m.tool_offset))
    following = next(later, None)
    if following is None or following.tool != move.tool:
        return False
    return following.start[2] >= following.end[2] - SLACK


def length_missing(move: Move, tools: Mapping[int, Tool]) -> str:
    """Return the effect of such a cut, and the required statement."""
    name = move.tool or "spindle"
    return (
        f"line {move.source.line} of the program cuts with tool {move.tool} while no tool length is in force: the tool would "
        f'cut {tools[move.tool].length:g} mm too deep; add G43 H{move.tool}, or state length = "0 mm" in [tools.{name}] of '
        "the set-up where the work offset was set with this tool"
    )


def tools_without_length(program: Program, setup: Setup) -> tuple[Remark, ...]:
    """Return the Tools that cut or touch, are no turning tools and have no length in the set-up: 0 mm is assumed for each, with a remark."""
    first: dict[int, Move] = {}
    for move in program.moves:
        if move.kind in CUTS:
            first.setdefault(move.tool, move)
    out = []
    for number, move in first.items():
        tool = setup.tools.get(number)
        if tool is not None and not tool.length_stated and tool.shape != "turning" and tool.driven is None:
            text = (
                f"[tools.{number or 'spindle'}] of the set-up states no length: 0 mm is taken, so its errors are those of a Z as much lower, without "
                f'the arm of the tool; write length = "80 mm" ("0 mm" where the work offset was set with this tool)'
            )
            out.append(Remark(move.source.line, 1, text))
    return tuple(out)


def remarks_on(program: Program, setup: Setup, machine: Machine | None) -> tuple[Remark, ...]:
    """Return the tool lengths not in force, work offsets that the set-up does not name, ends of moves beyond the travels."""
    out, moves = list(tools_without_length(program, setup)), program.moves
    late = without_length(moves, setup.tools)
    if late is not None:
        out.append(Remark(late.source.line, 1, length_missing(late, setup.tools)))
    offsets: set[str] = set()
    for move in moves:
        if move.offset not in setup.offsets and move.offset not in offsets and move.kind in CUTS:
            offsets.add(move.offset)
            text = (
                f"work offset {move.offset} is not in the set-up: machine zero is taken; add it to [offsets]"
            )
            out.append(Remark(program.offsets.get(move.offset, move.source).line, 1, text))
    return (*out, *(_kind(moves, machine) if machine else ()), *(_beyond(moves, machine) if machine else ()))


def missing_axis_fault(axes: Collection[str], axis: str) -> str:
    """Return the fault of a word of an axis that the machine does not have."""
    has = " ".join(sorted(axes))
    return f"the machine has no axis {axis} (it has {has}), and its control stops here; take {axis} out, or name the right machine"


def without_axis(moves: Sequence[Move], axes: Collection[str]) -> tuple[Move, str] | None:
    """Return the first move that turns an axis which the machine does not have, and that axis."""
    lost = [(i, a) for i, a in enumerate(ROTARY) if a not in axes]
    for move in moves:
        for i, axis in lost:
            if move.rotary_start[i] != move.rotary_end[i]:
                return move, axis
    return None


def _kind(moves: Sequence[Move], machine: Machine) -> list[Remark]:
    """Return a program in ZX alone on a machine that has Y, and one with Y on a machine that has none."""
    cuts = [
        m for m in moves if m.kind in CUTS and not m.is_tip_led
    ]  # a path over the end face is one of C, not of Y
    if not cuts:
        return []
    across = next((m for m in cuts if abs(m.end[1] - m.start[1]) > SLACK), None)
    if across is not None and "Y" not in machine.axes:
        text = f"the program cuts along Y, and {machine.name} has no axis Y: a milling program on a lathe? Name another machine"
        return [Remark(across.source.line, 1, text)]
    turning = across is None and any(m.plane == "ZX" for m in cuts)
    if turning and machine.kind == "machine-tool" and "Y" in machine.axes:
        text = f"the program turns in the plane ZX and never cuts along Y: a lathe program on the mill {machine.name}? Name another machine"
        return [Remark(cuts[0].source.line, 1, text)]
    return []


def _beyond(moves: Sequence[Move], machine: Machine) -> list[Remark]:
    """Return the first move of each axis that ends outside its travel."""
    out: list[Remark] = []
    left = {a: machine.axes[a].limits for a in machine.axes}
    for move in moves:
        for letter, (low, high) in list(left.items()):
            turning = letter in ROTARY
            q = move.rotary_end[ROTARY.index(letter)] if turning else move.end[LINEAR.index(letter)]
            q += 0.0 if turning else move.tool_offset[LINEAR.index(letter)]
            if low - SLACK <= q <= high + SLACK:
                continue
            del left[letter]
            scale, unit = (57.29577951308232, "deg") if turning else (1.0, "mm")
            out.append(
                Remark(
                    move.source.line, 1,
                    f"axis {letter} is sent to {q * scale:.6g} {unit}, its travel is {low * scale:.6g} to {high * scale:.6g} {unit}; "
                    "check work offset and tool length",
                )
            )  # fmt: skip
    return out
