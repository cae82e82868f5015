"""Blocks with a slash in programs that are written out: what hangs on the switch is refused with its line."""

from __future__ import annotations

import pytest

from tests.compensation.mill import SETUP, run, scale
from vcmm.core.errors import DataError

HEAD = "%\nO1\nG21 G17 G40 G80 G90 G94 G54\nG0 X0 Y0 Z0\n"


def test_an_expression_behind_a_switch_is_named_by_its_line(tmp_path) -> None:
    text = f"{HEAD}#1=90\n/#1=100\nG1 X#1 F500\nM30\n%\n"
    with pytest.raises(DataError, match="is in a block with a slash") as caught:
        run(tmp_path, text, scale(100.0), SETUP)
    assert caught.value.line == 7
    assert f"{tmp_path / 'part.nc'}:7:" in str(caught.value)


def test_a_move_behind_a_slash_is_rewritten(tmp_path) -> None:
    found = run(tmp_path, f"{HEAD}/G1 X100. F500\nM30\n%\n", scale(100.0), SETUP)
    assert "/G1 X99.990 F500" in found.text
