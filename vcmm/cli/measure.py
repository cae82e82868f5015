"""vcmm measure: one virtual measurement."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def measure_command(
    scenario: Path,
    *,
    seed: int | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Measure the part once, virtually: errors at their estimates, or one draw with --seed.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    seed
        Draw everything that is uncertain once with this seed; without it all errors are at their estimates.
    json
        Print one JSON document.
    out
        Folder for measure.json and points.csv.
    """
    from vcmm.api import measure
    from vcmm.console.common import about, document, output_folder, print_json, sources
    from vcmm.files.scenario import load_scenario

    folder = output_folder(out) if out else None
    loaded = load_scenario(scenario)
    with about(scenario):
        found = measure(loaded, seed)
    content = document(
        "vcmm.measure/1", measure_json(found), seed=seed, files=sources(scenario), warnings=found.warnings
    )
    if folder:
        _write(folder, found, content)
    if json:
        print_json(content)
    else:
        _show(found)
    return 0


def measure_json(found: Any) -> dict[str, Any]:
    """The body of the JSON document: characteristics with value only, and points."""
    characteristics = [
        {"name": v.name, "type": v.type, f"nominal_{v.unit}": v.nominal, f"value_{v.unit}": v.value}
        for v in found.values
    ]
    points = [
        {"feature": f, "nominal_mm": n.tolist(), "measured_mm": p.tolist(), "error_mm": float(e)}
        for f, n, p, e in zip(found.features, found.nominal_points, found.points, found.errors)
    ]
    return {"characteristics": characteristics, "points": points}


def _write(folder: Path, found: Any, content: dict[str, Any]) -> None:
    import json as _json

    from vcmm.console.common import say, write_files

    names = [f"{kind}_{c}_mm" for kind in ("measured", "nominal") for c in "xyz"]
    rows = [",".join(["feature", *names, "nx", "ny", "nz", "error_um"])]
    for i, f in enumerate(found.features):
        numbers = (*found.points[i], *found.nominal_points[i], *found.normals[i])
        rows.append(",".join([f, *(f"{v:.9f}" for v in numbers), f"{found.errors[i] * 1e3:.6f}"]))
    texts = {
        "measure.json": _json.dumps(content, indent=1, allow_nan=False),
        "points.csv": "\n".join(rows) + "\n",
    }
    write_files(folder, texts)
    say(f"wrote {folder}/measure.json, points.csv")


def _show(found: Any) -> None:
    from vcmm.console.common import show_table
    from vcmm.console.quantities import deviation_text, length_text

    rows = [
        [
            v.name,
            v.type,
            length_text(v.nominal, v.unit),
            length_text(v.value, v.unit),
            deviation_text(v.value - v.nominal, v.unit),
        ]
        for v in found.values
    ]
    show_table(
        "measured once, drawing frame",
        ["characteristic", "type", "nominal", "value", "deviation"],
        rows,
        left=(0, 1),
    )
