"""Subprograms, loops and macros written out: each block with numbers of its own, and the same moves."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.compensation.mill import SETUP, body, run, scale
from vcmm.core.errors import DataError, ModelLimit
from vcmm.program.interpret import interpret

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
    fewer = text.replace("4000", "400")
    with pytest.raises(DataError, match="--inline"):
        go(tmp_path, fewer, inline=20)
    assert go(tmp_path, fewer, inline=2000).blocks.before == 400


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


@pytest.mark.thorough
def test_conditions_that_only_the_machine_knows(tmp_path):
    text = HEAD + "#1=0\nWHILE[#1 LT 3]DO1\nG31 X100. F500\n#1=#5061\nEND1\nM30\n%\n"
    with pytest.raises(DataError, match=r"part\.nc:6.*G31"):
        go(tmp_path, text)


def test_an_unknown_offset_in_a_subprogram_names_the_line_of_the_file(tmp_path):
    text = HEAD + "G0 X0\nM98 P2 L2\nM30\nO2\nG57 G1 X100. F500\nG0 X0\nM99\n%\n"
    with pytest.raises(DataError, match=r"part\.nc:8:.*G57"):
        go(tmp_path, text)


LOOP = "FOR R2=1 TO 2\nG1 X=10*R2 F500\nENDFOR\n"


@pytest.mark.parametrize(
    ("dialect", "text", "line", "what"),
    [
        ("fanuc", HEAD + "G0 X0\n/M98 P2 (ROUGH ONLY)\nM98 P2\nM30\nO2\nG91 G1 X5. F100\nG90\nM99\n%\n", 5, "M98"),
        ("fanuc", HEAD + "G0 X0\n/2 M98 P2\nM98 P2\nM30\nO2\nG91 G1 X5. F100\nG90\nM99\n%\n", 5, "M98"),
        ("fanuc", HEAD + "M98 P2 L2\nM30\nO2\nG91 G1 X5. F100\nG90\n/M99\nG1 X7.\nM99\n%\n", 9, "M99"),
        ("fanuc", HEAD + "#1=1\n/#1=5\nM98 P2 L2\nM30\nO2\nG91 G1 X#1 F100\nG90\nM99\n%\n", 5, "#1=5"),
        ("fanuc", HEAD + "G1 X1. F100\n/GOTO 20\nX5.\nN20 M98 P2 L2\nM30\nO2\nG1 X9.\nM99\n%\n", 5, "GOTO 20"),
        ("linuxcnc", "G21 G90 G54\no1 sub\nG1 X5 F100\no1 endsub\no1 call\n/o1 call\nM2\n", 6, "o1 call"),
        ("sinumerik", "G54 G90\n/ ROUGH\nG0 X100\nROUGH\nM30\nPROC ROUGH\nG91 G1 X20 F500\nG90\nRET\n", 2, "ROUGH"),
        ("sinumerik", "G54 G90\nR1=1\n/3 R1=5\nFOR R2=1 TO 2\nG1 X=R1*R2 F500\nENDFOR\nM30\n", 3, "R1=5"),
        ("sinumerik", "G54 G90\n" + LOOP + "/ M30\nX5\nM30\n", 5, "ends in a block"),
    ],
)  # fmt: skip
def test_what_hangs_on_a_slash_is_not_written_out(tmp_path, dialect, text, line, what):
    """With the switch of the control on, other blocks are executed: no text of single blocks can say both."""
    with pytest.raises(DataError, match=rf"part\.nc:{line}:.*slash") as found:
        go(tmp_path, text, dialect=dialect)
    assert what in str(found.value)


@pytest.mark.parametrize("slash", ["/", "/2 "])
@pytest.mark.parametrize("dialect", ["fanuc", "sinumerik"])
def test_a_slash_stays_with_every_block_that_stays(tmp_path, dialect, slash):
    """Motion, codes and a label behind a slash are written out with it, each time with its level."""
    call, sub, end = ("M98 P2 L2", "O2", "M99") if dialect == "fanuc" else ("PART P2", "PROC PART", "RET")
    text = f"G21 G90 G54\n{call}\nM30\n{sub}\nG1 X100. F500\n{slash}Y10. M8\n{slash}M9\nG0 X0 Y0\n{end}\n"
    text = text if dialect == "fanuc" else text.replace("G21", "G17").replace("PART P2", "PART\nPART")
    lines = code(go(tmp_path, text, dialect=dialect))
    assert lines.count(f"{slash}Y10. M8") == 2
    assert lines.count(f"{slash}M9") == 2


@pytest.mark.parametrize(
    ("dialect", "text", "line"),
    [
        ("sinumerik", "G54 G90\nR1=100\n/ R1=500\nG1 X=R1 F500\nM30\n", 4),
        ("fanuc", HEAD + "#1=100\n/ #1=500\nG1 X#1 F500\nM30\n%\n", 6),
        ("linuxcnc", "G21 G90 G54\n#1=100\n/#1=500\nG1 X#1 F500\nM2\n", 4),
    ],
)
def test_no_number_stands_for_what_hangs_on_a_slash(tmp_path, dialect, text, line):
    with pytest.raises(DataError, match=rf"part\.nc:{line}:.*line {line - 1}.*slash"):
        go(tmp_path, text, dialect=dialect)
    plain = text.replace("/", "")
    assert "499.950" in go(tmp_path, plain, dialect=dialect).text


def test_a_block_with_a_slash_beside_plain_numbers_stays(tmp_path):
    """An assignment behind a slash harms nothing where every corrected number is written as a number."""
    found = go(tmp_path, "G54 G90\n/ R1=500\nG1 X100 F=R1\n/ X200\nM30\n", dialect="sinumerik")
    assert code(found)[1:4] == ["/ R1=500", "G1 X99.990 F=R1", "/ X199.980"]


def test_every_pass_of_a_loop_is_announced(tmp_path):
    """An IF inside does not end the loop; the end of a WHILE announces nothing."""
    text = "G54 G90\nG1 F500\nFOR R1=1 TO 3\nIF R1==2\nM8\nENDIF\nX=R1*100\nENDFOR\nM30\n"
    lines = code(go(tmp_path, text, dialect="sinumerik"))
    assert [line for line in lines if "PASS" in line] == [
        "; FROM LINE 4 AGAIN, PASS 2", "; FROM LINE 4 AGAIN, PASS 3",
    ]  # fmt: skip
    text = "G54 G90\nG1 F500\nR1=1\nWHILE R1<3\nIF R1==2\nM8\nENDIF\nX=R1*100\nR1=R1+1\nENDWHILE\nM30\n"
    lines = code(go(tmp_path, text, dialect="sinumerik"))
    assert [line for line in lines if "PASS" in line] == ["; FROM LINE 4 AGAIN, PASS 2"]


def test_messages_say_the_numbers_of_their_pass(tmp_path):
    text = 'G54 G90\nG1 F500\nDEF INT NN\nFOR NN=1 TO 2\nMSG("PASS "<<NN<<" OF 2, R9 "<<R9)\nX=NN*100\nENDFOR\nMSG("NN<<1")\nM30\n'
    lines = code(go(tmp_path, text, dialect="sinumerik"))
    assert [line for line in lines if "MSG" in line] == [
        'MSG("PASS "<<"1"<<" OF 2, R9 "<<R9)', 'MSG("PASS "<<"2"<<" OF 2, R9 "<<R9)', 'MSG("NN<<1")',
    ]  # fmt: skip
