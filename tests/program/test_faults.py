"""Faults carry their place as data."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError, ModelLimit
from vcmm.program.faults import BlockFault, ProgramFault, ProgramLimit, refuse
from vcmm.program.interpret import interpret
from vcmm.program.moves import Source
from vcmm.program.setup import Setup, Tool


def test_place_and_reason_of_a_fault():
    with pytest.raises(ProgramFault) as fault:
        interpret("G21\nG0 X1\nG1 F1 X#[1/0]\nM2", "linuxcnc", name="part.ngc")
    found = fault.value
    assert (found.file, found.line, found.column) == ("part.ngc", 3, 11)
    assert str(found) == f"part.ngc:3:11: {found.reason}"
    assert isinstance(found, DataError)


def test_place_of_a_limit():
    tooled = Setup(tools={1: Tool(1, diameter=10.0)})
    with pytest.raises(ProgramLimit) as limit:
        interpret("G21 F100\nT1 M6\nG41 D1\nG1 X1\nG1 X20\nM30", "fanuc", tooled, "part.nc")
    assert (limit.value.file, limit.value.line, limit.value.column) == ("part.nc", 4, 1)
    assert isinstance(limit.value, ModelLimit)
    with pytest.raises(ProgramLimit, match=r"^line 7: too narrow; use a smaller tool\.$"):
        refuse("", Source(7, 3, 9), "too narrow", "use a smaller tool")


def test_a_fault_of_a_block_waits_for_its_line():
    fault = BlockFault(12, "remove it")
    assert (fault.column, fault.text, str(fault)) == (12, "remove it", "remove it")
