"""The mark of a compensated program: its inputs, as comments that every control accepts."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vcmm.compensation.refusals import MARK
from vcmm.compensation.source import SourceText
from vcmm.core.effect import parameter_fields
from vcmm.core.machine import Machine
from vcmm.program.dialects import Dialect

LONGEST = 60  # characters of a comment: old controls show no more
_O_NUMBER = re.compile(
    r"\s*[O:]\s*\d+\s*(?:\(|$)", re.IGNORECASE
)  # no O-word: those go on with sub, if, while

SEMICOLON = ("sinumerik", "heidenhain")  # dialects whose comments begin with a semicolon
_HEADS = {
    "sinumerik": re.compile(r"\s*(?:%|;\$PATH|PROC\b)", re.IGNORECASE),
    "heidenhain": re.compile(r"\s*(?:\d+\s+)?BEGIN\s+PGM\b", re.IGNORECASE),
}


def digest(parts: Sequence[bytes]) -> str:
    """Return twelve characters that change with any of the inputs."""
    whole = hashlib.sha256()
    for part in parts:
        whole.update(hashlib.sha256(part).digest())
    return whole.hexdigest()[:12]


def file_parts(paths: Sequence[Path | None]) -> list[bytes]:
    return [p.read_bytes() for p in paths if p is not None]


def machine_parts(machine: Machine) -> list[bytes]:
    """Return the content of a machine that came from no file of its own."""
    out = [machine.name.encode("utf-8"), machine.chain.structure.encode("utf-8")]
    for effect in machine.effects:
        values = [np.asarray(getattr(effect, f.name)) for f in parameter_fields(effect)]
        grids = [np.asarray(g, dtype=float) for g in getattr(effect, "grids", ())]
        out += [
            effect.id.encode("utf-8"),
            *(np.asarray(v, dtype=float).tobytes() for v in (*values, *grids) if v.dtype.kind in "fiu"),
        ]
    return out


def comment(text: str, dialect: Dialect) -> str:
    """Return a comment: capitals, digits and plain signs only, no brackets inside."""
    if dialect.name in SEMICOLON:
        return f"; {' '.join(re.sub(r'[^ -:<-}]', ' ', text).split())[:LONGEST]}"
    clean = (
        re.sub(r"[^A-Z0-9 .,=/+-]", " ", text.upper())
        if dialect.words == "macro"
        else re.sub(r"[()]", " ", text)
    )
    return f"({' '.join(clean.split())[:LONGEST]})"


def header(machine: str, tolerance: float, hashed: str, dialect: Dialect) -> list[str]:
    """Return the lines of the mark."""
    lines = (
        f"{MARK} - DO NOT COMPENSATE AGAIN",
        f"MACHINE {machine}",
        f"TOLERANCE {tolerance * 1e3:g} um",
        f"HASH {hashed}",
    )
    return [comment(text, dialect) for text in lines]


def place(source: SourceText, dialect: Dialect) -> int:
    """Return the index of the line before which the mark is placed: behind % and the O number, %_N_NAME_MPF and its path, BEGIN PGM."""
    if dialect.name in SEMICOLON:
        head = _HEADS[dialect.name]
        at = 0
        while at < len(source.lines) and (not source.lines[at][0].strip() or head.match(source.lines[at][0])):
            at += 1
        return at if any(head.match(line) for line, _ in source.lines[:at]) else 0
    at = _code_from(source, 0)
    percent = at < len(source.lines) and source.lines[at][0].strip().startswith("%")
    begin = at + 1 if percent else 0
    at = _code_from(source, begin)
    if at < len(source.lines) and _O_NUMBER.match(source.lines[at][0]):
        return at + 1
    return begin


def _code_from(source: SourceText, at: int) -> int:
    """Return the index of the first line from `at` on that is not blank."""
    while at < len(source.lines) and not source.lines[at][0].strip():
        at += 1
    return at
