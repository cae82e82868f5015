"""Tables on stdout, remarks on stderr."""

from __future__ import annotations

from vcmm.show.console.terminal import SeldomSaid, progress, say, show_table
from vcmm.show.tables.table import listing


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
