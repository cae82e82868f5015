"""The door to the readers of all languages."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError, UsageError
from vcmm.nc.dialects import check_name, names
from vcmm.nc.interpret import interpret, read_program
from vcmm.nc.setup import Setup


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
