"""Subprograms in files of their own: the folders searched, and possible names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from vcmm.core.confinement import is_outside

ENDINGS = (
    "",
    ".ngc",
    ".nc",
    ".txt",
    ".tap",
    ".cnc",
    ".eia",
    ".prg",
    ".sub",
    ".mpf",
    ".spf",
    ".h",
    ".min",
    ".ssb",
    ".gcode",
)
BESIDE = ("", "sub", "subs", "subprograms", "subroutines", "macros", "nc_subroutines")


def folders_of(program: Path, further: Iterable[Path] = ()) -> list[Path]:
    """Return the folders searched for subprograms of a program: beside it, in the usual folders beside it, then in those of the set-up."""
    beside = [program.parent / name if name else program.parent for name in BESIDE]
    return [f for f in (*beside, *further) if not is_outside(f) and f.is_dir()]


def find_file(folders: Sequence[Path], names: Sequence[str]) -> Path | None:
    """Return the first file with one of the names, in any case and with any of ENDINGS; None where there is none."""
    for folder in folders:
        there = _listing(folder)
        for name in names:
            for ending in ENDINGS:
                path = there.get(f"{name}{ending}".lower())
                if path is not None:
                    return path
    return None


def _listing(folder: Path) -> dict[str, Path]:
    return {p.name.lower(): p for p in sorted(folder.iterdir()) if p.is_file()}
