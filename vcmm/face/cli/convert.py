"""vcmm convert: files of other systems (STEP, QIF, DMIS, DCC) made into vcmm files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def convert_command(
    file: Path,
    *,
    machine: Path | None = None,
    out: Path | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Make vcmm files of a file of another system: a part with plan, a machine with errors, quantities of a certificate.

    STEP (planes, cylinders, cones, spheres, tori; tolerances of AP242; needs vcmm[step]), QIF 3.0 (features, characteristics, measured points, 21 errors of a machine), DMIS (features, tolerances, touches), DCC
    (quantities), values and points that PC-DMIS or CALYPSO exported. What the file does not say is assumed and said; what vcmm has no word for is left out and said.

    Parameters
    ----------
    file
        The file: .step, .stp, .qif, .dmi, .dmis, .xml (DCC), .txt, .asc, .xyz (exports).
    machine
        Machine file (machine/1) of the scenario; without it a machine with a certificate stands in.
    out
        Folder for the files (default: the name of the file without its ending).
    json
        Print one JSON document.
    """
    from vcmm.core.errors import UsageError
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import say

    target = out or Path(file.stem)
    made, read = _convert(file, machine, target)
    folder = output_folder(target)
    taken = [folder / n for n in made.texts if (folder / n).exists()]
    if taken:
        raise UsageError(f"{taken[0]} exists already and is not overwritten; name another folder with --out")
    write_files(folder, made.texts)
    files = [str(folder / n) for n in made.texts]
    if json:
        body = {
            "kind": made.kind,
            "counts": made.counts,
            "written": files,
            "notes": list(made.notes),
            "problems": read,
        }
        print_json(document("vcmm.convert/1", body, files=[file], warnings=[*made.notes, *read]))
        return 0
    for note in (*made.notes, *read):
        say(f"note: {note}")
    print(f"{made.kind}: " + ", ".join(f"{n} {what}" for what, n in made.counts.items()))
    print(f"wrote {', '.join(files)}" + (f"\nnext: vcmm check {folder / made.check}" if made.check else ""))
    return 0


def _convert(file: Path, machine: Path | None, target: Path) -> tuple[Any, list[str]]:
    """The files, and what `vcmm check` says against them. A characteristic that contradicts the drawing is left out."""
    from vcmm.files.foreign.convert import Beside, convert

    name, centre = _machine(machine, target)
    made = convert(file, Beside(name, centre))
    found = _understood(made, target)
    wrong = {found.characteristics[i]: text for i, text in found.contradictory.items()}
    if wrong:
        made = convert(file, Beside(name, centre, wrong))
        found = _understood(made, target)
    return made, found.problems


@dataclass(frozen=True)
class _Understood:
    """What was read back: names of the characteristics, those that contradict the drawing, every problem."""

    characteristics: list[str]
    contradictory: dict[int, str]
    problems: list[str]


def _understood(made: Any, target: Path) -> _Understood:
    """The files read back from a folder beside the one that they are for."""
    import re
    import tempfile
    import tomllib

    from vcmm.core.errors import VcmmError
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.scenario import load_scenario

    if not made.check:
        return _Understood([], {}, [])
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
            return _Understood(names, {int(m[1]) - 1: m[2].rstrip(".") for m, _ in at}, problems)
    return _Understood(names, {}, [])


def _machine(machine: Path | None, folder: Path) -> tuple[str | None, list[float] | None]:
    """How the scenario names the machine file, and the middle of its volume in mm."""
    import os

    if machine is None:
        return None, None
    from vcmm.files.own.machine import load_machine

    axes = load_machine(machine).axes
    return os.path.relpath(machine, folder), [sum(axes[a].travel) / 2 if a in axes else 0.0 for a in "XYZ"]
