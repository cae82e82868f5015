"""Every kind of page has its screen, small enough for a repository."""

from __future__ import annotations

import importlib.util
import struct
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MOST = 100_000  # bytes of one picture


def test_every_page_has_its_screen() -> None:
    spec = importlib.util.spec_from_file_location("screens", ROOT / "tools" / "screens.py")
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    sys.modules["screens"] = tool
    spec.loader.exec_module(tool)
    wanted = {s.name for s in tool.SCREENS} | {f"{s.name}-390" for s in tool.SCREENS if s.narrow}
    found = {p.stem: p for p in tool.FOLDER.glob("*.png")}
    assert found.keys() == wanted
    for name, path in found.items():
        data = path.read_bytes()
        assert len(data) < MOST, name
        width, height = struct.unpack(">II", data[16:24])
        if name.endswith("-390"):
            assert (width, height) == (390, 800)
