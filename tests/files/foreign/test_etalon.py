"""Etalon Exchange Format: the same machine as its ISG twin."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import data_file
from vcmm.core.errors import DataError
from vcmm.files.foreign.etalon import is_etalon, read_etalon

TEXT = "// c\n[C0Y]\nVALUE = 4.8e-6\n[EXX]\nGridpoints = {\n0.0 0.0\n100.0 0.0012\n} // end\n"


def test_constants_and_tables(tmp_path):
    path = tmp_path / "e.txt"
    path.write_text(TEXT)
    found = read_etalon(path)
    assert found.constants == {"C0Y": 4.8e-6}
    assert found.tables[0].values["EXX"].tolist() == [0.0, 0.0012]
    assert is_etalon(TEXT)
    assert not is_etalon("// c\nX EXX\n0 0\n")


def test_sample_file():
    found = read_etalon(data_file("data/formats/constructed/etalon_vendor.txt"))
    assert {name for t in found.tables for name in t.values} == {"EXX", "EBX"}
    assert np.isclose(found.constants["C0Y"], 4.8e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("100.0 0.0012", "0.0 0.0012"), "not increasing"),
        (("[EXX]", "[EXQ]"), "EXQ"),
        (("100.0 0.0012", "100,0 0.0012"), "is not a number"),
        (("} // end", ""), "no closing"),
        (("VALUE = 4.8e-6", "VALU = 4.8e-6"), "not understood"),
    ],
)
def test_mistakes_name_the_line(tmp_path, change, message):
    path = tmp_path / "e.txt"
    path.write_text(TEXT.replace(*change))
    with pytest.raises(DataError, match=message) as caught:
        read_etalon(path)
    assert f"{path}:" in str(caught.value)
