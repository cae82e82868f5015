"""The exit codes of docs/cli.md are those of the code, and `vcmm VERB --help` says them."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from vcmm.face import cli
from vcmm.face.cli import VERBS, run

HERE = Path(cli.__file__).parent
PAGE = Path(__file__).parents[3] / "docs" / "cli.md"
OF_FILE = {"calibrate_design": "calibrate design", "calibrate_poses": "calibrate design"}


def rows() -> list[tuple[str, int]]:
    """Verb and code of each row of the table."""
    table = PAGE.read_text(encoding="utf-8").split("| verb | code | where |")[1].split("\n\n")[0]
    return [(m[1], int(m[2])) for m in re.finditer(r"^\| `([a-z ]+)` \| (\d+) \|", table, re.MULTILINE)]


def codes_of(function: ast.FunctionDef) -> set[int]:
    """The codes other than 0 that a job can end with: written numbers, and 1 for a decision that is taken elsewhere."""
    out: set[int] = set()
    for node in ast.walk(function):
        if isinstance(node, ast.Return) and node.value is not None:
            numbers = {
                n.value for n in ast.walk(node.value) if isinstance(n, ast.Constant) and type(n.value) is int
            }
            decides = any(isinstance(n, ast.Call | ast.Attribute) for n in ast.walk(node.value))
            out |= numbers & {1, 3, 70} or ({1} if decides else set())
    return out


def in_code() -> set[tuple[str, int]]:
    """Verb and code of every job of the command line that ends with another code than 0."""
    out: set[tuple[str, int]] = set()
    for file in HERE.glob("*.py"):
        verb = OF_FILE.get(file.stem, file.stem.split("_")[0])
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and node.name == "exit_code":
                assert codes_of(node), f"{file.name}: an exit code that is always 0 is left out"
                out |= {(verb, code) for code in codes_of(node)}
    return out


def test_the_table_is_that_of_the_code():
    listed = set(rows())
    assert len(listed) == len(rows())
    assert listed - {("merge", 1)} == in_code()  # merge runs the job of its shards
    assert {verb.split()[0] for verb, _ in listed} <= VERBS.keys()


@pytest.mark.parametrize("verb", sorted({verb for verb, _ in rows()}))
def test_help_says_the_exit_code(verb: str, capsys: pytest.CaptureFixture[str]):
    assert run([*verb.split(), "--help"]) == 0
    page = re.sub(r"[\s│]+", " ", capsys.readouterr().out)
    if verb in ("merge",):
        assert "Exit code: that of the job" in page
    for code in (
        {c for v, c in rows() if v == verb}
        - ({70} if verb == "audit" else set())
        - ({1} if verb == "merge" else set())
    ):
        assert re.search(rf"[Ee]xit code {code}\b", page), page


def test_a_wrong_file_ends_with_two_and_a_survey_with_zero(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    right, wrong = tmp_path / "right.nc", tmp_path / "wrong.nc"
    right.write_text("G21 G90 G0 X1.\nM30\n", encoding="utf-8")
    wrong.write_text("G21 G90 G0 X\nM30\n", encoding="utf-8")
    assert run(["nc", str(right), "--dialect", "fanuc"]) == 0
    assert run(["nc", str(wrong), "--dialect", "fanuc"]) == 2
    assert run(["nc", str(tmp_path)]) == 0
    capsys.readouterr()
