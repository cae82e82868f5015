"""tools/identity.py tells a change of words from a change of results."""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

import identity


def digests(document: object) -> tuple[str, str]:
    text = identity._blank(json.dumps(document), "/nowhere")
    return identity._sha(text), identity._sha(identity._numbers(text))


def test_other_words_move_the_text_alone():
    one = digests({"text": "U is 0.72 um here", "u": 0.36})
    two = digests({"text": "here, U is 0.72 um", "u": 0.36})
    assert one[0] != two[0]
    assert one[1] == two[1]


def test_a_number_or_a_key_moves_both():
    one = digests({"u": 0.36})
    assert one[1] != digests({"u": 0.3600000000000001})[1]
    assert one[1] != digests({"U": 0.36})[1]
    assert one[1] != digests({"u": 0.36, "text": "2 um"})[1]


def test_what_passes_is_blanked():
    assert digests({"version": "0.1.0", "u": 1.0}) == digests({"version": "0.2.0", "u": 1.0})


def test_differences_are_named(capsys):
    before = {"a": {"exit": 0, "text": "1", "numbers": "1"}, "b": {"exit": 0, "text": "1", "numbers": "1"}}
    after = {"a": {"exit": 0, "text": "2", "numbers": "2"}, "b": {"exit": 0, "text": "2", "numbers": "1"}}
    assert identity.compare_digests(before, after) == 1
    out = capsys.readouterr().out
    assert "RESULT differs: a" in out
    assert "words alone differ: b" in out
