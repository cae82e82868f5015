"""The mark of a compensated program: its words, its place, and a digest that changes with any input."""

from __future__ import annotations

import pytest

from tests.compensation.mill import scale
from vcmm.compensation.header import comment, digest, header, machine_parts, place
from vcmm.compensation.languages import LANGUAGES, writer_of
from vcmm.compensation.source import source_text
from vcmm.compensation.writer import Writer


def test_comments_that_old_controls_show() -> None:
    """Capitals, no brackets inside, 60 characters for Fanuc; a semicolon in Sinumerik."""
    assert comment("Mill (old) é 3", LANGUAGES["fanuc"]) == "(MILL OLD 3)"
    assert len(comment("x" * 99, LANGUAGES["fanuc"])) == 62
    assert comment("Mill (old)", LANGUAGES["sinumerik"]) == "; Mill (old)"
    assert header("mill", 1e-3, "abc", LANGUAGES["fanuc"])[2] == "(TOLERANCE 1 UM)"


@pytest.mark.parametrize(
    ("dialect", "text", "at"),
    [
        ("fanuc", "%\nO0001 (PART)\nG21\n", 2),
        ("fanuc", "G21\n", 0),
        ("linuxcnc", "%\nO100 sub\nG21\n", 1),
        ("sinumerik", "%_N_A_MPF\n;$PATH=/_N_WKS_DIR\nG71\n", 2),
        ("heidenhain", "0 BEGIN PGM A MM\n1 L X+1\n", 1),
    ],
)
def test_place_of_the_mark(dialect, text, at) -> None:
    assert place(source_text(text, "a"), LANGUAGES[dialect]) == at


def test_the_digest_changes_with_every_input() -> None:
    parts = machine_parts(scale(10.0))
    assert len(digest(parts)) == 12
    assert digest(parts) == digest(machine_parts(scale(10.0)))
    assert digest(parts) != digest(machine_parts(scale(10.1)))
    assert digest([b"ab", b"c"]) != digest([b"a", b"bc"])


def test_every_dialect_has_its_writer() -> None:
    names = {name: writer_of(dialect).__name__ for name, dialect in LANGUAGES.items()}
    assert names.pop("sinumerik") == "SinumerikWriter"
    assert names.pop("heidenhain") == "KlartextWriter"
    assert set(names.values()) == {Writer.__name__}
