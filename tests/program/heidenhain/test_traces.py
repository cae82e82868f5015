"""Where words of a Klartext block stand, and how it reads written out."""

from __future__ import annotations

from vcmm.program.interpret import interpret

TEXT = """BEGIN PGM A MM
Q1 = 2.5
LBL 1
L IX+Q1 Y-3,25 F100
CALL LBL 1 REP 1
CC X+0 Y+0
CP IPA+90 Z-1 DR+
END PGM A MM
"""


def program():
    return interpret(TEXT, "heidenhain", trace=True)


def test_words_and_values():
    traces = program().traces
    line, _, spiral = traces
    assert {k: (w.text, w.mode, w.plain) for k, w in line.words.items()} == {
        "path": ("L", "", False), "X": ("+Q1", "IC", False), "Y": ("-3,25", "", True), "F": ("100", "", True),
    }  # fmt: skip
    assert line.words["Y"].decimals == 2
    assert [t.runs for t in traces] == [2, 2, 1]
    assert (spiral.words["CC X"].text, spiral.words["CC path"].line) == ("+0", 6)


def test_blocks_written_out():
    lines = TEXT.splitlines()
    cuts = [
        (s.line, [f"{lines[c.line - 1][c.first - 1 : c.last - 1]}->{c.text}" for c in s.cuts])
        for s in program().steps
    ]
    loop = [(4, ["+Q1->+2.5"]), (5, ["CALL LBL 1 REP 1->"])]
    assert cuts[1:7] == [(2, ["Q1 = 2.5->"]), (3, ["LBL 1->"]), *loop, (3, ["LBL 1->"]), loop[0]]
