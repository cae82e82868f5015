"""The door to the readers of all languages."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError, UsageError
from vcmm.program.dialects import check_name, names
from vcmm.program.interpret import interpret, read_program
from vcmm.program.setup import Setup


def test_named_by_the_call_by_the_set_up_or_guessed(tmp_path):
    text = "G21 F100\nG0 X1.\nM30"
    assert interpret(text, "linuxcnc").dialect == "linuxcnc"
    assert interpret(text, None, Setup(dialect="fanuc-lathe")).dialect == "fanuc-lathe"
    guessed = interpret("N1 TRANS X1\nG0 X1\nM30")
    assert guessed.dialect == "sinumerik"
    assert guessed.dialect_reason.startswith(
        "it has Sinumerik words (score 5); runner-up fanuc (1: nothing but words"
    )
    path = tmp_path / "a.ngc"
    path.write_text(text)
    assert read_program(path).dialect == "linuxcnc"


def test_a_program_read_in_the_wrong_dialect_names_the_likely_one(tmp_path):
    path = tmp_path / "part.h"
    path.write_text("BEGIN PGM A MM\nL X+1 FMAX\nEND PGM A MM")
    with pytest.raises(DataError, match="perhaps --dialect heidenhain"):
        read_program(path, "fanuc")


def test_names():
    assert {"fanuc", "fanuc-lathe", "linuxcnc", "sinumerik", "heidenhain"} <= set(names())
    with pytest.raises(UsageError, match='Did you mean "linuxcnc"'):
        check_name("linuxnc")


def test_a_program_for_another_kind_of_control_is_told_though_it_can_be_read(tmp_path: Path):
    """A lathe program under the set-up of a mill; a mill program with few signs is not doubted."""
    lathe = tmp_path / "turn.nc"
    lathe.write_text("O1\nG21 T0101\nG50 S2000\nG96 S200 M3\nG0 X50. Z2.\nG1 Z-10. F.2\nM30\n")
    read = read_program(lathe, None, Setup(dialect="fanuc", strict=False))
    assert read.warnings[0].text.startswith(
        "this was read as fanuc, that of the set-up; it looks like fanuc-lathe"
    )
    assert not [
        w for w in read_program(lathe, "fanuc-lathe", Setup(strict=False)).warnings if "looks like" in w.text
    ]


def test_what_is_no_program_is_refused_in_one_sentence(tmp_path: Path):
    letter, wide = tmp_path / "letter.nc", tmp_path / "wide.nc"
    letter.write_text("Dear colleague,\nplease find the drawing attached.\n")
    wide.write_bytes("G21 G90\nG0 X1.\n".encode("utf-16-le"))
    with pytest.raises(DataError, match=r"letter\.nc:1:1: no line of this text holds a word of a control"):
        read_program(letter)
    with pytest.raises(DataError, match=r"wide\.nc:1:1: this text seems to be UTF-16"):
        read_program(wide)
