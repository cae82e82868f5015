"""An effect speaks for itself: nothing outside its file knows its name, and its file can be deleted with its line."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator

import pytest

from tests.house.other_effects import PACKAGE, classes_of, files, in_a_child, names_of, without
from tests.house.test_layers import inner_imports, sources, tree, within
from vcmm.core.declaration import OWNERS
from vcmm.core.effect import Effect, parameter_fields, place_fields
from vcmm.physics import ALL, BY_NAME

# (module, string): why it stands there without meaning the effect of that name.
CONTRACT = {
    (
        "files.learned.node_field",
        "scatter",
    ): "key of a residual field: scale of one approach at its nodes",
    ("files.learned.effect_text", "scatter"): "the same key",
    ("core.residual_process", "scatter"): "the same key",
    (
        "core.run",
        "work_offset",
    ): "label of the rows: which work offset they were cut under; a word of `redraw`",
    ("shop.motion.toolpath", "work_offset"): "the same label",
    ("files.own.placement_writer", "work_offset"): "key of the table [cut] of a scenario",
    ("files.own.room", "room_gradient"): "key of the table [environment]",
    ("files.foreign.iso230", "dead_path"): "beginning of a column name of recordings",
    ("task.instruments.tracker", "dead_path"): "the same word of [nuisance]",
    ("task.response.recording", "dead_path"): "word of the table [nuisance] of a recording",
}


def strings(module: str) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree(module)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value


def others() -> list[str]:
    return [m for m in sources() if not within(m, "physics")]


@pytest.mark.thorough
def test_no_effect_is_named_outside_its_file():
    met = {(m, value): line for m in others() for line, value in strings(m) if value in BY_NAME}
    wrong = [f'{m}:{line} names "{name}"' for (m, name), line in met.items() if (m, name) not in CONTRACT]
    assert not wrong, "declare it in the effect (vcmm/core/declaration.py) and ask for that:\n" + "\n".join(
        wrong
    )
    assert not set(CONTRACT) - set(met), f"no longer needed: {sorted(set(CONTRACT) - set(met))}"


def test_nobody_imports_a_file_of_the_catalogue():
    known = set(others())
    wrong = [f"{i.module}:{i.line} imports {i.target}" for i in inner_imports() if i.module in known and i.target.startswith("physics.catalogue.")]  # fmt: skip
    assert not wrong, "ask the effect for a declaration, or move it to structure:\n" + "\n".join(wrong)


def test_the_list_holds_every_file_of_both_folders():
    """A file without a line would be an effect that no file can state."""
    listed = {i.target for i in inner_imports() if i.module == "physics"}
    there = {m for m in sources() if m.startswith(("physics.structure.", "physics.catalogue."))}
    assert there <= listed, f"no line in vcmm/physics/__init__.py: {sorted(there - listed)}"


def test_every_file_of_the_catalogue_has_a_test_file_of_its_name():
    """The number by hand of an effect is found, and deleted, with it."""
    there = PACKAGE.parent / "tests" / "physics"
    without_one = [stem for stem in files() if not (there / f"test_{stem}.py").is_file()]
    assert not without_one, f"no tests/physics/test_NAME.py for {without_one}"
    strange = [
        stem
        for stem in files()
        if not re.search(
            rf"\b({'|'.join(classes_of(stem))})\b",
            (there / f"test_{stem}.py").read_text(encoding="utf-8"),
        )
    ]
    assert not strange, f"tests/physics/test_NAME.py does not use the classes of {strange}"


@pytest.mark.thorough
def test_every_file_of_effects_can_be_deleted():
    """Each with its line; then everything else is imported."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.house.other_effects"],
        cwd=PACKAGE.parent, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{len(files())} files of vcmm/physics/catalogue/ deleted" in done.stdout


@pytest.mark.count
def test_every_job_runs_without_any_file_of_the_catalogue():
    """measure, uncertainty, field, cut, diagnose, list, explain and schema, once without each file and its lines."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.house.small_jobs"],
        cwd=PACKAGE.parent, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert f"without {len(files())} of {len(files())} files of vcmm/physics/catalogue/" in done.stdout


def test_a_job_runs_without_a_file_of_the_catalogue():
    """The quick one: a scenario that states none of its effects is evaluated, and the others are listed."""
    code = (
        "import json\nfrom tests.house.other_effects import without\nwithout('probe').install()\n"
        "from tests.house.small_jobs import command\n"
        "names = {e['effect'] for e in json.loads(command('list', 'effects', '--json'))['items']}\n"
        "assert 'probe_lobing' not in names and 'tip_radius' in names\n"
        "command('uncertainty', 'scenarios/ring_gauge.toml', '--trials', '2000', '--json')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=PACKAGE.parent, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]


def test_a_deleted_file_is_really_gone():
    """The check above sees what needs the file: a case is made of its class."""
    code = (
        "import importlib\nfrom tests.house.other_effects import without\nwithout('backlash').install()\n"
        "from vcmm.physics import BY_NAME\nassert 'backlash' not in BY_NAME and 'component_table' in BY_NAME\n"
        "importlib.import_module('vcmm.physics.catalogue.backlash')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=PACKAGE.parent, capture_output=True, text=True, check=False
    )
    assert "ModuleNotFoundError: vcmm.physics.catalogue.backlash was deleted" in done.stderr


def test_the_line_goes_with_the_file():
    text = without("play").texts["vcmm.physics"]
    assert "LoadedPlay" not in text
    assert "    Backlash,\n" in text
    assert names_of("play") == ["backlash_ramp", "backlash_operator", "lost_motion_loaded"]


def test_what_a_child_raises_is_told():
    def fails() -> None:
        raise ValueError("a reason")

    assert "ValueError: a reason" in in_a_child(fails)
    assert in_a_child(lambda: None) == ""


@pytest.mark.parametrize("kind", ALL, ids=lambda k: k.name)
def test_declarations_mean_something(kind: type[Effect]):
    """Words of a declaration that nobody reads would be a fact that is lost."""
    assert kind.about.belongs_to in OWNERS
    assert kind.about.on_cut_part in ("", "turned", "stated")
    parameters = {f.name for f in parameter_fields(kind)}
    assert kind.diagnosis.size_name in ("rms", "sd", "amplitude", "arm") or (
        kind.diagnosis.moves_together and kind.diagnosis.size_name in parameters
    )
    first = BY_NAME.get(kind.diagnosis.family)
    assert not kind.about.words or first is None or places(kind) != places(first), (
        "it is reported in the words of its family"
    )
    assert {kind.about.table_parameter, kind.about.gap_parameter} <= {"", *parameters}
    if kind.about.words:
        shown = {*parameters, *kind.about.aliases, "amplitude", kind.diagnosis.size_name}
        opposite = () if kind.about.words.opposite is None else (kind.about.words.opposite.parameter,)
        assert {*kind.about.words.signed, *opposite} <= shown


def places(kind: type[Effect]) -> set[str]:
    """What an answer says of where it sits."""
    return {f.name for f in place_fields(kind) if not f.metadata["quiet"]}


@pytest.mark.parametrize(
    ("small", "large"), [(kind.name, large) for kind in ALL for large in kind.diagnosis.special_case_of]
)
def test_special_cases_are_of_effects_that_there_are(small: str, large: str):
    assert large in BY_NAME
    assert small != large


def test_the_interface_of_an_effect_is_small():
    """Nine things to declare, and two that follow from them; what more is known stands in `about` and `diagnosis`."""
    public = {name for name in dir(Effect) if not name.startswith("_")}
    declared = {"name", "per", "needs", "place", "own", "about", "diagnosis", "link", "error_motion"}
    assert public == declared | {"where", "id"}
