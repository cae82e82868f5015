"""The answer lines of a program: what was assumed, and where it can be stated."""

from __future__ import annotations

import pytest

from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup
from vcmm.program.summary import summary
from vcmm.show.report.answers import answer_text
from vcmm.show.tables.answers_machine import program_answers


@pytest.mark.parametrize(
    ("text", "line", "advice"),
    [
        (
            "G90 G0 X1.\nM30\n",
            "Assumed: once: to be confirmed",
            "mm; state it in a set-up file (--write-setup)",
        ),
        (
            "G21 G0 X1.\nM98 P7\nM98 P8\nM30\n",
            "Assumed: 2 times: to be confirmed",
            "are missing; refused by --strict",
        ),
    ],
)
def test_a_set_up_file_is_named_where_it_can_state_what_is_lacking(text, line, advice):
    """The unit stands in a set-up file; the moves of a subprogram that is not there do not."""
    program = interpret(text, "fanuc", Setup(strict=False))
    lines = answer_text(program_answers(program, summary(program.moves, Setup())))
    assert line in lines
    assert advice in lines
