"""Result files: one JSON line per case, written as soon as it is scored, so that a stop loses nothing.

Starting the same command again skips the cases that the file holds. Files of several runs can be summarised together.
"""

from __future__ import annotations

import gzip
import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

Row = dict[str, Any]
Key = tuple[str, int, int, float, int | None]


def key_of(row: Mapping[str, Any]) -> Key:
    """What makes a case: block, seed, number, strength asked for, rows asked for."""
    return (row["block"], row["seed"], row["case"], row["delta_asked"], row["rows_asked"])


def append(path: Path, row: Mapping[str, Any]) -> None:
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(_short(row), allow_nan=False, default=str) + "\n")


def _short(value: Any) -> Any:
    """Numbers to seven digits, what is not finite as null."""
    if isinstance(value, Mapping):
        return {k: _short(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_short(v) for v in value]
    if isinstance(value, float):
        return float(f"{value:.7g}") if math.isfinite(value) else None
    return value


def read(paths: Sequence[Path]) -> list[Row]:
    """Rows of all files (.gz or plain), each case once, the last one written. Raises ValueError naming file and line."""
    rows: dict[Key, Row] = {}
    for path in paths:
        whole = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
        for number, line in enumerate(whole.decode("utf-8").splitlines(), 1):
            try:
                row = json.loads(line)
                rows[key_of(row)] = row
            except (json.JSONDecodeError, KeyError, TypeError) as wrong:
                raise ValueError(
                    f"{path}, line {number}: no row of the exam ({wrong}); delete the line"
                ) from None
    return list(rows.values())


def done(path: Path | None) -> set[Key]:
    """Cases that need not run again: those answered. A case that failed to run is tried anew."""
    if path is None or not path.exists():
        return set()
    _without_half_a_line(path)
    return {key_of(r) for r in read([path]) if not r.get("error")}


def grouped(rows: Iterable[Row]) -> dict[tuple[str, float], list[Row]]:
    """(block, delta asked for) -> rows in the order of seed and number."""
    out: dict[tuple[str, float], list[Row]] = {}
    for row in sorted(rows, key=lambda r: (r["block"], -r["delta_asked"], r["seed"], r["case"])):
        out.setdefault((row["block"], row["delta_asked"]), []).append(row)
    return out


def _without_half_a_line(path: Path) -> None:
    """Cut off what a run that was killed while it wrote has left; the case runs again."""
    whole = path.read_bytes()
    if path.suffix != ".gz" and not whole.endswith(b"\n"):
        os.truncate(path, whole.rfind(b"\n") + 1)
