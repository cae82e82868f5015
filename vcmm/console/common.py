"""What all verbs share: JSON documents, file hashes, progress on stderr, tables on stdout."""

from __future__ import annotations

import hashlib
import json
import math
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from vcmm import __version__
from vcmm.core.errors import DataError, Environment, ModelLimit, UsageError


def document(
    schema: str,
    body: dict[str, Any],
    *,
    seed: int | None = None,
    files: Sequence[Path] = (),
    warnings: Sequence[str] = (),
) -> dict[str, Any]:
    """The frame of every JSON document; a number that is not finite becomes null with a warning."""
    notes = list(warnings)
    clean = _finite(body, "", notes)
    head = {
        "schema": schema,
        "version": __version__,
        "seed": seed,
        "inputs": [_hashed(p) for p in files],
        "warnings": notes,
    }
    return head | clean


def _finite(value: Any, where: str, notes: list[str]) -> Any:
    if isinstance(value, dict):
        return {k: _finite(v, f"{where}.{k}".lstrip("."), notes) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v, f"{where}[{i}]", notes) for i, v in enumerate(value)]
    if isinstance(value, float) and not math.isfinite(value):
        notes.append(f"{where} is {value}")
        return None
    return value


def _hashed(path: Path) -> dict[str, str]:
    return {"file": str(path), "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}


def sources(path: Path) -> list[Path]:
    """A TOML file and all files it names that lie beside it, for the record of inputs; each once."""
    found = [path]
    for one in found:  # grows while it is read
        if one.suffix == ".toml":
            found += [p for p in _named_in(one) if p not in found]
    return found


def _named_in(path: Path) -> list[Path]:
    """Files beside a TOML file whose names stand in it as texts; none where the file is no valid TOML."""
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError):
        return []
    names = {text for text in _texts(data) if len(text) < 200 and "\n" not in text and "\0" not in text}
    beside = [path.parent / name for name in sorted(names)]
    return [p for p in beside if p.suffix and p.is_file()]


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _texts(inner)


def print_json(content: dict[str, Any]) -> None:
    """Exactly one document on stdout."""
    print(json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False))


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


def write_files(folder: Path, texts: Mapping[str, str]) -> list[Path]:
    """Write several files, all or none: temporary files first, then renames. Raises Environment."""
    drafts = {folder / f".{name}.part": folder / name for name in texts}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for draft, text in zip(drafts, texts.values()):
            draft.write_text(text, encoding="utf-8")
        for draft, path in drafts.items():
            draft.replace(path)
    except OSError as error:
        for draft in drafts:
            draft.unlink(missing_ok=True)
        raise Environment(
            f"{folder / next(iter(texts))} cannot be written ({error.strerror}); choose another folder"
        ) from None
    return list(drafts.values())


@contextmanager
def about(file: Path, table: str = "") -> Iterator[None]:
    """Complaints about the numbers of a scenario get its file and line: those of `table` where the file has it.

    Else the pose where a point is out of reach, else the plan.
    """
    try:
        yield
    except DataError:
        raise
    except (ModelLimit, UsageError) as error:
        from vcmm.files.toml import read_toml

        read = read_toml(file)
        usual = "pose" if isinstance(error, ModelLimit) else "plan"
        where = read.where((table if table in read.data else usual,))
        raise type(error)(f"{where}: {error}") from None


@contextmanager
def progress(show: bool = True) -> Iterator[Any]:
    """A callback (text, share 0..1) that draws a bar on stderr; silent when stderr is no terminal."""
    if not show or not sys.stderr.isatty():
        yield lambda text, share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description:28}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=1.0)
        yield lambda text, share: bar.update(task, description=text, completed=share)


def say(text: str) -> None:
    """A remark for the person, on stderr."""
    print(text, file=sys.stderr)


def show_table(
    title: str,
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    left: Sequence[int] = (0,),
    caption: str = "",
) -> None:
    """A plain table on stdout; wide enough for a file when stdout is no terminal."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    width = None if sys.stdout.isatty() else 160
    console = Console(width=width, highlight=False)
    table = Table(
        title=_plain(title),
        caption=_plain(caption) or None,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        title_style="bold",
        caption_style="",
    )
    for i, name in enumerate(columns):
        table.add_column(_plain(name), justify="left" if i in left else "right", no_wrap=i in left and i == 0)
    for row in rows:
        table.add_row(*[_plain(cell) for cell in row])
    console.print(table)


def _plain(text: str) -> str:
    """Square brackets are text, not the markup of rich."""
    return text.replace("[", "\\[")
