"""Tables on stdout, also those that are wider than the terminal; remarks on stderr."""

from __future__ import annotations

import re

from vcmm.show.console.terminal import SeldomSaid, laid_out, progress, say, show_table
from vcmm.show.tables.table import Cells, listing

HEADS = ["characteristic", "nominal", "y", "bias", "U", "k", "interval from nominal", "decision"]
NUMBERS = ["30.00000 mm", "29.99998 mm", "-0.02 um", "0.76 um", "1.96", "[-0.78, +0.74] um"]
NAMES = ["distance of bore A from the front face", "distance of bore B from the front face of the base"]


def test_a_table_keeps_square_brackets_and_its_order(capsys):
    show_table(
        listing(
            "keys of [[effects]]", ["", "value"], [["a[down]", "1.5"], ["b", "-10"]], caption="Said [so]."
        )
    )
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert lines[0] == "keys of [[effects]]"
    first, second = (next(line for line in lines if word in line) for word in ("a[down]", "-10"))
    assert [line.split() for line in (first, second)] == [["a[down]", "1.5"], ["b", "-10"]]
    assert first.index("1.5") == second.index("-10")  # numbers end in one column
    assert "Said [so]." in [line.strip() for line in lines]


def test_remarks_and_progress_leave_stdout_alone(capsys):
    say("note")
    with progress() as report:  # stderr is no terminal here
        report("half", 0.5)
    out, err = capsys.readouterr()
    assert (out, err) == ("", "note\n")


def test_a_name_stays_on_one_line_and_words_behind_it_give_way(capsys):
    name, words = (
        "bore A to bore B of the base plate",
        "the repeatability of the machine along X, as stated " * 5,
    )
    show_table(listing("t", ["characteristic", "why"], [[name, words]]))
    lines = capsys.readouterr().out.splitlines()
    assert sum(name in line for line in lines) == 1
    assert max(len(line) for line in lines) <= 160
    assert sum("repeatability" in line for line in lines) >= 2


def test_a_long_job_says_a_line_a_minute(capsys):
    """Reports at 10, 59, 61, 100 and 130 s: lines at 61 s, and at 130 s, not before 121."""
    times = iter([0.0, 10.0, 59.0, 61.0, 100.0, 130.0])
    report = SeldomSaid(lambda: next(times))
    for text, share in (("a", 0.1), ("b", 0.5), ("c", 0.6), ("d", 0.7), ("descending", 0.9)):
        report(text, share)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == ["61 s: c, 60% of this step", "130 s: descending, 90% of this step"]


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
