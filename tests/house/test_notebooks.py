"""Every notebook runs from top to bottom. They are kept as Python files in percent format; jupytext reads them.

All run in this process, cell by cell, which spares the start of a kernel and every import; one runs in a kernel too.
"""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "notebooks").glob("*.py"))
IN_A_KERNEL = "test_piece"  # the quickest
LONG = (  # more than three seconds each: make test-all
    "05_cutting_before_cutting",
    "07_diagnosing_a_real_log",
    "09_a_year_of_one_machine",
    "abbe_milling",
    "five_papers",
    "marin2004",
    "measured_block",
)
pytestmark = pytest.mark.usefixtures("few_parts")
RUN = [pytest.param(p, id=p.stem, marks=[pytest.mark.thorough] if p.stem in LONG else []) for p in NOTEBOOKS]


def read(path: Path) -> Any:
    jupytext = pytest.importorskip("jupytext", reason="jupytext is not installed; pip install vcmm[notebook]")
    return jupytext.read(path, fmt="py:percent")


def run_cell(source: str, name: str, namespace: dict[str, Any]) -> None:
    """As a kernel does: run the cell, and show what its last line is worth."""
    tree = ast.parse(source, name)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, name, "exec"), namespace)
    if isinstance(last, ast.Expr):
        repr(eval(compile(ast.Expression(last.value), name, "eval"), namespace))


@pytest.mark.thorough
@pytest.mark.parametrize("path", RUN)
def test_notebook_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.chdir(tmp_path)
    cells = [cell for cell in read(path).cells if cell.cell_type == "code"]
    assert cells, f"{path.name} has no code cell; cells start with # %%"
    namespace: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(cells, 1):
        run_cell(cell.source, f"{path.name}, code cell {number}", namespace)


def test_a_cell_fails_with_its_name_and_shows_its_last_line():
    shown = []
    namespace: dict[str, Any] = {"Loud": type("Loud", (), {"__repr__": lambda self: shown.append(1) or ""})}
    run_cell("a = 1\nLoud()", "cell", namespace)
    assert (namespace["a"], shown) == (1, [1])
    with pytest.raises(ZeroDivisionError):
        run_cell("1 / 0", "cell", namespace)


@pytest.mark.thorough
def test_a_notebook_runs_in_a_kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed; pip install vcmm[notebook]")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed; pip install vcmm[notebook]")
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))  # no profile of the person who runs the test
    work = tmp_path / "work"
    work.mkdir()
    notebook = read(next(p for p in NOTEBOOKS if p.stem == IN_A_KERNEL))
    client = nbclient.NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(work)}}
    )
    client.execute()  # raises with the failing cell and its traceback
    assert [cell for cell in notebook.cells if cell.cell_type == "code" and cell.execution_count]
