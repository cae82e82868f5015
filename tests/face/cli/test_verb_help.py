"""The page of `vcmm VERB --help`, which is read from source text, holds what the parser of the command line takes."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import pytest

from vcmm.face.cli import CODES, VERBS, build_app, verb_help

JOBS = [
    ["calibrate", job] for job in ("fit", "design", "simulate", "thermal", "nodes", "face", "compare")
]  # docs/calibrate.md
PAGES = [[verb] for verb in VERBS] + JOBS


def parameters_of(words: list[str]) -> dict[str, Any]:
    """What the parser takes: argument of each parameter of the function."""
    app = build_app()
    for word in words:
        app = app[word]
    if app.default_command is None:
        app = app.get(words[-1], app)
    return {a.field_info.name: a for a in app.assemble_argument_collection() if not a.keys}


def options_of(words: list[str]) -> list[verb_help.HelpOption]:
    here = Path(verb_help.__file__).parent
    source = here / (f"{words[0]}.py" if len(words) == 1 else f"{words[0]}_jobs.py")
    return verb_help.options_of(ast.parse(source.read_text(encoding="utf-8")), f"{words[-1]}_command")


@pytest.mark.parametrize("words", PAGES, ids=" ".join)
def test_the_page_has_what_the_parser_takes(words: list[str]):
    taken = parameters_of(words)
    shown = {o.parameter: o for o in options_of(words)}
    assert shown.keys() == taken.keys()
    for name, option in shown.items():
        argument = taken[name]
        choices = argument.get_choices() or ()
        assert sorted(option.choices) == sorted(choices), name
        assert option.is_required == argument.required or option.is_many, name
        default = argument.field_info.default
        assert option.default in ("", str(default)), name
        if not option.is_word:
            assert option.name in argument.names, name
        if option.off:
            assert option.off in argument.negatives, name


@pytest.mark.parametrize("words", PAGES, ids=" ".join)
def test_every_option_has_its_words(words: list[str]):
    page = verb_help.verb_help(words, CODES)
    assert page is not None
    lines = page.splitlines()
    bare = [a for a, b in zip(lines, [*lines[1:], ""], strict=True) if a.startswith("  ") and a.strip().startswith("-") and len(a) <= 28 and not b.startswith(" " * 20)]  # fmt: skip
    assert bare == []


def test_the_page_stays_in_its_columns(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", "80")
    for words in PAGES:
        page = verb_help.verb_help(words, CODES)
        assert page is not None
        assert max(map(len, page.splitlines()[1:])) <= 80, words
