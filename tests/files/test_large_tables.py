"""Tables of very many rows: the same columns, and the same words about what is wrong, as from the reader of small ones."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hostile.corpus import TOUCHES_CSV
from vcmm.core.errors import DataError
from vcmm.files import large_tables
from vcmm.files.columns import positions_of, read_csv
from vcmm.files.large_tables import ColumnSheet, read_table


@pytest.fixture
def pieces(monkeypatch):
    """Files of any size, five rows at a time."""
    monkeypatch.setattr(large_tables, "LARGE", 0)
    monkeypatch.setattr(large_tables, "PIECE", 5)


def put(folder, text: str):
    path = folder / "touches.csv"
    path.write_text(text)
    return path


def same(one, other) -> bool:
    return (
        all(np.array_equal(one.position[a], other.position[a]) for a in "XYZ")
        and one.columns.keys() == other.columns.keys()
        and all(np.array_equal(one.columns[c], other.columns[c]) for c in one.columns)
        and all(one.labels[c].tolist() == other.labels[c].tolist() for c in other.labels)
    )


@pytest.mark.parametrize(
    "text",
    [TOUCHES_CSV, TOUCHES_CSV.replace(",down,", ',"do,wn",'), TOUCHES_CSV.replace("\n", "\n# said\n\n")],
)
def test_pieces_give_the_run_of_the_whole(text, tmp_path, pieces):
    path = put(tmp_path, text)
    found, whole = read_table(path), read_csv(path)
    assert isinstance(found, ColumnSheet)
    assert found.count == 12
    assert same(positions_of(found, ("X", "Y", "Z")), positions_of(whole, ("X", "Y", "Z")))
    assert [found.at(k) for k in (0, 11)] == [whole.at(k) for k in (0, 11)]


PLAIN = """time_s,X_mm,temp_air_C,pose
0, 1.5 ,+20.25, a
1,-.5e-3,2e1,bb
2,3.,-273.15,
3,0.1,20,a
4,123456789.123456789,20,a
5,4.9e-324,20,a
"""


def test_numpy_reads_what_the_slow_way_reads_to_the_last_bit(tmp_path, pieces, monkeypatch):
    path = put(tmp_path, PLAIN)
    monkeypatch.setattr(large_tables, "PIECE", 2)
    quick, taken = large_tables._quick, []
    monkeypatch.setattr(large_tables, "_quick", lambda *given: taken.append(quick(*given)) or taken[-1])
    found = read_table(path)
    assert [one is not None for one in taken] == [True] * 3  # all but the piece of the header
    slow = read_csv(path)
    for name in ("time_s", "X_mm", "temp_air_C"):
        assert found.numbers(name).tobytes() == slow.numbers(name).tobytes()
    assert found.texts("pose").tolist() == slow.texts("pose").tolist() == ["a", "bb", "", "a", "a", "a"]
    assert list(found.lines) == slow.lines == [2, 3, 4, 5, 6, 7]


@pytest.mark.parametrize(
    "line",
    ["4_0,1,20,a", "\u0664,1,20,a", "4,1,20,'=a", '4,1,20,"a"', "# 4,1,20,a", "", "  ", "4,1,20", "4,1,20,a,b", "nan,1,20,a",
     "4,1e13,20,a", "4,1,-273.2,a", "4;1;20;a", "0x4,1,20,a", ",1,20,a", "4,1 2,20,a", "\ufeff4,1,20,a"],
)  # fmt: skip
def test_what_is_not_plain_goes_the_slow_way(line):
    header = ["time_s", "X_mm", "temp_air_C", "pose"]
    assert large_tables._quick(["3,1,20,a\n", "5,1,20,a\n"], header, ",") is not None
    assert large_tables._quick(["3,1,20,a\n", line + "\n", "5,1,20,a\n"], header, ",") is None


@pytest.mark.parametrize(
    ("old", "new"),
    [("\n50,", "\n5_0,"), ("\n50,", "\n1e400,"), ("\n50,", "\n50,50,"), ("20.5", "-400"), ("time_s,X_mm", "X_mm,X_mm"), (",down,", ',"down,')],
)  # fmt: skip
def test_what_is_wrong_is_said_in_the_same_words(old, new, tmp_path, pieces):
    path = put(tmp_path, TOUCHES_CSV.replace(old, new, 1))
    said = []
    for read in (read_table, read_csv):
        with pytest.raises(DataError) as error:
            positions_of(read(path), ("X", "Y", "Z"))
        said.append(error.value.problems[0])
    assert (
        said[0] == said[1] or '"' in new
    )  # a quotation mark that is not closed runs to the end of its piece
    assert "touches.csv:" in said[0]


def test_a_zero_byte_in_a_label_is_refused_as_in_a_small_table(tmp_path, pieces):
    """numpy drops zero bytes at the end of a text, so that "top" and "top\\0" were one label."""
    path = put(tmp_path, "".join(["X_mm,pose\n", *(f"{k},top\n" for k in range(7)), "7,top\0\n"]))
    for read in (read_table, read_csv):
        with pytest.raises(DataError, match=r"touches\.csv:9: this line contains a zero byte"):
            read(path)


def test_a_blank_line_between_texts_is_no_row(tmp_path, pieces):
    path = put(tmp_path, "pose\n" + "top\n" * 6 + " \t\n" + "top\n" * 3)
    found, slow = read_table(path), read_csv(path)
    assert found.texts("pose").tolist() == slow.texts("pose").tolist() == ["top"] * 9
    assert list(found.lines) == slow.lines


def test_small_files_are_read_as_before(tmp_path):
    assert not isinstance(read_table(put(tmp_path, TOUCHES_CSV)), ColumnSheet)


def test_parquet_holds_the_same(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import csv, parquet

    path = put(tmp_path, TOUCHES_CSV)
    table = csv.read_csv(path)
    parquet.write_table(table, tmp_path / "touches.parquet")
    found = read_table(tmp_path / "touches.parquet")
    assert same(positions_of(found, ("X", "Y", "Z")), positions_of(read_csv(path), ("X", "Y", "Z")))
    lacking = table.set_column(1, "X_mm", pyarrow.array([1.0, None, *[2.0] * 10]))
    far = table.set_column(1, "X_mm", pyarrow.array([1.0] * 11 + [1e300]))
    for bad, words in (
        (lacking, "touches.parquet:2: column X_mm has no value"),
        (far, "touches.parquet:12: 1e\\+300"),
    ):
        parquet.write_table(bad, tmp_path / "touches.parquet")
        with pytest.raises(DataError, match=words):
            read_table(tmp_path / "touches.parquet")
    (tmp_path / "touches.parquet").write_text("no")
    with pytest.raises(DataError, match="no Parquet file"):
        read_table(tmp_path / "touches.parquet")


ODD = ("nan", "-inf", "1_0", "\u0664", "'", '"', "#", "\n", "\r", " ", ",,", "1e400", "-1e13", "0x1", "1.", "+.5e-3", "\0", "=1", "1d3", "--1", "\u2003", "\x1c", "")  # fmt: skip


def test_two_hundred_mutations_are_read_or_refused_alike(tmp_path, pieces, monkeypatch):
    """What numpy's reader takes is what the slow way takes, with the same numbers; what either refuses, in the same words."""
    rng, quick = np.random.default_rng(5), large_tables._quick

    def outcome(path, reader):
        monkeypatch.setattr(large_tables, "_quick", reader)
        try:
            run = positions_of(read_table(path), ("X", "Y", "Z"))
        except DataError as error:
            return error.problems
        return [v.tobytes() for v in (*run.position.values(), *run.columns.values(), *run.labels.values())]

    for _ in range(200):
        at, gone = int(rng.integers(len(TOUCHES_CSV))), int(rng.integers(4))
        path = put(tmp_path, TOUCHES_CSV[:at] + str(rng.choice(ODD)) + TOUCHES_CSV[at + gone :])
        assert outcome(path, quick) == outcome(path, lambda *given: None)
