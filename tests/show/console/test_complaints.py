"""Complaints about numbers get the file and the line of what they are about."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.program.faults import ProgramLimit, refuse
from vcmm.program.moves import Source
from vcmm.show.console.complaints import about

TEXT = 'vcmm = "scenario/1"\n[plan]\na = 1\n[pose]\nshift = "0 0 0 mm"\n[cut]\nb = 2\n'


@pytest.mark.parametrize(
    ("error", "table", "line"),
    [(UsageError, "", 2), (ModelLimit, "", 4), (ModelLimit, "cut", 6), (UsageError, "placement", 2)],
)
def test_the_line_of_the_table(tmp_path, error, table, line):
    file = tmp_path / "s.toml"
    file.write_text(TEXT)
    with pytest.raises(error, match=rf"s\.toml:{line}: too far$"), about(file, table):
        raise error("too far")


def test_what_knows_its_line_keeps_it(tmp_path):
    with pytest.raises(DataError, match=r"^e.csv:3: no number$"), about(tmp_path / "none.toml"):
        raise DataError("e.csv:3: no number")


def test_a_refusal_of_the_program_keeps_the_line_of_the_program(tmp_path):
    with (
        pytest.raises(ProgramLimit, match=r"^part.nc:21:1: an arc; use less\.$"),
        about(tmp_path / "none.toml", "cut"),
    ):
        refuse("part.nc", Source(21, 1, 1), "an arc", "use less")
