"""A scenario file with a new [pose]: the owner's text and comments stay as they are."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from vcmm.errors import DataError
from vcmm.files.toml import read_toml
from vcmm.pose import Array

_NAME = re.compile(r'"([^"\n]+\.[A-Za-z0-9]+)"' + r"|'([^'\n]+\.[A-Za-z0-9]+)'")


def placed_text(source: Path, target: Path, pose: Array) -> str:
    """Text of the scenario with the pose (6: mm, rad), to be written to `target`.

    Names of files that lie beside the source are rewritten as seen from the new folder.
    Raises DataError where [pose] is written in a way that cannot be edited.
    """
    text = source.read_text(encoding="utf-8-sig")
    shift = f'"{" ".join(_number(v, 6) for v in pose[:3])} mm"'
    turn = f'"{" ".join(_number(v, 9) for v in np.degrees(pose[3:]))} deg"'
    lines = text.splitlines()
    where = read_toml(source).lines
    if ("pose",) not in where:
        lines += ["", "[pose]", f"shift = {shift}", f"turn = {turn}"]
    else:
        lines = _edited(lines, where.get(("pose",), 0), shift, turn, source)
    return _moved("\n".join(lines) + "\n", source.parent, target.parent)


def _number(value: float, digits: int) -> str:
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _edited(lines: list[str], first: int, shift: str, turn: str, source: Path) -> list[str]:
    """The lines with the keys of [pose] (which starts at line `first`, 1-based) replaced or added."""
    head = lines[first - 1]
    inline = re.match(r"(\s*pose\s*=\s*)\{[^}]*\}(.*)$", head)
    if inline:
        lines[first - 1] = f"{inline[1]}{{ shift = {shift}, turn = {turn} }}{inline[2]}"
        return lines
    if not re.match(r"\s*\[\s*pose\s*\]", head):
        raise DataError(
            f"{source}:{first}: the pose is not written as [pose] with shift and turn; write it so, then it can be replaced"
        )
    missing = {"shift": shift, "turn": turn}
    for i in range(first, len(lines)):
        if re.match(r"\s*\[", lines[i]):
            break
        key = re.match(r"\s*(shift|turn)\s*=", lines[i])
        if key:
            lines[i] = _with_value(lines[i], missing.pop(key[1]), f"{source}:{i + 1}")
    return lines[:first] + [f"{k} = {v}" for k, v in missing.items()] + lines[first:]


def _with_value(line: str, value: str, where: str) -> str:
    """The line with its text or list of texts replaced; indentation and comment stay."""
    found = re.match(r"""(\s*\w+\s*=\s*)("[^"]*"|'[^']*'|\[[^\]]*\])(.*)$""", line)
    if not found:
        raise DataError(
            f"{where}: this value goes over several lines; write it on one, then it can be replaced"
        )
    return f"{found[1]}{value}{found[3]}"


def _moved(text: str, old: Path, new: Path) -> str:
    """Names of files, seen from the new folder."""

    def moved(match: re.Match[str]) -> str:
        name = match[1] or match[2]
        there = old / name
        return f'"{os.path.relpath(there, new)}"' if there.is_file() else match[0]

    return text if old.resolve() == new.resolve() else _NAME.sub(moved, text)
