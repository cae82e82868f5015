"""Whole programs of the G-code family, and the short cut for plain lines."""

from __future__ import annotations

from tests.program.meanings import linuxcnc
from vcmm.program.setup import Setup


def test_block_delete():
    assert len(linuxcnc("G21\n/G0 X1\nG0 X2")) == 2
    assert len(linuxcnc("G21\n/G0 X1\nG0 X2", Setup(block_delete=True))) == 1
