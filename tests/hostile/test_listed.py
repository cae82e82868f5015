"""Nonsense that people and machines have really written: each exit 2 with file and line, short, within seconds."""

from __future__ import annotations

import os

import pytest

from tests.hostile.corpus import BARE, CASES, ERRORS, MACHINE, POSITIONS, PROGRAM, SETUP, Case, ring
from tests.hostile.corpus_newest import CUT_SETUP, NEWEST, WRONG_MILL
from tests.hostile.judge import LONGEST, SLOWEST, ask, inside
from tests.plate import PLATE, line_of

PLATES = [  # what stands there, what is typed, words of the message
    ('part = "21.2 degC"', 'part = "-400 degC"', "below absolute zero"),
    ('name = "bore diameter"', 'name = ""', "is empty; write a name"),
    ('name = "bore diameter"', 'name = "a\\nb"', "control character"),
    ("bore  = {", '"" = {', "is empty; write a name"),
    ("styli.down =", 'styli."" =', "is empty; write a name"),
    ("trials = 20000", "seed = 18446744073709551616", "beyond 64 bits"),
    ("trials = 20000", "trials = 1_000_000_000_000", "1,000,000,000,000 trials would take days"),
    ("trials = 20000", "p = 0.9999999999999999", "between 0.5 and 0.999999"),
    ('plane = "top", line', 'plane = "", line', 'the alignment names ""'),
    ('line = "front", origin = "bore"', 'line = "", origin = ""', 'the alignment names ""'),
    ('speed = "5 mm/s"', 'speed = "1e-300 mm/s"', "as good as zero"),
    ('diameter = "30 mm"', 'diameter = "1e308 mm"', "which no machine has"),
    ('diameter = "30 mm"', 'diameter = "1_0 mm"', "has no number"),
    ('diameter = "30 mm"', 'diameter = "３０ mm"', "has no number"),
    ('diameter = "30 mm"', 'diameter = "30 ' + "(" * 5000 + 'mm"', "longer than 80 characters"),
    ("n = [3, 3]", "n = [100000, 100000]", "10,000,000,000 points"),
    ("n = 8", "n = 1000000000", "2,000,000,000 points"),
    ('["0 mm", "0.021 mm"]', '["0 mm", "1e-300 mm"]', "are one number to 16 digits"),
    ("[pose]", "a = " + "[" * 5000 + "]" * 5000 + "\n[pose]", "nested more than 64 deep"),
    ("[pose]", ".".join(["k"] * 100_000) + " = 1\n[pose]", "more than 64 parts"),
    ("[pose]", "n = " + "9" * 5000 + "\n[pose]", "more than 64 digits"),
    ('{ strategy = "grid", n = [3, 3], margin = "5 mm" }', '"/dev/zero"', "this is a device"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "words"), PLATES, ids=[f"{i}: {p[2][:30]}" for i, p in enumerate(PLATES)]
)
def test_scenarios(old, new, words, tmp_path):
    text = PLATE.replace(old, new, 1)
    (tmp_path / "plate.toml").write_text(text)
    with inside(tmp_path):
        answer = ask(
            ("check", "plate.toml") if "trials" not in words else ("uncertainty", "plate.toml"), SLOWEST
        )
    assert answer.code == 2
    assert words in answer.err
    assert len(answer.err.encode()) < LONGEST
    if "/dev" not in new and "alignment" not in words:
        line = line_of(text, new.split("\n")[0][:40])
        assert any(f"plate.toml:{line + k}: " in answer.err for k in (-2, -1, 0)), answer.err[:300]


def answer_to(folder, files: dict[str, str], *command: str):
    case = Case("", files, command, ())
    case.lay_out(folder)
    with inside(folder):
        return ask(case.command, SLOWEST)


NC = "%\nO1\nG21 G90 G94 G54\nT1 M6\nG43 H1\n{}\nM30\nO1000\nG91 G1 X0.001 F100\nM99\n%\n"


@pytest.mark.parametrize(
    ("block", "words"),
    [
        ("G1 X[" + "[" * 5000 + "1" + "]" * 5000 + "] F100", "nested more than 60 deep"),
        ("G1 X[" + "1+" * 5000 + "1] F100", "more than 200 operators"),
        ("G1 X" + "#" * 200_000, "nested more than 60 deep"),
        ("G1 X١٢ F100", "is not allowed"),
    ],
)
def test_programs(block, words, tmp_path):
    files = {"setup.toml": SETUP, "machine.toml": BARE, "p.nc": NC.format(block)}
    answer = answer_to(tmp_path, files, "nc", "p.nc", "--setup", "setup.toml")
    assert answer.code == 2
    assert words in answer.err
    assert "p.nc:6:" in answer.err


@pytest.mark.parametrize(
    "command",
    [
        ("evaluate", "ring.toml", "--values", "values.csv", "--out", "."),  # writes a values.csv of its own
        ("compensate", "mill.toml", "--points", "p.csv", "--out", "p.csv"),
        ("compensate", "slot.nc", "--setup", "setup.toml", "--out", "setup.toml"),
        ("compensate", "slot.nc", "--setup", "setup.toml", "--out", "mill.toml"),
    ],
)
def test_a_command_does_not_replace_what_it_reads(command, tmp_path):
    files = {
        "ring.toml": ring(), "values.csv": "characteristic,value_mm\ndiameter,50.0008\n", "p.csv": POSITIONS, "mill.toml": WRONG_MILL,
        "setup.toml": CUT_SETUP.replace("machine.toml", "mill.toml"), "slot.nc": PROGRAM,
    }  # fmt: skip
    answer = answer_to(tmp_path, files, *command)
    assert answer.code == 2
    assert "is one of the files that this command reads and would be lost" in answer.err
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == files


def test_a_normal_that_is_no_unit_vector_is_refused_in_a_plan(tmp_path):
    case = next(c for c in CASES if c.name == "points of a plan")
    answer = answer_to(
        tmp_path, case.files | {"top.csv": case.files["top.csv"].replace("0,0,1", "0,0,5", 1)}, *case.command
    )
    assert answer.code == 2
    assert "top.csv:2: nx ny nz has the length 5" in answer.err


def test_a_wrong_instrument_is_found_by_check(tmp_path):
    case = next(c for c in NEWEST if c.name == "lengths")
    head = case.files["recording.toml"].replace('"0.2 um/m"', '"0.2 kg"')
    answer = answer_to(tmp_path, case.files | {"recording.toml": head}, *case.command)
    assert answer.code == 2
    assert "recording.toml:14: [instrument" in answer.err


def test_a_negative_tool_length_is_told_how_to_become_a_length(tmp_path):
    files = {"setup.toml": SETUP.replace('length = "150 mm"', 'length = "-212.4 mm"'), "machine.toml": BARE}
    answer = answer_to(tmp_path, files, "check", "setup.toml")
    assert answer.code == 2
    assert 'setup.toml:10: [tools.1] length = "-212.4 mm" is negative' in answer.err
    assert "length = H - Z" in answer.err  # -212.4 - (-362.4) = 150
    assert 'give length = "150 mm"' in answer.err


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (("field", "machine.toml", "--nodes", "3000"), "27,000,000,000 points, and at most 10,000,000"),
        (("measure", "plate.toml", "--seed", "1" + "0" * 40), "--seed"),
        (("measure", "plate.toml", "--seed", "-1"), "--seed"),
        (("check", "x" * 5000), "cannot be read: File name too long"),
        (("check", "a\0b"), "cannot be the name of a file"),
        (("x" * 50_000,), "unknown command"),
        (("nc", "/dev/zero"), "this is a device"),
        (("check", "/dev/full"), "this is a device"),
        (("uncertainty", "plate.toml", "--workers", "1000000"), "usually one per core"),
        (("uncertainty", "plate.toml", "--trials", "1_000"), "--trials 1_000 is no number"),
        (("uncertainty", "plate.toml", "--trials", "١٢٣٤"), "is no number"),
        (("field", "machine.toml", "--nodes", "0x10"), "--nodes 0x10 is no number"),
        (("measure", "plate.toml", "--out", ""), '--out "" is empty'),  # --out "$UNSET"
        (("uncertainty", "plate.toml", "--evidence", "plate.toml"), "that is no pack; it would be lost"),
        (
            ("uncertainty", "plate.toml", "--evidence", "."),
            "is a folder; name a file in it, such as pack.zip",
        ),
        (("test", "machine.toml", "--iso", "230-2", "--trials", "-1"), "--trials"),
        (
            ("compensate", "plate.toml", "--setup", "setup.toml", "--dialect", "nonsense"),
            'unknown dialect "nonsense"',
        ),
        (("place", "plate.toml", "--machines", "loop"), "Too many levels of symbolic links"),
        (("place", "plate.toml", "--draws", "0"), "--draws"),  # taken for "not given" before
        (("uncertainty", "plate.toml", "--digits", "0"), "--digits"),
        (("check", "pipe"), "pipe:1: this is a pipe"),
    ],
)
def test_command_lines(command, words, tmp_path):
    files = {"machine.toml": MACHINE, "errors.csv": ERRORS, "plate.toml": PLATE, "setup.toml": SETUP}
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    before = sorted(p.name for p in tmp_path.iterdir())
    answer = answer_to(tmp_path, files, *command)
    assert answer.code == 2
    assert words in answer.err
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted({*before, *files})  # nothing half-written
    assert len(answer.err.encode()) < LONGEST


def test_five_hundred_problems_become_twenty_and_a_count(tmp_path):
    rows = "".join(f"x{i},0,0,0,0,0,0\n" for i in range(500))
    files = {"machine.toml": MACHINE, "errors.csv": "X EXX EYX EZX EAX EBX ECX\n" + rows}
    answer = answer_to(tmp_path, files, "check", "machine.toml")
    lines = answer.err.strip().split("\n")
    assert answer.code == 2
    assert len(lines) == 21
    assert lines[0].startswith("vcmm: errors.csv:2: ")
    assert lines[-1] == "vcmm: and 480 more problems of 500"
    assert len(answer.err.encode()) < LONGEST


def test_control_characters_of_a_file_do_not_reach_the_terminal(tmp_path):
    answer = answer_to(
        tmp_path, {"machine.toml": MACHINE, "errors.csv": "X EXX\n0 \x1b[2J\n"}, "check", "machine.toml"
    )
    assert answer.code == 2
    assert "\x1b" not in answer.err
    assert "\\x1b[2J" in answer.err


def test_too_little_memory_is_no_bug(tmp_path, monkeypatch):
    from vcmm.task.response import volumetric

    def too_much(*args):
        raise MemoryError("Unable to allocate 74.5 GiB")

    monkeypatch.setattr(volumetric, "grid", too_much)
    answer = answer_to(tmp_path, {"machine.toml": MACHINE, "errors.csv": ERRORS}, "field", "machine.toml")
    assert answer.code == 3
    assert (
        answer.err
        == "vcmm: this job needs more memory than there is (Unable to allocate 74.5 GiB); reduce its points or rows\n"
    )


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("dcc", "UTF-8", "UTF-1e6", "ring.xml:1: unknown encoding: UTF-1e6; export the file in UTF-8"),
        (
            "dmis",
            ",8\n",
            ",-8\n",
            'diameter = "-8 mm" must be positive',
        ),  # its position at MMC has no feature then
        ("design", '"laser along X"', '"' + 300 * "x" + '"', "name has 300 characters; 200 are the most"),
        (
            "dmis",
            "PTMEAS/CART,-30,-20,20,0,0,1",
            "PTMEAS/CART,-30,-20,20,0,0,0",
            "PTMEAS: the direction has no length",
        ),
    ],
)
def test_files_of_other_systems(name, old, new, words, tmp_path):
    case = next(c for c in CASES if c.name == name)
    (file,) = case.mutated
    assert old in case.files[file]
    answer = answer_to(tmp_path, {file: case.files[file].replace(old, new, 1)}, *case.command)
    assert answer.code in (0, 2)
    assert words in answer.err
