"""A cutting scenario and its set-up moved to the pose found: the owner's texts and comments stay as they are."""

from __future__ import annotations

import re
from pathlib import Path

from vcmm.core.errors import DataError
from vcmm.core.pose import Array
from vcmm.files.placed import moved_names, number_text, placed_text
from vcmm.files.toml import read_toml
from vcmm.machining.scenario import CutScenario

_VALUE = r"""("[^"]*"|'[^']*'|\[[^\]]*\])"""


def placed_cut(source: Path, scenario: CutScenario, folder: Path, pose: Array, by: Array) -> dict[str, str]:
    """File name -> text: placed.toml and the set-up that it names, part and work offsets moved by `by` (3,) mm.

    pose (6,): the pose found. Raises DataError, with the line, for a value that is written over several lines.
    """
    setup = scenario.setup.path
    assert setup is not None
    name = "placed-setup.toml"
    document = read_toml(source)
    text = source.read_text(encoding="utf-8-sig")
    if "pose" in document.data:
        text = placed_text(source, folder / "placed.toml", pose)
    else:
        text = moved_names(text, source.parent, folder)
    lines = text.splitlines()
    _exchange(lines, document.lines[("cut", "setup")], "setup", f'"{name}"', source)
    at = document.lines.get(("cut", "work_offset", "at"))
    if at is not None and scenario.set_at is not None:
        _exchange(lines, at, "at", _point(scenario.set_at, by), source)
    return {"placed.toml": "\n".join(lines) + "\n", name: _setup_text(setup, scenario, folder, by)}


def _setup_text(setup: Path, scenario: CutScenario, folder: Path, by: Array) -> str:
    """The set-up with every work offset moved."""
    lines = moved_names(setup.read_text(encoding="utf-8-sig"), setup.parent, folder).splitlines()
    where = read_toml(setup).lines
    for name, point in scenario.setup.offsets.items():
        line = where.get(("offsets", name))
        if line is not None:
            _exchange(lines, line, f'(?:"{re.escape(name)}"|{re.escape(name)})', _point(point, by), setup)
    return "\n".join(lines) + "\n"


def _point(point: tuple[float, float, float], by: Array) -> str:
    return "[" + ", ".join(f'"{number_text(p + d, 6)} mm"' for p, d in zip(point, by)) + "]"


def _exchange(lines: list[str], line: int, key: str, value: str, file: Path) -> None:
    """Replace the value of a key (a pattern) in a line, counted from 1."""
    found = re.search(rf"(?<![\w.-]){key}\s*=\s*{_VALUE}", lines[line - 1])
    if not found:
        raise DataError(
            f"{file}:{line}: this value goes over several lines; write it on one, then it can be moved"
        )
    old = lines[line - 1]
    lines[line - 1] = old[: found.start(1)] + value + old[found.end(1) :]
