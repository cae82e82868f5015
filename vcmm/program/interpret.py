"""Read the text of an NC program, in any dialect, as a Program: entry to the readers of all languages."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from vcmm.core.errors import DataError, VcmmError
from vcmm.program.dialects import FRONT_ENDS, G_CODE_READER, TRACE_READERS, check_name, late
from vcmm.program.faults import ProgramFault
from vcmm.program.levels import demand
from vcmm.program.moves import MoveFlow, Program, Remark
from vcmm.program.reading import guess, read_bytes, runner_up
from vcmm.program.recognition import SURE, Candidate, candidates, kin
from vcmm.program.sensible import missing_axis_fault, tools_without_length, without_axis
from vcmm.program.setup import Setup

CLEAR = 8.0  # score of signs from which on they speak against what was said


def read_program(
    path: str | Path, dialect: str | None = None, setup: Setup | None = None, trace: bool = False,
    *, flow: MoveFlow | None = None,
) -> Program:  # fmt: skip
    """Read a program file. The dialect is the one named, else that of the set-up, else guessed (a remark says why).

    Raises DataError 'file:line:column: reason; what to do' and ModelLimit.
    """
    path = Path(path)
    text = read_bytes(path)
    choice = dialect or (setup.dialect if setup else None)
    if choice is None:
        return interpret(text, None, setup, str(path), trace, flow=flow)
    ranking = candidates(text, path)
    whose = "asked for" if dialect else "that of the set-up"
    try:
        read = interpret(text, dialect, setup, str(path), trace, flow=flow)
        return _doubt(read, f"this was read as {choice}, {whose}", choice, ranking)
    except DataError as error:
        raise _with_hint(error, f"{path} was read as {choice}, {whose}", choice, ranking) from None


def _with_hint(error: DataError, how: str, choice: str, ranking: list[Candidate]) -> DataError:
    """Return the refusal, with an additional sentence where the program looks like one of another control than the stated one."""
    likely = ranking[0].dialect if ranking else choice
    if likely == choice or ranking[0].score <= 1:
        return error
    return DataError([*error.problems, f"{how}; it looks like {ranking[0]}: perhaps --dialect {likely}"])


def _doubt(read: Program, how: str, choice: str, ranking: list[Candidate]) -> Program:
    """Add a remark where all signs are those of another kind of control than the stated one."""
    if not ranking or ranking[0].score < CLEAR or kin(ranking[0].dialect) == kin(choice):
        return read
    score = next((c.score for c in ranking if kin(c.dialect) == kin(choice)), 0.0)
    if score >= SURE * ranking[0].score:
        return read
    text = f"{how}; it looks like {ranking[0]}: perhaps --dialect {ranking[0].dialect}, or another set-up"
    return replace(read, warnings=(Remark(1, 1, text), *read.warnings))


def interpret(
    text: str,
    dialect: str | None = None,
    setup: Setup | None = None,
    name: str = "program",
    trace: bool = False,
    *,
    flow: MoveFlow | None = None,
) -> Program:
    """Return the meaning of a program text. `name` is used in messages; a file of that name has its subprograms beside it. flow: takes the
    moves as they come, and the Program has none."""
    setup = setup or Setup()
    chosen = dialect or setup.dialect
    if chosen is not None:
        return _read(text, check_name(chosen), setup, name=name, trace=trace, flow=flow)
    chosen, why = guess(text, Path(name))
    try:
        return replace(_read(text, chosen, setup, name=name, trace=trace, flow=flow), dialect_reason=why)
    except DataError:
        second = runner_up(text, Path(name))
        if second is None:
            raise
        if flow is not None:
            flow.restart()
        try:
            program = _read(text, second.dialect, setup, name=name, trace=trace, flow=flow)
        except DataError:
            program = None
        if program is None or not (program.moves or (flow and flow.count)):
            raise
    reason = f"it has {', '.join(second.signs[:4])}; as {chosen}, which has more signs, it cannot be read"
    return replace(program, dialect_reason=reason)


def read_for(
    job: str, text: str, dialect: str | None, setup: Setup, *, name: str = "program", trace: bool = False
) -> Program:
    """Return the program for a job whose answer depends on every number: no value is assumed. Where numbers are missing, DataError names
    each of them and how to give it; other faults are refused as they are. A tool without a length in the set-up
    is a remark."""
    try:
        read = interpret(text, dialect, replace(setup, strict=True), name, trace)
        return replace(read, warnings=(*read.warnings, *tools_without_length(read, setup)))
    except DataError as refusal:
        try:
            survey = interpret(text, dialect, replace(setup, strict=False), name)
        except VcmmError:
            choice = dialect or setup.dialect
            if choice is None:
                raise refusal from None
            whose = "that of the set-up" if choice == setup.dialect else "asked for"
            how = f"{name} was read as {choice}, {whose}"
            raise _with_hint(refusal, how, choice, candidates(text, Path(name))) from None
        demand(survey.assumed, name, job)
        raise


def check_unit(dialect: str, name: str) -> None:
    """Check the unit: languages whose programs state their unit take none from the set-up. Raises DataError."""
    how = {"heidenhain": "BEGIN PGM ... MM or INCH", "sinumerik": "G70, G71, G700 or G710"}.get(dialect)
    if how is not None:
        raise DataError(
            f"{name}:1:1: the set-up states a unit, but a {dialect} program says it itself ({how}); leave unit out"
        )


@contextmanager
def _no_search_for_rings() -> Iterator[None]:
    """Switch off the search for reference cycles: a program becomes very many small objects without cycles, and the search slows down
    with their number."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


@_no_search_for_rings()
def _read(text: str, dialect: str, setup: Setup, *, name: str, trace: bool, flow: MoveFlow | None) -> Program:
    if dialect not in FRONT_ENDS:
        program: Program = late(G_CODE_READER, "run")(text, dialect, setup, name, trace, flow=flow)
        return program
    if setup.unit is not None:
        check_unit(dialect, name)
    program = (TRACE_READERS if trace and dialect in TRACE_READERS else FRONT_ENDS)[dialect](
        text, name, setup
    )
    lost = None if setup.axes is None else without_axis(program.moves, setup.axes)
    if lost is not None and setup.axes is not None:
        move, axis = lost
        raise ProgramFault(name, move.source.line, move.source.first, missing_axis_fault(setup.axes, axis))
    if flow is None:
        return program
    flow.take(program.moves)
    return replace(program, moves=())
