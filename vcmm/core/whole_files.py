"""Write a file as a whole or not at all, and a set of files all or none."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
from collections.abc import Mapping
from pathlib import Path

from vcmm.core.errors import Environment
from vcmm.core.own_files import check_replacing


def write_files(folder: Path, texts: Mapping[str, str]) -> list[Path]:
    """Write several files (name, with folders below `folder` -> text), all or none. Raises Environment, and UsageError where
    one would replace what the command under way has read.

    Drafts beside them first, then renames; where one rename fails, or is interrupted, the files that had been replaced
    are put back. Drafts have names of their own, so two processes do not write into one another's.
    """
    token = f"{os.getpid()}-{secrets.token_hex(3)}"
    paths = [folder / name for name in texts]
    check_replacing(paths)
    drafts = {path.with_name(f".{path.name}.{token}.part"): path for path in paths}
    before: dict[Path, Path | None] = {}  # file -> what it was, None where it was not there
    try:
        for draft, text in zip(drafts, texts.values()):
            draft.parent.mkdir(parents=True, exist_ok=True)
            draft.write_text(text, encoding="utf-8", errors="backslashreplace")
        for draft, path in drafts.items():
            before[path] = _keep_copy(path, token)
            draft.replace(path)
    except BaseException as error:
        for path, old in before.items():
            with contextlib.suppress(OSError):
                path.unlink() if old is None else old.replace(path)
        if not isinstance(error, OSError):
            raise
        raise Environment(
            f"{folder / next(iter(texts))} cannot be written ({error.strerror}); choose another folder"
        ) from None
    finally:
        for path in (*drafts, *(old for old in before.values() if old is not None)):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
    return paths


def _keep_copy(path: Path, token: str) -> Path | None:
    """Make a second name of a file that will be replaced; a copy where the file system has no second names."""
    if not path.exists():
        return None
    old = path.with_name(f".{path.name}.{token}.old")
    try:
        os.link(path, old)
    except OSError:
        shutil.copy2(path, old)
    return old
