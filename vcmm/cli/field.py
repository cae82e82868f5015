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
    """Volumetric error map: tip errors (actual - nominal), maxima, body diagonals.

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
    from vcmm.console.common import document, output_folder, print_json, say, sources
    from vcmm.files.columns import read_positions
    from vcmm.files.machine import load_machine
    from vcmm.response.volumetric import field, grid, not_mapped

    folder = output_folder(out) if out else None
    loaded = load_machine(machine)
    run = read_positions(at, loaded.chain.letters) if at else None
    absent = not_mapped(loaded, run or grid(loaded, 2))
    with _rows_of(machine, at):
        found = field(loaded, run, exact, nodes)
    files = sources(machine) + ([at] if at else [])
    body = {**field_json(found), "not_mapped": {name: list(columns) for name, columns in absent}}
    content = document("vcmm.field/1", body, files=files)
    if folder:
        _write(folder, loaded, found, content)
    if json:
        print_json(content)
    else:
        _show(loaded, found)
    if absent:
        named = ", ".join(f"{name} ({', '.join(columns)})" for name, columns in absent)
        say(
            f"note: not in this map, which holds positions only: {named}{'' if at else '; give such rows with --at'}"
        )
    return 0


@contextmanager
def _rows_of(machine: Path, at: Path | None) -> Iterator[None]:
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
        from vcmm.files.columns import read_csv

        raise ModelLimit(f"{read_csv(at).at(int(row[1]) - 1)}: {text[row.end() :]}") from None


def field_json(found: Any) -> dict[str, Any]:
    """The body of the JSON document."""
    import numpy as np

    size = found.size
    return {
        "engine": "exact" if found.exact else "first-order",
        "points": int(found.run.n),
        "tip_error_mm": found.tip_error.tolist(),
        "summary": {
            "max_mm": float(size.max(initial=0.0)),
            "mean_mm": float(size.mean()) if len(size) else 0.0,
            "max_xyz_mm": np.abs(found.tip_error).max(axis=0, initial=0.0).tolist(),
            "body_diagonals_mm": [
                {"from": list(d.start), "to": list(d.end), "length_error": d.length_error}
                for d in found.diagonals
            ],
        },
    }


def _write(folder: Path, machine: Any, found: Any, content: dict[str, Any]) -> None:
    import json as _json

    from vcmm.console.common import say, write_files
    from vcmm.pages.field import field_page

    texts = {
        "field.json": _json.dumps(content, indent=1, allow_nan=False),
        "field.csv": _csv(machine, found),
        "field.html": field_page(machine, found),
    }
    write_files(folder, texts)
    say(f"wrote {folder}/field.html, field.csv, field.json")


def scale_of(axis: str) -> float:
    """Axis positions are shown in mm and deg."""
    return 57.29577951308232 if axis in "ABC" else 1.0


def _csv(machine: Any, found: Any) -> str:
    import numpy as np

    letters = list(machine.chain.letters)
    names = [f"{a}_deg" if a in "ABC" else f"{a}_mm" for a in letters]
    header = ",".join([*names, "error_x_um", "error_y_um", "error_z_um"])
    scale = [scale_of(a) for a in letters]
    rows = np.column_stack([found.run.q(a) * s for a, s in zip(letters, scale)] + [found.tip_error * 1e3])
    return header + "\n" + "\n".join(",".join(f"{v:.9g}" for v in row) for row in rows) + "\n"


def _show(machine: Any, found: Any) -> None:
    import numpy as np

    from vcmm.console.common import show_table

    size = found.size
    worst = int(size.argmax())
    letters = machine.chain.letters
    place = ", ".join(
        f"{a} {found.run.q(a)[worst] * scale_of(a):.4g} {'deg' if a in 'ABC' else 'mm'}" for a in letters
    )
    largest = np.abs(found.tip_error).max(axis=0) * 1e3
    rows = [
        ["largest tip error", f"{size.max() * 1e3:.3f} um", f"at {place}"],
        ["mean tip error", f"{size.mean() * 1e3:.3f} um", f"{found.run.n} points"],
        ["largest in x, y, z", " ".join(f"{v:.3f}" for v in largest) + " um", ""],
    ]
    for d in found.diagonals:
        ends = " to ".join("(" + " ".join(f"{v:g}" for v in end) + ")" for end in (d.start, d.end))
        rows.append(["body diagonal", f"{d.length_error * 1e3:+.3f} um", ends])
    engine = "exact transforms" if found.exact else "first order"
    show_table(
        f"{machine.name}: tip error, actual - nominal ({engine})", ["", "value", "where"], rows, left=(0, 2)
    )
