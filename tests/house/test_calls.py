"""No call says more than six things by position alone: beyond that nobody knows which is which."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tests.house.test_layers import KERNELS, PACKAGE, ROOT, sources, tree

MOST = 6
# Compiled kernels take no keywords in the loops where they are called, so files of kernels are left out (KERNELS), and
# whoever hands them their arrays.
KERNEL_CALLS = (
    ("vcmm/shop/cutting/stock.py", "kernels.cut_all"),
    ("vcmm/part/fit/exchange.py", "minimax_steps"),
)
ROOMS = ("learn",)  # that still have such calls: what they hold is to be built anew


def long_calls() -> dict[str, list[str]]:
    """Room -> "file:line callee (number)" of calls with more than MOST positional values."""
    out: dict[str, list[str]] = {}
    for module, path in sources().items():
        if path.stem.endswith(KERNELS):
            continue
        room = path.relative_to(PACKAGE).parts[0]
        for node in ast.walk(tree(module)):
            if isinstance(node, ast.Call) and len(node.args) > MOST:
                file = path.relative_to(PACKAGE.parent).as_posix()
                if (file, ast.unparse(node.func)) in KERNEL_CALLS:
                    continue
                where = f"{file}:{node.lineno}"
                out.setdefault(room, []).append(f"{where} {ast.unparse(node.func)} ({len(node.args)})")
    return out


@pytest.mark.thorough
def test_calls_name_their_values():
    several = long_calls()
    new = [call for room, calls in several.items() if room not in ROOMS for call in calls]
    assert not new, "name the values of these calls:\n" + "\n".join(new)
    gone = sorted(room for room in ROOMS if room not in several)
    assert not gone, f"these rooms have no such call any more, take them out of the table: {gone}"


def _names_of(module: Path) -> set[str]:
    """Names that stand at the top of a module: definitions, imports, values."""
    out: set[str] = set()
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            out.add(node.name)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            out |= {(a.asname or a.name).split(".")[0] for a in node.names}
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            out.add(node.id)
    return out


@pytest.mark.thorough
def test_tools_and_benchmarks_import_names_that_exist():
    """No job runs them all: a function that only tools/tooth_forces.py used was deleted, and nothing failed."""
    missing = []
    for folder in ("tools", "benchmarks", "scenarios", "referee", "notebooks", "docs"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            for node in ast.walk(ast.parse(file.read_text())):
                if (
                    isinstance(node, ast.ImportFrom)
                    and (node.module or "").startswith("vcmm.")
                    and not node.level
                ):
                    place = ROOT.joinpath(*node.module.split("."))
                    module = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
                    names = _names_of(module) if module.is_file() else set()
                    missing += [
                        f"{file.relative_to(ROOT)}: {node.module}.{a.name}"
                        for a in node.names
                        if a.name not in names
                        and not (place / a.name).is_dir()
                        and not (place / f"{a.name}.py").is_file()
                    ]
    assert missing == []
