"""Front-end for Sinumerik programs (840D sl, 828D, One): text -> canonical moves. The docs list the supported blocks."""

from __future__ import annotations

from dataclasses import replace

from vcmm.program.facing import with_angles
from vcmm.program.moves import Program
from vcmm.program.recorder import Recorder
from vcmm.program.setup import Setup
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.motion import SinumerikInterpreter
from vcmm.program.sinumerik.sections import sections_of
from vcmm.program.sinumerik.text import tokenize
from vcmm.program.tracer import Tracer, lines_with_ends

__all__ = ["read", "tokenize"]


def read(text: str, file: str, setup: Setup, trace: bool = False) -> Program:
    """Return the moves of a program. `file` is its name for messages.

    Raises ProgramFault (file, line, column, reason, fix) for what cannot be understood, and ModelLimit for a contour that
    the tool cannot follow. A tool change takes place at M6 where the program has M6 anywhere, else at T.
    """
    sections = sections_of(text, file)
    recorder = Recorder(file=file, setup=setup, dialect="sinumerik")
    if trace:
        recorder.tracer = Tracer([line for line, _ in lines_with_ends(text)])
    by_m6 = any(
        item.name == "M" and item.text in ("6", "06")
        for s in sections
        for b in s.blocks
        if not b.plain
        for item in b.items
    )
    interpreter = SinumerikInterpreter(recorder, by_m6)
    runner = SinumerikRunner(
        recorder, {s.name: s for s in sections[1:] if s.name}, interpreter.work, interpreter.short
    )
    runner.run_alone(sections[0])
    sections[0].tell_rest(recorder)
    program, face = recorder.program(file), interpreter.modes.last_face
    return program if face is None else replace(program, moves=with_angles(program.moves, face))
