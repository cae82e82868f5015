"""Programs made to break readers: refused within seconds with their line."""

from __future__ import annotations

import time

import pytest

from vcmm.core.errors import DataError
from vcmm.nc.interpret import interpret
from vcmm.nc.setup import Setup

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
