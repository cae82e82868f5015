"""From the text of an NC program, in whatever dialect, to a Program: the door to the readers of all languages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from vcmm.core.errors import DataError
from vcmm.nc.dialects import FRONT_ENDS, G_CODE_READER, TRACED, check_name, late
from vcmm.nc.moves import Program
from vcmm.nc.reading import guess, read_bytes
from vcmm.nc.setup import Setup


def read_program(
    path: str | Path, dialect: str | None = None, setup: Setup | None = None, trace: bool = False
) -> Program:
    """Read a program file. The dialect is the one named, else that of the set-up, else guessed (a remark says why).

    Raises DataError 'file:line:column: reason; what to do' and ModelLimit.
    """
    path = Path(path)
    text = read_bytes(path)
    try:
        return interpret(text, dialect, setup, str(path), trace)
    except DataError as error:
        said = dialect or (setup.dialect if setup else None)
        likely, why = guess(text, path)
        if said is None or likely == said or why.startswith("nothing"):
            raise
        whose = "asked for" if dialect else "that of the set-up"
        hint = f"{path} was read as {said}, {whose}; {why}, which is {likely}: perhaps --dialect {likely}"
        raise DataError([*error.problems, hint]) from None


def interpret(
    text: str,
    dialect: str | None = None,
    setup: Setup | None = None,
    name: str = "program",
    trace: bool = False,
) -> Program:
    """The meaning of a program text. `name` stands in messages; a file of that name has its subprograms beside it."""
    setup = setup or Setup()
    chosen, why = dialect or setup.dialect, ""
    if chosen is None:
        chosen, why = guess(text, Path(name))
    check_name(chosen)
    if chosen in FRONT_ENDS:
        program = (TRACED if trace and chosen in TRACED else FRONT_ENDS)[chosen](text, name, setup)
    else:
        program = late(G_CODE_READER, "run")(text, chosen, setup, name, trace)
    return replace(program, dialect_reason=why) if why else program
