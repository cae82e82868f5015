"""Where words of a Sinumerik block stand, and how it reads written out."""

from __future__ import annotations

from vcmm.program.interpret import interpret
from vcmm.program.sinumerik.blocks import parse_block
from vcmm.program.sinumerik.text import lines_of
from vcmm.program.sinumerik.traces import argument_spans, cycle_words, words_of

LINE = "N5 G2 X10 Y=IC(4.5) CR=R1 I1=AC(2)"


def test_words_and_values():
    words = words_of(parse_block(lines_of(LINE)[0], 3), LINE)
    shown = {k: (w.text, w.mode, w.plain, w.decimals, w.line) for k, w in words.items() if k != "G"}
    assert shown == {
        "X": ("10", "", True, None, 3), "Y": ("4.5", "IC", True, 1, 3), "R": ("R1", "", False, None, 3), "I1": ("2", "AC", True, None, 3),
    }  # fmt: skip
    assert LINE[words["Y"].begin - 1 : words["Y"].end - 1] == "4.5"


def test_arguments_of_a_cycle():
    line = "CYCLE81(10, 0,,R1*(2+1))"
    item = parse_block(lines_of(line)[0], 1).items[0]
    assert [line[a - 1 : b - 1] for a, b in argument_spans(item, line)] == ["10", "0", "", "R1*(2+1)"]
    assert set(cycle_words(item, line, 1)) == {"RTP", "RFP", "DP", "cycle"}


def test_blocks_written_out():
    text = 'R1=2\nMSG("PASS "<<R1)\nL_A: X=R1*2 G0\nGOTOF L_E\nX9\nL_E: M30'
    lines = text.splitlines()
    steps = interpret(text, "sinumerik", trace=True).steps
    cuts = [[f"{lines[c.line - 1][c.first - 1 : c.last - 1]}->{c.text}" for c in s.cuts] for s in steps]
    assert cuts == [
        ["R1=2->"], ['MSG("PASS "<<R1)->MSG("PASS "<<"2")'], ["R1*2->4", "L_A:->"], ["GOTOF L_E->"], ["L_E:->"],
    ]  # fmt: skip


def test_a_text_among_the_arguments_stays_and_an_empty_end_too():
    """CYCLE800 names the data set of the head: the expression beside it becomes a number, the text stays as it is."""
    text = 'N10 R1=30\nN20 CYCLE800(1,"TC,1",0,57,0,0,0,R1,0,0,0,0,0,-1,)\nN30 G0 X0\nM30\n'
    steps = interpret(text, "sinumerik", trace=True).steps
    (cut,) = next(s.cuts for s in steps if s.line == 2)
    assert cut.text == 'CYCLE800(1,"TC,1",0,57,0,0,0,30,0,0,0,0,0,-1,)'
    assert interpret(text.replace("R1,", "30,"), "sinumerik", trace=True).steps[1].cuts == ()
