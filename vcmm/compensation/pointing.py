"""Directions of the tool in a rewritten program: angles that only the machine knows, their correction, and its proof."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vcmm.compensation.field import PathErrors
from vcmm.compensation.orientation import oriented_source
from vcmm.compensation.source import SourceText, at_origin
from vcmm.core.errors import DataError, ModelLimit
from vcmm.core.machine import Machine
from vcmm.program.interpret import interpret
from vcmm.program.moves import Program
from vcmm.shop.motion.tool_centre import leads, orient_moves


def with_angles(read: Program, machine: Machine, name: str) -> Program:
    """Return the program with the angles of rotary axes that only the machine knows: tilted planes, directions of the tool."""
    if not leads(read.moves):
        return read
    moves, remarks = orient_moves(read.moves, machine, name)
    return replace(read, moves=moves, warnings=(*read.warnings, *remarks))


def correct_orientation(
    source: SourceText, read: Program, field: PathErrors, name: str, *, decimals: int | None, origin: Sequence[int], notes: list[str]
) -> tuple[SourceText, Program, PathErrors]:  # fmt: skip
    """Return the program with the words that turn the tool corrected, its meaning, and the errors along it; the tip is not yet corrected."""
    try:
        source, remarks = oriented_source(source, read, field, decimals)
    except (DataError, ModelLimit) as error:
        raise at_origin(error, source.name, origin) from None
    notes += remarks
    again = interpret(source.text, name, field.setup, source.name, trace=True)
    read = with_angles(again, field.known_errors.machine, source.name)
    return source, read, replace(field, moves=read.moves)
