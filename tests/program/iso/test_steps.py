"""How executed blocks read without expressions, calls and jumps."""

from __future__ import annotations

from vcmm.program.interpret import interpret

TEXT = """%
O1
#1=2.5
N10 G0 X[#1*2] Y1.25
M98 P20 L2
M30
O20
G1 Z-#1 F100.
M99
%
"""


def shown() -> list[tuple[int, int, list[str]]]:
    lines = TEXT.splitlines()
    steps = interpret(TEXT, "fanuc", trace=True).steps
    return [
        (s.line, s.call, [f"{lines[c.line - 1][c.first - 1 : c.last - 1]}->{c.text}" for c in s.cuts])
        for s in steps
    ]


def test_expressions_become_numbers_and_calls_go():
    inside = [(8, 1, ["Z-#1->Z-2.5"]), (9, 1, ["M99->"])]
    assert shown() == [
        (2, 0, []), (3, 0, ["#1=2.5->"]), (4, 0, ["X[#1*2]->X5."]), (5, 0, ["M98->", "P20->", "L2->"]), *inside, *inside, (6, 0, []),
    ]  # fmt: skip


def test_words_keep_their_columns_and_decimals():
    traces = interpret(TEXT, "fanuc", trace=True).traces
    word = traces[0].words["Y"]
    assert (word.first, word.last, word.text, word.plain, word.decimals) == (16, 21, "1.25", True, 2)
    assert not traces[0].words["X"].plain
    assert [t.runs for t in traces] == [1, 2, 2]
