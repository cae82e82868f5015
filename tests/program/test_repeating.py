"""Programs that never end are told from those that only run long, by the state of the control alone."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from tests.hostile.corpus import BARE, SETUP
from tests.hostile.judge import ask, inside
from vcmm.program import repeating
from vcmm.program.faults import ProgramFault
from vcmm.program.interpret import interpret
from vcmm.program.repeating import FIRST, RepeatedStates, content_of
from vcmm.program.setup import Setup

ISO = "%\nO1\nG21 G90 G94 G54\nT1 M6\nG43 H1\nS1000 M3\nG0 X0 Y0 Z5\n{}\nM30\n%\n"
SIN = "G17 G90 G54 G71\nT1 D1\nM6\nS1000 M3\nG0 X0 Y0 Z5\n{}\nM30\n"
HEI = "BEGIN PGM S MM\nTOOL CALL 1 Z S4000\nQ1 = +1\nL X+0 Y+0 Z+5 R0 FMAX M3\n{}\nEND PGM S MM\n"


def said_of(folder, dialect: str, text: str):
    name = {"heidenhain": "p.h", "sinumerik": "p.mpf"}.get(dialect, "p.nc")
    (folder / "setup.toml").write_text(SETUP.replace("fanuc", dialect))
    (folder / "machine.toml").write_text(BARE)
    (folder / name).write_text(text)
    with inside(folder):
        return ask(("nc", name, "--setup", "setup.toml"))


@pytest.mark.parametrize(
    ("dialect", "text", "line"),
    [
        ("fanuc", ISO.format("N10 G1 X1 F100\nX2\nGOTO 10"), "p.nc:10:"),
        ("fanuc", ISO.format("#1=0\nWHILE [#1 LT 5] DO1\nG1 X1 F100\nX2\nEND1"), "p.nc:12:"),
        ("fanuc", ISO.format("N10 G91 G1 X0.25 F100\nX-0.25\nGOTO 10"), "p.nc:10:"),
        ("linuxcnc", ISO.format("o1 do\nG1 X1 F100\nX2\no1 while [1]"), "p.nc:11:"),
        ("okuma", ISO.format("V1=1\nN10 G1 X1 F100\nX2\nIF [V1 EQ 1] N10"), "p.nc:11:"),
        ("sinumerik", SIN.format("L1:\nG1 X1 F100\nX2\nGOTOB L1"), "p.mpf:9:"),
        ("sinumerik", SIN.format("R1=1\nREPEAT\nG1 X1 F100\nX2\nUNTIL R1<0"), "p.mpf:10:"),
        ("heidenhain", HEI.format("LBL 1\nL X+1 F300\nL X+2\nFN 9: IF +Q1 EQU +1 GOTO LBL 1"), "p.h:8:"),
    ],
)
def test_a_loop_that_comes_back_to_itself_is_refused_at_its_jump(dialect, text, line, tmp_path):
    answer = said_of(tmp_path, dialect, text)
    assert answer.code == 2
    assert f"vcmm: {line}" in answer.err
    assert "this loop is endless: position, variables and modes" in answer.err
    assert "clocks and signals of the machine stand still here" in answer.err


@pytest.mark.parametrize(
    ("dialect", "text", "lines"),
    [  # the same places again and again, but something counts: 2 moves per pass
        ("fanuc", ISO.format("#1=0\nWHILE [#1 LT 3000] DO1\nG1 X1 F100\nX2\n#1=#1+1\nEND1"), 6000),
        ("fanuc", ISO.format("#100=0\nN10 G1 X1 F100\nX2\n#100=#100+1\nIF [#100 LT 3000] GOTO 10"), 6000),
        ("linuxcnc", ISO.format("o1 repeat [3000]\nG1 X1 F100\nX2\no1 endrepeat"), 6000),
        ("sinumerik", SIN.format("FOR R3=1 TO 3000\nG1 X1 F100\nX2\nENDFOR"), 6000),
        ("sinumerik", SIN.format("DEF INT NN\nL1:\nG1 X1 F100\nX2\nNN=NN+1\nIF NN<3000 GOTOB L1"), 6000),
        ("heidenhain", HEI.format("LBL 1\nL X+1 F300\nL X+2\nCALL LBL 1 REP2999"), 6000),
        ("heidenhain", HEI.format("LBL 1\nL X+1 F300\nL X+2\nQ1 = Q1 + 1\nFN 12: IF +Q1 LT +3001 GOTO LBL 1"), 6000),
        # a mode that is no variable ends it: the work offset that G10 moves is asked for with #5221 , in `whole` alone
        ("fanuc", ISO.format("N10 G1 X1 F100\nX2\nG10 L2 P2 X[#5241+0.0625]\nIF [#5241 LT 187.5] GOTO 10"), 6000),
    ],
)  # fmt: skip
def test_a_loop_that_counts_runs_to_its_end(dialect, text, lines, tmp_path):
    answer = said_of(tmp_path, dialect, text)
    assert answer.code == 0, answer.err
    assert f"line {lines}" in " ".join(answer.out.split())


@dataclass
class Sample:
    a: float = 1.0
    moves: list[int] = field(default_factory=list)
    inner: list[object] = field(default_factory=list)


def test_what_blocks_may_ask_counts_and_what_they_cannot_does_not():
    assert content_of(Sample(moves=[1])) == content_of(Sample(moves=[1, 2]))
    assert content_of(Sample()) != content_of(Sample(a=math.nextafter(1.0, 2.0)))
    assert content_of(Sample(inner=[np.zeros(2)])) != content_of(Sample(inner=[np.ones(2)]))
    assert content_of(0.0) != content_of(-0.0)  # 1/#1 would tell them apart
    assert content_of(1) != content_of(1.0)
    one = [1]
    assert content_of([one, one]) != content_of([[1], [1]])  # what is changed in one is changed in the other


def test_states_are_compared_with_the_one_kept_at_a_power_of_two():
    states = RepeatedStates()
    period = 5
    passes = (
        k for k in range(1, 10_000) if states.is_repetition(0, lambda p=k % period: p, lambda p=k % period: p)
    )
    assert next(passes) == FIRST + period


@pytest.mark.parametrize(
    ("dialect", "text", "waits"),
    [  # the machine ends them: a clock, an input, a variable that the operator sets, a timer, system data
        ("fanuc", ISO.format("#3002=0\nWHILE[#3002 LT 0.5]DO1\nEND1\nX7."), {"the clock #3002": 10}),
        ("fanuc", ISO.format("N10 IF[#1005 EQ 0]GOTO 10\nN20 IF[#1006 EQ 0]GOTO 20\nX7."), {"#1005": 8, "#1006": 9}),
        ("fanuc", ISO.format("N10 #3006=1(SET 510)\nIF[#510 NE 1]GOTO 10\nX7."), {"#510": 9}),
        ("sinumerik", SIN.format("WHILE $A_IN[1]==0\nENDWHILE\nX7"), {"the system variable $A_IN[1]": 7}),
        ("heidenhain", HEI.format("LBL 1\nFN 18: SYSREAD Q5 = ID2000 NR10\nFN 9: IF +Q5 EQU +0 GOTO LBL 1\nL X+7"), {"SYSREAD ID2000 NR10": 7}),
    ],
)  # fmt: skip
def test_a_loop_that_waits_for_the_machine_is_left_and_told(dialect, text, waits):
    program = interpret(text, dialect, Setup(strict=False))
    assert program.moves[-1].end[0] == 7.0
    found = {a.what: a.line for a in program.assumed if a.what.startswith("the end of the wait")}
    assert found == {f"the end of the wait in line {line}, for {what}": line for what, line in waits.items()}


def test_a_wait_is_refused_where_nothing_is_assumed():
    with pytest.raises(ProgramFault, match=r"8:1.*waits for #510, which only the machine knows"):
        interpret(ISO.format("N10 IF[#510 NE 1]GOTO 10\nX7."), "fanuc", Setup(strict=True))


def test_what_was_asked_outside_a_loop_does_not_make_it_a_wait():
    with pytest.raises(ProgramFault, match=r"10:1.*endless"):
        interpret(ISO.format("#101=#510\nN10 G1 X1. F100\nGOTO 10\nX7."), "fanuc")


def test_what_is_left_out_of_the_state_exists():
    """A name that no reader has would leave nothing out, without a word."""
    sources = "\n".join(p.read_text(encoding="utf-8") for p in Path(repeating.__file__).parent.rglob("*.py"))
    for name in repeating.OUTSIDE_STATE:
        made = rf"self\.{name}\b[^=\n]*=(?!=)|^    {name}: |cached_property\n    def {name}\("
        assert re.search(made, sources, re.MULTILINE), name
