"""Convert files of other systems to vcmm files, and read them back."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vcmm.files.foreign.convert import ConvertedFiles


def convert_file(file: Path, machine: Path | None, target: Path) -> tuple[ConvertedFiles, list[str]]:
    """Return the files, and the problems that `vcmm check` reports for them. A characteristic that contradicts the drawing is left out."""
    from vcmm.files.foreign.convert import Beside, convert

    name, centre = _machine_beside(machine, target)
    made = convert(file, Beside(name, centre))
    read_back = _read_back(made, target)
    wrong = {read_back.characteristics[i]: text for i, text in read_back.contradictory.items()}
    if wrong:
        made = convert(file, Beside(name, centre, wrong))
        read_back = _read_back(made, target)
    return made, read_back.problems


@dataclass(frozen=True)
class _ReadBack:
    """Result of reading back: names of the characteristics, those that contradict the drawing, every problem."""

    characteristics: list[str]
    contradictory: dict[int, str]
    problems: list[str]


def _read_back(made: ConvertedFiles, target: Path) -> _ReadBack:
    """Return the files read back from a folder beside the one that they are for."""
    import re
    import tempfile
    import tomllib

    from vcmm.core.errors import VcmmError
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.scenario import load_scenario

    if not made.check:
        return _ReadBack([], {}, [])
    names = [c["name"] for c in tomllib.loads(made.texts.get("part.toml", "")).get("characteristics", [])]
    parent = target.resolve().parent
    with tempfile.TemporaryDirectory(prefix=".vcmm-", dir=parent if parent.is_dir() else None) as folder:
        for name, text in made.texts.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        try:
            (load_machine if made.check == "machine.toml" else load_scenario)(Path(folder) / made.check)
        except VcmmError as error:
            problems = [p.replace(f"{folder}/", "") for p in getattr(error, "problems", (str(error),))]
            at = [
                (m, p)
                for p in problems
                if (m := re.match(r"part\.toml:\d+: \[characteristics (\d+)\] (.*)", p))
            ]
            return _ReadBack(names, {int(m[1]) - 1: m[2].rstrip(".") for m, _ in at}, problems)
    return _ReadBack(names, {}, [])


def _machine_beside(machine: Path | None, folder: Path) -> tuple[str | None, list[float] | None]:
    """Return how the scenario names the machine file, and the middle of its volume in mm."""
    import os

    if machine is None:
        return None, None
    from vcmm.files.own.machine import load_machine

    axes = load_machine(machine).axes
    return os.path.relpath(machine, folder), [sum(axes[a].travel) / 2 if a in axes else 0.0 for a in "XYZ"]


def refuse_taken(folder: Path, names: Iterable[str]) -> None:
    """Raise UsageError where one of the files exists already."""
    from vcmm.core.errors import UsageError

    taken = next((folder / name for name in names if (folder / name).exists()), None)
    if taken is not None:
        raise UsageError(f"{taken} exists already and is not overwritten; name another folder with --out")


def written_files(
    file: Path, machine: Path | None, out: Path | None
) -> tuple[ConvertedFiles, list[str], list[Path]]:
    """Return (the converted files, the problems that `vcmm check` reports for them, the files that were written). UsageError where one of
    them is there already."""
    from vcmm.show.console.files import output_folder, write_files

    folder = output_folder(out or Path(file.stem))
    made, problems = convert_file(file, machine, folder)
    refuse_taken(folder, made.texts)
    write_files(folder, made.texts)
    return made, problems, [folder / name for name in made.texts]
