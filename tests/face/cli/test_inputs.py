"""A missing input file is refused before anything heavy is loaded, by every verb that reads one."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.face.cli import VERBS, verb_help
from vcmm.face.cli.inputs import check_inputs

HEAVY = ("numpy", "scipy", "numba", "pydantic", "cyclopts", "rich")
HERE = Path(verb_help.__file__).parent

# Verbs that read no file of the user: what they take instead.
NO_FILE = {
    "demo": "an example of ours",
    "new": "the name of an example",
    "list": "what is listed",
    "explain": "the name of an effect",
    "doctor": "nothing",
    "schema": "the name of a format",
}
OUTPUTS = {"out", "report", "export", "png", "write_setup", "residual", "evidence"}


def commands() -> dict[tuple[str, ...], list[verb_help.HelpOption]]:
    """Words of a verb, or of a verb and its job -> its options."""
    out: dict[tuple[str, ...], list[verb_help.HelpOption]] = {}
    for verb in VERBS:
        tree = ast.parse((HERE / f"{verb}.py").read_text(encoding="utf-8"))
        out[(verb,)] = verb_help.options_of(tree, f"{verb}_command")
    tree = ast.parse((HERE / "calibrate_jobs.py").read_text(encoding="utf-8"))
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name.endswith("_command"):
            out["calibrate", node.name.removesuffix("_command")] = verb_help.options_of(tree, node.name)
    return out


def test_every_path_of_a_verb_is_an_input_or_an_output() -> None:
    """A verb that forgets to declare what it reads would refuse a missing file late."""
    loose = {
        (*words, o.parameter)
        for words, options in commands().items()
        for o in options
        if o.kind == "PATH" and not o.reads and o.parameter not in OUTPUTS
    }
    assert loose == set()
    assert {words[0] for words, options in commands().items() if not any(o.reads for o in options)} == set(
        NO_FILE
    )


def lines_with_one_missing_file() -> list[list[str]]:
    """For every input of every verb a line in which that file is missing, and all files that must stand before it are there."""
    lines = []
    for words, options in commands().items():
        places = [o for o in options if o.is_word and o.reads]
        for i, option in enumerate(places):
            lines.append([*words, *["here.toml"] * i, "missing.toml"])
            if option.is_many:
                lines.append([*words, *["here.toml"] * (i + 1), "missing.toml"])
        before = ["here.toml"] * len([o for o in places if o.is_required and not o.is_many])
        lines += [[*words, *before, o.name, "missing.toml"] for o in options if o.reads and not o.is_word]
        lines += [[*words, *before, f"{o.name}=missing.toml"] for o in options if o.reads and not o.is_word]
        lines += [[*words, *before, o.name, "here.toml", "missing.toml"] for o in options if o.takes_all]
    return lines


def test_no_verb_loads_anything_heavy_to_refuse_a_missing_file(tmp_path: Path) -> None:
    """One process for all lines: whatever one of them loaded would be seen at the end."""
    (tmp_path / "here.toml").write_text("")
    lines = lines_with_one_missing_file()
    assert len(lines) > 80  # 22 verbs and 9 jobs, most with several inputs
    code = (
        "import contextlib, io, json, sys\nfrom vcmm.face.cli import run\n"
        "answers = []\n"
        "for line in json.loads(sys.argv[1]):\n"
        "    with contextlib.redirect_stderr(io.StringIO()) as told:\n"
        "        answers.append((run(line), told.getvalue()))\n"
        f"print(json.dumps([answers, [m for m in {HEAVY!r} if m in sys.modules]]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, json.dumps(lines)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    answers, loaded = json.loads(done.stdout)
    assert loaded == []
    wrong = [(line, said) for line, (code, said) in zip(lines, answers, strict=True) if code != 2 or "missing.toml does not exist" not in said]  # fmt: skip
    assert wrong == []


def test_what_is_there_is_let_through(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("here.toml").write_text("")
    Path("folder").mkdir()
    check_inputs(["measure", "here.toml", "--seed", "3", "--out", "new", "--json"])
    check_inputs(["diagnose", "folder"])
    check_inputs(["place", "gaska2014", "--machines", "folder", "here.toml", "--json"])


def test_what_the_parser_refuses_is_left_to_it() -> None:
    """An unknown option, a value that is not there, a word too many, a word that is no job."""
    for line in ("measure no.toml --sed 3", "measure --seed", "measure no.toml b.toml", "calibrate poses no"):
        check_inputs(line.split())


def test_a_folder_where_a_file_is_read(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="is a folder; name a file in it"):
        check_inputs(["measure", str(tmp_path)])
    with pytest.raises(DataError, match="cannot be the name of a file"):
        check_inputs(["measure", "a\0b.toml"])
