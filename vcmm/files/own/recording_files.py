"""The recording files of a folder."""

from __future__ import annotations

from pathlib import Path

from vcmm.core.errors import DataError, UsageError
from vcmm.files.toml import read_toml


def recordings_in(folder: Path) -> list[Path]:
    """Recording files in a folder and below it: TOML files that say so, and those that cannot be read and may be some.

    Raises UsageError where there is none.
    """
    found = [p for p in sorted(folder.rglob("*.toml")) if p.is_file() and _may_be_recording(p)]
    if not found:
        raise UsageError(
            f'{folder} holds no recording: no .toml file there says vcmm = "recording/1"; name another folder, or the file itself'
        )
    return found


def _may_be_recording(path: Path) -> bool:
    try:
        return str(read_toml(path).data.get("vcmm", "")).startswith("recording/")
    except DataError:
        return b"recording/" in path.read_bytes()[:100_000]
