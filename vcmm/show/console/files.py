"""Write files as a whole or not at all."""

from __future__ import annotations

from pathlib import Path

from vcmm.core.errors import Environment
from vcmm.core.whole_files import write_files

__all__ = ["output_folder", "write_files", "write_text"]


def output_folder(path: Path) -> Path:
    """Make sure that a folder can be made and written. Raises Environment before any work is done.

    Nothing is left behind: the folder comes into being with the first file that is written into it, so that a
    command that fails leaves no empty folder.
    """
    missing = [p for p in (path, *path.parents) if not p.exists()]
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".vcmm-probe"
        probe.write_text("")
        probe.unlink()
        for made in missing:
            made.rmdir()
    except OSError as error:
        raise Environment(
            f"the folder {path} cannot be written ({error.strerror}); choose another with --out"
        ) from None
    return path


def write_text(path: Path, text: str) -> Path:
    """Write a whole file or nothing: a temporary file beside it, then a rename."""
    return write_files(path.parent, {path.name: text})[0]
