"""JSON documents: their frame with version, seed, hashes of all files read and warnings."""

from __future__ import annotations

import hashlib
import json
import math
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from vcmm import __version__
from vcmm.show.console.streams import writes_utf8


def document(
    schema: str,
    body: dict[str, Any],
    *,
    seed: int | None = None,
    files: Sequence[Path] = (),
    warnings: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the frame of every JSON document, each file once; a number that is not finite becomes null with a warning.

    warnings: sentences; each is written as severity, where, text and cure, and `warning_texts` holds the sentences alone.
    """
    from vcmm.show.report.notices import documents as as_documents

    notes = list(warnings)
    clean = _finite(body, "", notes)
    head = {
        "schema": schema,
        "version": __version__,
        "seed": seed,
        "inputs": [_file_hash(p) for p in {p.absolute(): p for p in files}.values()],
        "warnings": as_documents(notes),
        "warning_texts": notes,
    }
    return head | clean


def _finite(value: Any, where: str, notes: list[str]) -> Any:
    if isinstance(value, dict):
        return {k: _finite(v, f"{where}.{k}".lstrip("."), notes) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v, f"{where}[{_entry_name(v, i)}]", notes) for i, v in enumerate(value)]
    if isinstance(value, float) and not math.isfinite(value):
        notes.append(f"{where} is {value}")
        return None
    return value


def _entry_name(value: Any, number: int) -> str:
    """Return how an entry of a list is identified: by its name where it has one."""
    name = value.get("name") if isinstance(value, dict) else None
    return name if isinstance(name, str) and name else str(number)


def fingerprint(content: dict[str, Any]) -> str:
    """Return the SHA-256 of a document without its own key "sha256", which shows whether a file is unchanged."""
    plain = {key: value for key, value in content.items() if key != "sha256"}
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def _file_hash(path: Path) -> dict[str, str]:
    return {"file": str(path), "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}


def sources(path: Path) -> list[Path]:
    """Return a TOML file and all files it names that lie beside it, for the record of inputs; each once."""
    return sources_of_all([path])


def sources_of_all(paths: Iterable[Path]) -> list[Path]:
    """Return the same of several files, one after another; a file that many of them name is read once."""
    named, out = cache(_named_in), dict[Path, None]()
    for path in paths:
        reached = [path]
        for file in reached:  # grows while it is read
            if file.suffix == ".toml":
                reached += [p for p in named(file) if p not in reached]
        out.update(dict.fromkeys(reached))
    return list(out)


def _named_in(path: Path) -> list[Path]:
    """Return the files beside a TOML file whose names it holds as texts; none where the file is no valid TOML."""
    from vcmm.files.toml import find_file

    try:
        data = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError):
        return []
    beside = (find_file(text, path.parent) for text in sorted(set(_texts(data))))
    return [p for p in beside if p is not None]


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _texts(inner)


def print_json(content: dict[str, Any]) -> None:
    """Print exactly one document on stdout."""
    print(json.dumps(content, indent=1, ensure_ascii=not writes_utf8(), allow_nan=False))


def json_text(content: dict[str, Any]) -> str:
    """Return the document as written to a file."""
    return json.dumps(content, indent=1, allow_nan=False)
