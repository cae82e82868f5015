"""The error table of a machine followed in time, with the numbers of the day."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.files.learned.dated_machine import _renew_table
from vcmm.files.own.known_errors import effects_of, read_error_file

TABLE = "X EXX\n0 0\n300 0.002\n600 0.004\n#\nC0Y\n12e-6\n"


def test_a_squareness_of_the_table_is_that_of_the_day(tmp_path: Path):
    """12 urad in the file and 3 urad since: 15 urad. EXX moves by 1 um at its second node: 0.002 + 0.001 mm."""
    (tmp_path / "errors.csv").write_text(TABLE)
    effects = {type(e).__name__: e for e in effects_of(read_error_file(tmp_path / "errors.csv"), False)}
    table, square = effects["ComponentTable"], effects["Squareness"]
    departure = np.array([0.0, 1e-3, 0.0, 3e-6])
    quantities = [
        SimpleNamespace(effect=table, parameter="values", id="t"),
        SimpleNamespace(effect=square, parameter="angle", id="s"),
    ]
    tracked = SimpleNamespace(rows={"t": slice(0, 3), "s": slice(3, 4)}, quantities=quantities)
    dated = SimpleNamespace(departure=departure, history=SimpleNamespace(tracked=tracked))
    files: dict[str, str] = {}
    done = _renew_table(
        dated, {"errors": {"table": "errors.csv"}}, tmp_path / "machine.toml", "of the day", files, "new.csv"
    )  # type: ignore[arg-type]
    (tmp_path / "new.csv").write_text(files["new.csv"])
    new = read_error_file(tmp_path / "new.csv")
    assert new.constants["C0Y"] == pytest.approx(15e-6)
    assert new.tables[0].values["EXX"] == pytest.approx([0.0, 0.003, 0.004])
    assert done == {table.id, square.id}
