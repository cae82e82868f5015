"""Convert files of another system to vcmm files: their names and texts, and the assumptions made."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vcmm.core.errors import DataError
from vcmm.core.text import csv_of
from vcmm.files.foreign.drawing import DrawnPart, mm, part_toml
from vcmm.files.foreign.scenario_text import features_of, machine_toml, scenario_toml, target_csv, target_file

if TYPE_CHECKING:
    from vcmm.files.foreign.cmm_exports import Export

FORMAT_BY_SUFFIX = {
    ".qif": "QIF",
    ".dmi": "DMIS",
    ".dmis": "DMIS",
    ".dms": "DMIS",
    ".xml": "DCC",
    ".step": "STEP",
    ".stp": "STEP",
    ".txt": "export",
    ".xyz": "export",
    ".asc": "export",
}


@dataclass(frozen=True)
class ConvertedFiles:
    """kind: STEP, QIF part, QIF machine, DMIS, DCC, CALYPSO table, PC-DMIS report, list of points. texts: by file name. notes: what was assumed or left out. check: the file to check."""

    kind: str
    texts: dict[str, str]
    notes: tuple[str, ...]
    counts: dict[str, int]
    check: str = ""


@dataclass(frozen=True)
class Beside:
    """Surroundings of a part: name of a machine file and the centre of its volume (mm); characteristics to leave out, and why."""

    machine: str | None = None
    centre: Sequence[float] | None = None
    without: Mapping[str, str] = field(default_factory=dict)


def convert(path: str | Path, around: Beside = Beside()) -> ConvertedFiles:
    """Convert a file of another system to the texts of vcmm files.

    Raises DataError: a kind of file that is not read, and what its reader refuses.
    """
    kind = FORMAT_BY_SUFFIX.get(Path(path).suffix.lower())
    if kind is None:
        formats = "STEP (.step, .stp), QIF (.qif), DMIS (.dmi, .dmis, .dms), DCC (.xml), exports of measuring software (.txt, .asc, .xyz)"
        raise DataError(
            f'{path}: files named "{Path(path).suffix or "without ending"}" are not converted; {formats} are'
        )
    if kind == "DCC":
        return _certificate(path)
    if kind == "export":
        return _export(path)
    if kind == "STEP":
        from vcmm.files.foreign.step import read_step

        return _part("STEP", read_step(path), around)
    if kind == "DMIS":
        from vcmm.files.foreign.dmis import read_dmis

        return _part("DMIS", read_dmis(path), around)
    return _qif(path, around)


def _qif(path: str | Path, around: Beside) -> ConvertedFiles:
    from vcmm.files.foreign.qif import machine_files, read_qif, read_qif_machine
    from vcmm.files.foreign.qif_part import read_qif_part

    root = read_qif(path).root
    if root.one("Features/FeatureItems") is not None:
        return _part("QIF part", read_qif_part(path), around)
    qif_machine = read_qif_machine(path)
    texts = machine_files(qif_machine, Path(path).name)
    counts = {"errors": sum(len(c) for c in qif_machine.curves.values()) + len(qif_machine.squareness)}
    return ConvertedFiles("QIF machine", texts, qif_machine.notes, counts, "machine.toml")


def _part(kind: str, whole: DrawnPart, around: Beside) -> ConvertedFiles:
    understood = [c for c in whole.characteristics if c["name"] not in around.without]
    silent = _without_points(whole, understood)
    left_out_notes = [
        f"{c['name']}: {why}; left out, and written to part.toml as a comment" for c, why in silent
    ]
    drawn = replace(
        whole,
        characteristics=[c for c in understood if c["name"] not in {s["name"] for s, _ in silent}],
        silent=silent,
        notes=[
            *whole.notes,
            *(f"{name}: {why}; left out" for name, why in around.without.items()),
            *left_out_notes,
        ],
    )
    texts = {
        "part.toml": part_toml(drawn),
        "scenario.toml": scenario_toml(drawn, around.machine, around.centre),
    }
    if around.machine is None:
        texts["machine.toml"] = machine_toml(drawn)
    for name, rows in drawn.targets.items():
        texts[target_file(name)] = target_csv(rows)
    notes = list(drawn.notes)
    if drawn.points:
        texts["points.csv"] = _points_csv(drawn)
        advice = "points.csv holds what was measured: vcmm evaluate scenario.toml --points points.csv"
        notes.append(
            advice
            if drawn.tip_radius is None
            else f"{advice} --tip-centres (tip of {mm(2 * drawn.tip_radius)})"
        )
    counts = {
        "features": len(drawn.features), "characteristics": len(drawn.characteristics),
        "points": sum(len(p) for p in (*drawn.points.values(), *drawn.targets.values())),
    }  # fmt: skip
    return ConvertedFiles(kind, texts, tuple(notes), counts, "scenario.toml")


def _without_points(
    drawn: DrawnPart, characteristics: Sequence[dict[str, Any]]
) -> list[tuple[dict[str, Any], str]]:
    """Return the characteristics of features without points, which `evaluate` could not evaluate, and these features. Where no points are
    known, none."""
    pairs = [(c, next((n for n in features_of(c) if n not in drawn.points), "")) for c in characteristics]
    return [(c, f"{bare} has no measured points") for c, bare in pairs if bare and drawn.points]


def _points_csv(drawn: DrawnPart) -> str:
    rows = [[name, *(f"{v:.12g}" for v in p)] for name, points in drawn.points.items() for p in points]
    return csv_of([["feature", "x_mm", "y_mm", "z_mm"], *rows])


def _certificate(path: str | Path) -> ConvertedFiles:
    from vcmm.files.foreign.dcc import quantities_csv, read_dcc

    certificate = read_dcc(path)
    return ConvertedFiles(
        "DCC", {"quantities.csv": quantities_csv(certificate)}, (), {"quantities": len(certificate)}
    )


def _export(path: str | Path) -> ConvertedFiles:
    """Return values or points that other software measured, as values.csv or points.csv. Raises DataError: neither."""
    from vcmm.files.foreign.cmm_exports import read_export
    from vcmm.files.foreign.point_lists import read_point_list

    export = read_export(path)
    if export is not None:
        return _values(export)
    points = read_point_list(path)
    if points is None:
        raise DataError(
            f"{path}:1: neither a table of CALYPSO (planid, partnb, id ...), nor a report of PC-DMIS (DIM LOC1= ... UNITS=MM), nor a list of "
            "points (x y z); docs/from_cmm_software.md shows what each looks like"
        )
    given = points.points
    head = [*(["feature"] if given.features else []), "x_mm", "y_mm", "z_mm"]
    head += ["nx", "ny", "nz"] if given.normals is not None else []
    rows = []
    for i, p in enumerate(given.points):
        beside = [] if given.normals is None else given.normals[i]
        rows.append([*([given.features[i]] if given.features else []), *(f"{v:.12g}" for v in (*p, *beside))])
    text = csv_of([head, *rows])
    advice = "vcmm evaluate SCENARIO --points points.csv (--tip-centres where these are centres of the tip)"
    return ConvertedFiles(
        "list of points", {"points.csv": text}, (*points.notes, advice), {"points": len(rows)}
    )


def _values(export: Export) -> ConvertedFiles:
    """Return values.csv of all rows; a row that cannot be read becomes a note."""
    notes, rows = list(export.notes), []
    for row in export.rows:
        try:
            v = row.value(row.short or row.name)
        except DataError as error:
            notes.append(f"{error}; left out")
            continue
        number = f"{math.degrees(v.number) if v.angle else v.number:.12g}"
        rows.append([v.part, v.name, *(["", number] if v.angle else [number, ""])])
    head = ["part", "characteristic", "value_mm", "value_deg"]
    keep = [0, 1, 2, 3] if any(r[0] for r in rows) else [1, 2, 3]
    text = csv_of([[r[i] for i in keep] for r in (head, *rows)])
    notes.append(
        "name the characteristics of a scenario as values.csv does, then vcmm evaluate SCENARIO --values values.csv"
    )
    return ConvertedFiles(export.kind, {"values.csv": text}, tuple(notes), {"values": len(rows)})
