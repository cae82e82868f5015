"""O-words of LinuxCNC."""

from __future__ import annotations

from tests.program.meanings import ends
from vcmm.program.interpret import interpret


def test_o_words():
    text = (
        "G21 G0\no1 sub\no2 if [#1 GT 2]\nX#1\no2 elseif [#1 EQ 2]\nY#1\no2 else\nZ#1\no2 endif\no1 endsub\n"
        "#10=0\no3 while [#10 LT 4]\n#10=[#10+1]\no4 if [#10 EQ 3]\no3 continue\no4 endif\no1 call [#10]\no3 endwhile\n"
        "o5 repeat [2]\nG91 X1\no5 endrepeat\no6 do\n#10=[#10-1]\nX1\no6 while [#10 GT 2]\nM2"
    )
    assert ends(interpret(text, "linuxcnc").moves) == [
        (0, 0, 1), (0, 2, 1), (4, 2, 1), (5, 2, 1), (6, 2, 1), (7, 2, 1), (8, 2, 1),
    ]  # fmt: skip
