"""Measured points of QIF results: the sets of every measured feature, with or without compensation for the tip."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.answer.inference.given_points import GivenPoints
from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.core.text import brief
from vcmm.files.foreign.qif import Qif, read_qif
from vcmm.files.foreign.xml import Node, series

TIP = 1e-6  # mm: 1 nm, what two statements of one tip radius may differ by


@dataclass(frozen=True, eq=False)
class MeasuredSet:
    """points (n, 3) mm; tip_radius mm where they are centres of the tip, None where they lie on the surface."""

    points: Array
    tip_radius: float | None
    at: str


@dataclass(frozen=True, eq=False)
class QifPoints:
    """Points of every part in the form that `evaluate` needs; tip_radius mm: they are centres of such a tip (None: on the surface)."""

    parts: tuple[GivenPoints, ...]
    tip_radius: float | None
    notes: tuple[str, ...]


def read_qif_points(path: str | Path) -> QifPoints:
    """Raises DataError: no points, points of two kinds (tip centres and surface), sets that do not exist."""
    qif = read_qif(path)
    parts: list[GivenPoints] = []
    notes: list[str] = []
    radii: dict[float | None, str] = {}
    results = [n for n in qif.root.below() if n.name == "MeasurementResults"]
    for result in results:
        points_of = of_features(qif, result, notes)
        names = feature_names(qif)
        features, points, where = [], [], []
        for item, item_points in points_of.items():
            radii.setdefault(item_points.tip_radius, item_points.at)
            features += [names[item]] * len(item_points.points)
            points.append(item_points.points)
            where += [
                f"{item_points.at} ({names[item]}, point {i})" for i in range(1, len(item_points.points) + 1)
            ]
        if points:
            name = "" if len(results) == 1 else result.attributes.get("id", "")
            parts.append(GivenPoints(name, np.concatenate(points), tuple(where), tuple(features)))
    if not parts:
        raise DataError(f"{qif.root.at}: no MeasurementResults with points are in this file")
    if len(radii) > 1:
        (_, first), (_, second), *_ = radii.items()
        raise DataError(
            f"{second}: these points are compensated for another tip than those at {first}; export all of them alike"
        )
    return QifPoints(tuple(parts), next(iter(radii)), tuple(notes))


def feature_names(qif: Qif) -> dict[str, str]:
    """Return FeatureName of every feature item by its id; "feature ID" where it has none."""
    items = qif.root.one("Features/FeatureItems")
    return {
        key: item.words("FeatureName") or f"feature {key}"
        for item in (items.children if items else ())
        if (key := item.attributes.get("id"))
    }


def of_features(qif: Qif, result: Node, notes: list[str]) -> dict[str, MeasuredSet]:
    """Return the points of one set of results by id of the feature item; measured features without points become notes."""
    sets = {s.attributes.get("id", ""): s for s in result.many("MeasuredPointSets/MeasuredPointSet")}
    measured = result.one("MeasuredFeatures")
    out: dict[str, MeasuredSet] = {}
    for node in measured.children if measured else ():
        item = node.words("FeatureItemId")
        if item not in qif.by_id:
            raise DataError(f'{node.at}: the feature item "{brief(item)}" is not in this file')
        listed = node.one("PointList")
        if listed is None:
            notes.append(f"{node.at}: {feature_names(qif)[item]} was constructed, without points of its own")
            continue
        lost = next((e for e in listed.children if e.text.strip() not in sets), None)
        if lost is not None:
            notes.append(
                f'{lost.at}: the point set "{brief(lost.text.strip())}" of {feature_names(qif)[item]} is not in these results: no points'
            )
            continue
        out[item] = _join_sets(qif, listed, sets)
    return out


def _join_sets(qif: Qif, listed: Node, sets: Mapping[str, Node]) -> MeasuredSet:
    pieces = [_piece(qif, entry, sets) for entry in listed.children]
    if not pieces:
        raise DataError(f"{listed.at}: the list of points is empty")
    radii = {p.tip_radius for p in pieces}
    if len(radii) > 1:
        raise DataError(f"{listed.at}: one feature has points with different compensation of the tip")
    return MeasuredSet(np.concatenate([p.points for p in pieces]), pieces[0].tip_radius, pieces[0].at)


def _piece(qif: Qif, entry: Node, sets: Mapping[str, Node]) -> MeasuredSet:
    node = sets[entry.text.strip()]
    listed = node.one("Points")
    if listed is None:
        raise DataError(
            f"{node.at}: the point set has no <Points>; binary points are not read, export them as text"
        )
    points = qif.to_mm * series(listed, 3)
    first, last = _rows(entry, len(points))
    return MeasuredSet(points[first - 1 : last], _tip(qif, node), node.at)


def _rows(entry: Node, count: int) -> tuple[int, int]:
    """Return the first and last row that an entry names, counted from 1."""
    if entry.name == "WholePointSetId":
        return 1, count
    text = entry.attributes.get("range" if entry.name == "RangePointSetId" else "index", "")
    ends = [int(n) for n in text.split() if re.fullmatch("[0-9]{1,9}", n)]
    if not ends or not 1 <= ends[0] <= ends[-1] <= count:
        raise DataError(f'{entry.at}: "{brief(text)}" names no points of a set of {count}')
    return ends[0], ends[-1]


def _tip(qif: Qif, node: Node) -> float | None:
    if node.words("Compensated", "true") in ("true", "1"):
        return None
    radius = node.one("ProbeRadius")
    if radius is None:
        raise DataError(f"{node.at}: the points are not compensated and no <ProbeRadius> is stated")
    return qif.length(radius)
