"""Subprograms, loops and macros written out: each block with numbers of its own, and the same moves."""

from __future__ import annotations

from dataclasses import replace

import pytest
from mill import SETUP, body, run, scale

from vcmm.errors import DataError, ModelLimit
from vcmm.nc.interpret import interpret

HEAD = "%\nO1\nG21 G90 G54\n"


def go(tmp_path, text, machine=None, dialect="fanuc", **more):
    return run(tmp_path, text, machine or scale(100.0), replace(SETUP, dialect=dialect), **more)


def code(found) -> list[str]:
    """Lines of the new program without the mark and blank ones."""
    return [line.strip() for line in body(found) if line.strip()]


def test_a_subprogram_called_twice(tmp_path):
    # 100 mm at +100 um/m is 99.990; a second time 50 mm further on (G55 starts at 100 mm): 150 mm, of which 10 um belong to the setting
    text = (
        HEAD
        + "N5 G0 X0\nM98 P2 (first)\nG55 G0 X0\nM98 P2\nM30\nO2 (SUB)\nN10 G1 X50. F500 (cut)\nG0 X0\nN30 M99\n%\n"
    )
    lines = code(go(tmp_path, text))
    assert lines[4:] == [
        "(first)", "(FROM LINE 10, CALLED IN LINE 5)", "N10 G1 X49.995 F500 (cut)", "G0 X0", "(BACK AT LINE 6)", "G55 G0 X0",
        "(FROM LINE 10, CALLED IN LINE 7)", "G1 X49.995 F500 (cut)", "G0 X0", "(BACK AT LINE 8)", "M30", "%",
    ]  # fmt: skip


def test_a_macro_loop_becomes_numbers(tmp_path):
    text = HEAD + "#1=1\nWHILE[#1 LE 3]DO1\nG1 X[100*#1] F500 (row)\n#1=#1+1\nEND1\nM30\n%\n"
    found = go(tmp_path, text)
    assert [line for line in code(found) if line.startswith("G1")] == [
        "G1 X99.990 F500 (row)", "G1 X199.980 F500 (row)", "G1 X299.970 F500 (row)",
    ]  # fmt: skip
    assert not any("#" in line for line in code(found))
    assert any("written out" in w for w in found.warnings)


def test_macro_calls_with_arguments_and_increments(tmp_path):
    text = (
        HEAD
        + "G65 P9100 A100. B2.\nG65 P9100 A200. B3.\nM30\nO9100\nG1 X#1 Y[#2*10] F[#2*100]\nG91 X10.\nG90 M99\n%\n"
    )
    lines = code(go(tmp_path, text))
    assert "G1 X99.990 Y20. F200" in lines
    assert "G1 X199.980 Y30. F300" in lines
    assert lines.count("G91 X9.999") == 2


def test_o_words(tmp_path):
    text = "G21 G90 G54\no100 sub\nG1 X#1 F500 (go)\no100 endsub\no100 call [100]\no100 call [200]\no101 repeat [2]\nG91 G1 X10\nG90\no101 endrepeat\nM2\n"
    lines = code(go(tmp_path, text, dialect="linuxcnc"))
    assert [line for line in lines if line.startswith("G1")] == [
        "G1 X99.990 F500 (go)",
        "G1 X199.980 F500 (go)",
    ]
    assert lines.count("G91 G1 X9.999") == 2


def test_sinumerik_loops_repeats_and_subprograms(tmp_path):
    text = (
        "N10 G54 G90 R1=1\nG1 F500\nWHILE R1<3\n  X=R1*100 ; row\n  R1=R1+1\nENDWHILE\nPART: G91 X10\nG90\nREPEAT PART P=2\n"
        "SLOT(100)\nSLOT(200)\nN90 M30\nPROC SLOT(REAL px)\nG0 X=px\nG1 Y10 ; slot\nY0\nRET\n"
    )
    found = go(tmp_path, text, dialect="sinumerik")
    lines = code(found)
    assert "X=99.990 ; row" in lines
    assert "X=199.980 ; row" in lines
    assert lines.count("G91 X9.999") == 3
    assert [line for line in lines if line.startswith("G0")] == ["G0 X=99.990", "G0 X=199.980"]
    assert not any(word in line for line in lines for word in ("WHILE", "R1", "PROC", "SLOT("))


def test_klartext_labels(tmp_path):
    text = (
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n2 Q1 = 100\n3 L X+Q1 Y+0 R0 F500\n4 CALL LBL 1\n5 L X+200\n6 CALL LBL 1\n7 LBL 2\n"
        "8 L IX+10\n9 CALL LBL 2 REP 2\n10 M30\n11 LBL 1 ; slot\n12 L IY+10 ; along\n13 L IY-10\n14 LBL 0\n15 END PGM A MM\n"
    )
    found = go(tmp_path, text, dialect="heidenhain")
    lines = code(found)
    assert "3 L X+99.990 Y+0 R0 F500" in lines
    assert "5 L X+199.980" in lines
    assert lines.count("12 L IY+10 ; along") == 1  # the number stays unique
    assert lines.count("L IY+10 ; along") == 1
    assert [line for line in lines if "IX" in line] == ["8 L IX+9.999", "L IX+9.999", "L IX+9.999"]
    assert lines[-1] == "15 END PGM A MM"


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("fanuc", HEAD + "N1 M98 P2 L3\nN2 G1 X1. F100\nM30\nO2\nN7 G91 G1 X5. F100\nN8 G90\nM99\n%\n"),
        ("sinumerik", "N1 G54 G90\nN2 PART: G1 X5 F100\nN3 REPEAT PART P=2\nM30\n"),
    ],
)
def test_numbers_of_blocks_are_unique(tmp_path, dialect, text):
    import re

    found = go(tmp_path, text, dialect=dialect)
    numbers = [m[0] for line in code(found) if (m := re.match(r"N\d+\b", line))]
    assert len(numbers) == len(set(numbers))


def test_the_same_moves_before_correction(tmp_path):
    """Where nothing has to be corrected by more than a digit, the written-out program moves as the original."""
    text = (
        HEAD + "#1=0\nWHILE[#1 LT 4]DO1\nG2 X[10+#1] Y0 I[#1/3+1] J1. F500\nG1 Y[#1]\n#1=#1+1\nEND1\nM30\n%\n"
    )
    text = text.replace("G2 X[10+#1] Y0 I[#1/3+1] J1. F500", "G1 X[10+#1/3] F500")
    setup = replace(SETUP, dialect="fanuc")
    found = go(tmp_path, text, scale(0.001))
    old, new = (interpret(t, "fanuc", setup).moves for t in (text, found.text))
    assert len(old) == len(new)
    for a, b in zip(old, new):
        assert b.end == pytest.approx(a.end, abs=0.51e-3)
        assert a.feed == b.feed


def test_a_loop_that_grows_too_far_is_refused(tmp_path):
    text = HEAD + "#1=0\nWHILE[#1 LT 4000]DO1\nG1 X[#1/100] F500\n#1=#1+1\nEND1\nM30\n%\n"
    with pytest.raises(DataError, match=r"part\.nc:\d+.*--inline"):
        go(tmp_path, text)
    assert go(tmp_path, text, inline=2000).blocks.before == 4000


def test_lines_are_those_of_the_file(tmp_path):
    """Messages and the worst line name lines of the program, not of the written-out text."""
    text = HEAD + "G0 X0\nM98 P2 L2\nM30\nO2\nG1 X100. F500\nG0 X0\nM99\n%\n"
    found = go(tmp_path, text)
    assert found.before.line == 8
    assert max(found.source_lines) <= len(text.splitlines())


def test_a_subprogram_in_a_file_of_its_own(tmp_path):
    (tmp_path / "O0002.nc").write_text("O2\nG1 X100. F500\nM99\n")
    found = go(tmp_path, HEAD + "M98 P2\nM30\n%\n")
    assert "G1 X99.990 F500" in code(found)


def test_what_cannot_be_written_out_is_refused_with_its_line(tmp_path):
    """G92 in a subprogram sets the frame where the tool stands: after a correction that is elsewhere."""
    text = HEAD + "G0 X0\nM98 P2 L2\nM30\nO2\nG1 X100. F500\nG92 X0\nM99\n%\n"
    with pytest.raises(ModelLimit, match=r"part\.nc:\d+.*G92"):
        go(tmp_path, text)


def test_conditions_that_only_the_machine_knows(tmp_path):
    text = HEAD + "#1=0\nWHILE[#1 LT 3]DO1\nG31 X100. F500\n#1=#5061\nEND1\nM30\n%\n"
    with pytest.raises(DataError, match=r"part\.nc:6.*G31"):
        go(tmp_path, text)


def test_an_unknown_offset_in_a_subprogram_names_the_line_of_the_file(tmp_path):
    text = HEAD + "G0 X0\nM98 P2 L2\nM30\nO2\nG57 G1 X100. F500\nG0 X0\nM99\n%\n"
    with pytest.raises(DataError, match=r"part\.nc:8:.*G57"):
        go(tmp_path, text)
