"""Programs made to break readers: refused within seconds with their line."""

from __future__ import annotations

import time

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup

MANY, FEWER = 100_000, 20_000
CASES = {
    "brackets": ("fanuc", "G0 X" + "[" * MANY + "1" + "]" * MANY + "\nM30", "nested more than"),
    "signs": ("linuxcnc", "#1=" + "-" * FEWER + "1\nM2", "nested more than"),
    "operators": ("fanuc", "#1=1" + "+1" * FEWER + "\nM30", "operators in one block"),
    "functions": ("sinumerik", "R1=" + "ABS(" * FEWER + "1\nM30", "nested more than"),
    "comments": ("fanuc", "G0 X1 " + "(" * MANY + "\nM30", "never closed"),
    "repeats": ("linuxcnc", "o1 repeat [1000000000]\nG0 X1\no1 endrepeat\nM2", "repeated 1000000000 times"),
    "calls": ("fanuc", "O1\nM98 P2 L1000000000\nM30\nO2\nM99", "run 1000000000 times"),
    "nested calls": ("fanuc", "O1\nM98 P2 L9999\nM30\nO2\nM98 P3 L9999\nM99\nO3\nM99", "run 99980001 times"),
    "holes": ("fanuc", "G91 F100\nG81 X1. R1. Z-1. K1000000000\nM30", "repeats of a cycle"),
    "turns": ("linuxcnc", "G21 F100\nG2 X1 Y0 I1 J1 P1000000000\nM2", "turns"),
    "recursion": ("fanuc", "O1\nM98 P1\nM30", "call one another"),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_refused_at_once_with_its_line(name: str):
    dialect, text, words = CASES[name]
    began = time.process_time()
    with pytest.raises(DataError, match=rf"^bad:\d+:\d+: .*{words}"):
        interpret(text, dialect, Setup(strict=False), "bad")
    assert time.process_time() - began < 5.0


def test_recognition_of_one_long_line_is_linear():
    began = time.process_time()
    with pytest.raises(DataError, match="never closed"):
        interpret("(" * MANY, None, Setup(strict=False))
    assert time.process_time() - began < 5.0


HOLE = "CYCL DEF 201 Q200=2 Q201=-5 Q206=9 Q203=+0\n"


@pytest.mark.parametrize(
    ("dialect", "text", "line"),
    [
        ("heidenhain", f"{HOLE}CYCL DEF 221 Q225=+0 Q226=+0 Q237=1 Q238=1 Q242=1000000000 Q243=1 Q224=+0", 2),
        ("heidenhain", f"{HOLE}PATTERN DEF ROW1 (X+0 Y+0 D+1 NUM1000000000 ROT+0 Z+0)", 2),
        ("heidenhain", "CYCL DEF 200 Q200=2 Q201=-5 Q206=9 Q202=0.000000001 Q203=+0\nL X+1 FMAX M99", 2),
        ("heidenhain", "LBL 1\nL IX+1 FMAX\nCALL LBL 1 REP 1000000000", 3),
        ("sinumerik", "MCALL CYCLE81(9,0,1,-1)\nHOLES1(0,0,0,0,1,1000000000)", 2),
        ("sinumerik", "AA_1: G0 X1\nREPEATB AA_1 P=1000000000", 2),
        ("sinumerik", "FOR R1=1 TO 1000000000\nG0 X=R1\nENDFOR", 1),
        ("sinumerik", "L70 P1000000000\nM30\n%_N_L70_SPF\nG0 X1\nM17", 1),
    ],
)
def test_repetitions_are_bounded(dialect: str, text: str, line: int):
    with pytest.raises(DataError, match=rf"^t:{line}:\d+: .*repetitions are more than"):
        interpret(text, dialect, Setup(strict=False), "t")
