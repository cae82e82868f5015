"""QS parameters: numbers by hand from "String parameters" of the TNC 640 manual."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

SURVEY = Setup(strict=False, tools={1: Tool(1, 50.0, 10.0)})
STRICT = Setup(strict=True, tools={1: Tool(1, 50.0, 10.0)})


def x_of(lines: str, setup: Setup = STRICT) -> float:
    """Where `L X+Q1` goes."""
    text = f"BEGIN PGM A MM\nTOOL CALL 1 Z S1000\n{lines}\nL X+Q1 R0 FMAX\nEND PGM A MM\n"
    return interpret(text, "heidenhain", setup).moves[-1].end[0]


@pytest.mark.parametrize(
    ("lines", "x"),
    [
        ('DECLARE STRING QS1 = "WORKPIECE"\nQ1 = STRLEN ( SRC_QS1 )', 9),
        ('QS1 = "ABC"\nQS2 = QS1 || "DE f"\nQ1 = STRLEN ( SRC_QS2 )', 7),
        ('QS1 = "-12.5"\nQ1 = TONUMB ( SRC_QS1 )', -12.5),
        ('QS1 = "X=40 mm"\nQS2 = SUBSTR ( SRC_QS1 BEG2 LEN2 )\nQ1 = TONUMB ( SRC_QS2 )', 40),
        ('QS1 = "ABCDABCD"\nQS2 = "CD"\nQ1 = INSTR ( SRC_QS1 SEA_QS2 BEG3 )', 6),
        ('QS1 = "ABCD"\nQS2 = "X"\nQ1 = INSTR ( SRC_QS1 SEA_QS2 BEG0 )', 4),  # not there: its length
        ('QS1 = "AB"\nQS2 = "AC"\nQ1 = STRCOMP ( SRC_QS1 SEA_QS2 )', -1),
        ("Q5 = 7.126\nQS1 = TOCHAR ( DAT+Q5 DECIMALS2 )\nQ1 = TONUMB ( SRC_QS1 )", 7.13),
        ("Q5 = 3\nQS1 = \"12345\"\nQS2 = SUBSTR ( SRC_QS1 BEG+Q5 LEN1 )\nQ1 = TONUMB ( SRC_QS2 )", 4),
    ],
)  # fmt: skip
def test_texts_become_numbers(lines: str, x: float):
    assert x_of(lines) == pytest.approx(x)


def test_a_program_is_called_by_its_text(tmp_path):
    (tmp_path / "HOLE.H").write_text("BEGIN PGM HOLE MM\nL X+33 R0 FMAX\nEND PGM HOLE MM\n")
    main = tmp_path / "a.h"
    text = 'BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nQS7 = "HO" || "LE.H"\nCALL PGM QS7\nEND PGM A MM\n'
    assert interpret(text, "heidenhain", STRICT, str(main)).moves[-1].end[0] == 33


@pytest.mark.parametrize(
    "lines", ["QS1 = SYSSTR ( ID10950 NR1 )\nQ1 = STRLEN ( SRC_QS1 )", "Q1 = STRLEN ( SRC_QS9 )"]
)
def test_what_is_not_known_is_told_and_refused_in_strict_reading(lines: str):
    assert x_of(lines, SURVEY) == 0
    with pytest.raises(DataError, match="not known here"):
        x_of(lines)
