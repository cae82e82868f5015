"""vcmm new: a commented scenario to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from vcmm.core.errors import UsageError
from vcmm.files.own.library import companions, cuts, example, follows, instrument_read, records, turns_over
from vcmm.files.own.recording_data import is_poses
from vcmm.show.console.files import output_folder, write_files
from vcmm.show.console.terminal import say

MANY = 12  # files that are not named one by one


def new_command(
    name: str = "plate", *, source: Annotated[str | None, Parameter(name="--from")] = None, out: Path = Path()
) -> int:
    """Write a commented scenario that you can edit: machine, part, plan, environment in one file.

    A cutting scenario brings its program and set-up along, a recording its data and machine, in a folder of the same name.

    Parameters
    ----------
    name
        Name of the new file (without .toml); also the embedded scenario to copy unless --from is given.
    source
        Embedded scenario to copy; see `vcmm list scenarios`.
    out
        Folder for the file.
    """
    original = source or name
    stem = name.removesuffix(".toml")
    target = output_folder(out) / f"{stem}.toml"
    texts = _texts(example(original), stem)
    taken = [file for file in (out / name for name in texts) if file.exists()]
    if taken:
        raise UsageError(
            f"{taken[0]} exists already and is not overwritten; choose another name, for example vcmm new {name}2 --from {original}"
        )
    _write(out, texts)
    say(f"wrote {_names(out, texts)}; edit, then:")
    print(f"vcmm check {target}\n{_next_steps(target)}")
    return 0


def _texts(original: Path, stem: str) -> dict[str, str]:
    """Name relative to the folder -> text: the scenario and its companions, their folder named after the new file."""
    old = original.stem
    beside = companions(old)
    text = original.read_text(encoding="utf-8")
    if beside and stem != old:
        text = text.replace(f"{old}.toml", f"{stem}.toml").replace(f"{old}/", f"{stem}/")
    out = {f"{stem}.toml": text}
    for name, file in beside.items():
        out[f"{stem}/{name.removeprefix(old + '/')}"] = file.read_text(encoding="utf-8")
    return out


def _names(folder: Path, texts: dict[str, str]) -> str:
    """Return the sentence about the written files, each file; of many the first, and how many lie in its folder."""
    first, *beside = (folder / name for name in texts)
    if len(beside) < MANY:
        return ", ".join(map(str, (first, *beside)))
    return f"{first} and {len(beside)} files in {first.with_suffix('')}"


def _write(folder: Path, texts: dict[str, str]) -> None:
    for name in texts:
        output_folder((folder / name).parent)
    write_files(folder, texts)


def _next_steps(target: Path) -> str:
    folder = target.with_suffix("")
    if follows(target):
        track = f"vcmm track {folder / 'machine.toml'} {folder / 'checks'}"
        return f'{track}\n{track} --task {target} --limit "length = 2 um" --checks {folder / "checks.toml"} --days 90'
    if turns_over(target):
        beside = "".join(f" {p}" for p in sorted((target.parent / target.stem).glob("*.toml")))
        return (
            f"vcmm calibrate {target}{beside} --structure \"w C' X' b Z t\" --out {target.stem}-machine.toml\n"
            f"vcmm test {target} --iso 230-7"
        )
    if instrument_read(target):
        machine_file = target.parent / target.stem / "machine.toml"
        return f"vcmm calibrate {target} --machine {machine_file} --out {target.stem}-machine.toml"
    if is_poses(target):
        return f"vcmm calibrate {target} --machine {folder / 'machine.toml'} --out {target.stem}-machine.toml --test {folder / 'others.toml'}"
    if records(target):
        return f"vcmm diagnose {target} --out {target.stem}-report"
    if cuts(target):
        return f"vcmm cut {target} --out {target.stem}-report"
    return f"vcmm measure {target}\nvcmm uncertainty {target} --out {target.stem}-report"
