"""What all verbs share: JSON documents, file hashes, progress on stderr, tables on stdout."""

from __future__ import annotations

import hashlib
import json
import math
import sys
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from vcmm import __version__
from vcmm.errors import Environment


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
    """A TOML file and all files it names that lie beside it, for the record of inputs."""
    found = [path]
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    for text in _texts(data):
        other = path.parent / text
        if len(text) < 200 and other.suffix and "\n" not in text and other.is_file() and other not in found:
            found += [p for p in (sources(other) if other.suffix == ".toml" else [other]) if p not in found]
    return found


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _texts(inner)


def print_json(content: dict[str, Any]) -> None:
    """Exactly one document on stdout."""
    print(json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False))


def output_folder(path: Path) -> Path:
    """Make a folder and make sure it can be written. Raises Environment before any work is done."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".vcmm-probe"
        probe.write_text("")
        probe.unlink()
    except OSError as error:
        raise Environment(
            f"the folder {path} cannot be written ({error.strerror}); choose another with --out"
        ) from None
    return path


def write_text(path: Path, text: str) -> Path:
    """Write a whole file or nothing: a temporary file beside it, then a rename."""
    temporary = path.with_name(f".{path.name}.part")
    try:
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise Environment(f"{path} cannot be written ({error.strerror}); choose another folder") from None
    return path


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
        title=title,
        caption=caption or None,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        title_style="bold",
        caption_style="",
    )
    for i, name in enumerate(columns):
        table.add_column(name, justify="left" if i in left else "right", no_wrap=i in left and i == 0)
    for row in rows:
        table.add_row(*[cell.replace("[", "\\[") for cell in row])
    console.print(table)
