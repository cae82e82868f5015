"""The recording files of a folder."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path

from vcmm.core.errors import DataError, UsageError
from vcmm.files.toml import read_toml

ALIKE = 0.8  # of the letters, from which "recordings" or "recoding" is a recording mistyped


def recordings_in(folder: Path) -> list[Path]:
    """Return recording files in a folder and below it: TOML files that state so, those that cannot be read and may be some, and those
    whose first line is
    mistyped or missing: reading them refuses them, where passing them over would leave a recording out in silence.

    Raises UsageError where there is none.
    """
    files = [p for p in sorted(folder.rglob("*.toml")) if p.is_file() and _may_be_recording(p)]
    if not files:
        raise UsageError(
            f'{folder} holds no recording: no .toml file there says vcmm = "recording/1"; name another folder, or the file itself'
        )
    return files


def _may_be_recording(path: Path) -> bool:
    try:
        data = read_toml(path).data
    except DataError:
        return b"recording/" in path.read_bytes()[:100_000]
    tag = str(data.get("vcmm", ""))
    if not tag:
        return {"data", "kind", "machine"} <= data.keys()
    return bool(get_close_matches(tag.partition("/")[0].lower(), ["recording"], cutoff=ALIKE))
