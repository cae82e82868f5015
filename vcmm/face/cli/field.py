"""vcmm field: the volumetric error map of a machine."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def field_command(
    machine: Path,
    *,
    at: Path | None = None,
    exact: bool = False,
    nodes: int = 5,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Volumetric error map: tip errors (actual - nominal), their U, maxima, body diagonals.

    Parameters
    ----------
    machine
        Machine file (machine/1).
    at
        CSV of positions (X_mm, Y_mm ... offset_x_mm ...); without it a grid over the travels.
    exact
        Multiply the transforms instead of first order.
    nodes
        Nodes per axis of the grid.
    json
        Print one JSON document.
    out
        Folder for field.html (picture of the deformed volume), field.csv and field.json.
    """
    from vcmm.files.columns import read_positions
    from vcmm.files.own.machine import load_machine
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import output_folder
    from vcmm.show.console.terminal import say, show_answers, show_table
    from vcmm.show.tables.answers import field_answers
    from vcmm.show.tables.error_field import field_json, maxima
    from vcmm.task.response.logs import with_logs
    from vcmm.task.response.volumetric import field, grid, missing_columns

    folder = output_folder(out) if out else None
    loaded = load_machine(machine)
    run = with_logs(read_positions(at, loaded.chain.letters)) if at else None
    absent = missing_columns(loaded, run or grid(loaded, 2))
    with rows_of(machine, at):
        error_map = field(loaded, run, exact, nodes)
    files = sources(machine) + ([at] if at else [])
    body = {**field_json(error_map), "not_mapped": {name: list(columns) for name, columns in absent}}
    content = document("vcmm.field/1", body, files=files)
    if folder:
        _write(folder, loaded, error_map, content)
    if json:
        print_json(content)
    else:
        show_answers(field_answers(loaded, error_map))
        show_table(maxima(loaded, error_map))
    _say_limits(loaded, error_map)
    if absent:
        named = ", ".join(f"{name} ({', '.join(columns)})" for name, columns in absent)
        say(
            f"note: not in this map, which holds positions only: {named}{'' if at else '; give such rows with --at'}"
        )
    return 0


def _say_limits(loaded: Any, error_map: Any) -> None:
    """Where the map ends, and what its U does not hold."""
    from vcmm.answer.evaluation.checks import independent_draws
    from vcmm.show.console.terminal import say

    if error_map.within:
        ranges = ", ".join(f"{a} {low:g} to {high:g} mm" for a, low, high in error_map.within)
        say(
            f"note: mapped where every effect is known: within {ranges}; body diagonals of the travels lie beyond"
        )
    for text in independent_draws(loaded.inputs):
        say(f"warning: {text}")
    if error_map.left_out:
        say(f"note: not in U, which is that of one positioning at 20 degC: {', '.join(error_map.left_out)}")


@contextmanager
def rows_of(machine: Path, at: Path | None) -> Iterator[None]:
    """A complaint about a row gets the line of the positions file; without one, the way to choose the positions."""
    from vcmm.core.errors import ModelLimit

    try:
        yield
    except ModelLimit as error:
        text = str(error)
        row = re.match(r"row (\d+): ", text)
        if at is None:
            raise ModelLimit(f"{machine}: {text}; or choose the positions with --at") from None
        if not row:
            raise ModelLimit(f"{at}: {text}") from None
        from vcmm.files.sheets import read_csv

        raise ModelLimit(f"{read_csv(at).at(int(row[1]) - 1)}: {text[row.end() :]}") from None


def _write(folder: Path, machine: Any, error_map: Any, content: dict[str, Any]) -> None:
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.field import field_page
    from vcmm.show.tables.error_field import field_csv

    texts = {
        "field.json": json_text(content),
        "field.csv": field_csv(machine, error_map),
        "field.html": field_page(machine, error_map),
    }
    write_files(folder, texts)
    say(f"wrote {folder}/field.html, field.csv, field.json")
