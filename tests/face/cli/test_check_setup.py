"""What `vcmm check` says of a set-up file."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.face.cli import run

SETUP = """vcmm = "setup/1"
dialect = "fanuc"
[offsets]
G54 = ["100 mm", "50 mm", "-200 mm"]
[tools.1]
length = "80 mm"
diameter = "10 mm"
shape = "flat"
"""


def test_offsets_and_tools_are_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "setup.toml").write_text(SETUP)
    assert run(["check", str(tmp_path / "setup.toml")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "offset G54 work zero at 100 50 -200 mm" in said
    assert "tool 1 flat, length 80 mm, diameter 10 mm" in said
