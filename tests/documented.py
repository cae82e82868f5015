"""What the documentation shows of a twin is what its command prints; one run of the twin serves all its tests."""

from __future__ import annotations

import inspect
from pathlib import Path
from types import ModuleType
from typing import Any

from vcmm.show.report.blocks import escape
from vcmm.show.tables.table import text

DOCS = Path(__file__).resolve().parent.parent / "docs"


def assert_documented(name: str, tables: list[Any]) -> None:
    """Every table stands in docs/NAME.md with its caption."""
    written = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    for table in tables:
        assert text(table) in written, table.title
        assert table.caption in written


def assert_titled(page: ModuleType, scenario: Any, result: Any) -> None:
    """The report holds every table by its title."""
    report = page.twin_page(scenario, result)
    assert all(escape(table.title) in report for table in page.tables(result))


def instead(monkeypatch: Any, twin: ModuleType, name: str, result: Any, **options: int) -> None:
    """Let the command take `result`, which `twin.run` gave for the scenario of this name and these options."""

    def run(scenario: Any, *, progress: Any, **given: int) -> Any:
        assert (scenario.program.parent.name, given) == (name, options)
        return result

    run.__signature__ = inspect.signature(twin.run)  # type: ignore[attr-defined]
    monkeypatch.setattr(twin, "run", run)
