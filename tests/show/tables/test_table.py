"""A column is declared once and serves terminal, page, CSV and JSON."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass

from vcmm.show.tables.quantities import DEVIATION, LENGTH, fixed, in_file
from vcmm.show.tables.table import (
    COUNT,
    Column,
    ResultTable,
    csv_text,
    entry,
    html,
    in_terminal,
    listing,
    on_page,
    records,
    text,
    titled_html,
)


@dataclass(frozen=True)
class Measured:
    name: str
    unit: str
    value: float
    bias: float | None = None
    trials: int = 0


COLUMNS: tuple[Column[Measured], ...] = (
    Column("what", lambda m: m.name, key="name", csv="name"),
    Column("value", lambda m: m.value, LENGTH, key="value_{unit}", csv="value_mm", file=in_file(3)),
    Column("bias", lambda m: m.bias, DEVIATION, page_head="bias / {small}", on="page"),
    Column("trials", lambda m: m.trials, COUNT, csv="trials", on="terminal"),
    entry("trials", lambda m: m.trials),
)
ROWS = (Measured('bore "a", front', "mm", 30.0001234, -1.5e-4, 20_000), Measured("angle", "rad", math.pi / 2))
TABLE = ResultTable("Title", COLUMNS, ROWS, "Said.")


def test_the_terminal_has_units_in_its_cells():
    cells = in_terminal(TABLE)
    assert cells.heads == ["what", "value", "trials"]
    assert cells.rows == [['bore "a", front', "30.00012 mm", "20,000"], ["angle", "90.000000 deg", "–"]]
    assert cells.words == [0]


def test_the_page_has_units_in_its_headings():
    cells = on_page(TABLE)
    assert cells.heads == ["what", "value", "bias / µm"]
    assert cells.rows == [['bore "a", front', "30.00012", "−0.150"], ["angle", "90.000000°", "–"]]


def test_documents_have_values_of_the_inside_under_keys_with_their_unit():
    assert records(COLUMNS, ROWS) == [
        {"name": 'bore "a", front', "value_mm": 30.0001234, "trials": 20_000},
        {"name": "angle", "value_rad": math.pi / 2, "trials": 0},
    ]


def test_a_file_is_read_back_by_the_csv_module():
    read = list(csv.reader(io.StringIO(csv_text(TABLE))))
    assert read == [
        ["name", "value_mm", "trials"],
        ['bore "a", front', "30.000", "20000"],
        ["angle", "1.571", "0"],
    ]


def test_floats_of_a_file_have_six_digits_and_what_is_missing_is_empty():
    column: Column[float | None] = Column(None, lambda value: value, csv="x")
    assert csv_text(ResultTable("", [column], [1 / 3, math.inf, None])) == 'x\n0.333333\n""\n""\n'


def test_lines_of_fixed_width():
    shown = listing("Title", ("what", "um"), (("a", "1.5"), ("longer", "-10")), caption="Said.")
    assert text(shown) == "what     um\na       1.5\nlonger  -10"
    heading, table = titled_html(shown)
    assert "Title" in heading
    assert '<th scope="col" class="num">um</th>' in table
    assert "<caption>Said.</caption>" in table


def test_a_page_may_say_more_and_has_further_and_closing_rows():
    shown = ResultTable("", COLUMNS[:1], ROWS[:1], "in the terminal", "on the page")
    page = html(shown, emphasise=(0,), more=[["further"]], foot=[["total"]])
    assert "<caption>on the page</caption>" in page
    assert '<tr class="strong"><th scope="row">bore &quot;a&quot;, front</th></tr>' in page
    assert (
        '<tr><th scope="row">further</th></tr></tbody><tfoot><tr><th scope="row">total</th></tr></tfoot>'
        in page
    )


def test_numbers_stand_to_the_right():
    column: Column[float] = Column("x", lambda value: value, fixed(1))
    assert in_terminal(ResultTable("", [column], [1.0])).words == []
