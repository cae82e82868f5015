"""Macro B and subprograms of Fanuc."""

from __future__ import annotations

from pathlib import Path

from vcmm.program.interpret import interpret


# -- flow ---------------------------------------------------------------------------------------------------------------
def test_subprograms_of_fanuc():
    text = "O1\nG21 G91 G0\nM98 P20 L3\nM98 P20020\nM30\nO20\nX1.\nM99\n"
    assert interpret(text, "fanuc").moves[-1].end[0] == 5  # 3 + 2 times


def test_a_subprogram_in_a_file_of_its_own(tmp_path: Path):
    (tmp_path / "O0020.nc").write_text("O0020\nG0 X7.\nM99\n")
    assert interpret("O1\nM98 P20\nM30", "fanuc", name=str(tmp_path / "main.nc")).moves[-1].end[0] == 7
    (tmp_path / "hop.ngc").write_text("o<hop> sub\nG0 X#1\no<hop> endsub [#1 * 2]\nM2\n")
    text = "G21\no<hop> call [4]\nG0 Y#<_value>\nM2"
    assert interpret(text, "linuxcnc", name=str(tmp_path / "main.ngc")).moves[-1].end == (4, 8, 0)


def test_macro_b():
    text = (
        "O1\nG21 G90 G0\n#100=0\nWHILE[#100 LT 3] DO1\n#100=#100+1\nX#100\nEND1\nIF[#100 EQ 3] GOTO 50\nX99.\nN50 Y[SQRT[16]*2]\n"
        "IF[#100 GT 2] THEN #101=7\nZ#101\nX#150\nG65 P9000 A1.5 I2. I4.\nM30\nO9000\nX#1 Y#4 Z#7\nM99\n"
    )
    moves = interpret(text, "fanuc").moves
    assert [m.end[0] for m in moves[:3]] == [1, 2, 3]
    assert [m.end for m in moves[3:]] == [
        (3, 8, 0),
        (3, 8, 7),
        (1.5, 2, 4),
    ]  # X#150 is vacant: no word at all


def test_modal_macro_after_every_motion():
    text = "O1\nG21 G90 G0\nG66 P9000 Z-5.\nX1.\nX2.\nG67\nX3.\nM30\nO9000\nG0 Z#26\nG0 Z0.\nM99\n"
    assert [(m.end[0], m.end[2]) for m in interpret(text, "fanuc").moves] == [
        (1, 0), (1, -5), (1, 0), (2, 0), (2, -5), (2, 0), (3, 0),
    ]  # fmt: skip
