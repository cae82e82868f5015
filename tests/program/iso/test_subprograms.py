"""Subprograms: where they are found, what a missing one is, and one that stands on its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret, read_program
from vcmm.program.setup import Setup

SURVEY = Setup(strict=False)
MAIN = "%\nO1\nG21 G90\nG0 X1.\nM98 P5001\nX3.\nM30\n%"


@pytest.mark.parametrize("name", ["O5001", "O5001.NC", "5001.nc", "o5001.txt", "sub/O5001.nc"])
def test_it_is_found_by_any_of_its_names(tmp_path: Path, name: str):
    (tmp_path / "main.nc").write_text(MAIN)
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("%\nO5001\nX2.\nM99\n%")
    assert [m.end[0] for m in read_program(tmp_path / "main.nc", "fanuc").moves] == [1, 2, 3]


def test_the_set_up_names_further_folders(tmp_path: Path):
    (tmp_path / "macros").mkdir()
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "main.nc").write_text(MAIN)
    (tmp_path / "macros" / "O5001.nc").write_text("O5001\nX2.\nM99\n")
    setup = Setup(subprograms=(tmp_path / "macros",))
    assert len(read_program(tmp_path / "p" / "main.nc", "fanuc", setup).moves) == 3


def test_a_missing_one_is_a_hole_with_its_line():
    program = interpret(MAIN, "fanuc", SURVEY)
    assert [m.end[0] for m in program.moves] == [1, 3]
    assert [(a.line, a.what, a.matters) for a in program.assumed] == [
        (5, "the subprogram O5001 (O5001.nc)", True)
    ]
    with pytest.raises(DataError, match=r"program:5:1: the subprogram O5001 is neither"):
        interpret(MAIN, "fanuc")


def test_one_on_its_own_is_read_as_one():
    program = interpret(
        "o<square> sub\nG1 F100 X10\nY[10 + #1]\no<square> endsub\n", "linuxcnc", Setup(strict=False)
    )
    assert [m.end[:2] for m in program.moves] == [(10, 0), (10, 10)]
    assert "the call of o<square>, a subprogram on its own" in {a.what for a in program.assumed}


def test_a_macro_without_its_arguments_is_read_as_far_as_it_goes():
    program = interpret("O9010\nG21 F100.\nG0 Z5.\nG1 X[10./#1]\nM99\n", "fanuc", SURVEY)
    assert len(program.moves) == 1
    (rest,) = [a for a in program.assumed if a.what.startswith("the rest")]
    assert rest.line == 4
    assert "division by zero" in rest.value


def test_a_block_of_the_caller_is_found_where_its_last_line_is_the_call() -> None:
    """The subprogram follows at once: N20 is looked for in the program that called, which goes on there."""
    text = "O1\nG0 X1\nGOTO 30\nN20 G0 X9\nM30\nN30 M98 P100\nO100\nG0 Y5\nM99 P20\n"
    assert [m.end[:2] for m in interpret(text, "fanuc").moves] == [(1.0, 0.0), (1.0, 5.0), (9.0, 5.0)]
