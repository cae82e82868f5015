"""A scenario file with a new [pose]: the owner's text and comments stay as they are."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.pose import Array
from vcmm.files.toml import read_toml

_NAME = re.compile(r'"([^"\n]+\.[A-Za-z0-9]+)"' + r"|'([^'\n]+\.[A-Za-z0-9]+)'")


def placed_text(
    source: Path, target: Path, pose: Array, machine: Path | None = None, convenient: Array | None = None
) -> str:
    """Text of the scenario with the pose (6: mm, rad), to be written to `target`.

    Names of files that lie beside the source are rewritten as seen from the new folder. machine: a file that takes the
    place of the scenario's machine. convenient (6,): a pose in round numbers that is nearly as good, named in a comment.
    Raises DataError where [pose] or the machine is written in a way that cannot be edited.
    """
    text = source.read_text(encoding="utf-8-sig")
    shift, turn = _pair(pose)
    lines = text.splitlines()
    where = read_toml(source).lines
    if ("pose",) not in where:
        lines += ["", "[pose]", f"shift = {shift}", f"turn = {turn}"]
        first = len(lines) - 2
    else:
        first = where.get(("pose",), 0)
        lines = _edited(lines, first, shift, turn, source)
    if convenient is not None:
        round_shift, round_turn = _pair(convenient)
        lines.insert(
            first, f"# in round numbers and nearly as good: shift = {round_shift}, turn = {round_turn}"
        )
    moved = moved_names("\n".join(lines) + "\n", source.parent, target.parent)
    if machine is None:
        return moved
    return _with_machine(moved, os.path.relpath(machine, target.parent), source)


def _pair(pose: Array) -> tuple[str, str]:
    """Shift and turn of a pose (6,) as values of a file."""
    turns = " ".join(number_text(v, 9) for v in np.degrees(pose[3:]))
    return f'"{" ".join(number_text(v, 6) for v in pose[:3])} mm"', f'"{turns} deg"'


def _with_machine(text: str, name: str, source: Path) -> str:
    """The text with another machine file; tables that described the machine go, with the comments inside them."""
    kept: list[str] = []
    heading: list[str] = []  # blank lines and comments that stand over the next table
    inside = False
    for line in text.splitlines():
        header = re.match(r"\s*\[\[?\s*([A-Za-z0-9_-]+)", line)
        if header and header[1] != "machine" and inside:
            kept += heading
        inside = header[1] == "machine" if header else inside
        heading = [*heading, line] if re.match(r"\s*(#|$)", line) else []
        if not inside:
            kept.append(line)
    first = next((i for i, line in enumerate(kept) if re.match(r"\s*\[", line)), len(kept))
    for i in range(first):
        if re.match(r"\s*machine\s*[=.]", kept[i]):
            found = re.match(r"""(\s*machine\s*=\s*)("[^"]*"|'[^']*')(.*)$""", kept[i])
            if not found:
                raise DataError(
                    f'{source}: the machine is not written as machine = "file" or [machine]; write it so, then it can be replaced'
                )
            kept[i] = f'{found[1]}"{name}"{found[3]}'
            return "\n".join(kept) + "\n"
    after = max((i + 1 for i in range(first) if not re.match(r"\s*(#|$)", kept[i])), default=first)
    return "\n".join([*kept[:after], f'machine = "{name}"', *kept[after:]]) + "\n"


def number_text(value: float, digits: int) -> str:
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


def moved_names(text: str, old: Path, new: Path) -> str:
    """Names of files, seen from the new folder."""

    def moved(match: re.Match[str]) -> str:
        name = match[1] or match[2]
        there = old / name
        return f'"{os.path.relpath(there, new)}"' if there.is_file() else match[0]

    return text if old.resolve() == new.resolve() else _NAME.sub(moved, text)
