"""TOML files: where every key stands, versions, syntax errors."""

from __future__ import annotations

import tomllib

import pytest

from tests.plate import PLATE, line_of
from vcmm.core.errors import DataError
from vcmm.files.problems import Problems, TableProblems, misspelt
from vcmm.files.toml import check_version, read_toml
from vcmm.files.toml_lines import key_lines

TRICKY = '''a = 1 # c = 2
b.c = { x = 1, "y z" = [ 1,
  2, { q = "}]" } ] }
[t]
s = """
fake = 3
[fake]
"""
d = 2026-03-01 10:00:00
[[p.steps]]
f = 1
[p.steps.points]
n = 3
[[p.steps]]
f = 'it # is'
[[p.steps.sub]]
k = 1
[p."x.y"]
z=1
arr = [
 # note ]
 { a = 1 },
 { a = "b", c.d = 2 },
]
'''


def test_lines_of_keys_in_every_kind_of_table():
    tomllib.loads(TRICKY)
    lines = key_lines(TRICKY)
    assert lines[("a",)] == 1
    assert lines[("b", "c", "x")] == 2
    assert lines[("b", "c", "y z", 2, "q")] == 3
    assert lines[("t", "s")] == 5
    assert ("t", "fake") not in lines
    assert lines[("t", "d")] == 9
    assert lines[("p", "steps", 0, "f")] == 11
    assert lines[("p", "steps", 0, "points", "n")] == 13
    assert lines[("p", "steps", 1, "f")] == 15
    assert lines[("p", "steps", 1, "sub", 0, "k")] == 17
    assert lines[("p", "x.y", "z")] == 19
    assert lines[("p", "x.y", "arr", 0)] == 22
    assert lines[("p", "x.y", "arr", 1, "c", "d")] == 23
    assert max(lines.values()) <= len(TRICKY.splitlines())


def _locations(value, at=()):
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield (*at, key)
        yield from _locations(inner, (*at, key))


@pytest.mark.parametrize("text", [TRICKY, PLATE, "", "# only a comment\n", 'x = "a"'])
def test_every_key_has_a_line_and_no_line_has_a_false_key(text):
    assert set(key_lines(text)) == set(_locations(tomllib.loads(text)))


def test_windows_line_ends():
    assert key_lines("a = 1\r\n[b]\r\nc = 2\r\n")[("b", "c")] == 3


def test_where_falls_back_to_the_table(tmp_path):
    path = tmp_path / "plate.toml"
    path.write_text(PLATE)
    document = read_toml(path)
    step = line_of(PLATE, 'feature = "bore"')
    assert document.where(("plan", "steps", 1, "feature")) == f"{path}:{step}"
    assert document.where(("plan", "steps", 1, "nothing")) == f"{path}:{step - 1}"
    assert document.where(("nothing", "at", "all")) == f"{path}:1"
    assert document.table(("plan", "steps", 1, "points", "n")) == "[plan.steps 2.points] "
    assert document.table(("pose", "shift")) == "[pose] "
    assert document.table(()) == ""


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("a = 1\ntravel = [0 mm, 1 mm]\n", 2, ["travel = [0 mm, 1 mm]", "texts need quotes"]),
        ("a = 1\nb\n", 2, ["keys need ="]),
        ("a = 1\na = 2\n", 2, ["each key and each table is written once"]),
        ("[t]\nx = 1\n[t]\ny = 2\n", 3, ["each key and each table is written once"]),
        ('a = "open\n', 1, ['a = "open']),
        ("a = [1,\n2\n", 1, ["not valid TOML", "is not closed before line 2"]),  # where the bracket stands
        ("a = [1,\nb = 2\n", 1, ['the "[" is not closed before line 2', 'close it with "]"']),
        ("a = [1, 2\n\n[machine]\n", 1, ['the "[" is not closed before line 3']),
        ("a = { b = 1,\nc = 2 }\n", 1, ['the "{" is not closed', "stays on one line"]),
        ("a = [\n 1,\n abc,\n]\n", 3, ["texts need quotes"]),  # a list over lines, closed: the value is wrong
    ],
)
def test_syntax_errors_show_the_line(tmp_path, text, line, words):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(DataError) as caught:
        read_toml(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:{line}: not valid TOML")
    assert all(word in message for word in words)


def test_files_that_cannot_be_read(tmp_path):
    (tmp_path / "plate.toml").write_text(PLATE)
    with pytest.raises(DataError, match=r'plat.toml does not exist. Did you mean "plate.toml"'):
        read_toml(tmp_path / "plat.toml")
    with pytest.raises(DataError, match="is a folder"):
        read_toml(tmp_path)
    (tmp_path / "latin.toml").write_bytes('name = "M\xfcller"'.encode("latin-1"))
    with pytest.raises(DataError, match="is not UTF-8 text"):
        read_toml(tmp_path / "latin.toml")


def test_a_byte_order_mark_is_no_mistake(tmp_path):
    path = tmp_path / "bom.toml"
    path.write_bytes(b"\xef\xbb\xbf" + b'vcmm = "machine/1"\n')
    assert read_toml(path).data["vcmm"] == "machine/1"


@pytest.mark.parametrize(
    ("first", "message"),
    [
        ("", 'the first line must be vcmm = "machine/1"'),
        ('vcmm = "scenario/1"', "but expected a machine file"),
        ('vcmm = "machine"', "but expected a machine file"),
        (
            'vcmm = "machine/2"',
            r'"machine/2" was written by a newer vcmm; this one reads machine/1 to machine/1',
        ),
    ],
)
def test_versions(tmp_path, first, message):
    path = tmp_path / "m.toml"
    path.write_text(f"{first}\n")
    with pytest.raises(DataError, match=message):
        check_version(read_toml(path), "machine")


def test_older_versions_are_read(tmp_path):
    path = tmp_path / "m.toml"
    path.write_text('vcmm = "machine/1"\n')
    check_version(read_toml(path), "machine", version=3)


def test_problems_are_collected_with_file_line_and_table(tmp_path):
    path = tmp_path / "plate.toml"
    path.write_text(PLATE)
    problems = Problems(read_toml(path))

    def wrong():
        raise TableProblems([("pair", "first"), (("points", "n"), "second")])

    assert problems.attempt(("machine", "effects", 0), wrong) is None
    assert problems.attempt((), lambda: 5) == 5
    problems.add(("pose",), "other.toml:3: is located already")
    with pytest.raises(DataError) as caught:
        problems.raise_if_any()
    assert caught.value.problems == (
        f"{path}:{line_of(PLATE, '[[machine.inputs]]') - 2}: [machine.effects 1] first",
        f"{path}:{line_of(PLATE, '[[machine.effects]]')}: [machine.effects 1] second",
        "other.toml:3: is located already",
    )


def test_a_missing_word_that_is_there_in_another_spelling():
    assert misspelt("strategy", ["stratgy", "n"]) == ' "stratgy" is there; rename it to "strategy".'
    assert misspelt("strategy", ["n"]) == ""
