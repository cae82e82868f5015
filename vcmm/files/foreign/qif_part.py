"""A QIF document as a part: its features with extents, characteristics and measured points.

Criterion of the forms of a QIF file: QIF items often name none, and their values determine it where the file holds points.

The form of the file's own points is computed by least squares (G) and as minimum zone (C). The radius of the tip does not matter: points and
centres of the tip have the same range. Where one of them is the value that the file states, that criterion is taken; else G is assumed, and said.

Features of a QIF document as tables of part/1, from definition, nominal and item; their measured points.

A feature item is one surface of the part: its name, its nominal (where it lies) and its definition (size, inside or
outside). What the file leaves open (size of a plane, length of a bore) comes from the measured points, or is assumed
and said.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.files.foreign.drawing import DEFAULT_EXTENT, DrawnPart, deg, mm, spanned_plane, unit
from vcmm.files.foreign.qif import Qif, read_qif
from vcmm.files.foreign.qif_points import MeasuredSet, of_features
from vcmm.files.foreign.qif_tolerances import add_characteristics
from vcmm.files.foreign.xml import Node, series
from vcmm.part.fit.criteria import associate
from vcmm.part.fit.gauss import gauss

FEATURE_BY_ITEM = {
    "PlaneFeatureItem": "plane", "CircleFeatureItem": "circle", "CylinderFeatureItem": "cylinder",
    "SphereFeatureItem": "sphere", "ConeFeatureItem": "cone", "LineFeatureItem": "line", "PointFeatureItem": "point",
    "SurfacePointFeatureItem": "point", "EdgePointFeatureItem": "point", "TorusFeatureItem": "torus",
}  # fmt: skip


def add_features(qif: Qif, drawn: DrawnPart, measured: Mapping[str, Array]) -> dict[str, str]:
    """Add every feature item that vcmm has to `drawn`; return its name by item id. Other items become notes.

    measured: points (n, 3) mm by id of the feature item.
    """
    names: dict[str, str] = {}
    items = qif.root.one("Features/FeatureItems")
    for item in items.children if items else ():
        name = drawn.free_feature(item.words("FeatureName") or f"feature {item.attributes.get('id', '')}")
        kind = FEATURE_BY_ITEM.get(item.name)
        if kind is None:
            drawn.notes.append(
                f"{item.at}: {item.name.removesuffix('FeatureItem')} {name}: no such feature here, left out"
            )
            continue
        nominal = qif.node_at(item, "FeatureNominalId")
        if nominal is None:
            drawn.notes.append(f"{item.at}: {name} has no nominal, left out")
            continue
        definition = qif.node_at(nominal, "FeatureDefinitionId")
        key = item.attributes.get("id", "")
        points = measured.get(key)
        drawn.features[name] = _table(qif, drawn, kind, (name, nominal, definition or nominal), points)
        if points is not None:
            drawn.points[name] = points
        names[key] = name
    return names


def _table(
    qif: Qif, drawn: DrawnPart, kind: str, described: tuple[str, Node, Node], points: Array | None
) -> dict[str, Any]:
    name, nominal, definition = described
    place, axis = _place(qif, nominal, kind)
    table: dict[str, Any] = {"type": kind, "point": mm(*place)}
    if kind in ("circle", "cylinder", "cone", "torus"):
        table["axis"] = axis
    if kind in ("point", "plane"):
        table["normal"] = axis
    if kind == "line":
        table["direction"] = axis
    if kind in ("circle", "cylinder", "sphere", "cone", "torus"):
        table |= _round(qif, definition, kind, name) | _side(drawn, definition, table, points)
    if kind in ("plane", "line", "cylinder", "cone"):
        table |= _extent(qif, drawn, kind, described, (place, axis), points)
    return table


def _place(qif: Qif, nominal: Node, kind: str) -> tuple[Array, list[float]]:
    """Return a point of the feature and its direction; a sphere has none."""
    point = nominal.one("Location") or nominal.one("Axis/AxisPoint") or nominal.one("StartPoint")
    if point is None:
        raise DataError(
            f"{nominal.at}: <{nominal.name}> says neither Location nor Axis/AxisPoint nor StartPoint"
        )
    if kind == "sphere":
        return qif.place(point), [0.0, 0.0, 1.0]
    way = nominal.one("Normal") or nominal.one("Direction") or nominal.one("Axis/Direction")
    if way is None:
        raise DataError(f"{nominal.at}: <{nominal.name}> has no Normal, Direction or Axis/Direction")
    try:
        return qif.place(point), unit(series(way, 3)[0])
    except ValueError as error:
        raise DataError(f"{way.at}: {error}") from None


def _round(qif: Qif, definition: Node, kind: str, name: str) -> dict[str, Any]:
    if kind == "torus":
        ring, tube = definition.one("MajorDiameter"), definition.one("MinorDiameter")
        if ring is None or tube is None:
            raise DataError(f"{definition.at}: the torus {name} needs MajorDiameter and MinorDiameter")
        sizes = {"diameter": mm(qif.length(ring)), "tube": mm(qif.length(tube))}
    else:
        size = definition.one("Diameter") or definition.one("LargeDiameter")
        if size is None:
            raise DataError(f"{definition.at}: <{definition.name}> of {name} has no Diameter")
        sizes = {"diameter": mm(qif.length(size))}
    if kind == "cone":
        half, full = definition.one("HalfAngle"), definition.one("FullAngle") or definition.one("Angle")
        if half is None and full is None:
            raise DataError(f"{definition.at}: the cone {name} needs HalfAngle")
        sizes["angle"] = deg(qif.angle(full) if half is None else 2.0 * qif.angle(half))  # type: ignore[arg-type]
    return sizes


def _side(drawn: DrawnPart, definition: Node, table: dict[str, Any], points: Array | None) -> dict[str, Any]:
    """Return {"inside": True} of a bore. Where the file does not state it, centres of the tip within the diameter show it."""
    stated = definition.words("InternalExternal")
    if stated in ("INTERNAL", "EXTERNAL"):
        return {"inside": True} if stated == "INTERNAL" else {}
    if points is not None and drawn.tip_radius and table["type"] in ("circle", "cylinder"):
        place = np.array([float(v) for v in table["point"].removesuffix(" mm").split()])
        beside = np.cross(points - place, np.array(table["axis"]))
        radius = float(np.linalg.norm(beside, axis=1).mean())
        diameter = definition.one("Diameter")
        if diameter is not None:
            return {"inside": True} if radius < 0.5 * float(diameter.text) else {}
    drawn.notes.append(
        f"{definition.at}: neither INTERNAL nor EXTERNAL is stated; outside is assumed, correct it"
    )
    return {}


def _extent(
    qif: Qif, drawn: DrawnPart, kind: str, described: tuple[str, Node, Node], frame: tuple[Array, list[float]],
    points: Array | None,
) -> dict[str, Any]:  # fmt: skip
    """Return the size of a plane, length of the others: stated, spanned by the points, or assumed with a note."""
    name, nominal, definition = described
    place, axis = frame
    stated = definition.one("Length") or nominal.one("Length")
    if kind != "plane" and stated is not None:
        return {"length": mm(qif.length(stated))}
    ends = [nominal.one(f"{end}Point") for end in ("Start", "End")]
    if kind == "line" and ends[0] is not None and ends[1] is not None:
        return {"length": mm(float(np.linalg.norm(qif.place(ends[1]) - qif.place(ends[0]))))}
    if points is not None and len(points) > 1 and (span := _span(kind, place, np.array(axis), points)):
        drawn.notes.append(f"{nominal.at}: {name}: its extent is that of its measured points")
        return span
    drawn.notes.append(
        f"{nominal.at}: {name}: the file states no extent; {mm(DEFAULT_EXTENT)} is assumed, correct it"
    )
    return {"size": mm(DEFAULT_EXTENT, DEFAULT_EXTENT)} if kind == "plane" else {"length": mm(DEFAULT_EXTENT)}


def _span(kind: str, place: Array, axis: Array, points: Array) -> dict[str, Any]:
    if kind == "plane":
        return spanned_plane(place, axis, points)
    along = (points - place) @ axis
    span = float(along.max() - along.min())
    return {"point": mm(*(place + axis * along.min())), "length": mm(span)} if span > 0.0 else {}


FORMS = {"flatness": "plane", "roundness": "circle", "cylindricity": "cylinder"}
# of the value: two programs that mean the same; G and C differ by some percent of real surfaces
CRITERION_TOLERANCE = 2e-3
ROUNDING = 5e-7  # mm, half a nanometre: values are written so


def take_criteria(qif: Qif, drawn: DrawnPart, names: dict[str, str]) -> None:
    """Add `criterion` to the forms in `drawn` that the file's own values determine, and a note to every form. names: by item id."""
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
    radii = {c: _form(feature, points, c) for c in "GC"}
    text = f"of the file's own points G gives {mm(round(radii['G'], 7))}, C {mm(round(radii['C'], 7))}, and it states {mm(round(stated, 7))}"
    alike = [
        c for c, value in radii.items() if abs(value - stated) <= CRITERION_TOLERANCE * stated + ROUNDING
    ]
    if alike == ["C"]:
        table["criterion"] = "C"
        return f"criterion C (minimum zone) is taken: {text}"
    return f"G (least squares), as its value says: {text}" if "G" in alike else f"{assumed}: {text}"


def _form(feature: dict[str, Any], points: Array, criterion: str) -> float:
    """Return the range of the distances from the element, mm."""
    axis = np.array(feature["axis"], float) if feature["type"] == "circle" else None
    element = gauss(feature["type"], points, fixed_axis=axis)
    if criterion == "C":
        element = associate(feature["type"], "C", points, element, fixed_axis=axis, judged=False).element
    return float(np.ptp(element.residuals))


def _stated_values(qif: Qif) -> dict[str, float]:
    """Return the values in mm of the first results, by item id."""
    result = next((n for n in qif.root.below() if n.name == "MeasurementResults"), None)
    listed = None if result is None else result.one("MeasuredCharacteristics/CharacteristicMeasurements")
    out: dict[str, float] = {}
    for node in listed.children if listed else ():
        value = node.one("Value")
        if value is not None and node.name.removesuffix("CharacteristicMeasurement") in (
            "Flatness",
            "Circularity",
            "Cylindricity",
        ):
            out[node.words("CharacteristicItemId")] = qif.length(value)
    return out


def read_qif_part(path: str | Path) -> DrawnPart:
    """Raises DataError with file and line where the document is broken, or holds no feature that vcmm has."""
    qif = read_qif(path)
    notes: list[str] = []
    measured = _measured_sets(qif, notes)
    radii = {item_values.tip_radius for item_values in measured.values()}
    drawn = DrawnPart(
        Path(path).name, _name(qif), notes=notes, tip_radius=next(iter(radii)) if len(radii) == 1 else None
    )
    if len(radii) > 1:
        measured = {}
        notes.append(f"{qif.path}:1: points compensated in different ways are mixed; none are taken over")
    names = add_features(qif, drawn, {item: item_values.points for item, item_values in measured.items()})
    if not names:
        raise DataError(
            f"{qif.root.at}: this document holds no features; vcmm makes a part of features with nominals"
        )
    take_criteria(qif, drawn, add_characteristics(qif, drawn, names))
    return drawn


def _measured_sets(qif: Qif, notes: list[str]) -> dict[str, MeasuredSet]:
    """Return the points by feature item of the first results, from which extents follow; a tip radius changes these by itself at most."""
    result = next((n for n in qif.root.below() if n.name == "MeasurementResults"), None)
    if result is None:
        return {}
    return of_features(qif, result, notes)


def _name(qif: Qif) -> str:
    part = qif.root.one("Product/PartSet/Part")
    if part is None:
        return qif.path.stem
    return part.words("Header/Name") or part.words("Name") or part.words("ModelNumber") or qif.path.stem
