"""The counting itself, with documents written by hand in place of the command line."""

import json

import pytest

from referee import __main__ as command
from referee import count, files, table


def document(width, claimed, parts=3, p=0.9):
    """Answers of one circle's size: about the nominal, half a width to either side."""
    line = {
        "name": "size",
        "type": "size",
        "interval_mm": [30 - width, 30 + width],
        "coverage_shown": claimed,
        "why_not_shown": None if claimed else "too few",
        "decision": "conforms" if claimed else "undecided",
        "p_conform": p if claimed else None,
        "measured_mm": 30.0,
    }
    true = {"interval_mm": line["interval_mm"], "coverage_claimed": claimed, "reason": line["why_not_shown"]}
    return {
        "parts": [{"part": f"p{i}", "characteristics": [{**line, "true_value": true}]} for i in range(parts)]
    }


@pytest.mark.parametrize(("width", "claimed", "held"), [(1.0, True, 3), (1e-9, True, 0), (1.0, False, 0)])
def test_only_what_is_claimed_is_counted(monkeypatch, tmp_path, width, claimed, held):
    monkeypatch.setattr(files, "call", lambda *words: document(width, claimed))
    (row,) = count.evaluate(tmp_path, 1, "evaluate/arc30/lobes/exact", 3)
    assert (row["n"], row["claimed"], row["held"]) == (3, 3 * claimed, held)
    assert row["accepted"] == 3 * claimed


def test_probabilities_are_put_into_bins(monkeypatch, tmp_path):
    monkeypatch.setattr(files, "call", lambda *words: document(1.0, True))
    (row,) = count.decide(tmp_path, 1, "decide/arc30/lobes/exact", 3)
    assert row["characteristic"] == "size, p 0.8 to 0.95"
    assert row["claimed"] == pytest.approx(2.7)
    monkeypatch.setattr(files, "call", lambda *words: document(1.0, False))
    (row,) = count.decide(tmp_path, 1, "decide/arc30/lobes/exact", 3)
    assert (row["characteristic"], row["n"], row["claimed"]) == ("size, no p", 3, 0)


def test_a_counted_cell_is_not_counted_again(monkeypatch, tmp_path):
    calls = []

    def answer(*words):
        calls.append(words)
        return document(1.0, True)

    monkeypatch.setattr(files, "call", answer)
    words = [
        "--cells",
        "evaluate/arc30/*/exact",
        "--parts",
        "3",
        "--out",
        str(tmp_path / "o.jsonl"),
        "--shard",
        "2/5",
    ]
    command.main(words)
    cells = [json.loads(line)["cell"] for line in (tmp_path / "o.jsonl").read_text().splitlines()]
    assert cells == ["evaluate/arc30/lobes/exact", "evaluate/arc30/cusps/exact"]  # the 2nd and 7th of nine
    command.main(words)
    assert len(calls) == 2
    text = table.markdown(tmp_path / "o.jsonl")
    assert "| 1.000 | 0.292 to 1.000 |" in text  # 3 of 3: the share whose third power is 2.5 %


def test_a_failure_is_a_row_and_is_tried_again(monkeypatch, tmp_path):
    def fail(*words):
        raise RuntimeError("exit 2: no")

    monkeypatch.setattr(files, "call", fail)
    path = tmp_path / "o.jsonl"
    command.main(["--cells", "evaluate/arc30/lobes/exact", "--parts", "2", "--out", str(path)])
    assert "exit 2: no" in table.markdown(path)
    assert command.done_cells(path, 2, 1) == set()
