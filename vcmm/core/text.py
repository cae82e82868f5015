"""Read a text file, or say why it cannot be read and which files lie beside it."""

from __future__ import annotations

from pathlib import Path

from vcmm.core.errors import DataError, did_you_mean


def read_text(path: Path) -> str:
    """The text of a UTF-8 file, with or without byte order mark. Raises DataError naming the file and the fix."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise DataError(f"{path} does not exist.{_beside(path)}") from None
    except UnicodeDecodeError as error:
        raise DataError(
            f"{path} is not UTF-8 text ({error.reason} at byte {error.start}); save it as UTF-8"
        ) from None
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror}") from None


def _beside(path: Path) -> str:
    """' Did you mean "plate.toml"?' or the files of that kind in the folder."""
    if not path.parent.is_dir():
        return f" There is no folder {path.parent}"
    near = sorted(p.name for p in path.parent.glob(f"*{path.suffix}") if p.is_file())
    listed = f" Files there: {', '.join(near[:8])}" if near and path.suffix else ""
    return did_you_mean(path.name, near) or listed
