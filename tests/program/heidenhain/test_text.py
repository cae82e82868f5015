"""Klartext tokens and formulas."""

from __future__ import annotations

import math

import pytest

from tests.program.heidenhain.klartext import ends, sample
from vcmm.program.heidenhain.reader import tokenize


def test_tokens_are_lossless():
    text = '1 BEGIN PGM A MM\r\n2 L X+Q12 IY-2,5 R0 FMAX M3 ; note ~\n3 ;a\rb\r\nTOOL CALL "A B" Z§\n'
    assert "".join(t.text for t in tokenize(text)) == text


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("2 + 3 * 4", 14), ("( 2 + 3 ) * 4", 20), ("- 2 + 5", 3), ("2 ^ 3", 8), ("SIN 30 * 2", 1), ("SQRT ( 9 + 16 )", 5), ("SQ 3", 9),
        ("INT 2.7", 2), ("FRAC 2.75", 0.75), ("ABS - 4", 4), ("NEG 4", -4), ("ATAN 1", 45), ("10 - 4 - 3", 3), ("SGN -5", -1),
        ("7 % 4", 3), ("COS 60 ^ 2", 0.25), ("PI", math.pi), ("- 3 ^ 2", -9),
    ],
)  # fmt: skip
def test_formulas(formula, value):
    assert math.isclose(ends(f"Q1 = {formula}\nL X+Q1 FMAX")[0][0], value, rel_tol=1e-12)


@pytest.mark.parametrize("name", ["CIRSTUD", "PROFILE", "metrologia_11"])
def test_samples_are_lossless(name):
    assert "".join(t.text for t in tokenize(sample(name))) == sample(name)
