"""Names: a class name stands once in the whole package, and names say what a thing is or does."""

from __future__ import annotations

import ast
from collections import defaultdict

import pytest

from tests.house.counts import (
    KEPT,
    KEPT_FIELDS,
    bare_constants,
    defined_names,
    is_participle,
    kept_fields,
    participles,
    unclear_variables,
)
from tests.house.test_layers import PACKAGE, sources, tree

# Names that stand more than once, and why.
TWICE: dict[str, str] = {
    "LineTable": "names of schemas of files, which stand in the published JSON Schema",
    "Shape": "of a feature (the protocol of nominal and fitted ones), and of a form between points",
    "StylusTable": "names of schemas of files, which stand in the published JSON Schema",
    "Term": "of a linear model: of an arm, of warming, of an evaluation",
}


def homes() -> dict[str, list[str]]:
    """Class name -> files (without vcmm/) in which it is defined at the top of a module."""
    out: dict[str, list[str]] = defaultdict(list)
    for module, path in sources().items():
        for node in tree(module).body:
            if isinstance(node, ast.ClassDef):
                out[node.name].append(path.relative_to(PACKAGE).as_posix())
    return out


def test_a_class_name_stands_once():
    several = {name: tuple(files) for name, files in homes().items() if len(files) > 1}
    new = {name: files for name, files in several.items() if name not in TWICE}
    assert not new, f"name the thing by what it is, so that the name stands once: {new}"
    gone = sorted(set(TWICE) - set(several))
    assert not gone, f"no longer twice, take them out of the table: {gone}"


def test_no_class_is_called_look():
    assert "Look" not in homes()


# How many may be left, by room: figures of November 2026, which can only fall. Where a room has fewer, write the new figure here.
PARTICIPLES = {
    "core": 0, "physics": 0, "part": 0, "program": 0, "task": 0, "answer": 0, "shop": 0, "compensation": 0, "learn": 0,
    "files": 0, "show": 0, "face": 0,
}  # fmt: skip
VARIABLES = {
    "core": 0, "physics": 0, "part": 0, "program": 0, "task": 0, "answer": 0, "shop": 0, "compensation": 0, "learn": 1,
    "files": 3, "show": 0, "face": 0,
}  # fmt: skip

CONSTANTS = {
    "core": 6, "physics": 4, "part": 9, "program": 33, "task": 5, "answer": 22, "shop": 17, "compensation": 3, "learn": 44,
    "files": 17, "show": 15, "face": 7,
}  # fmt: skip


def test_no_further_definition_is_a_bare_participle():
    """`told(...)` may report, test or change something: verbs for what does, nouns for what returns, is_ and has_ for what asks."""
    more = {room: names for room, names in participles().items() if len(names) > PARTICIPLES.get(room, 0)}
    assert not more, (
        f"name it by what it does or returns; a term of the trade goes into TERMS of counts.py: {more}"
    )


def test_every_name_that_is_kept_still_stands():
    """A name of KEPT that is gone or renamed goes from the list too."""
    gone = {
        module: [n for n in names if n not in {name for name, _ in defined_names(module)}]
        for module, (names, _) in KEPT.items()
    }
    assert not any(gone.values()), gone
    for where in KEPT_FIELDS:
        assert any(kept_fields(m) for m in sources() if m == where or m.split(".")[0] == where), where


def test_no_further_variable_has_an_unclear_name():
    """`found` and `one` say nothing of what they hold: the class, or the noun of the trade, does."""
    counts = unclear_variables()
    more = {room: (n, VARIABLES.get(room, 0)) for room, n in counts.items() if n > VARIABLES.get(room, 0)}
    assert not more, f"rooms with more such names than before (now, allowed): {more}"


def test_no_further_constant_is_named_by_one_bare_adjective():
    """`MOST` had 24 values and `FAR` 16: MOST_ROWS, SAME_PLACE_MM say of what, and in which unit."""
    more = {room: names for room, names in bare_constants().items() if len(names) > CONSTANTS.get(room, 0)}
    assert not more, f"name the quantity and its unit, as LEAST_TRAVEL_MM does: {more}"


@pytest.mark.parametrize(
    ("name", "is_one"),
    [("told", True), ("_drawn", True), ("moved", True), ("speed", False), ("expanded", False), ("is_drawn", False), ("Drawn", False)],
)  # fmt: skip
def test_what_counts_as_a_bare_participle(name: str, is_one: bool):
    assert is_participle(name) == is_one
