"""Calls that a reader can follow: no more than six values by position, and class names that stand once."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "vcmm"
MOST = 6
ROOMS = ("machining", "cutting", "compensating")
# Numba takes arrays, not objects that hold them; keywords cost it its cache of signatures.
KERNELS = "_kernels.py"
TO_KERNELS = {("cutting/stock.py", "kernels.cut_all"): "arrays of a kernel"}


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def long_calls(room: str) -> Iterator[tuple[str, str]]:
    """(file, function) of calls with more than MOST values by position."""
    for path in sorted((PACKAGE / room).rglob("*.py")):
        if not path.name.endswith(KERNELS):
            for node in ast.walk(tree(path)):
                if (
                    isinstance(node, ast.Call)
                    and sum(not isinstance(a, ast.Starred) for a in node.args) > MOST
                ):
                    yield str(path.relative_to(PACKAGE)), ast.unparse(node.func)


@pytest.mark.parametrize("room", ROOMS)
def test_no_call_has_more_than_six_values_by_position(room):
    assert not set(long_calls(room)) - set(TO_KERNELS)


def test_the_table_of_kernels_holds_what_is_needed():
    assert set(TO_KERNELS) == {call for room in ROOMS for call in long_calls(room)}


def test_class_names_of_the_cutting_rooms_stand_once():
    where: dict[str, list[str]] = {}
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.ClassDef):
                where.setdefault(node.name, []).append(str(path.relative_to(PACKAGE)))
    twice = {
        n: sorted(f) for n, f in where.items() if len(f) > 1 and any(x.split("/")[0] in ROOMS for x in f)
    }
    assert not twice
