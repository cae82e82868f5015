"""vcmm new: a commented scenario to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def new_command(
    name: str = "plate", *, source: Annotated[str | None, Parameter(name="--from")] = None, out: Path = Path()
) -> int:
    """Write a commented scenario that you can edit: machine, part, plan, environment in one file.

    Parameters
    ----------
    name
        Name of the new file (without .toml); also the embedded scenario to copy unless --from is given.
    source
        Embedded scenario to copy; see `vcmm list scenarios`.
    out
        Folder for the file.
    """
    from vcmm.cli.common import output_folder, say, write_text
    from vcmm.errors import UsageError
    from vcmm.library import path

    text = path(source or name).read_text(encoding="utf-8")
    target = output_folder(out) / f"{name.removesuffix('.toml')}.toml"
    if target.exists():
        raise UsageError(
            f"{target} exists already and is not overwritten; choose another name, for example vcmm new {name}2 --from {source or name}"
        )
    write_text(target, text)
    say(f"wrote {target}; edit it, then:")
    print(f"vcmm check {target}\nvcmm measure {target}\nvcmm uncertainty {target} --out {target.stem}-report")
    return 0
