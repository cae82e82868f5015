"""Where labels and programs stand in a text."""

from __future__ import annotations

from vcmm.program.interpret import interpret


def test_a_colon_is_a_program_number():
    assert interpret(":12\nM98 P13\nM30\n:13\nG0 X7.\nM99\n", "fanuc").moves[-1].end[0] == 7
