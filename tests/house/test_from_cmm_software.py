"""docs/from_cmm_software.md runs: its files are written, its commands executed in their order, and do what the page says."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from tests.house.test_docs import ROOT, blocks
from vcmm.face.cli import run

PAGE = ROOT / "docs" / "from_cmm_software.md"


@pytest.mark.thorough
def test_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    said, commands = {}, []
    for block in blocks(PAGE):
        if block.note:
            (tmp_path / block.note).write_text(block.text, encoding="utf-8")
        elif block.language == "sh":
            for line in block.text.splitlines():
                commands.append(line)
                assert run(shlex.split(line)[1:]) in (0, 1), (line, capsys.readouterr().err)
                printed = capsys.readouterr()
                said[line] = " ".join((printed.out + printed.err).split())
    assert len(commands) == 6
    calypso, report, made, points, values = (said[c] for c in commands[1:])
    assert "17" in calypso
    assert "18" in calypso
    assert "left out: roundness" in calypso
    assert "POS1.X, POS1.TP" in report
    assert "3 values" in made
    assert "states no unit; millimetres are taken" in points
    assert "50.0012" in values
    assert (tmp_path / "everything" / "values.csv").read_text().splitlines()[1:] == [
        "diameter,50.0012,",
        "POS1.X,0.0031,",
        "POS1.TP,0.0062,",
    ]
    assert (
        "meanError" in (tmp_path / "ring.qif").read_text() or "Value>" in (tmp_path / "ring.qif").read_text()
    )
    # U = 0.54 um: two digits of it are five decimals (K2022)
    assert "K0001/1 50.00120\n" in (tmp_path / "ring.dfq").read_text()
