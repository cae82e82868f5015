"""Every promise of README and which test shows it: a sentence that is not in this list fails, and so does a test that is no more."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
# words of the sentence -> what shows it: a file of tests, or a test in it
PROMISES = {
    "what will be measured or cut": "tests/answer/evaluation/test_uncertainty.py",
    "measures a ring gauge virtually and writes a report": "tests/delivery/test_wheel.py::test_it_runs_in_an_empty_environment",
    "five minutes from your certificate to U": "tests/delivery/test_readme.py::test_the_first_tutorial_runs",
    "what measured points are": "tests/answer/inference",
    "where the part should lie": "tests/answer/placing",
    "runs the NC program on the machine as it is": "tests/shop/machining",
    "rewrites the program and proves the new one by a cut": "tests/compensation",
    "turns readings of lasers, ball bars and trackers into a machine file": "tests/learn/calibration",
    "what physics a recording holds that the file lacks": "tests/learn/diagnosis",
    "value ± U (k), decision with its probability": "tests/house/test_docs.py::test_examples_run",
    "one file, works offline": "tests/browser/test_report.py",
    "what the command prints with --json": "tests/face/test_python.py",
    "The jobs are functions too": "tests/face/test_python.py",
    "needs pandas or polars": "tests/face/test_python.py",
    "exact trials (transforms multiplied": "tests/answer/evaluation/test_uncertainty.py",
    "the same to the last bit on one core or a cluster": "tests/answer/evaluation",
    "residuals as scaled and shifted t-distributions": "tests/core",
    "a machine drawn from nothing but its certificate": "tests/task/certification",
    "coverage was not demonstrated says so": "tests/answer/inference",
    "From the part back to the machine": "tests/face/cli/test_loop.py",
    "every job has `--json`": "tests/delivery/test_promises.py::test_every_command_has_json",
    "no service, no network, no GPL": "tests/delivery/test_promises.py::test_no_network_and_no_gpl",
    "By others' numbers": "tests/published",
    "the count": "tests/delivery/test_readme.py::test_readme_counts_as_the_judge_has_counted",
    "the blind exam": "tests/exam",
    "Monte Carlo on the linear model 146 times": "benchmarks",
    "it install all they use": "Makefile",
    "Python 3.11 to 3.13": "docs/install.md",
    "A Dockerfile and a conda recipe are in the repository": "tests/delivery/test_wheel.py::test_the_sdist_holds_tests_and_documentation",
    "whose 3-D bundle comes with vcmm and is only in pages that hold a scene": "tests/show/report/test_page.py",
    "Each has a twin": "tests/papers",
    "all five in one shop": "tests/papers",
    "Kinematics follow ISO 230-1": "tests/core",
}  # fmt: skip
PROMISES["install all they use into `.venv`"] = PROMISES.pop("it install all they use")
NO_JSON = {"new", "serve", "view", "schema"}  # they write files, open something, or print a schema
COMMANDS = r"`vcmm (\w+)"


@pytest.mark.parametrize("words", PROMISES)
def test_a_promise_has_what_shows_it(words: str) -> None:
    text = " ".join(README.split())
    assert words in text, "the sentence is gone: take it out of the list"
    file, _, name = PROMISES[words].partition("::")
    assert (ROOT / file).exists(), file
    if name:
        assert f"def {name}(" in (ROOT / file).read_text(encoding="utf-8")


def test_every_paragraph_of_the_front_has_its_promise() -> None:
    """Paragraphs and points between the title and "How it is known": each holds words of the list, a block of code, a picture, or a job."""
    front = README[: README.index("## How it is known")]
    parts = re.split(r"\n\n|\n(?=- )", re.sub(r"```.*?```", "", front, flags=re.DOTALL))
    prose = [
        " ".join(p.split()) for p in parts if p.strip() and not p.lstrip().startswith(("#", "!", "|", "Give"))
    ]
    bare = [p[:60] for p in prose if not any(words in p for words in PROMISES)]
    assert bare == []


def test_every_command_that_is_named_is_one() -> None:
    from vcmm.face.cli import run

    for verb in sorted(set(re.findall(COMMANDS, README))):
        assert run([verb, "--help"]) == 0, verb


def test_every_command_has_json(capsys: pytest.CaptureFixture[str]) -> None:
    """But those that write files, open something or print a schema, and are no jobs."""
    from vcmm.face.cli import run

    folder = ROOT / "vcmm" / "face" / "cli"
    verbs = set(re.findall(r"^  (\w+) {2,}", _help(capsys), re.MULTILINE))
    assert len(verbs) >= 25
    assert (folder / "uncertainty.py").is_file()
    without = set()
    for verb in verbs:
        capsys.readouterr()
        assert run([verb, "--help"]) == 0
        if "--json" not in capsys.readouterr().out:
            without.add(verb)
    assert without == NO_JSON


def _help(capsys: pytest.CaptureFixture[str]) -> str:
    from vcmm.face.cli import run

    capsys.readouterr()
    run(["--help"])
    return capsys.readouterr().out


def test_no_network_and_no_gpl() -> None:
    """No module asks another computer (the workbench listens on 127.0.0.1, Dask is asked for by name); no dependency is under the GPL."""
    asks = re.compile(
        r"^\s*(?:import|from) (?:requests|urllib\.request|httpx|aiohttp|ftplib|smtplib)\b", re.MULTILINE
    )
    assert [str(f) for f in (ROOT / "vcmm").rglob("*.py") if asks.search(f.read_text(encoding="utf-8"))] == []
    from importlib.metadata import metadata

    for name in (
        "numpy",
        "scipy",
        "numba",
        "trimesh",
        "matplotlib",
        "pydantic",
        "cyclopts",
        "rich",
        "tomlkit",
    ):
        found = metadata(name)
        words = " ".join([found.get("License-Expression") or "", *(found.get_all("Classifier") or [])])
        assert not re.search(r"\b(?:L?GPL|GNU (?:Lesser )?General)", words), name
