"""Tables that are wider than the terminal: every number whole, names shortened in the middle."""

from __future__ import annotations

import re

from vcmm.show.console.terminal import show_table
from vcmm.show.console.widths import laid_out
from vcmm.show.tables.table import Cells, listing

HEADS = ["characteristic", "nominal", "y", "bias", "U", "k", "interval from nominal", "decision"]
NUMBERS = ["30.00000 mm", "29.99998 mm", "-0.02 um", "0.76 um", "1.96", "[-0.78, +0.74] um"]
NAMES = ["distance of bore A from the front face", "distance of bore B from the front face of the base"]


def test_numbers_stay_whole_at_80_columns_and_the_rest_follows_behind_the_names(capsys, monkeypatch):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "80")
    show_table(listing("found", HEADS, [[n, *NUMBERS, "does not conform"] for n in NAMES], words=(0, 7)))
    out = re.sub(r"\x1b\[\d*m", "", capsys.readouterr().out)
    assert max(map(len, out.splitlines())) <= 80
    assert all(out.count(number) == 2 for number in NUMBERS)  # one in each row
    assert "(continued)" in out
    assert "distance...ont face" in out
    assert "distance...the base" in out


def test_what_fits_is_left_as_it_is():
    cells = Cells(["name", "y"], [["bore", "1.0 mm"]], [0])
    (one,) = laid_out(cells, 4 + 6 + 2 * 3 + 1)
    assert (one.cells, one.widths) == (cells, (None, None))


def test_names_that_would_look_alike_are_wrapped_instead():
    names = ["distance of bore A from the front", "distance of bore B from the front"]
    cells = Cells(["name", "y"], [[name, "1.00000 mm"] for name in names], [0])
    (one,) = laid_out(cells, 16 + 10 + 2 * 3 + 1)
    assert [row[0] for row in one.cells.rows] == names
    assert one.widths == (16, 10)


def test_a_table_of_numbers_alone_is_split_between_columns():
    cells = Cells(["a", "b", "c"], [["1" * 30, "2" * 30, "3" * 30]])
    parts = laid_out(cells, 80)
    assert [part.cells.rows for part in parts] == [[["1" * 30, "2" * 30]], [["3" * 30]]]
    assert [part.widths for part in parts] == [(30, 30), (30,)]
