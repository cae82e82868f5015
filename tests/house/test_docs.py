"""The documentation is true: its examples run, its files load, the tests and keys it names exist.

A page is one program: its fenced blocks run from top to bottom in one namespace and one empty folder. A block opened
by ```toml NAME or ```text NAME is written to that file first; ```python no-run is shown only.
"""

from __future__ import annotations

import ast
import re
import runpy
import shlex
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "DESIGN.md",
    *sorted((ROOT / "docs").glob("*.md")),
]
GENERATED = ("effects.md", "reference.md")  # by docs/generate.py, when the pages are built
FENCE = re.compile(r"^```(\w+)[ \t]*([^\n`]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A fenced block: language, the rest of its first line, text, line in the page."""

    language: str
    note: str
    text: str
    line: int


def blocks(page: Path) -> Iterator[Block]:
    text = page.read_text(encoding="utf-8")
    for match in FENCE.finditer(text):
        yield Block(match[1], match[2].strip(), match[3], text.count("\n", 0, match.start()) + 2)


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


pytestmark = pytest.mark.usefixtures("few_parts")
LONG = ("docs/criteria.md", "docs/cutting_geometry.md")  # more than three seconds each: make test-all


def with_examples() -> list[Any]:
    """Pages with Python in them, as parameters of a test."""
    pages = [p for p in PAGES if any(b.language == "python" for b in blocks(p))]
    marks = {file: [pytest.mark.thorough] for file in LONG}
    return [pytest.param(p, id=name(p), marks=marks.get(name(p), [])) for p in pages]


@pytest.mark.thorough
@pytest.mark.parametrize("page", with_examples())
def test_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, Any] = {"__name__": "__main__"}
    for block in blocks(page):
        if block.language in ("toml", "text") and block.note:
            (tmp_path / block.note).write_text(block.text, encoding="utf-8")
        elif block.language == "python" and block.note != "no-run":
            code = "\n" * (block.line - 1) + block.text  # so that a traceback names the line of the page
            exec(compile(code, str(page), "exec"), namespace)


@pytest.mark.parametrize("page", [p for p in PAGES if any(b.language == "toml" for b in blocks(p))], ids=name)
def test_toml_examples_are_toml(page: Path):
    for block in blocks(page):
        if block.language == "toml":
            tomllib.loads(block.text)


def words(page: str) -> set[str]:
    """Everything set as code in a page."""
    text = FENCE.sub("", (ROOT / page).read_text(encoding="utf-8"))
    return {word.strip() for code in re.findall(r"`([^`\n]+)`", text) for word in code.split(".")} | set(
        re.findall(r"`([^`\n]+)`", text)
    )


def test_every_key_of_the_file_formats_is_documented():
    """Keys are read from the formats themselves, so that a new key cannot stay undocumented."""
    from vcmm.files.own import machine, part, plan, recording_tables, scenario
    from vcmm.files.own.inputs import INPUT_KEYS, LAW_KEYS
    from vcmm.files.schema import Table

    models = [m for file in (machine, part, plan, scenario, recording_tables) for m in vars(file).values()]
    tables = [m for m in models if isinstance(m, type) and issubclass(m, Table)]
    keys = {key for m in tables for key in m.model_fields} | set(INPUT_KEYS) | set(LAW_KEYS)
    assert len(keys) > 60
    assert not sorted(keys - words("docs/files.md") - words("docs/diagnose.md") - {"vcmm"})


def test_every_strategy_feature_and_characteristic_is_documented():
    from dataclasses import fields

    from vcmm.part.part import FEATURE_KINDS, TYPES
    from vcmm.task.measuring.strategies import PATTERNS

    shown = words("docs/files.md")
    strategies = {n for by_name in PATTERNS.values() for n in by_name}
    keys = {f.name for by_name in PATTERNS.values() for pattern in by_name.values() for f in fields(pattern)}
    assert not sorted((strategies | keys | set(FEATURE_KINDS) | set(TYPES)) - shown)


def test_every_verb_is_documented():
    from vcmm.face.cli import VERBS

    shown = words("docs/cli.md")
    assert not sorted(set(VERBS) - shown)


def command_lines() -> Iterator[tuple[str, list[str]]]:
    """(where, words) of every `vcmm ...` that a page shows, in its blocks and in its text; lines with "..." show only a part."""
    for page in PAGES:
        shown = [
            (f"{name(page)}:{b.line + i}", line.strip().removeprefix(".venv/bin/"))
            for b in blocks(page) if b.language in ("text", "sh") for i, line in enumerate(b.text.splitlines())
        ]  # fmt: skip
        text = FENCE.sub("", page.read_text(encoding="utf-8"))
        shown += [(name(page), " ".join(code.split())) for code in re.findall(r"`(vcmm [^`]+)`", text)]
        for where, line in shown:
            words = re.split(r"\s{2,}|\s#", line)[0].split(" | ")[0]
            if words.startswith("vcmm ") and words.split()[1][0].islower() and "..." not in words:
                yield where, shlex.split(words)[1:]


@pytest.mark.thorough
def test_every_command_that_is_shown_is_understood():
    """Verbs, options and their values, as the command line itself reads them; nothing is run. NAME stands for a value."""
    from cyclopts import CycloptsError, MissingArgumentError

    from vcmm.face.cli import build_app

    app, wrong = build_app(), []
    found = list(command_lines())
    for where, words in found:
        try:
            app.parse_args([w for w in words if not w.isupper()], print_error=False, exit_on_error=False)
        except MissingArgumentError:
            pass  # the text names a verb or an option, without its file
        except CycloptsError as error:
            wrong.append(f"{where}: vcmm {' '.join(words)}: {error}")
    assert len(found) > 200
    assert wrong == []


def test_json_keys_are_documented():
    """The keys of the uncertainty document, from a real one."""
    from vcmm.face.api import uncertainty
    from vcmm.files.own.library import example
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.tables.uncertainty import uncertainty_json

    document = uncertainty_json(uncertainty(load_scenario(example("plate")), trials=2000))
    characteristic = document["characteristics"][0]
    keys = {*document, *characteristic, *characteristic["budget"][0]}
    shown = words("docs/cli.md")
    assert not sorted(k for k in keys if k.replace("_rad", "_mm") not in shown)


@cache
def generator() -> dict[str, Any]:
    """The functions of docs/generate.py by name."""
    return runpy.run_path(str(ROOT / "docs" / "generate.py"))


def test_the_page_of_effects_holds_every_effect_and_parameter(tmp_path: Path):
    from vcmm.core.effect import parameter_fields
    from vcmm.physics import ALL

    target = tmp_path / "effects.md"
    generator()["write"](target)
    page = target.read_text(encoding="utf-8")
    for effect in ALL:
        section = page.split(f"\n## {effect.name}\n")[1].split("\n## ")[0]
        assert effect.about.cites in section, effect.name
        assert "indicated - true" in section or "actual - nominal" in section
        for f in parameter_fields(effect):
            assert str(f.metadata["doc"]) in section, f"{effect.name}.{f.name}"


def test_the_reference_holds_every_function_and_every_verb():
    import vcmm
    from vcmm.face.cli import VERBS

    page = generator()["reference"]()
    assert all(f"### vcmm.{name}\n" in page for name in vcmm.__all__[1:])
    assert all(f"### vcmm {verb}\n" in page for verb in VERBS)
    assert "points: 'str | Path | None' = None" in page


def test_a_lesson_as_a_notebook_repeats():
    lesson = ROOT / "notebooks" / "01_first_uncertainty.py"
    text = generator()["notebook"](lesson)
    assert text == generator()["notebook"](lesson)
    assert '"outputs": []' in text
    assert "A first uncertainty" in text
    assert '"scenario.plot();"' in text


def test_examples_of_effects_can_be_read():
    from vcmm.files.own.effects import build_effect
    from vcmm.physics import ALL

    read = 0
    for effect in ALL:
        lines = generator()["tables"](effect)
        if lines:
            table = tomllib.loads("\n".join(lines))["effects"][0]
            assert isinstance(build_effect(table), effect)
            read += 1
    assert read >= len(ALL) / 2


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_named_tests_exist(page: Path):
    for file, test in re.findall(r"`(tests/[\w/]+\.py)(?:::(\w+))?`", page.read_text(encoding="utf-8")):
        assert (ROOT / file).is_file(), f"{page.name} names {file}"
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        functions = {n.name for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)}
        assert not test or test in functions, f"{page.name} names {file}::{test}"


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_between_pages_exist(page: Path):
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", FENCE.sub("", page.read_text(encoding="utf-8"))):
        generated = target in GENERATED
        if "://" not in target and not generated:
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_the_index_lists_every_page():
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    trees = re.findall(r"```\{toctree\}\n.*?\n\n(.*?)```", index, re.DOTALL)
    pages = " ".join(trees).split()
    assert len(pages) == len(set(pages)), "a page stands in one part"
    assert re.findall(r"^## (.*)$", index, re.MULTILINE) == [
        "Tutorials",
        "How-to",
        "Explanation",
        "Reference",
    ]
    listed = set(pages)
    assert listed == {p.stem for p in (ROOT / "docs").glob("*.md")} - {"index"} | {
        g.removesuffix(".md") for g in GENERATED
    }
