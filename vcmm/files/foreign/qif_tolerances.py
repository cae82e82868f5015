"""Convert characteristics of a QIF document to tables of part/1; characteristics that vcmm cannot express become notes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vcmm.core.errors import DataError
from vcmm.files.foreign.drawing import DrawnPart, NotHere, deg, mm
from vcmm.files.foreign.qif import Qif
from vcmm.files.foreign.xml import Node

SUFFIX = "CharacteristicItem"
ZONES = {
    "Flatness": "flatness", "Straightness": "straightness", "Circularity": "roundness", "Cylindricity": "cylindricity",
    "Parallelism": "parallelism", "Perpendicularity": "perpendicularity", "Angularity": "angularity",
    "Position": "position", "Concentricity": "coaxiality", "Coaxiality": "coaxiality", "Symmetry": "symmetry",
    "CircularRunout": "circular_runout", "TotalRunout": "total_runout", "LineProfile": "line_profile",
    "SurfaceProfile": "surface_profile",
}  # fmt: skip
SIZES = {
    "Diameter": 1.0,
    "SphericalDiameter": 1.0,
    "Radius": 2.0,
    "SphericalRadius": 2.0,
}  # diameters per value
BETWEEN = {"DistanceBetween": "distance", "AngleBetween": "angle"}
MATERIAL = {"MAXIMUM": "M", "LEAST": "L"}
NO_NAMES = ("", "NONE", "N/A", "NO NAME", "UNNAMED")
NO_MODIFIER = ("", "NONE", "REGARDLESS")


@dataclass(frozen=True, eq=False)
class QifDefinition:
    """A characteristic: kind in QIF's word, its item, nominal and definition."""

    kind: str
    item: Node
    nominal: Node
    definition: Node


def add_characteristics(qif: Qif, drawn: DrawnPart, names: Mapping[str, str]) -> dict[str, str]:
    """Add every characteristic item that part/1 can express to `drawn`; return its name by item id. The others become notes."""
    items = qif.root.one("Characteristics/CharacteristicItems")
    datums = _datum_features(qif, names)
    out: dict[str, str] = {}
    for item in items.children if items else ():
        label = item.words("Name") or item.words("CharacteristicDesignator/Designator")
        name = drawn.free_name(label or f"characteristic {item.attributes.get('id', '')}")
        try:
            table = _table(qif, drawn, item, names, datums)
        except NotHere as why:
            drawn.notes.append(f"{item.at}: {item.name.removesuffix(SUFFIX)} {name}: {why}; left out")
            continue
        drawn.characteristics.append({"name": name, **table})
        if label and label.strip("-_ .").upper() in NO_NAMES:
            drawn.notes.append(f'{item.at}: the file calls a {table["type"]} "{label}"; give it a name')
        out[item.attributes.get("id", "")] = name
    return out


def _table(
    qif: Qif, drawn: DrawnPart, item: Node, names: Mapping[str, str], datums: Mapping[str, str]
) -> dict[str, Any]:
    kind = item.name.removesuffix(SUFFIX)
    if kind not in (*ZONES, *SIZES, *BETWEEN):
        raise NotHere("no such characteristic here")
    nominal = qif.node_at(item, "CharacteristicNominalId")
    definition = None if nominal is None else qif.node_at(nominal, "CharacteristicDefinitionId")
    if nominal is None or definition is None:
        raise NotHere("its nominal or definition is missing")
    of = [names.get(i.text.strip()) for i in item.many("FeatureItemIds/Id")]
    if not of or None in of:
        raise NotHere("its feature is not here")
    definition_of = QifDefinition(kind, item, nominal, definition)
    features = [str(f) for f in of]
    if kind in BETWEEN:
        if len(features) != 2:
            raise NotHere(f"between {len(features)} features, expected two")
        if nominal.words("AnalysisMode", "THREEDIMENSIONAL") != "THREEDIMENSIONAL":
            raise NotHere("along one direction or in one plane only")
        return {"type": BETWEEN[kind], "between": drawn.reference_first(features)} | _limits(
            qif, definition_of, None
        )
    if len(features) != 1 and kind != "Position":
        raise NotHere(f"of {len(features)} features")
    if kind in SIZES:
        diameter = drawn.features[features[0]].get("diameter")
        if diameter is None:
            raise NotHere("its feature has no diameter")
        return {"type": "size", "of": features[0]} | _limits(qif, definition_of, float(diameter.split()[0]))
    return {"type": ZONES[kind], "of": features[0] if len(features) == 1 else features} | _zone(
        qif, definition_of, datums
    )


def _zone(qif: Qif, definition: QifDefinition, datums: Mapping[str, str]) -> dict[str, Any]:
    width = definition.definition.one("ToleranceValue")
    if width is None:
        raise NotHere("no tolerance value")
    if definition.definition.one("OuterDisposition") is not None:
        raise NotHere("a zone that is not disposed equally")
    out: dict[str, Any] = {"zone": mm(qif.length(width))}
    frame = qif.node_at(definition.definition, "DatumReferenceFrameId")
    if frame is not None and (letters := _datums(qif, frame, datums)):
        out["datums"] = letters
    condition = definition.definition.words("MaterialCondition")
    if condition in MATERIAL:
        out["material"] = MATERIAL[condition]
    elif condition not in NO_MODIFIER:
        raise NotHere(f"material condition {condition}")
    return out


def _datums(qif: Qif, frame: Node, datums: Mapping[str, str]) -> list[str]:
    """Return the features of the datums in their order. NotHere: a modifier on a datum, a datum without feature."""
    rank = {"PRIMARY": 0, "SECONDARY": 1, "TERTIARY": 2}
    letters = []
    for datum in frame.many("Datums/Datum"):
        modifier = datum.words("SimpleDatum/MaterialModifier")
        if datum.one("SimpleDatum") is None:
            raise NotHere("a common datum")
        if modifier not in NO_MODIFIER:
            raise NotHere(f"a material requirement ({modifier}) on a datum")
        definition = qif.node_at(datum, "SimpleDatum/DatumDefinitionId")
        key = "" if definition is None else definition.attributes.get("id", "")
        if key not in datums:
            label = "" if definition is None else definition.words("DatumLabel")
            raise NotHere(f"the datum {label} has no feature here")
        letters.append((rank.get(datum.words("Precedence/PrecedenceEnum"), 3), datums[key]))
    return [name for _, name in sorted(letters, key=lambda f: f[0])]


def _datum_features(qif: Qif, names: Mapping[str, str]) -> dict[str, str]:
    """Name of the feature by id of the datum definition: the feature that it names, or the one that bears its label."""
    out: dict[str, str] = {}
    nominal_of = {
        qif.by_id[item].words("FeatureNominalId"): name for item, name in names.items() if item in qif.by_id
    }
    for definition in qif.root.many("DatumDefinitions/DatumDefinition"):
        named = [n.text.strip() for n in definition.below() if n.name == "Id"]
        name = next((names.get(i) or nominal_of.get(i) for i in named if i in names or i in nominal_of), None)
        label = definition.words("DatumLabel")
        if name is None and label in names.values():
            name = label
        if name is not None:
            out[definition.attributes.get("id", "")] = name
    return out


def _limits(qif: Qif, definition: QifDefinition, diameter: float | None) -> dict[str, Any]:
    """Return limits from the nominal value of the features, or nothing where the drawing states none."""
    tolerance = definition.definition.one("Tolerance")
    if tolerance is None:
        return {}
    ends = [tolerance.one(f"{end}Value") for end in ("Min", "Max")]
    if ends[0] is None or ends[1] is None:
        raise NotHere("one limit only")
    angle = definition.kind == "AngleBetween"
    read = qif.angle if angle else qif.length
    low, high = read(ends[0]), read(ends[1])
    target = definition.nominal.one("TargetValue")
    nominal = None if target is None else read(target)
    factor = SIZES.get(definition.kind, 1.0)
    if diameter is not None:
        nominal = diameter / factor if nominal is None else nominal
        shift = nominal - diameter / factor
    else:
        shift = 0.0
    if tolerance.words("DefinedAsLimit") in ("true", "1"):
        if nominal is None:
            raise NotHere("absolute limits without a nominal value")
        low, high = low - nominal, high - nominal
    if not low < high:
        raise DataError(f"{tolerance.at}: the limits {low:g} and {high:g} hold nothing between them")
    write = deg if angle else mm
    return {"limits": [write(factor * (_clean(low) + shift)), write(factor * (_clean(high) + shift))]}


def _clean(value: float) -> float:
    """Return limits minus nominal without the noise of subtraction: to 1e-9 mm."""
    return round(value, 9) if math.isfinite(value) else value
