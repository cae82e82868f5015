"""The frame of JSON documents, and the files that they name."""

from __future__ import annotations

import hashlib
import json
import math

import pytest

from vcmm import __version__
from vcmm.show.console.documents import document, json_text, print_json, sources


def test_frame(tmp_path, capsys):
    file = tmp_path / "a.toml"
    file.write_text("x = 1\n")
    content = document(
        "vcmm.x/1", {"u": [1.0, math.nan], "deep": {"v": math.inf}}, seed=3, files=[file], warnings=["w"]
    )
    digest = hashlib.sha256(b"x = 1\n").hexdigest()
    assert content == {
        "schema": "vcmm.x/1", "version": __version__, "seed": 3, "inputs": [{"file": str(file), "sha256": digest}],
        "warnings": [
            {"severity": "warning", "where": "", "text": "w", "cure": ""},
            {"severity": "error", "where": "", "text": "u[1] is nan", "cure": ""},
            {"severity": "error", "where": "", "text": "deep.v is inf", "cure": ""},
        ],
        "warning_texts": ["w", "u[1] is nan", "deep.v is inf"], "u": [1.0, None], "deep": {"v": None},
    }  # fmt: skip
    print_json(content)
    assert json.loads(capsys.readouterr().out) == json.loads(json_text(content)) == content


def test_a_file_that_is_named_twice_is_an_input_once(tmp_path):
    file = tmp_path / "machine.toml"
    file.write_text("x = 1\n")
    assert [i["file"] for i in document("vcmm.x/1", {}, files=[file, file])["inputs"]] == [str(file)]


def test_what_is_not_finite_never_reaches_a_file():
    with pytest.raises(ValueError, match="JSON"):
        json_text({"x": math.nan})


def test_sources_follow_files_that_name_files(tmp_path):
    for name, text in {
        "a.toml": 'machine = "b.toml"\nnot_there = "c.csv"\ntext = """\nlong.toml\n"""\n',
        "b.toml": '[errors]\ntable = "e.csv"\nback = "a.toml"\n',
        "e.csv": "C0Y\n0\n",
    }.items():
        (tmp_path / name).write_text(text)
    assert [p.name for p in sources(tmp_path / "a.toml")] == ["a.toml", "b.toml", "e.csv"]
