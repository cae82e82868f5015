"""By which criterion a QIF file states its forms: QIF items often name none, and their values tell it where points stand beside them.

The form of the file's own points is computed by least squares (G) and as minimum zone (C). The radius of the tip is no matter: points and
centres of the tip lie as far apart. Where one of them is the value that the file states, that criterion is taken; else G is assumed, and said.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vcmm.core.run import Array
from vcmm.files.foreign.drawing import DrawnPart, mm
from vcmm.files.foreign.qif import Qif
from vcmm.part.fit.criteria import associate
from vcmm.part.fit.gauss import gauss

FORMS = {"flatness": "plane", "roundness": "circle", "cylindricity": "cylinder"}
CRITERION_TOLERANCE = (
    2e-3  # of the value: two programs that mean the same; G and C differ by some percent of real surfaces
)
ROUNDING = 5e-7  # mm, half a nanometre: values are written so


def take_criteria(qif: Qif, drawn: DrawnPart, names: dict[str, str]) -> None:
    """Adds `criterion` to the forms in `drawn` that the file's own values decide, and a note to every form. names: by item id."""
    stated = _stated_values(qif)
    for item, name in names.items():
        table = next(c for c in drawn.characteristics if c["name"] == name)
        if FORMS.get(table["type"]) is None or "criterion" in table:
            continue
        drawn.notes.append(f"{qif.by_id[item].at}: {name}: {_criterion_note(drawn, table, stated.get(item))}")


def _criterion_note(drawn: DrawnPart, table: dict[str, Any], stated: float | None) -> str:
    assumed = "the file names no criterion; G (least squares) is assumed"
    feature = drawn.features[table["of"]]
    points = drawn.points.get(table["of"])
    enough = points is not None and len(points) > (6 if feature["type"] == "cylinder" else 4)
    if stated is None or points is None or not enough or FORMS[table["type"]] != feature["type"]:
        return assumed
    found = {c: _form(feature, points, c) for c in "GC"}
    own = f"of the file's own points G gives {mm(round(found['G'], 7))}, C {mm(round(found['C'], 7))}, and it states {mm(round(stated, 7))}"
    alike = [
        c for c, value in found.items() if abs(value - stated) <= CRITERION_TOLERANCE * stated + ROUNDING
    ]
    if alike == ["C"]:
        table["criterion"] = "C"
        return f"criterion C (minimum zone) is taken: {own}"
    return f"G (least squares), as its value says: {own}" if "G" in alike else f"{assumed}: {own}"


def _form(feature: dict[str, Any], points: Array, criterion: str) -> float:
    """Range of the distances from the element, mm."""
    axis = np.array(feature["axis"], float) if feature["type"] == "circle" else None
    found = gauss(feature["type"], points, fixed_axis=axis)
    if criterion == "C":
        found = associate(feature["type"], "C", points, found, fixed_axis=axis, judged=False).element
    return float(np.ptp(found.residuals))


def _stated_values(qif: Qif) -> dict[str, float]:
    """Values in mm of the first results, by item id."""
    result = next((n for n in qif.root.below() if n.name == "MeasurementResults"), None)
    listed = None if result is None else result.one("MeasuredCharacteristics/CharacteristicMeasurements")
    out: dict[str, float] = {}
    for one in listed.children if listed else ():
        value = one.one("Value")
        if value is not None and one.name.removesuffix("CharacteristicMeasurement") in (
            "Flatness",
            "Circularity",
            "Cylindricity",
        ):
            out[one.words("CharacteristicItemId")] = qif.length(value)
    return out
