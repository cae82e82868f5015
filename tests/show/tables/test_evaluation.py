"""Words about several parts."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import vcmm
from vcmm.files.own.library import example
from vcmm.show.pages.sheet import in_words
from vcmm.show.tables.evaluation import batch, part_table, values_csv, warnings_of_parts, wholes


def part(name: str, *warnings: str) -> Any:
    return SimpleNamespace(part=name, warnings=warnings)


def test_what_only_some_parts_say_stands_with_their_names() -> None:
    parts = [part("A", "cold room"), part("B", "cold room", "oval"), part("C", "cold room", "oval", "oval")]
    assert warnings_of_parts(parts) == ["cold room", 'part "B", "C": oval']
    assert warnings_of_parts([part("", "oval")]) == ["oval"]


def test_parts_as_wholes_are_counted_by_their_decision() -> None:
    joint = [SimpleNamespace(decision=d) for d in ("conforms", "undecided", "conforms")]
    parts: Any = [SimpleNamespace(part=n, joint=j) for n, j in zip("ABC", joint)]
    assert wholes(parts) == [
        "all tolerances together: 2 of 3 parts: conforms (A, C)",
        "all tolerances together: 1 of 3 parts: undecided (B)",
    ]
    assert wholes([SimpleNamespace(part="A", joint=None)]) == []


@pytest.mark.parametrize("known_bias", ["reported", "corrected"])
def test_a_bias_that_is_left_in_stands_in_the_interval_of_the_true_value(
    tmp_path: Path, known_bias: str
) -> None:
    """A steel ring of 50 mm at 22 degC reads 11.5e-6 * 2 * 50 mm = 1.15 µm too large."""
    text = (
        example("ring_gauge").read_text(encoding="utf-8").replace('part = "20.0 degC"', 'part = "22.0 degC"')
    )
    (tmp_path / "ring.toml").write_text(text.replace("seed = 1", f'seed = 1\nknown_bias = "{known_bias}"'))
    (tmp_path / "values.csv").write_text("characteristic,value_mm\ndiameter,50.0012\n")
    found = vcmm.evaluate(
        vcmm.load_scenario(tmp_path / "ring.toml"), values=tmp_path / "values.csv", trials=4000
    )
    table, several, row = part_table(found[0]), batch(found), values_csv(found).splitlines()[1].split(",")
    heads = {str(c.head) for c in table.columns}
    assert "true value from nominal" in heads
    assert table.title.endswith("the 95% interval of the true value")
    assert several.title.endswith("the 95% interval of the true value")
    if known_bias == "reported":
        # about what is indicated, and by 1.15 µm further on both sides: it holds 50.0012 mm - 1.15 µm
        assert float(row[4]) + float(row[5]) == pytest.approx(2 * 50.0012, abs=1e-4)
        assert float(row[4]) < 50.0012 - 1.15e-3 < float(row[5])
        assert "U + |bias| about the indicated value" in table.caption
        assert in_words(found[0].characteristics[0]).startswith("diameter = 50.0012 mm ± 0.0017 mm")
    else:
        assert float(row[4]) < 50.00005 < float(row[5])
        assert in_words(found[0].characteristics[0]).startswith("diameter = 50.00005 mm ± ")
