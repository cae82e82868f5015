"""Repetitions that no program lives to see are refused at once, with their line."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.nc.interpret import interpret
from vcmm.nc.setup import Setup

HOLE = "CYCL DEF 201 Q200=2 Q201=-5 Q206=9 Q203=+0\n"


@pytest.mark.parametrize(
    ("dialect", "text", "line"),
    [
        ("heidenhain", f"{HOLE}CYCL DEF 221 Q242=1000000000 Q243=1 Q237=1", 2),
        ("heidenhain", f"{HOLE}PATTERN DEF ROW1 (X+0 Y+0 D+1 NUM1000000000 ROT+0 Z+0)", 2),
        ("heidenhain", "CYCL DEF 200 Q200=2 Q201=-5 Q206=9 Q202=0.000000001 Q203=+0\nL X+1 FMAX M99", 2),
        ("heidenhain", "LBL 1\nL IX+1 FMAX\nCALL LBL 1 REP 1000000000", 3),
        ("sinumerik", "MCALL CYCLE81(9,0,1,-1)\nHOLES1(0,0,0,0,1,1000000000)", 2),
        ("sinumerik", "AA_1: G0 X1\nREPEATB AA_1 P=1000000000", 2),
        ("sinumerik", "FOR R1=1 TO 1000000000\nG0 X=R1\nENDFOR", 1),
        ("sinumerik", "L70 P1000000000\nM30\n%_N_L70_SPF\nG0 X1\nM17", 1),
    ],
)
def test_refused_at_once(dialect: str, text: str, line: int):
    with pytest.raises(DataError, match=rf"^t:{line}:\d+: .*repetitions are more than"):
        interpret(text, dialect, Setup(strict=False), "t")
