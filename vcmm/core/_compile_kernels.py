"""njit for the kernels of vcmm: keep the compiled code in the user's cache, under a key of all kernel sources.

numba keeps compiled code beside the source, where an installed package may not be writable, and looks at the time of that
one file only: a kernel that calls one of another file would keep the old one. NUMBA_CACHE_DIR names another place.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba

PACKAGE = Path(__file__).parent.parent


def sources_key(package: Path = PACKAGE) -> str:
    """Return a key of all kernel sources and of the compiler and its versions, 16 hexadecimal digits."""
    digest = hashlib.sha256(f"{numba.__version__} {sys.version}".encode())
    for file in sorted(package.rglob("*_kernels.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> tuple[Path, bool]:
    """Return the folder for compiled code and whether it outlives this process: the user's cache, else a temporary folder."""
    home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    named = vars(numba.config)["CACHE_DIR"]
    try:
        base = Path(named) if named else (Path(home) if home else Path.home() / ".cache") / "vcmm" / "numba"
        folder = base / sources_key()
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK):
            return folder, True
    except (OSError, RuntimeError):  # RuntimeError: there is no home
        pass
    return Path(tempfile.mkdtemp(prefix="vcmm-kernels-")), False


FOLDER, KEPT = cache_folder()


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorate as numba.njit does, with FOLDER as its cache; the settings of other users of numba in this process do not change."""

    def compile_kernel(function: Callable[..., Any]) -> Any:
        settings = vars(numba.config)
        before = settings["CACHE_DIR"]
        settings["CACHE_DIR"] = str(FOLDER)  # read when a function is decorated
        try:
            return numba.njit(**options)(function)
        finally:
            settings["CACHE_DIR"] = before

    return compile_kernel
