"""ISG error tables: read as controls write them; everything wrong is said with its line."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.files.foreign.isg import read_isg


def _write(tmp_path, text: str):
    path = tmp_path / "errors.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_tables_comments_separators_and_constants(tmp_path):
    path = _write(
        tmp_path,
        "// machine A\nX EXX EYX // mm\n0 0 0\n100; 0.001; -0.002\n\n# Y EYY\n0,0.5e-3\n50,1e-3\n#\nA0Z B0Z EC0Y\n1e-6 2e-6 3e-6\n",
    )
    read = read_isg(path)
    assert [t.arguments for t in read.tables] == [("X",), ("Y",)]
    assert read.tables[0].values["EYX"].tolist() == [0.0, -0.002]
    assert read.tables[1].grids[0].tolist() == [0.0, 50.0]
    assert read.tables[1].line == 6
    assert read.constants == {"A0Z": 1e-6, "B0Z": 2e-6, "C0Y": 3e-6}


def test_a_grid_in_any_order(tmp_path):
    rows = [(z, x, 10 * z + x) for z in (0, 1) for x in (0, 5, 9)]
    text = "Z X EBX\n" + "\n".join(" ".join(map(str, r)) for r in reversed(rows)) + "\n"
    table = read_isg(_write(tmp_path, text)).tables[0]
    assert [g.tolist() for g in table.grids] == [[0.0, 1.0], [0.0, 5.0, 9.0]]
    assert np.array_equal(table.values["EBX"], [[0, 5, 9], [10, 15, 19]])


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("X EXX\n0 0\n100 0\n50 0\n", 4, ["column X is not increasing: 50 after 100", "sort the rows"]),
        ("X EXX\n0 0\n100 0\n100 0\n", 4, ["100 after 100"]),
        ("X EXX\n0 0\n100 nan\n", 3, ["not finite"]),
        ("X EXX\n0 0\n100 0,5\n", 3, ["3 numbers where the header names 2"]),
        ("X EXX\n0 0\n100 abc\n", 3, ["not a number in 100 abc"]),
        ("X EXX\n", 1, ["has no rows"]),
        ("X EXQ\n0 0\n", 1, ['unknown error name "EXQ"', "EXX"]),
        ("X exx\n0 0\n", 1, ['Did you mean "EXX"']),
        ("EXX X\n0 0\n", 1, ["Axis letters come first"]),
        ("EXX EYX\n0 0\n", 1, ["EXX varies along X; put a column X before it"]),
        ("X C0Y\n0 0\n", 1, ["C0Y does not depend on a position"]),
        ("X Y\n0 0\n", 1, ["names axes but no error"]),
        ("X EXX EXX\n0 0 0\n", 1, ["EXX is given twice"]),
        ("X EXX\n0 0\n#\nX EXX\n0 0\n", 4, ["EXX is given twice, first in line 1"]),
        ("C0Y\n1e-6\n2e-6\n", 1, ["need one row, got 2"]),
        ("Z X EBX\n0 0 1\n0 5 1\n1 0 1\n", 1, ["3 rows do not fill the grid of 2 x 2 nodes over Z X"]),
        ("Z X EBX\n0 0 1\n0 5 1\n1 0 1\n0 5 2\n", 5, ["the node Z = 0, X = 5 is given twice"]),
        ("// nothing\n", 1, ["holds no table"]),
    ],
)
def test_what_is_refused(tmp_path, text, line, words):
    path = _write(tmp_path, text)
    with pytest.raises(DataError) as caught:
        read_isg(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:{line}: "), message
    assert all(word in message for word in words), message


def test_all_problems_at_once(tmp_path):
    path = _write(tmp_path, "X EXX EXQ\n0 0 0\n1 x 0\n#\nY EYY\n5 0\n0 0\n#\nC0Q\n1\n")
    with pytest.raises(DataError) as caught:
        read_isg(path)
    assert [p.removeprefix(f"{path}:").split(":")[0] for p in caught.value.problems] == ["1", "3", "7", "9"]


def test_files_that_cannot_be_read(tmp_path):
    _write(tmp_path, "")
    with pytest.raises(DataError, match=r'error.csv does not exist. Did you mean "errors.csv"'):
        read_isg(tmp_path / "error.csv")
    (tmp_path / "b.csv").write_bytes(b"X EXX\n\xff\xfe")
    with pytest.raises(DataError, match="is not UTF-8"):
        read_isg(tmp_path / "b.csv")
