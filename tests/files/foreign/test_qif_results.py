"""Results as QIF: every element that vcmm writes, against what the schema of QIF 3.0 asks (tests/files/foreign/qif_schema.py)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.files.foreign.qif_schema import faults
from vcmm.files.foreign.exported_values import HandedValue
from vcmm.files.foreign.qif_results import decimal, qif_text
from vcmm.files.foreign.xml import Node, read_xml
from vcmm.part.part import Characteristic, Feature, Part

UP, OUT, O3 = [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], np.zeros(3)
FEATURES = (
    Feature("touch", "point", [1, 2, 3], UP, ()),
    Feature("edge", "line", O3, OUT, (), extent=(40.0,)),
    Feature("top", "plane", O3, UP, (), extent=(60.0, 40.0)),
    Feature("side", "plane", O3, OUT, (), extent=(60.0, 40.0)),
    Feature("ring", "circle", O3, UP, (10.0,), inside=True),
    Feature("ball", "sphere", O3, O3, (12.5,)),
    Feature("bore", "cylinder", O3, UP, (0.00004, ), inside=True, extent=(20.0,)),
    Feature("shaft", "cylinder", O3, UP, (6.0,), extent=(20.0,)),
    Feature("taper", "cone", O3, UP, (3.0, 0.25), extent=(8.0,)),
)  # fmt: skip
CHARACTERISTICS = (
    Characteristic("D", "size", "bore", limits=(-1e-5, 2e-5)), Characteristic("untoleranced", "size", "ball"),
    Characteristic("L", "distance", between=("bore", "shaft"), limits=(-0.1, 0.1)), Characteristic("W", "angle", between=("top", "side")),
    Characteristic("flat", "flatness", "top", zone=0.01), Characteristic("straight", "straightness", "edge", zone=0.01),
    Characteristic("round", "roundness", "ring", zone=0.01), Characteristic("cyl", "cylindricity", "shaft"),
    Characteristic("par", "parallelism", "shaft", datums=("bore",), zone=0.02), Characteristic("perp", "perpendicularity", "shaft", datums=("top",), zone=0.02),
    Characteristic("perp plane", "perpendicularity", "side", datums=("top",), zone=0.02),
    Characteristic("along", "parallelism", "shaft", datums=("side",), zone=0.02),
    Characteristic("pos", "position", "shaft", datums=("top", "side"), zone=0.05, material="M", size_limits=(11.9, 12.1)),
    Characteristic("pos ball", "position", "ball", zone=0.05), Characteristic("pos plane", "position", "side", datums=("top",), zone=0.05),
    Characteristic("coax", "coaxiality", "shaft", datums=("bore",), zone=0.02), Characteristic("sym", "symmetry", "side", datums=("top",), zone=0.02),
    Characteristic("run", "circular_runout", "shaft", datums=("bore",), zone=0.02), Characteristic("total", "total_runout", "shaft", datums=("bore",), zone=0.02),
    Characteristic("line", "line_profile", "edge", zone=0.02), Characteristic("surface", "surface_profile", "top", datums=("side",), zone=0.02),
    Characteristic("common", "circular_runout", "ring", datums=(("bore", "shaft"),), zone=0.02),
    Characteristic("slope", "angularity", "taper", datums=("top",), zone=0.02),
)  # fmt: skip


def part() -> Part:
    return Part({f.name: f for f in FEATURES}, CHARACTERISTICS)


def handed(c: Characteristic, u: float | None = 3.1e-6, bias: float = -2.5e-5) -> HandedValue:
    low, high = (c.limits or (0.0, c.zone)) if c.limits or c.zone else (None, None)
    nominal = 25.0 if c.limits else 0.0
    tolerance = None if high is None or low is None else (nominal + low, nominal + high)
    decision = {"flat": "conforms", "round": "does not conform"}.get(c.name, "")
    one = {"U": None, "k": None, "p": 0.95, "interval": None, "tolerance": tolerance, "decision": decision}
    return HandedValue(
        c.name, c.type, "rad" if c.type == "angle" else "mm", nominal, nominal + 3e-7, bias, u, **one
    )  # type: ignore[arg-type]


def written(tmp_path: Path, *names: str) -> tuple[Node, tuple[str, ...]]:
    rows = [handed(c) for c in CHARACTERISTICS]
    text, notes = qif_text(part(), dict.fromkeys(names or ("",), rows), "seed")
    path = tmp_path / "results.qif"
    path.write_text(text, encoding="utf-8")
    return read_xml(path), notes


@pytest.mark.parametrize("names", [(), ("no 1", "no & 2")])
def test_nothing_that_the_schema_forbids(tmp_path: Path, names: tuple[str, ...]) -> None:
    root, _ = written(tmp_path, *names)
    assert faults(root) == []
    kinds = {n.name for n in root.below()}
    assert (
        len([k for k in kinds if k.endswith("CharacteristicMeasurement")]) == 17
    )  # 3 of size, 14 with a zone
    assert len([k for k in kinds if k.endswith("FeatureDefinition")]) == 7


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("INDETERMINATE", "UNKNOWN", 'the word "UNKNOWN" is not allowed'),
        ("<MaterialCondition>MAXIMUM</MaterialCondition>", "", "MaterialCondition is required"),
        ("<ZoneShape><SphericalZone/></ZoneShape>", "<ZoneShape><PlanarZone/></ZoneShape>", "has no PlanarZone"),
        ("<ReferencedComponent>ACTUAL</ReferencedComponent>", "", "ReferencedComponent is required"),
        ("<LargeEndDistance>8</LargeEndDistance>", "", "LargeEndDistance is required"),
        ('meanError="0.000025"', 'meanError="-0.000025"', "is a decimal that is not negative"),
        ('meanError="0.000025"', "", "stand together or not at all"),
        ("<Diameter>0.00008</Diameter>", "<Diameter>8e-05</Diameter>", "is no xs:decimal"),
        ('<FeatureItems n="9">', '<FeatureItems n="8">', "n is 8 of 9"),
        ("<FeatureDefinitionId>1</FeatureDefinitionId>", "<FeatureDefinitionId>4</FeatureDefinitionId>", "leads to LineFeatureDefinition"),
        ("<Header>", "<Header><Author/>", "Author is not allowed at its place"),
    ],
)  # fmt: skip
def test_the_rules_find_what_is_wrong(tmp_path: Path, old: str, new: str, says: str) -> None:
    """Each of these was, or would be, invalid: the rules are no formality."""
    text, _ = qif_text(part(), {"": [handed(c) for c in CHARACTERISTICS]}, "seed")
    assert old in text
    path = tmp_path / "results.qif"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    assert any(says in f for f in faults(read_xml(path)))


def test_the_bias_keeps_its_sign_beside_a_mean_error_that_has_none(tmp_path: Path) -> None:
    """u = 3.1 nm and a bias of -25 nm: meanError is its size, the attribute says the sign; both without exponent."""
    root, _ = written(tmp_path)
    one = next(n for n in root.below() if n.name == "DiameterCharacteristicMeasurement")
    value, bias = one.one("Value"), one.one("Attributes/AttributeD1")
    assert value is not None
    assert bias is not None
    assert value.attributes == {"combinedUncertainty": "0.0000031", "meanError": "0.000025"}
    assert (bias.attributes["name"], float(bias.attributes["value"])) == ("bias", -2.5e-5)


def test_shapes_of_the_zones(tmp_path: Path) -> None:
    """An axis square to a plane turns two ways, one along a plane only one; a sphere lies in a sphere."""
    root, _ = written(tmp_path)
    names = [n.words("Name") for n in root.many("Characteristics/CharacteristicItems")[0].children]
    definitions = root.many("Characteristics/CharacteristicDefinitions")[0].children
    shapes = {
        name: d.one("ZoneShape").children[0].name  # type: ignore[union-attr]
        for name, d in zip(names, definitions)
        if d.one("ZoneShape")
    }
    assert shapes == {
        "straight": "NonDiametricalZone", "par": "DiametricalZone", "perp": "DiametricalZone", "perp plane": "PlanarZone",
        "along": "PlanarZone", "pos": "DiametricalZone", "pos ball": "SphericalZone", "pos plane": "NonDiametricalZone",
        "coax": "DiametricalZone", "slope": "DiametricalZone",
    }  # fmt: skip


def test_what_qif_cannot_say_is_told(tmp_path: Path) -> None:
    _, notes = written(tmp_path)
    assert len(notes) == 2
    assert "cyl: it has no tolerance, and QIF demands a width" in notes[0]
    assert "common: a common datum has no word in QIF as written here" in notes[1]


def test_where_nothing_can_be_written_no_empty_list_stands(tmp_path: Path) -> None:
    row = replace(handed(CHARACTERISTICS[0]), name="of another part")
    text, notes = qif_text(part(), {"": [row]}, "seed")
    path = tmp_path / "results.qif"
    path.write_text(text, encoding="utf-8")
    assert faults(read_xml(path)) == []
    assert notes == (
        "of another part: its feature has no word in QIF as written here; left out of the QIF file",
    )


def test_decimals() -> None:
    assert [decimal(v) for v in (8.5e-05, -1e-7, 25.4, 0.0, 1e15)] == [
        "0.000085",
        "-0.0000001",
        "25.4",
        "0",
        "1000000000000000",
    ]
    assert decimal(1 / 3, 6) == "0.333333"
