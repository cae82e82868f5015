"""Write results as a QIF 3.0 document: features, characteristics and their measured values with combinedUncertainty and meanError.

combinedUncertainty is the combined standard uncertainty u, meanError the size of the bias (indicated - true): QIF allows no
sign there, so the bias with its sign is an attribute "bias" of the measurement. Elements, their order, required
ones and allowed words follow the schema of QIF 3.0; tests/files/foreign/qif_schema.py holds them.
Source: ISO 23952:2020, QIF 3.0: QIFDocument.xsd, QIFResults.xsd, Characteristics.xsd, Features.xsd, IntermediatesPMI.xsd, Units.xsd.

Statements of QIF 3.0 about a characteristic before it is measured: tolerance, material condition, shape of the zone; its numbers.

A zone of orientation, position, coaxiality or straightness must name its shape; orientation and position also a material condition.
Numbers of lengths and angles are xs:decimal, which has no exponent. Source: the schema of QIF 3.0 (Characteristics.xsd, Units.xsd).
"""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from xml.sax.saxutils import escape

from vcmm.core.pose import dot
from vcmm.files.foreign.exported_values import HandedValue
from vcmm.files.foreign.qif import NAMESPACE
from vcmm.part.part import Characteristic, Feature, Part

CONDITIONS = {"": "REGARDLESS", "M": "MAXIMUM", "L": "LEAST"}
ORIENTATIONS = ("parallelism", "perpendicularity", "angularity")
PARALLEL = 1e-9  # of a cosine from 1: directions that the drawing calls parallel


def decimal(value: float, digits: int = 15) -> str:
    """Return a number as xs:decimal: significant digits, never an exponent.

    >>> decimal(0.000085), decimal(-1e-7), decimal(25.4), decimal(0.0)
    ('0.000085', '-0.0000001', '25.4', '0')
    """
    return f"{Decimal(f'{value:.{digits}g}'):f}"


def size_definition(v: HandedValue) -> str:
    """Return the content of the definition of a size, distance or angle: limits from the nominal value, or that it has none."""
    if v.tolerance is None:
        return "<NonTolerance>MEASURED</NonTolerance>"
    low, high = (decimal(end - v.nominal, 12) for end in v.tolerance)
    return f"<Tolerance><MaxValue>{high}</MaxValue><MinValue>{low}</MinValue><DefinedAsLimit>false</DefinedAsLimit></Tolerance>"


def zone_definition(
    c: Characteristic, v: HandedValue, features: Mapping[str, Feature], frame: int | None
) -> str:
    """Return the content of the definition of a form, orientation, location, run-out or profile; without tolerance its width is 0."""
    width = v.tolerance[1] if v.tolerance is not None else 0.0
    parts = [f"<ToleranceValue>{decimal(width)}</ToleranceValue>"]
    if frame is not None:
        parts.append(f"<DatumReferenceFrameId>{frame}</DatumReferenceFrameId>")
    if c.type in (*ORIENTATIONS, "position"):
        parts.append(f"<MaterialCondition>{CONDITIONS[c.material]}</MaterialCondition>")
    shape = _shape(c, [features[n] for n in c.of], [features[d] for d in c.datums if d in features])
    return "".join(parts) + (f"<ZoneShape><{shape}/></ZoneShape>" if shape else "")


def _shape(c: Characteristic, of: Sequence[Feature], datums: Sequence[Feature]) -> str:
    """Return the word for the zone that vcmm evaluates (vcmm.part.gps.orientation, vcmm.part.gps.location); "" where none is needed."""
    kind = of[0].kind
    if c.type == "straightness":
        return "NonDiametricalZone"
    if c.type == "coaxiality":
        return "DiametricalZone"
    if c.type == "position":
        if kind in ("sphere", "torus"):
            return "SphericalZone"
        return "DiametricalZone" if kind in ("circle", "cylinder", "cone") else "NonDiametricalZone"
    if c.type in ORIENTATIONS:
        turns = (
            bool(datums) and kind != "plane" and abs(abs(dot(of[0].axis, datums[0].axis)) - 1.0) < PARALLEL
        )
        return "DiametricalZone" if turns else "PlanarZone"
    return ""


FEATURES = {
    "point": "Point", "line": "Line", "plane": "Plane", "circle": "Circle", "cylinder": "Cylinder", "sphere": "Sphere",
    "cone": "Cone",
}  # fmt: skip
ZONES = {
    "flatness": "Flatness", "straightness": "Straightness", "roundness": "Circularity", "cylindricity": "Cylindricity",
    "parallelism": "Parallelism", "perpendicularity": "Perpendicularity", "angularity": "Angularity",
    "position": "Position", "coaxiality": "Coaxiality", "symmetry": "Symmetry", "circular_runout": "CircularRunout",
    "total_runout": "TotalRunout", "line_profile": "LineProfile", "surface_profile": "SurfaceProfile",
}  # fmt: skip
SIZES = {"size": "Diameter", "distance": "DistanceBetween", "angle": "AngleBetween"}
STATUS = {"conforms": "PASS", "does not conform": "FAIL"}
UNDECIDED, UNASKED = "INDETERMINATE", "NOT_ANALYZED"  # of a characteristic with and without tolerance


@dataclass
class _Writer:
    """Lines of the sections, and the next id."""

    last: int = 0
    sections: dict[str, list[str]] = field(default_factory=dict)

    def id(self) -> int:
        self.last += 1
        return self.last

    def add(self, section: str, text: str) -> None:
        self.sections.setdefault(section, []).append(text)

    def lists(self, *sections: str) -> str:
        """Return lists with their counts, as every list of QIF has one; empty ones are left out."""
        lists = [(s, self.sections.get(s, [])) for s in sections]
        return "\n".join(f'<{s} n="{len(t)}">\n' + "\n".join(t) + f"\n</{s}>" for s, t in lists if t)


def qif_text(
    part: Part, values: Mapping[str, Sequence[HandedValue]], seed: str
) -> tuple[str, tuple[str, ...]]:
    """Return the document, and notes on content that it cannot express. values: by part. seed: makes the document's identifier, so that
    it repeats."""
    writer, notes = _Writer(), []
    items = {n: _feature(writer, f) for n, f in part.features.items() if f.kind in FEATURES}
    datums = _datums(writer, part, items)
    made: dict[str, tuple[str, int]] = {}
    first = next(iter(values.values()))
    for v in first:
        c = next((c for c in part.characteristics if c.name == v.name), None)
        of = [] if c is None else [*c.of, *c.between]
        if c is None or any(n not in items for n in of):
            notes.append(
                f"{v.name}: its feature has no word in QIF as written here; left out of the QIF file"
            )
            continue
        notes += _gaps(c, v, datums)
        made[v.name] = _characteristic(writer, c, v, part.features, (items, datums.get(c.name)))
    results = [_results(writer, name, part_values, made) for name, part_values in values.items()]
    listed = writer.lists("ActualComponentSet")
    parts = f'<ActualComponentSets n="1">\n{listed}\n</ActualComponentSets>\n' if listed else ""
    body = [
        _section("", writer.lists("DatumDefinitions", "DatumReferenceFrames")),
        _section("Features", writer.lists("FeatureDefinitions", "FeatureNominals", "FeatureItems")),
        _section("Characteristics", writer.lists("CharacteristicDefinitions", "CharacteristicNominals", "CharacteristicItems")),
        f'<Results>\n<MeasurementResultsSet n="{len(results)}">\n' + "\n".join(results) + f"\n</MeasurementResultsSet>\n{parts}</Results>",
    ]  # fmt: skip
    head = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<QIFDocument xmlns="{NAMESPACE}" idMax="{writer.last}" versionQIF="3.0.0">\n'
        f"<QPId>{uuid.uuid5(uuid.NAMESPACE_URL, seed)}</QPId>\n"
        "<Header><Application><Name>vcmm</Name></Application></Header>\n" + UNITS
    )
    return head + "\n".join(b for b in body if b) + "\n</QIFDocument>\n", tuple(notes)


UNITS = (
    "<FileUnits><PrimaryUnits>"
    "<AngularUnit><SIUnitName>radian</SIUnitName><UnitName>radian</UnitName></AngularUnit>"
    "<LinearUnit><SIUnitName>meter</SIUnitName><UnitName>mm</UnitName>"
    "<UnitConversion><Factor>0.001</Factor></UnitConversion></LinearUnit>"
    "</PrimaryUnits></FileUnits>\n"
)


def _section(name: str, content: str) -> str:
    return content if not name or not content else f"<{name}>\n{content}\n</{name}>"


def _feature(w: _Writer, f: Feature) -> tuple[int, int]:
    """Return the ids of the nominal and the item of a feature."""
    kind, definition, nominal, item = FEATURES[f.kind], w.id(), w.id(), w.id()
    size = ""
    if f.kind in ("circle", "cylinder", "sphere", "cone"):
        side = "INTERNAL" if f.inside else "EXTERNAL"
        size = f"<InternalExternal>{side}</InternalExternal><Diameter>{decimal(2 * f.sizes[0])}</Diameter>"
    if f.kind == "cylinder":
        size += f"<Length>{decimal(f.extent[0])}</Length>"
    if f.kind == "cone":  # its axis leads from the small end to the large one, in QIF as here
        size += f"<HalfAngle>{decimal(f.sizes[1])}</HalfAngle><LargeEndDistance>{decimal(f.extent[0])}</LargeEndDistance>"
        size += "<SmallEndDistance>0</SmallEndDistance>"
    w.add(
        "FeatureDefinitions", f'<{kind}FeatureDefinition id="{definition}">{size}</{kind}FeatureDefinition>'
    )
    place = f"<FeatureDefinitionId>{definition}</FeatureDefinitionId>{_place(f)}"
    w.add("FeatureNominals", f'<{kind}FeatureNominal id="{nominal}">{place}</{kind}FeatureNominal>')
    measured = (
        "<DeterminationMode><Checked><CheckDetails><Measured/></CheckDetails></Checked></DeterminationMode>"
    )
    text = (
        f"<FeatureNominalId>{nominal}</FeatureNominalId><FeatureName>{escape(f.name)}</FeatureName>{measured}"
    )
    w.add("FeatureItems", f'<{kind}FeatureItem id="{item}">{text}</{kind}FeatureItem>')
    return nominal, item


def _place(f: Feature) -> str:
    point, axis = " ".join(f"{v:.15g}" for v in f.point), " ".join(f"{v:.15g}" for v in f.axis)
    if f.kind in ("cylinder", "cone"):
        return f"<Axis><AxisPoint>{point}</AxisPoint><Direction>{axis}</Direction></Axis>"
    if f.kind == "sphere":
        return f"<Location>{point}</Location>"
    way = "Direction" if f.kind == "line" else "Normal"
    return f"<Location>{point}</Location><{way}>{axis}</{way}>"


def _datums(w: _Writer, part: Part, items: Mapping[str, tuple[int, int]]) -> dict[str, int]:
    """Return the id of the datum reference frame by characteristic; datums are lettered in the order in which they are met."""
    letters: dict[str, int] = {}
    frames: dict[str, int] = {}
    order = ("PRIMARY", "SECONDARY", "TERTIARY")
    for c in part.characteristics:
        if not c.datums or any(d not in items for d in c.datums):
            continue
        for d in c.datums:
            if d not in letters:
                letters[d] = w.id()
                label = chr(ord("A") + len(letters) - 1) if len(letters) <= 26 else f"A{len(letters)}"
                named = f'<FeatureNominalIds n="1"><Id>{items[d][0]}</Id></FeatureNominalIds>'
                w.add("DatumDefinitions", f'<DatumDefinition id="{letters[d]}"><DatumLabel>{label}</DatumLabel>{named}</DatumDefinition>')  # fmt: skip
        frames[c.name] = w.id()
        rows = "".join(
            f"<Datum><SimpleDatum><DatumDefinitionId>{letters[d]}</DatumDefinitionId>"
            "<MaterialModifier>NONE</MaterialModifier><ReferencedComponent>ACTUAL</ReferencedComponent></SimpleDatum>"
            f"<Precedence><PrecedenceEnum>{order[i]}</PrecedenceEnum></Precedence></Datum>"
            for i, d in enumerate(c.datums)
        )
        w.add("DatumReferenceFrames", f'<DatumReferenceFrame id="{frames[c.name]}"><Datums n="{len(c.datums)}">{rows}</Datums></DatumReferenceFrame>')  # fmt: skip
    return frames


def _gaps(c: Characteristic, v: HandedValue, frames: Mapping[str, int]) -> list[str]:
    """Return notes on properties of a characteristic that QIF as written here cannot express."""
    out = []
    if c.datums and c.name not in frames:
        out.append(
            f"{c.name}: a common datum has no word in QIF as written here; it is written without datums"
        )
    if v.tolerance is None and c.type not in SIZES:
        out.append(
            f"{c.name}: it has no tolerance, and QIF demands a width; 0 is written, with the status {UNASKED}"
        )
    return out


def _characteristic(
    w: _Writer,
    c: Characteristic,
    v: HandedValue,
    features: Mapping[str, Feature],
    placed: tuple[Mapping[str, tuple[int, int]], int | None],
) -> tuple[str, int]:
    """Return the kind and id of the item of a characteristic. placed: ids of features, and of its datum reference frame."""
    items, frame = placed
    kind = SIZES.get(c.type) or ZONES[c.type]
    definition, nominal, item = w.id(), w.id(), w.id()
    inside = size_definition(v) if c.type in SIZES else zone_definition(c, v, features, frame)
    w.add("CharacteristicDefinitions", f'<{kind}CharacteristicDefinition id="{definition}">{inside}</{kind}CharacteristicDefinition>')  # fmt: skip
    target = f"<TargetValue>{decimal(v.nominal)}</TargetValue>" if c.type in SIZES else ""
    mode = "<AnalysisMode>THREEDIMENSIONAL</AnalysisMode>" if c.type in ("distance", "angle") else ""
    w.add("CharacteristicNominals", f'<{kind}CharacteristicNominal id="{nominal}"><CharacteristicDefinitionId>{definition}</CharacteristicDefinitionId>{target}{mode}</{kind}CharacteristicNominal>')  # fmt: skip
    of = [*c.of, *c.between]
    ids = "".join(f"<Id>{items[n][1]}</Id>" for n in of)
    w.add("CharacteristicItems", f'<{kind}CharacteristicItem id="{item}"><Name>{escape(c.name)}</Name><FeatureItemIds n="{len(of)}">{ids}</FeatureItemIds><CharacteristicNominalId>{nominal}</CharacteristicNominalId></{kind}CharacteristicItem>')  # fmt: skip
    return kind, item


def _results(
    w: _Writer, name: str, values: Sequence[HandedValue], made: Mapping[str, tuple[str, int]]
) -> str:
    rows = [_measurement(w, v, *made[v.name]) for v in values if v.name in made]
    decided = [_status(v) for v in values if v.tolerance is not None]
    whole = "FAIL" if "FAIL" in decided else "PASS" if decided and set(decided) == {"PASS"} else "UNKNOWN"
    listed = (
        f'<CharacteristicMeasurements n="{len(rows)}">\n'
        + "\n".join(rows)
        + "\n</CharacteristicMeasurements>"
    )
    measured = f"<MeasuredCharacteristics>\n{listed}\n</MeasuredCharacteristics>\n" if rows else ""
    label = f"<ThisResultsInstanceQPId>{uuid.uuid5(uuid.NAMESPACE_URL, f'{name}/{w.last}')}</ThisResultsInstanceQPId>\n"
    return (
        f'<MeasurementResults id="{w.id()}">\n{label}{measured}'
        f"<InspectionStatus><InspectionStatusEnum>{whole}</InspectionStatusEnum></InspectionStatus>\n{_component(w, name, whole)}</MeasurementResults>"
    )


def _measurement(w: _Writer, v: HandedValue, kind: str, item: int) -> str:
    signed, stated = "", ""
    if v.u is not None:
        signed = f'<Attributes n="1"><AttributeD1 name="bias" value="{v.bias:.6g}"/></Attributes>'
        stated = f' combinedUncertainty="{decimal(v.u, 6)}" meanError="{decimal(abs(v.bias), 6)}"'
    return (
        f'<{kind}CharacteristicMeasurement id="{w.id()}">{signed}<Status><CharacteristicStatusEnum>{_status(v)}</CharacteristicStatusEnum></Status>'
        f"<CharacteristicItemId>{item}</CharacteristicItemId><Value{stated}>{decimal(v.measured)}</Value></{kind}CharacteristicMeasurement>"
    )


def _status(v: HandedValue) -> str:
    return STATUS.get(v.decision, UNDECIDED) if v.tolerance is not None else UNASKED


def _component(w: _Writer, name: str, status: str) -> str:
    """Return the component that was measured, by its name as serial number; nothing for a part without name."""
    if not name:
        return ""
    key = w.id()
    stated = f"<Status><InspectionStatusEnum>{status}</InspectionStatusEnum></Status>"
    w.add(
        "ActualComponentSet",
        f'<ActualComponent id="{key}"><SerialNumber>{escape(name)}</SerialNumber>{stated}</ActualComponent>',
    )
    return f'<ActualComponentIds n="1"><Id>{key}</Id></ActualComponentIds>\n'
