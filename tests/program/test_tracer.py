"""What is noted of every block: words, places, modal state."""

from __future__ import annotations

from tests.program.meanings import ONE
from vcmm.program.interpret import interpret


# -- traces and dialects ------------------------------------------------------------------------------------------------------
def test_traces_find_the_words():
    text = "O1\nG21 G90 F100.\nG1 X1.50 y-2.\nM98 P9 L2\nG81 X5. Z-1. R1.\nM30\nO9\nG91 G1 X1.\nG90\nM99\n"
    found = interpret(text, "fanuc", ONE, trace=True)
    assert len(found.traces) == len(found.moves)
    lines = text.split("\n")
    first = found.traces[0]
    x = first.words["X"]
    assert (lines[first.line - 1][x.first - 1 : x.last - 1], x.decimals, x.plain) == ("X1.50", 2, True)
    y = first.words["Y"]
    assert lines[first.line - 1][y.first - 1 : y.last - 1] == "y-2."
    assert first.transformation.undo(first.contour.end) == (
        1.5,
        -2,
        200,
    )  # the axis at 0 is at 200 in work coordinates
    assert first.transformation.shift == (100, 50, -200)
    assert (first.before.motion, first.after.motion) == ("G0", "G1")
    assert [t.runs for t in found.traces if t.line == 8] == [2, 2]
    assert not found.traces[1].after.absolute
    assert {t.cycle for t in found.traces if t.line == 5} == {"G81"}
    assert [m.end for m in found.moves] == [m.end for m in interpret(text, "fanuc", ONE).moves]
