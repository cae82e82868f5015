"""What QIF 3.0 says of a characteristic before it is measured: tolerance, material condition, shape of the zone; its numbers.

A zone of orientation, position, coaxiality or straightness must name its shape; orientation and position also a material condition.
Numbers of lengths and angles are xs:decimal, which has no exponent. Read in the schema of QIF 3.0 (Characteristics.xsd, Units.xsd).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import Decimal

from vcmm.core.pose import dot
from vcmm.files.foreign.exported_values import HandedValue
from vcmm.part.part import Characteristic, Feature

CONDITIONS = {"": "REGARDLESS", "M": "MAXIMUM", "L": "LEAST"}
ORIENTATIONS = ("parallelism", "perpendicularity", "angularity")
PARALLEL = 1e-9  # of a cosine from 1: directions that the drawing calls parallel


def decimal(value: float, digits: int = 15) -> str:
    """A number as xs:decimal has it: significant digits, never an exponent.

    >>> decimal(0.000085), decimal(-1e-7), decimal(25.4), decimal(0.0)
    ('0.000085', '-0.0000001', '25.4', '0')
    """
    return f"{Decimal(f'{value:.{digits}g}'):f}"


def size_definition(v: HandedValue) -> str:
    """Content of the definition of a size, distance or angle: limits from the nominal value, or that it has none."""
    if v.tolerance is None:
        return "<NonTolerance>MEASURED</NonTolerance>"
    low, high = (decimal(end - v.nominal, 12) for end in v.tolerance)
    return f"<Tolerance><MaxValue>{high}</MaxValue><MinValue>{low}</MinValue><DefinedAsLimit>false</DefinedAsLimit></Tolerance>"


def zone_definition(
    c: Characteristic, v: HandedValue, features: Mapping[str, Feature], frame: int | None
) -> str:
    """Content of the definition of a form, orientation, location, run-out or profile; without tolerance its width is 0."""
    width = v.tolerance[1] if v.tolerance is not None else 0.0
    parts = [f"<ToleranceValue>{decimal(width)}</ToleranceValue>"]
    if frame is not None:
        parts.append(f"<DatumReferenceFrameId>{frame}</DatumReferenceFrameId>")
    if c.type in (*ORIENTATIONS, "position"):
        parts.append(f"<MaterialCondition>{CONDITIONS[c.material]}</MaterialCondition>")
    shape = _shape(c, [features[n] for n in c.of], [features[d] for d in c.datums if d in features])
    return "".join(parts) + (f"<ZoneShape><{shape}/></ZoneShape>" if shape else "")


def _shape(c: Characteristic, of: Sequence[Feature], datums: Sequence[Feature]) -> str:
    """The word for the zone that vcmm evaluates (vcmm.part.gps.orientation, vcmm.part.gps.location); "" where none is due."""
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
