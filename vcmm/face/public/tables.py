"""Tables of results: columns declared once for terminal, page, CSV and documents."""

from __future__ import annotations

from vcmm.core.text import csv_of
from vcmm.show.tables.quantities import fixed, percent
from vcmm.show.tables.table import NUMBER_TEXT, Column, ResultTable, Writing, html, text, titled_html
from vcmm.show.tables.uncertainty import characteristic_json

__all__ = [
    "NUMBER_TEXT",
    "Column",
    "ResultTable",
    "Writing",
    "characteristic_json",
    "csv_of",
    "fixed",
    "html",
    "percent",
    "text",
    "titled_html",
]
