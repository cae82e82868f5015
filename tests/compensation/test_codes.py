"""M codes of a split block: told from texts, names and labels, and put where they act."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.compensation.mill import SETUP, body, rough, run
from vcmm.compensation.codes import codes_after_motion
from vcmm.compensation.languages import LANGUAGES

G_HEAD = "G54 G90 G17 S3000 M3\nG0 X0 Y0 Z0\n"


def split(tmp_path, text: str, dialect: str) -> list[str]:
    return [
        line.strip()
        for line in body(run(tmp_path, text, rough(), replace(SETUP, dialect=dialect)))
        if line.strip()
    ]


@pytest.mark.parametrize(
    ("dialect", "line", "codes"),
    [
        ("sinumerik", 'G1 X300 MSG("M9 COOL") M5', ["M5"]),
        ("sinumerik", "G1 X=DIAM2 F=FM5", []),
        ("sinumerik", "ATM9: G1 X300 M=5", ["M=5"]),
        ("sinumerik", "G1 X300 M2=3", []),
        ("sinumerik", "G1 X300 M2=5 M09 RND=2", ["M2=5", "M09", "RND=2"]),
        ("sinumerik", "G1 X300 ; M5", []),
        ("linuxcnc", "G1 X#<diam1> F[#<m9>*2] M1", ["M1"]),
        ("linuxcnc", "G1 X300 M5 M9", []),
        ("fanuc", "G1X300.M9(M5)M05", ["M9", "M05"]),
        ("fanuc", "G1 X300. M8 M#1", []),
        ("heidenhain", "L X+Q1 M140 MB MAX M9 ; M5", ["M9"]),
        ("heidenhain", 'TOOL CALL "M5" Z S3000', []),
    ],
)
def test_what_acts_behind_the_motion(dialect, line, codes):
    assert [c.text for c in codes_after_motion(line, LANGUAGES[dialect])] == codes
    assert all(line[c.first - 1 : c.last - 1] == c.text for c in codes_after_motion(line, LANGUAGES[dialect]))


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        (G_HEAD + 'G1 X300 F500 MSG("M9 COOL")\nY200\nM30\n', 'MSG("M9 COOL")'),
        ("DEF REAL FM5=500\n" + G_HEAD + "G1 X300 F=FM5\nY200\nM30\n", "F=FM5"),
        (G_HEAD + "ATM5: G1 X300 F500\nY200\nIF R1==1 GOTOF ATM5\nM30\n", "ATM5: G1"),
        (G_HEAD + "G1 X300 F500 M2=3\nY200\nM30\n", "M2=3"),
    ],
)
def test_texts_and_names_keep_what_looks_like_a_code(tmp_path, text, kept):
    lines = split(tmp_path, text, "sinumerik")
    assert len(lines) > len(text.splitlines()) + 3  # the block is split
    assert sum(kept in line for line in lines) == 1
    assert not any(line.endswith((" M5", " M9", " M2")) for line in lines)


def test_names_of_parameters_are_no_codes(tmp_path):
    lines = split(tmp_path, "#<fm1>=500\n" + G_HEAD + "G1 X300 F#<fm1>\nY200\nM30\n", "linuxcnc")
    assert sum("F#<fm1>" in line for line in lines) == 1
    assert not any("M1" in line for line in lines)


@pytest.mark.parametrize(("dialect", "last"), [("fanuc", True), ("sinumerik", True), ("linuxcnc", False)])
def test_spindle_and_coolant_stop_behind_the_motion_but_not_on_linuxcnc(tmp_path, dialect, last):
    """ISO 6983-1: behind the motion; the order of execution of RS274/NGC has M5 and M9 before it, M1 behind it."""
    lines = split(tmp_path, G_HEAD + "G1 X300. F500. M9 M5\nY200. M1\nM30\n", dialect)
    at = [i for i, line in enumerate(lines) if "M9" in line and "M5" in line]
    first = next(i for i, line in enumerate(lines) if line.startswith("G1"))
    stop = next(i for i, line in enumerate(lines) if "M1" in line)
    assert len(at) == 1
    assert (at[0] > first and lines[at[0]].startswith("X299.982")) if last else at == [first]
    assert lines[stop] == "X299.986 Y199.997 M1"


def test_a_computed_code_keeps_its_block_in_one(tmp_path):
    """Nobody knows whether M=R3 acts before or behind the motion."""
    text = "R3=8\n" + G_HEAD + "G1 X300 F500 M=R3\nM30\n"
    assert len(split(tmp_path, text, "sinumerik")) == len(text.splitlines())
