"""What the schema of QIF 3.0 asks of every element that vcmm writes, as it was read there; no text of the schema is copied.

Read by eye on 23 November 2026 in github.com/QualityInformationFramework/qif-community, bindings/CPP-Kramer/schema:
QIFDocument.xsd (QIFDocumentType, header), QIFResults.xsd (all), Characteristics.xsd (bases of definition, nominal, item and
measurement; orientation; straightness, flatness, circularity, cylindricity), Features.xsd (cone), Units.xsd (decimals, measured
decimals), Primitives.xsd (points, references, attributes). Position, coaxiality, run-out, profiles, datums, units, the other
features and the words of states: in the classes of github.com/KBoSys/QIF_Import that were made from the same schema.

A rule is the children in their order: "Name" must stand once, "Name?" may be missing, "Name+" stands once or more, "A|B" is one of two.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from vcmm.files.foreign.xml import Node

DECIMAL, DOUBLE, REFERENCE = "decimal", "double", "reference"
TEXT, THREE = "text", "three doubles"
SIZED = ("Tolerance|NonTolerance",)
GEOMETRIC = ("ToleranceValue", "DatumReferenceFrameId?")
FORM = ("ToleranceValue",)
ORIENTED = (*GEOMETRIC, "MaterialCondition", "ZoneShape")
RULES: dict[str, tuple[str, ...] | str] = {
    "QIFDocument": (
        "QPId", "Header?", "FileUnits?", "DatumDefinitions?", "DatumReferenceFrames?", "Features?", "Characteristics?", "Results?",
    ),
    "QPId": TEXT, "Header": ("Application?",), "Application": ("Name",), "Name": TEXT,
    "FileUnits": ("PrimaryUnits",), "PrimaryUnits": ("AngularUnit?", "LinearUnit?"),
    "AngularUnit": ("SIUnitName?", "UnitName", "UnitConversion?"), "LinearUnit": ("SIUnitName?", "UnitName", "UnitConversion?"),
    "SIUnitName": TEXT, "UnitName": TEXT, "UnitConversion": ("Factor", "Offset?"), "Factor": DECIMAL,
    "DatumDefinitions": ("DatumDefinition+",), "DatumDefinition": ("DatumLabel", "FeatureNominalIds?"), "DatumLabel": TEXT,
    "FeatureNominalIds": ("Id+",), "FeatureItemIds": ("Id+",), "ActualComponentIds": ("Id+",), "Id": REFERENCE,
    "DatumReferenceFrames": ("DatumReferenceFrame+",), "DatumReferenceFrame": ("Datums?",), "Datums": ("Datum+",),
    "Datum": ("SimpleDatum", "Precedence"), "SimpleDatum": ("DatumDefinitionId", "MaterialModifier", "ReferencedComponent"),
    "DatumDefinitionId": REFERENCE, "Precedence": ("PrecedenceEnum",),
    "Features": ("FeatureDefinitions?", "FeatureNominals?", "FeatureItems?"),
    "FeatureDefinitions": ("*FeatureDefinition+",), "FeatureNominals": ("*FeatureNominal+",), "FeatureItems": ("*FeatureItem+",),
    "PointFeatureDefinition": (), "LineFeatureDefinition": (), "PlaneFeatureDefinition": (),
    "CircleFeatureDefinition": ("InternalExternal", "Diameter"), "SphereFeatureDefinition": ("InternalExternal", "Diameter"),
    "CylinderFeatureDefinition": ("InternalExternal", "Diameter", "Length?"),
    "ConeFeatureDefinition": ("InternalExternal", "Diameter", "HalfAngle", "LargeEndDistance", "SmallEndDistance?"),
    "Diameter": DECIMAL, "Length": DECIMAL, "HalfAngle": DECIMAL, "LargeEndDistance": DECIMAL, "SmallEndDistance": DECIMAL,
    "PointFeatureNominal": ("FeatureDefinitionId", "Location", "Normal?"),
    "PlaneFeatureNominal": ("FeatureDefinitionId", "Location", "Normal"),
    "CircleFeatureNominal": ("FeatureDefinitionId", "Location", "Normal"),
    "LineFeatureNominal": ("FeatureDefinitionId", "Location", "Direction"),
    "SphereFeatureNominal": ("FeatureDefinitionId", "Location"),
    "CylinderFeatureNominal": ("FeatureDefinitionId", "Axis"), "ConeFeatureNominal": ("FeatureDefinitionId", "Axis"),
    "FeatureDefinitionId": REFERENCE, "Location": THREE, "Normal": THREE, "Direction": THREE,
    "Axis": ("AxisPoint", "Direction"), "AxisPoint": THREE,
    "*FeatureItem": ("FeatureNominalId?", "FeatureName", "DeterminationMode"), "FeatureNominalId": REFERENCE, "FeatureName": TEXT,
    "DeterminationMode": ("Checked",), "Checked": ("CheckDetails?",), "CheckDetails": ("Measured",), "Measured": (),
    "Characteristics": ("CharacteristicDefinitions?", "CharacteristicNominals?", "CharacteristicItems?"),
    "CharacteristicDefinitions": ("*CharacteristicDefinition+",), "CharacteristicNominals": ("*CharacteristicNominal+",),
    "CharacteristicItems": ("*CharacteristicItem+",),
    "DiameterCharacteristicDefinition": SIZED, "DistanceBetweenCharacteristicDefinition": SIZED, "AngleBetweenCharacteristicDefinition": SIZED,
    "Tolerance": ("MaxValue", "MinValue", "DefinedAsLimit"), "MaxValue": DECIMAL, "MinValue": DECIMAL, "ToleranceValue": DECIMAL,
    "FlatnessCharacteristicDefinition": FORM, "CircularityCharacteristicDefinition": FORM, "CylindricityCharacteristicDefinition": FORM,
    "StraightnessCharacteristicDefinition": (*FORM, "ZoneShape"),
    "ParallelismCharacteristicDefinition": ORIENTED, "PerpendicularityCharacteristicDefinition": ORIENTED,
    "AngularityCharacteristicDefinition": ORIENTED, "PositionCharacteristicDefinition": ORIENTED,
    "CoaxialityCharacteristicDefinition": (*GEOMETRIC, "ZoneShape"), "SymmetryCharacteristicDefinition": GEOMETRIC,
    "CircularRunoutCharacteristicDefinition": GEOMETRIC, "TotalRunoutCharacteristicDefinition": GEOMETRIC,
    "LineProfileCharacteristicDefinition": GEOMETRIC, "SurfaceProfileCharacteristicDefinition": GEOMETRIC,
    "DatumReferenceFrameId": REFERENCE,
    "ZoneShape": ("DiametricalZone|NonDiametricalZone|PlanarZone|SphericalZone",),
    "DiametricalZone": (), "NonDiametricalZone": (), "PlanarZone": (), "SphericalZone": (),
    "DistanceBetweenCharacteristicNominal": ("CharacteristicDefinitionId", "TargetValue?", "AnalysisMode"),
    "AngleBetweenCharacteristicNominal": ("CharacteristicDefinitionId", "TargetValue?", "AnalysisMode"),
    "*CharacteristicNominal": ("CharacteristicDefinitionId", "TargetValue?"), "CharacteristicDefinitionId": REFERENCE, "TargetValue": DECIMAL,
    "*CharacteristicItem": ("Name?", "FeatureItemIds?", "CharacteristicNominalId"), "CharacteristicNominalId": REFERENCE,
    "Results": ("MeasurementResultsSet", "ActualComponentSets?"), "MeasurementResultsSet": ("MeasurementResults+",),
    "MeasurementResults": ("ThisResultsInstanceQPId?", "MeasuredCharacteristics?", "InspectionStatus", "ActualComponentIds?"),
    "ThisResultsInstanceQPId": TEXT, "MeasuredCharacteristics": ("CharacteristicMeasurements",),
    "CharacteristicMeasurements": ("*CharacteristicMeasurement+",),
    "*CharacteristicMeasurement": ("Attributes?", "Status", "CharacteristicItemId", "Value?"),
    "Attributes": ("AttributeD1+",), "AttributeD1": (), "CharacteristicItemId": REFERENCE, "Value": DECIMAL,
    "Status": ("CharacteristicStatusEnum|InspectionStatusEnum",), "InspectionStatus": ("InspectionStatusEnum",),
    "ActualComponentSets": ("ActualComponentSet+",), "ActualComponentSet": ("ActualComponent+",),
    "ActualComponent": ("SerialNumber?", "Status"), "SerialNumber": TEXT,
}  # fmt: skip
WORDS = {
    "CharacteristicStatusEnum": "PASS FAIL REWORK SYSERROR INDETERMINATE NOT_ANALYZED BASIC_OR_TED UNDEFINED",
    "InspectionStatusEnum": "PASS FAIL REWORK SYSERROR UNKNOWN NOT_CALCULATED NOT_MEASURED UNDEFINED",
    "MaterialCondition": "REGARDLESS LEAST MAXIMUM LEAST_RPR MAXIMUM_RPR NONE",
    "MaterialModifier": "REGARDLESS LEAST MAXIMUM LEAST_RPR MAXIMUM_RPR NONE",
    "ReferencedComponent": "NOMINAL ACTUAL",
    "PrecedenceEnum": "PRIMARY SECONDARY TERTIARY QUATERNARY QUINARY SENARY",
    "NonTolerance": "MEASURED SET",
    "InternalExternal": "INTERNAL EXTERNAL NOT_APPLICABLE",
    "AnalysisMode": "ONEDIMENSIONAL TWODIMENSIONAL THREEDIMENSIONAL",
    "DefinedAsLimit": "true false",
}
ZONES = {  # which shapes each definition may name
    "Straightness": "DiametricalZone NonDiametricalZone", "Coaxiality": "DiametricalZone NonDiametricalZone",
    "Position": "DiametricalZone NonDiametricalZone SphericalZone", "Parallelism": "DiametricalZone PlanarZone",
    "Perpendicularity": "DiametricalZone PlanarZone", "Angularity": "DiametricalZone PlanarZone",
}  # fmt: skip
NUMBERED = re.compile(
    r"(Definition|Nominal|Item|Measurement|DatumReferenceFrame|MeasurementResults|ActualComponent)$"
)
LISTS = re.compile(r"(s|Set)$")
IS_DECIMAL = re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)")
GROUPS = ("CharacteristicMeasurement", "CharacteristicDefinition", "CharacteristicNominal", "CharacteristicItem",
          "FeatureDefinition", "FeatureNominal", "FeatureItem")  # fmt: skip


def faults(root: Node) -> list[str]:
    """Everything that the rules forbid, with its line; what no rule names is a fault as well."""
    nodes = [root, *root.below()]
    out = [f for node in nodes for f in _of(node)]
    ids = [n.attributes["id"] for n in nodes if "id" in n.attributes]
    out += [f"id {i} stands twice" for i in sorted(set(ids)) if ids.count(i) > 1]
    if root.attributes.get("versionQIF") != "3.0.0" or int(root.attributes.get("idMax", 0)) < max(
        map(int, ids), default=0
    ):
        out.append("versionQIF is 3.0.0 and idMax no less than the largest id")
    return [*out, *_references(root)]


def _of(node: Node) -> Iterator[str]:
    where = f"{node.at}: <{node.name}>"
    if node.name in WORDS:
        if node.text.strip() not in WORDS[node.name].split():
            yield f'{where}: the word "{node.text.strip()}" is not allowed'
        return
    rule = RULES.get(node.name, RULES.get(_group(node.name)))
    if rule is None:
        yield f"{where}: no rule was read for it"
        return
    if isinstance(rule, str):
        yield from (f"{where}: {f}" for f in _value(node, rule))
    else:
        yield from (f"{where}: {f}" for f in _children([c.name for c in node.children], rule))
    yield from (f"{where}: {f}" for f in _attributes(node, rule))


def _group(name: str) -> str:
    """The rule that all elements of one kind share: "*FeatureItem" of PlaneFeatureItem."""
    return next((f"*{g}" for g in GROUPS if name.endswith(g)), name)


def _children(names: list[str], rule: tuple[str, ...]) -> Iterator[str]:
    left = list(names)
    for wanted in rule:
        plain, count = wanted.rstrip("?+"), 0
        while left and _fits(left[0], plain) and (count == 0 or wanted.endswith("+")):
            left.pop(0)
            count += 1
        if count == 0 and not wanted.endswith("?"):
            yield f"{plain} is required here, found {left[:1] or 'nothing'}"
    if left:
        yield f"{left[0]} is not allowed at its place"


def _fits(name: str, wanted: str) -> bool:
    if wanted.startswith("*"):
        return name.endswith(wanted[1:])
    return name in wanted.split("|")


def _value(node: Node, rule: str) -> Iterator[str]:
    text = node.text.strip()
    if node.children or not text:
        yield "a text is due"
    elif rule == DECIMAL and not IS_DECIMAL.fullmatch(text):
        yield f"{text} is no xs:decimal"
    elif rule == THREE and (len(text.split()) != 3 or not all(abs(float(v)) < 1e12 for v in text.split())):
        yield f"{text} are not three numbers"
    elif rule == REFERENCE and not text.isdigit():
        yield f"{text} is no id"


def _attributes(node: Node, rule: tuple[str, ...] | str) -> Iterator[str]:
    listed = isinstance(rule, tuple) and rule[:1] and rule[0].endswith("+") and LISTS.search(node.name)
    if listed and node.attributes.get("n") != str(len(node.children)):
        yield f"n is {node.attributes.get('n')} of {len(node.children)}"
    if NUMBERED.search(node.name) and not node.attributes.get("id", "").isdigit():
        yield "it has no id"
    if node.name == "AttributeD1" and set(node.attributes) != {"name", "value"}:
        yield "it needs name and value"
    stated = [k for k in ("combinedUncertainty", "meanError") if k in node.attributes]
    if len(stated) == 1:
        yield "combinedUncertainty and meanError stand together or not at all"
    for key in stated:
        if not IS_DECIMAL.fullmatch(node.attributes[key]) or float(node.attributes[key]) < 0.0:
            yield f"{key} is a decimal that is not negative"


def _references(root: Node) -> Iterator[str]:
    """Every reference leads to an element of its kind; nominals, items and measurements to their like."""
    kinds = {n.attributes["id"]: n.name for n in root.below() if "id" in n.attributes}
    targets = {"FeatureDefinitionId": "FeatureDefinition", "FeatureNominalId": "FeatureNominal", "DatumDefinitionId": "DatumDefinition",
               "CharacteristicDefinitionId": "CharacteristicDefinition", "CharacteristicNominalId": "CharacteristicNominal",
               "CharacteristicItemId": "CharacteristicItem", "DatumReferenceFrameId": "DatumReferenceFrame"}  # fmt: skip
    lists = {
        "FeatureNominalIds": "FeatureNominal",
        "FeatureItemIds": "FeatureItem",
        "ActualComponentIds": "ActualComponent",
    }
    for node in root.below():
        kind = node.name.removesuffix(_group(node.name).lstrip("*"))
        for child in node.children:
            wanted = targets.get(child.name) or (lists.get(node.name) if child.name == "Id" else None)
            found = kinds.get(child.text.strip(), "nothing")
            alike = (
                kind
                if child.name.endswith(("DefinitionId", "NominalId", "ItemId")) and node.name != "SimpleDatum"
                else ""
            )
            if wanted and not (found.endswith(wanted) and (not alike or found == f"{alike}{wanted}")):
                yield f"{child.at}: <{child.name}> of <{node.name}> leads to {found}"
        shape = node.one("ZoneShape") if node.name.endswith("CharacteristicDefinition") else None
        if shape and shape.children[0].name not in ZONES.get(kind, "").split():
            yield f"{node.at}: <{node.name}> has no {shape.children[0].name}"
