"""Every notebook runs from top to bottom. They are kept as Python files in percent format; jupytext reads them."""

from __future__ import annotations

from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "notebooks").glob("*.py"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    jupytext = pytest.importorskip("jupytext", reason="jupytext is not installed; pip install vcmm[notebook]")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed; pip install vcmm[notebook]")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed; pip install vcmm[notebook]")
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))  # no profile of the person who runs the test
    work = tmp_path / "work"
    work.mkdir()
    notebook = jupytext.read(path, fmt="py:percent")
    client = nbclient.NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(work)}}
    )
    client.execute()  # raises with the failing cell and its traceback
    ran = [cell for cell in notebook.cells if cell.cell_type == "code" and cell.execution_count]
    assert ran, f"{path.name} has no code cell; cells start with # %%"
