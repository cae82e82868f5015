"""Check the input files of a command line before its verb is imported: refusing a missing file needs no numerical library.

A verb declares what it reads in its signature, by the types `InputFile`, `InputPath` and `InputName` of `vcmm.face.cli.options`; they
are read from its source, as help is. A line that the parser would refuse, such as one with an unknown option, is left to the parser.
"""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from vcmm.core.text import is_file, read_head
from vcmm.face.cli.verb_help import HERE, HelpOption, options_of

NUMBERS = {
    "INT": re.compile(r"[0-9]+"),
    "NUMBER": re.compile(r"[-+]?[0-9]+(\.[0-9]*)?"),
}  # of other forms the parser judges


def check_inputs(words: Sequence[str]) -> None:
    """Raises DataError for the first input file of a command line that is missing, a folder, or cannot be read."""
    for text, kind in _inputs(words):
        path = Path(text)
        if (kind == "InputPath" and os.path.isdir(path)) or (kind == "InputName" and not path.suffix):
            continue
        if not (is_file(path) and os.access(path, os.R_OK)):
            read_head(path)


def _inputs(words: Sequence[str]) -> list[tuple[str, str]]:
    """Return (path, the name of its type) of the files that a line names; none where the parser refuses the line."""
    command = _command(words)
    if command is None:
        return []
    options, rest = command
    try:
        return [(text, option.reads) for option, text in _values_of(options, rest) if option.reads]
    except LookupError:
        return []


def _command(words: Sequence[str]) -> tuple[list[HelpOption], list[str]] | None:
    """Return the options of `VERB` or `VERB JOB`, and the words behind it; None where there is no such job or no source."""
    verb, rest = words[0], list(words[1:])
    try:
        if rest and (jobs := HERE / f"{verb}_jobs.py").is_file():
            tree = ast.parse(jobs.read_text(encoding="utf-8"))
            if any(isinstance(n, ast.FunctionDef) and n.name == f"{rest[0]}_command" for n in tree.body):
                return options_of(tree, f"{rest[0]}_command"), rest[1:]
            if not rest[0].startswith("-") and not Path(rest[0]).suffix:
                return None  # a mistyped job: the verb names the nearest
        tree = ast.parse((HERE / f"{verb}.py").read_text(encoding="utf-8"))
        return options_of(tree, f"{verb}_command"), rest
    except (OSError, StopIteration):
        return None


def _values_of(options: Sequence[HelpOption], words: Sequence[str]) -> Iterator[tuple[HelpOption, str]]:
    """Yield (option, value) in the order of the line. Raises LookupError for a word that no option takes, or a value that is missing or
    no plain number."""
    by_name = {o.name: o for o in options if not o.is_word} | {o.off: o for o in options if o.off}
    places = [o for o in options if o.is_word]
    left = list(words)
    while left:
        word = left.pop(0)
        if not word.startswith("-") or word == "-":
            yield places[0], word
            if not places[0].is_many:
                places.pop(0)
            continue
        name, equals, value = word.partition("=")
        option = by_name[name]
        if not option.kind:
            continue
        value = value if equals else left.pop(0)
        if option.kind in NUMBERS and not NUMBERS[option.kind].fullmatch(value):
            raise LookupError(f"{name} {value}")
        yield option, value
        while option.takes_all and left and not left[0].startswith("-"):
            yield option, left.pop(0)
