"""The referee shares nothing with what it judges: no import of the package, in any disguise."""

import ast
import re
from itertools import pairwise
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / "referee").rglob("*.py"))
OURS = {"vcmm", "tests", "tools", "benchmarks"}
LOADERS = {"importlib", "runpy", "pkgutil", "imp", "zipimport", "code", "codeop", "ctypes"}
CALLS = {"__import__", "exec", "eval", "compile", "import_module", "run_module", "run_path", "load_module"}
WORDS = re.compile(
    r"(\bimport\s+vcmm\b|\bfrom\s+vcmm\b|-m\s*vcmm\b|\bvcmm\.\w+\s*\(|__import__|import_module)"
)


def faults(source: str) -> list[str]:
    """What in a file would bring in the package, with its line."""
    found = []
    for node in ast.walk(ast.parse(source)):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
            if node.level:
                found.append(f"{node.lineno}: relative import")
        elif isinstance(node, ast.Name) and node.id in CALLS:
            found.append(f"{node.lineno}: {node.id}")
        elif isinstance(node, ast.Attribute) and node.attr in (CALLS - {"compile"}) | {
            "modules",
            "meta_path",
        }:
            found.append(f"{node.lineno}: .{node.attr}")
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and WORDS.search(node.value):
            found.append(f"{node.lineno}: text that loads the package")
        elif isinstance(node, (ast.List, ast.Tuple)):
            items = [e.value for e in node.elts if isinstance(e, ast.Constant)]
            if "-c" in items or any(a == "-m" and b == "vcmm" for a, b in pairwise(items)):
                found.append(f"{node.lineno}: code or a module handed to an interpreter")
        found += [f"{node.lineno}: {n}" for n in names if n.split(".")[0] in OURS | LOADERS]
    return found


def test_there_is_something_to_look_at():
    assert len(FILES) >= 10
    assert all(len(f.read_text().splitlines()) <= 400 for f in FILES)


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.name)
def test_the_referee_imports_nothing_of_the_package(file):
    assert faults(file.read_text()) == []


@pytest.mark.parametrize(
    "source",
    [
        "import vcmm",
        "import numpy, vcmm.part.fit as f",
        "from vcmm.part.fit import associate",
        "from tests.plate import x",
        "from . import fits",
        "def f():\n    import vcmm",
        "import importlib",
        "from importlib import import_module",
        "__import__('v' + 'cmm')",
        "import sys\nsys.modules['x']",
        "import subprocess\nsubprocess.run(['python', '-c', 'import vcmm'])",
        "import subprocess\nsubprocess.run(['python', '-c', text])",
        "import subprocess\nsubprocess.run(('python', '-m', 'vcmm', 'check'))",
        "import os\nos.system('python -m vcmm check x')",
        "exec('x')",
        "text = 'from vcmm import evaluate'",
    ],
)
def test_every_disguise_is_seen(source):
    assert faults(source)


def test_the_command_line_is_allowed():
    assert faults("import subprocess\nsubprocess.run(['vcmm', 'evaluate', 's.toml'])") == []
