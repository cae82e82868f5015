"""The gallery: its pictures are those that the commands write today, their numbers those of the table."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from vcmm.face.cli import run

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def gallery() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_gallery", ROOT / "docs" / "make_gallery.py")
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    sys.modules["make_gallery"] = made
    spec.loader.exec_module(made)
    return made


def stored(name: str) -> dict[str, Any]:
    return dict(json.loads((ROOT / "docs" / "gallery" / f"{name}.json").read_text()))


def flat(value: Any) -> list[Any]:
    if isinstance(value, dict):
        return [x for k in sorted(value) for x in (k, *flat(value[k]))]
    return [x for v in value for x in flat(v)] if isinstance(value, list) else [value]


def test_the_page_names_what_there_is(gallery: ModuleType) -> None:
    assert (ROOT / "docs" / "gallery.md").read_text() == gallery.page()
    for p in gallery.PICTURES:
        svg = (ROOT / "docs" / "gallery" / f"{p.name}.svg").read_text()
        assert svg.startswith("<svg xmlns=")
        assert not re.search(r"<script|https?://(?!www\.w3\.org)", svg)
        assert (ROOT / "notebooks" / f"{p.notebook}.py").is_file()
        assert stored(p.name)["chart"] == p.chart


@pytest.mark.parametrize(
    "name",
    [
        "positioning",
        "ballbar",
        *(pytest.param(n, marks=pytest.mark.thorough) for n in ("decision", "waterfall", "before", "boxes")),
    ],
)
def test_a_command_still_makes_its_picture(gallery: ModuleType, name: str, tmp_path: Path) -> None:
    picture = next(p for p in gallery.PICTURES if p.name == name)
    gallery.lay_out(tmp_path)
    numbers, _ = gallery.take(picture, tmp_path, set())
    for a, b in zip(flat(numbers), flat(stored(name)), strict=True):
        assert a == (pytest.approx(b, rel=1e-6, abs=1e-9) if isinstance(b, float) else b)


def test_the_band_chart_is_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A, R, E, B, M of the kept picture, and what its arrows span, against the document of the command."""
    assert run(["test", str(ROOT / "docs" / "gallery" / "axis.toml"), "--iso", "230-2", "--json"]) == 0
    table = {f["name"]: f["value_um"] for f in json.loads(capsys.readouterr().out)["figures"]}
    shown = stored("positioning")
    for name, value in shown["figures"].items():
        assert value == pytest.approx(table[f"{name} X"], rel=1e-9)
    for name, (low, high) in shown["spans"].items():
        assert high - low == pytest.approx(table[f"{name} X"], rel=1e-9)
