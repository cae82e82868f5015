"""What decides a diagnosis stands in one table with its reasons; the count of numbers in the room only falls."""

from __future__ import annotations

import re
from pathlib import Path

from tools import count_numbers

DECIDING, ELSEWHERE = 30, 230  # most that may decide, and most that may stand anywhere else
ROOT = Path(__file__).resolve().parents[2]


def test_few_numbers_decide_and_no_new_ones_come():
    found = list(count_numbers.numbers())
    deciding = [n for n in found if n.file == count_numbers.TABLE]
    assert 20 < len(deciding) <= DECIDING
    others = len(found) - len(deciding)
    assert others <= ELSEWHERE, "put what decides into constants.py with its reason; use what is there"


def test_every_constant_says_why_and_is_used():
    rows = count_numbers.table()
    assert [r.name for r in rows if len(r.reason) < 20] == []
    others = [p for p in count_numbers.ROOM.glob("*.py") if p.name != count_numbers.TABLE]
    text = "\n".join(p.read_text(encoding="utf-8") for p in others)
    own = (count_numbers.ROOM / count_numbers.TABLE).read_text(encoding="utf-8")
    used = [
        r.name
        for r in rows
        if re.search(rf"\b{r.name}\b", text) or len(re.findall(rf"\b{r.name}\b", own)) > 1
    ]
    assert used == [r.name for r in rows]


def test_the_page_shows_the_table_as_it_is():
    page = (ROOT / "docs" / "diagnose.md").read_text(encoding="utf-8")
    assert count_numbers.markdown() in page, "run python tools/count_numbers.py --table"
    found = list(count_numbers.numbers())
    assert count_numbers.kinds_markdown(found) in page, "run python tools/count_numbers.py --kinds"


def test_the_count_sees_numbers_and_leaves_out_columns_and_units(tmp_path):
    (tmp_path / "one.py").write_text(
        "A = 0.25\nB = x[:, 3:]\nC = 1e3 * x[4]\nD = f(7, -3)\nE = f'{x:.3g}'\nF = x[x > 5]\n"
    )
    found = [(n.line, n.value) for n in count_numbers.numbers(tmp_path)]
    assert found == [(1, 0.25), (4, 7.0), (4, 3.0), (6, 5.0)]
