"""Features of a QIF document as tables of part/1, from definition, nominal and item; their measured points.

A feature item is one surface of the part: its name, its nominal (where it lies) and its definition (size, inside or
outside). What the file leaves open (size of a plane, length of a bore) comes from the measured points, or is assumed
and said.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.files.foreign.drawing import DEFAULT_EXTENT, DrawnPart, deg, mm, spanned_plane, unit
from vcmm.files.foreign.qif import Qif
from vcmm.files.foreign.xml import Node, series

KINDS = {
    "PlaneFeatureItem": "plane", "CircleFeatureItem": "circle", "CylinderFeatureItem": "cylinder",
    "SphereFeatureItem": "sphere", "ConeFeatureItem": "cone", "LineFeatureItem": "line", "PointFeatureItem": "point",
    "SurfacePointFeatureItem": "point", "EdgePointFeatureItem": "point", "TorusFeatureItem": "torus",
}  # fmt: skip


def add_features(qif: Qif, drawn: DrawnPart, measured: Mapping[str, Array]) -> dict[str, str]:
    """Every feature item that vcmm has, into `drawn`; its name by item id. What it has not becomes a note.

    measured: points (n, 3) mm by id of the feature item.
    """
    names: dict[str, str] = {}
    items = qif.root.one("Features/FeatureItems")
    for item in items.children if items else ():
        name = drawn.free_feature(item.words("FeatureName") or f"feature {item.attributes.get('id', '')}")
        kind = KINDS.get(item.name)
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
    """A point of the feature and its direction; a sphere has none."""
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
    """{"inside": True} of a bore. Where the file does not say it, centres of the tip within the diameter tell."""
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
    """Size of a plane, length of the others: stated, spanned by the points, or assumed and said."""
    name, nominal, definition = described
    place, axis = frame
    stated = definition.one("Length") or nominal.one("Length")
    if kind != "plane" and stated is not None:
        return {"length": mm(qif.length(stated))}
    ends = [nominal.one(f"{end}Point") for end in ("Start", "End")]
    if kind == "line" and ends[0] is not None and ends[1] is not None:
        return {"length": mm(float(np.linalg.norm(qif.place(ends[1]) - qif.place(ends[0]))))}
    if points is not None and len(points) > 1 and (found := _span(kind, place, np.array(axis), points)):
        drawn.notes.append(f"{nominal.at}: {name}: its extent is that of its measured points")
        return found
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
