"""Which tests call which functions of vcmm, and how long they take: a plugin of pytest, and what is made of its record.

    python -m pytest -p mutant_map ...      (with VCMM_MUTANT_MAP set to a folder)

writes one JSON file per process: test -> seconds of computing, outcome and the functions "file:qualified name" that it or
one of its fixtures called in that process. Compiled code and other processes are not seen; `Coverage.noticing` falls back on the
imports of the tests there.
"""

from __future__ import annotations

import ast
import json
import os
import sys
import time
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest

PACKAGE = str(Path.cwd() / "vcmm") + os.sep
_called: set[CodeType] = set()
_by_fixture: dict[int, set[CodeType]] = {}
_record: dict[str, dict[str, Any]] = {}


def _tracer(frame: FrameType, event: str, argument: object) -> None:
    del event, argument
    _called.add(frame.f_code)


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: Any) -> Generator[None, object, object]:
    """What a fixture calls counts for every test that uses it, not only for the first."""
    global _called
    outside, _called = _called, set()
    sys.settrace(_tracer)
    try:
        return (yield)
    finally:
        _by_fixture.setdefault(id(fixturedef), set()).update(_called)
        _called = outside


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: Any) -> Generator[None, object, object]:
    _called.clear()
    begin = time.process_time()
    sys.settrace(_tracer)
    try:
        return (yield)
    finally:
        sys.settrace(None)
        _entry(item.nodeid)["seconds"] = time.process_time() - begin
        calls = set(_called)
        for definitions in getattr(item, "_fixtureinfo", item).name2fixturedefs.values():
            for one in definitions:
                calls |= _by_fixture.get(id(one), set())
        _entry(item.nodeid)["calls"] = sorted({_name(c) for c in calls if c.co_filename.startswith(PACKAGE)})


def pytest_runtest_logreport(report: Any) -> None:
    if "PYTEST_XDIST_WORKER" in os.environ or not hasattr(report, "node"):
        one = _entry(report.nodeid)
        one["passed"] = one["passed"] and report.passed


def pytest_sessionfinish() -> None:
    if any(one["calls"] for one in _record.values()):
        target = Path(os.environ["VCMM_MUTANT_MAP"]) / f"map-{os.getpid()}.json"
        target.write_text(json.dumps(_record), encoding="utf-8")


def _entry(test: str) -> dict[str, Any]:
    return _record.setdefault(test, {"seconds": 0.0, "passed": True, "calls": []})


def _name(code: CodeType) -> str:
    return f"vcmm/{Path(code.co_filename[len(PACKAGE) :]).as_posix()}:{code.co_qualname}"


# ---------------------------------------------------------------------- what is made of it


@dataclass(frozen=True)
class Coverage:
    """The record of a run of all tests: test -> seconds, and function -> tests that passed and call it."""

    root: Path
    seconds: dict[str, float]
    callers: dict[str, set[str]]

    @classmethod
    def read(cls, root: Path, folder: Path) -> Coverage:
        seconds: dict[str, float] = {}
        callers: dict[str, set[str]] = {}
        for file in folder.glob("map-*.json"):
            for test, one in json.loads(file.read_text(encoding="utf-8")).items():
                if one["passed"] and one["calls"]:
                    seconds[test] = one["seconds"]
                    for function in one["calls"]:
                        callers.setdefault(function, set()).add(test)
        return cls(root, seconds, callers)

    def noticing(self, file: str, owner: str) -> list[str]:
        """Tests that can notice a change, the likeliest first: those that call the function, then those that know the file.

        Of each the tests of the same name come first, then those of the same room, the quick before the slow.
        """
        calling = self.callers.get(f"{file}:{owner}", set()) if owner else set()
        knowing = {t for t in self.seconds if file in self.files_of(t.split("::")[0])}
        above = self._above_kernels(file) if file.endswith("_kernels.py") else ()
        knowing |= {t for one in (file, *above) for f in self._callers_of_file(one) for t in self.callers[f]}
        return [*self._ranked(file, calling), *self._ranked(file, knowing - calling)]

    def _above_kernels(self, kernels: str) -> set[str]:
        """Files that lead to compiled loops, whose calls are not seen."""
        every = {name.split(":")[0] for name in self.callers}
        return {f for f in every if kernels in _kernels_behind(self.root, (f,))}

    def _callers_of_file(self, file: str) -> Iterator[str]:
        return (f for f in self.callers if f.startswith(f"{file}:"))

    def _ranked(self, file: str, tests: Iterable[str]) -> list[str]:
        room, stem = file.split("/")[1:-1], Path(file).stem.lstrip("_")
        folder = "/".join(["tests", *room]) + "/"

        def rank(test: str) -> tuple[int, float, str]:
            own = test.startswith(f"{folder}test_{stem}.py")
            slow = test.startswith("tests/house/")
            return (
                (0 if own else 1 if test.startswith(folder) else 3 if slow else 2),
                self.seconds[test],
                test,
            )

        return sorted(tests, key=rank)

    def files_of(self, test_file: str) -> frozenset[str]:
        """Files of vcmm that a test file imports itself, and the kernels behind them."""
        if test_file not in self._imports:
            direct = _imported(self.root, self.root / test_file)
            self._imports[test_file] = frozenset(direct | _kernels_behind(self.root, direct))
        return self._imports[test_file]

    @cached_property
    def _imports(self) -> dict[str, frozenset[str]]:
        return {}


def _kernels_behind(root: Path, files: Iterable[str]) -> set[str]:
    """The compiled loops that files call, and the loops that these call in turn."""
    behind: set[str] = set()
    left = set(files)
    while left:
        left = {k for f in left for k in _imported(root, root / f) if k.endswith("_kernels.py")} - behind
        behind |= left
    return behind


def _imported(root: Path, file: Path) -> set[str]:
    """Modules of vcmm, as files within root, that a file imports anywhere."""
    if not file.is_file():
        return set()
    names = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    paths = (
        name.replace(".", "/") + end
        for name in names
        if name.startswith("vcmm")
        for end in (".py", "/__init__.py")
    )
    return {path for path in paths if (root / path).is_file()}
