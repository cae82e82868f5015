"""Words of a line: replaced, added and dropped in the style of the line, by hand."""

from __future__ import annotations

import numpy as np

from tests.compensation.mill import SETUP
from vcmm.compensation.languages import LANGUAGES
from vcmm.compensation.source import source_text
from vcmm.compensation.wording import Wording
from vcmm.program.interpret import interpret

HEAD = "%\nO1\nG21 G17 G40 G80 G90 G94 G54\n"


def words(line: str) -> tuple[Wording, object]:
    """A wording of a program whose fourth line this is, and its trace."""
    text = f"{HEAD}{line}\nM30\n%\n"
    trace = interpret(text, "fanuc", SETUP, "part.nc", trace=True).traces[-1]
    return Wording(source_text(text, "part.nc"), LANGUAGES["fanuc"], (3, 4), np.zeros(3)), trace


def line(writing: Wording) -> str:
    return writing.lines()[3][0].rstrip("\n")


def test_a_number_changes_in_place() -> None:
    writing, trace = words("G1 X10. Y+20. F100 (A)")
    writing.word(3, trace, "X", 9.998, 10.0, False)
    writing.word(3, trace, "Y", 20.0101, 20.0, False)
    assert line(writing) == "G1 X9.998 Y+20.010 F100 (A)"


def test_a_number_that_is_right_stays_as_it_is_written() -> None:
    writing, trace = words("G1 X10. F100")
    writing.word(3, trace, "X", 10.0 + 1e-7, 10.0, False)
    assert line(writing) == "G1 X10. F100"


def test_a_new_word_stands_in_the_order_of_axes() -> None:
    writing, trace = words("G1 X10. Z5. F100")
    writing.word(3, trace, "Y", 0.004, 0.0, False)
    assert line(writing) == "G1 X10. Y0.004 Z5. F100"
    low, trace = words("g1 x10. f100")
    low.word(3, trace, "Y", 1.0, 0.0, False)
    assert line(low) == "g1 x10. y1.000 f100"


def test_a_word_goes_with_its_blank_and_blocks_keep_the_slash() -> None:
    writing, trace = words("/2 G1 X10. Y5. F100")
    writing.drop(3, trace.words["Y"])
    writing.insert(3, ["X1.", "Y2."])
    assert [text for text, index in writing.lines() if index == 3] == ["/2 G1 X10. F100\n", "/2 X1. Y2.\n"]


def test_an_expression_becomes_a_number_only_where_it_must() -> None:
    writing, trace = words("#1=10\nG1 X#1 F100")
    writing.word(4, trace, "X", 10.0, 10.0, False)
    assert writing.expressions == set()
    writing.word(4, trace, "X", 9.99, 10.0, False)
    assert writing.expressions == {4}


def test_a_word_of_a_block_that_has_none_of_its_kind_stands_behind_all_others() -> None:
    """`M8` ends at character 2: the word and its blank come after it, before the comment."""
    writing, trace = words("G1 X10. F100\nM8 (A)")
    writing.word(4, trace._replace(words={}), "Y", 0.004, 0.0, False)
    assert writing.lines()[4][0] == "M8 Y0.004 (A)\n"
