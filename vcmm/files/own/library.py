"""The example scenarios of vcmm."""

from __future__ import annotations

from pathlib import Path

from vcmm.core.errors import UsageError, choose_from

_PACKAGE = Path(__file__).parents[2]
EXAMPLE_BY_NEED = {
    "mill": "pallet_block",
    "lathe": "turned_shaft",
    "year": "tracked_mill",
}  # what somebody who cuts asks for -> its example


def folder() -> Path:
    """Return the folder of the scenarios: inside the installed package, or beside it in a checkout."""
    inside = _PACKAGE / "scenarios"
    return inside if inside.is_dir() else _PACKAGE.parent / "scenarios"


def scenarios() -> dict[str, str]:
    """Name -> first comment line of every embedded scenario."""
    folders = {}
    for path in sorted(folder().glob("*.toml")):
        folders[path.stem] = path.read_text(encoding="utf-8").split("\n", 1)[0].lstrip("# ").strip()
    return folders


def example(name: str) -> Path:
    """Return the path of a scenario that comes with the package.

    Parameters
    ----------
    name
        Its name (`vcmm list scenarios`), or its kind: mill, lathe, year.

    Returns
    -------
    pathlib.Path
        The file; `vcmm new NAME` copies it.

    Raises
    ------
    UsageError
        There is none of this name; the closest is named.
    """
    folders = scenarios()
    word = name if name in folders else EXAMPLE_BY_NEED.get(name, name)
    if word not in folders:
        raise UsageError(f'there is no scenario "{name}".{choose_from(name, [*folders, *EXAMPLE_BY_NEED])}')
    return folder() / f"{word}.toml"


def companions(name: str) -> dict[str, Path]:
    """Return files that an embedded scenario needs beside it: path relative to its folder -> file. Empty for most.

    Python files are none of them: they are the twin, which `vcmm demo --twin` runs.
    """
    beside = folder() / name
    files = sorted(p for p in beside.rglob("*") if p.is_file() and not p.name.startswith("."))
    return {str(p.relative_to(folder())): p for p in files if p.suffix not in (".py", ".pyc")}


def cuts(scenario: Path) -> bool:
    """Return whether a scenario file is a cutting scenario: it has a [cut] table."""
    from vcmm.files.toml import read_toml

    return "cut" in read_toml(scenario).data


def records(scenario: Path) -> bool:
    """Return whether the file is a recording, to be diagnosed."""
    from vcmm.files.toml import read_toml

    return str(read_toml(scenario).data.get("vcmm", "")).startswith("recording/")


def follows(scenario: Path) -> bool:
    """Return whether a folder of dated recordings of its machine lies beside the file, to follow that machine by."""
    return (scenario.with_suffix("") / "checks").is_dir()


def turns_over(scenario: Path) -> bool:
    """Return whether the file is a reversal, to be separated."""
    from vcmm.files.own.reversal import is_reversal

    return is_reversal(scenario)


def instrument_read(scenario: Path) -> bool:
    """Return whether the file is a recording that states its instrument, for calibration."""
    from vcmm.files.toml import read_toml

    return records(scenario) and "instrument" in read_toml(scenario).data
