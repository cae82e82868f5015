"""Read a TOML file and remember where everything stands, so that a message can name file and line."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vcmm.errors import DataError

Location = tuple[str | int, ...]


@dataclass(frozen=True)
class Document:
    """A parsed file. `lines` maps the path of a key to its line number (1 = first)."""

    path: Path
    data: dict[str, Any]
    lines: dict[Location, int]

    def where(self, location: Location) -> str:
        """'machine.toml:12', the line of the key or of the nearest table above it."""
        location = tuple(location)
        while location and location not in self.lines:
            location = location[:-1]
        return f"{self.path}:{self.lines.get(location, 1)}"

    def has(self, *location: str | int) -> bool:
        return tuple(location) in self.lines


def read_toml(path: str | Path) -> Document:
    """Parse a file. Raises DataError: missing, a folder, not text, or a TOML syntax error with its line."""
    path = Path(path)
    if path.is_dir():
        raise DataError(f"{path} is a folder; name the TOML file in it")
    if not path.exists():
        near = sorted(p.name for p in path.parent.glob("*.toml"))[:8] if path.parent.is_dir() else []
        raise DataError(f"{path} does not exist" + (f"; TOML files there: {', '.join(near)}" if near else ""))
    try:
        text = path.read_text(encoding="utf-8")
        data = tomllib.loads(text)
    except UnicodeDecodeError as error:
        raise DataError(
            f"{path} is not UTF-8 text ({error.reason} at byte {error.start}); save it as UTF-8"
        ) from None
    except tomllib.TOMLDecodeError as error:
        line = re.search(r"line (\d+)", str(error))
        at = f"{path}:{line[1]}" if line else str(path)
        raise DataError(f"{at}: this is not valid TOML: {error}; texts need quotes, keys need =") from None
    return Document(path, data, key_lines(text))


def check_version(document: Document, kind: str, version: int = 1) -> None:
    """Accept `kind/1 .. kind/version`; refuse others by name."""
    word = document.data.get("vcmm")
    at = document.where(("vcmm",))
    if word is None:
        raise DataError(f'{at}: the first line must be vcmm = "{kind}/{version}"')
    match = re.fullmatch(r"([a-z]+)/(\d+)", str(word))
    if not match or match[1] != kind:
        raise DataError(f'{at}: vcmm = "{word}", but a {kind} file is due here: vcmm = "{kind}/{version}"')
    if int(match[2]) > version:
        raise DataError(
            f'{at}: "{word}" was written by a newer vcmm; this one reads {kind}/1 to {kind}/{version}: update vcmm'
        )


def key_lines(text: str) -> dict[Location, int]:
    """Line of every key that starts a line, and of the keys of inline tables (on the line of their table)."""
    lines: dict[Location, int] = {}
    table: Location = ()
    counts: dict[Location, int] = {}
    for number, raw in enumerate(text.splitlines(), 1):
        line = raw.strip()
        if header := re.match(r"\[\[\s*([^\]]+?)\s*\]\]", line):
            name = _parts(header[1])
            counts[name] = counts.get(name, -1) + 1
            table = (*name, counts[name])
            lines.setdefault(name, number)
            lines[table] = number
        elif header := re.match(r"\[\s*([^\]]+?)\s*\]", line):
            table = _under_last(_parts(header[1]), counts)
            lines.setdefault(table, number)
        elif key := re.match(r"""((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"))*)\s*=""", line):
            here = (*table, *_parts(key[1]))
            lines.setdefault(here, number)
            for inner in re.findall(r"[{,]\s*([\w-]+)\s*=", line[key.end() :]):
                lines.setdefault((*here, inner), number)
    return lines


def _parts(dotted: str) -> Location:
    return tuple(part.strip().strip("\"'") for part in re.findall(r'"[^"]*"|[^.]+', dotted))


def _under_last(name: Location, counts: dict[Location, int]) -> Location:
    """[plan.steps.points] after [[plan.steps]] belongs to the last step."""
    for cut in range(len(name), 0, -1):
        if name[:cut] in counts:
            return (*name[:cut], counts[name[:cut]], *name[cut:])
    return name
