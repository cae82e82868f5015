"""Twins of papers live beside their scenarios and use what `import vcmm` offers, as any program does."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path
from typing import get_args, get_type_hints

import pytest

import vcmm
from tests.house.test_layers import LONGEST_FUNCTION, LONGEST_MODULE, PACKAGE, ROOT
from vcmm.core.errors import UsageError
from vcmm.face.cli.demo import demo_command
from vcmm.face.twins import names
from vcmm.files.own.library import companions, folder

FILES = sorted((ROOT / "scenarios").rglob("*.py"))

# What a twin still imports from inside the package, because `import vcmm` does not offer it. This table may only shrink.
REACHES: dict[str, tuple[str, ...]] = {
    "abbe_milling/survey": (
        "vcmm.core.history",
        "vcmm.task.response.nuisance",
        "vcmm.task.response.observe",
    ),
    "gaska2014/maps": ("vcmm.core.residual_weights",),
    "gaska2014/page": ("vcmm.show.pages.uncertainty", "vcmm.show.pages.view"),
    "gaska2014/placement": (
        "vcmm.answer.placing.fixture_boxes",
        "vcmm.answer.placing.objective",
        "vcmm.answer.placing.travels",
        "vcmm.task.measuring.plan",
    ),
    "gaska2014/readings": (
        "vcmm.answer.evaluation.linear",
        "vcmm.answer.evaluation.streams",
        "vcmm.core.residual_weights",
    ),
    "gaska2014/twin": ("vcmm.core.residual_weights",),
    "marin2004/day": ("vcmm.core.run",),
    "marin2004/rewritten": ("vcmm.core.run",),
}


def trees() -> dict[str, ast.Module]:
    """File without its ending, relative to the folder of scenarios -> what it says."""
    top = ROOT / "scenarios"
    return {
        p.relative_to(top).with_suffix("").as_posix(): ast.parse(p.read_text(encoding="utf-8")) for p in FILES
    }


def imported(tree: ast.Module) -> set[str]:
    """Modules of the package that a file names, `vcmm` itself excepted."""
    froms = {str(n.module) for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.level == 0}
    plain = {alias.name for n in ast.walk(tree) if isinstance(n, ast.Import) for alias in n.names}
    return {m for m in froms | plain if m.startswith("vcmm.")}


def test_twins_use_what_import_vcmm_offers():
    assert {
        name: tuple(sorted(reached)) for name, tree in trees().items() if (reached := imported(tree))
    } == REACHES


def test_names_that_twins_import_are_offered():
    """`from vcmm import x` finds a submodule too; only names of the table count."""
    froms = [
        n
        for t in trees().values()
        for n in ast.walk(t)
        if isinstance(n, ast.ImportFrom) and n.module == "vcmm"
    ]
    assert {alias.name for n in froms for alias in n.names} <= set(vcmm.__all__)


def test_the_package_imports_no_twin():
    """Only the loader knows where twins are; whoever wants one asks it by name."""
    met = [p for p in PACKAGE.rglob("*.py") if "vcmm_twins" in p.read_text(encoding="utf-8")]
    assert [p.relative_to(PACKAGE).as_posix() for p in met] == ["face/twins.py"]


def test_nothing_of_a_twin_is_read_before_it_is_asked_for():
    code = (
        "import sys, vcmm\nfrom vcmm.face.cli import run\nassert run(['demo', '--help']) == 0\n"
        "assert not [m for m in sys.modules if m.startswith('vcmm_twins')]\n"
        "paper = vcmm.twin('marin2004')\n"
        "assert 'vcmm_twins.marin2004.chain' in sys.modules and paper.chain is sys.modules['vcmm_twins.marin2004.chain']\n"
        "assert not [m for m in sys.modules if m.startswith('vcmm_twins.gaska')]"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd="/", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_command_offers_every_twin():
    assert {name for one in get_args(get_type_hints(demo_command)["twin"]) for name in get_args(one)} == set(
        names()
    )


def test_an_unknown_twin_is_answered_with_the_closest():
    with pytest.raises(UsageError, match=r'no twin "marin".*Did you mean "marin2004"'):
        vcmm.twin("marin")


def test_a_copied_scenario_brings_no_python_along():
    assert (folder() / "marin2004" / "twin.py").is_file()
    assert set(companions("marin2004")) == {f"marin2004/{n}" for n in ("errors.csv", "part.nc", "setup.toml")}


def test_twins_are_as_short_as_the_package():
    for path in FILES:
        text = path.read_text(encoding="utf-8")
        assert len(text.splitlines()) <= LONGEST_MODULE, path
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef):
                assert int(node.end_lineno or 0) - node.lineno < LONGEST_FUNCTION, f"{path}: {node.name}"


def test_type_checkers_see_the_names_that_programs_see():
    """The imports under TYPE_CHECKING of vcmm/__init__.py name the modules of its tables."""
    tree = ast.parse(Path(vcmm.__file__).read_text(encoding="utf-8"))
    (block,) = (n for n in tree.body if isinstance(n, ast.If))
    typed = {}
    for node in block.body:
        assert isinstance(node, ast.ImportFrom)
        for alias in node.names:
            typed[alias.asname or alias.name] = (str(node.module), alias.name)
    tables = {n: (m, n) for n, m in vcmm._HOME.items()}
    tables |= {n: tuple(m.rpartition(".")[::2]) for n, m in vcmm._SUBJECTS.items()}
    assert typed == tables
