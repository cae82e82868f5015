"""A QIF document as a part: its features with extents, characteristics and measured points."""

from __future__ import annotations

from pathlib import Path

from vcmm.core.errors import DataError
from vcmm.files.foreign.drawing import DrawnPart
from vcmm.files.foreign.qif import Qif, read_qif
from vcmm.files.foreign.qif_criterion import take_criteria
from vcmm.files.foreign.qif_features import add_features
from vcmm.files.foreign.qif_points import MeasuredSet, of_features
from vcmm.files.foreign.qif_tolerances import add_characteristics


def read_qif_part(path: str | Path) -> DrawnPart:
    """Raises DataError with file and line where the document is broken, or holds no feature that vcmm has."""
    qif = read_qif(path)
    notes: list[str] = []
    measured = _measured_sets(qif, notes)
    radii = {one.tip_radius for one in measured.values()}
    drawn = DrawnPart(
        Path(path).name, _name(qif), notes=notes, tip_radius=next(iter(radii)) if len(radii) == 1 else None
    )
    if len(radii) > 1:
        measured = {}
        notes.append(f"{qif.path}:1: points compensated in different ways are mixed; none are taken over")
    names = add_features(qif, drawn, {item: one.points for item, one in measured.items()})
    if not names:
        raise DataError(
            f"{qif.root.at}: this document holds no features; vcmm makes a part of features with nominals"
        )
    take_criteria(qif, drawn, add_characteristics(qif, drawn, names))
    return drawn


def _measured_sets(qif: Qif, notes: list[str]) -> dict[str, MeasuredSet]:
    """Points by feature item of the first results: they tell extents; a tip radius changes these by itself at most."""
    result = next((n for n in qif.root.below() if n.name == "MeasurementResults"), None)
    if result is None:
        return {}
    return of_features(qif, result, notes)


def _name(qif: Qif) -> str:
    part = qif.root.one("Product/PartSet/Part")
    if part is None:
        return qif.path.stem
    return part.words("Header/Name") or part.words("Name") or part.words("ModelNumber") or qif.path.stem
