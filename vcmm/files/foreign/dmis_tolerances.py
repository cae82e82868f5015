"""Tolerances of DMIS as characteristics of part/1: TOL statements with the features of OUTPUT or EVAL."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vcmm.core.errors import DataError
from vcmm.core.text import is_usual, to_number
from vcmm.files.foreign.drawing import DrawnPart, deg, mm

ZONES = {
    "FLAT": "flatness", "STRGHT": "straightness", "CIRLTY": "roundness", "CYLCTY": "cylindricity",
    "PARLEL": "parallelism", "PERP": "perpendicularity", "ANGLR": "angularity", "POS": "position",
    "CONCEN": "coaxiality", "COAX": "coaxiality", "SYM": "symmetry", "CRNOUT": "circular_runout",
    "TRNOUT": "total_runout",
}  # fmt: skip
PROFILES = {"PROFS": "surface_profile", "PROFL": "line_profile"}
SIZES = {"DIAM": 1.0, "RAD": 2.0}
BETWEEN = {"DISTB": "distance", "ANGLB": "angle"}
TOLERANCES = (*ZONES, *PROFILES, *SIZES, *BETWEEN)
MATERIAL = {"MMC": "M", "LMC": "L"}


@dataclass(frozen=True)
class ToleranceStatement:
    """A statement T(name)=TOL/kind,words at a line; factors of its units to mm and rad."""

    at: str
    name: str
    kind: str
    words: tuple[str, ...]
    mm: float
    rad: float


def tables_of(
    drawn: DrawnPart, t: ToleranceStatement, features: list[str], context: tuple[str, Mapping[str, str]]
) -> None:
    """Add to `drawn` the characteristic of a tolerance for features; a note where part/1 cannot express it.

    context: the line of the OUTPUT, and the feature of every datum letter.
    """
    at, datums = context
    if t.kind not in TOLERANCES:
        drawn.notes.append(f"{at}: T({t.name}) of {', '.join(features)}: left out")
        return
    lost = [f for f in features if f not in drawn.features]
    if lost or not features:
        drawn.notes.append(
            f"{at}: T({t.name}): the feature {', '.join(lost) or '(none)'} is not here; left out"
        )
        return
    table = _table(drawn, t, features, datums)
    if isinstance(table, str):
        drawn.notes.append(f"{t.at}: T({t.name}): {table}; left out")
        return
    drawn.characteristics.append({"name": drawn.free_name(f"{t.name} {' '.join(features)}"), **table})


def _table(
    drawn: DrawnPart, t: ToleranceStatement, features: list[str], datums: Mapping[str, str]
) -> dict[str, Any] | str:
    """Return the table, or why there is none."""
    if t.kind in BETWEEN:
        if len(features) != 2:
            return f"TOL/{t.kind} needs two features in its OUTPUT"
        if any(w.upper() in ("XAXIS", "YAXIS", "ZAXIS", "XYPLAN", "YZPLAN", "ZXPLAN") for w in t.words):
            return "along an axis or in a plane only"
        if "NOMINL" in (w.upper() for w in t.words):
            low, high = _numbers(t, 3)[1:3]
        else:
            low, high = _numbers(t, 2)[:2]
        return {
            "type": BETWEEN[t.kind],
            "between": drawn.reference_first(features),
            "limits": _limits(t, low, high),
        }
    if len(features) != 1:
        return f"of {len(features)} features"
    if t.kind in SIZES:
        if "diameter" not in drawn.features[features[0]]:
            return f"{features[0]} has no diameter"
        low, high = _numbers(t, 2)[:2]
        return {
            "type": "size",
            "of": features[0],
            "limits": _limits(t, SIZES[t.kind] * low, SIZES[t.kind] * high),
        }
    return _zone(t, features[0], datums)


def _zone(t: ToleranceStatement, feature: str, datums: Mapping[str, str]) -> dict[str, Any] | str:
    if t.kind in PROFILES:
        low, high = _numbers(t, 2)[:2]
        if abs(low + high) > 1e-9 * max(abs(low), abs(high)):
            return f"a zone from {low:g} to {high:g} that is not disposed equally"
        width, kind = high - low, PROFILES[t.kind]
    else:
        numbers = _numbers(t, 2 if t.kind == "ANGLR" else 1)
        width, kind = numbers[1 if t.kind == "ANGLR" else 0], ZONES[t.kind]
    if width <= 0.0:
        raise DataError(f"{t.at}: T({t.name}): a zone of {width:g}")
    out: dict[str, Any] = {"type": kind, "of": feature, "zone": mm(t.mm * width)}
    words = [w.upper() for w in t.words]
    letters = [m[1].strip() for w in t.words if (m := re.fullmatch(r"DAT\(([^)]*)\)", w, re.IGNORECASE))]
    unknown = [x for x in letters if x not in datums]
    if unknown:
        return f"the datum {unknown[0]} is not defined (DATDEF)"
    first = next((i for i, w in enumerate(words) if w.startswith("DAT(")), len(words))
    if any(w in MATERIAL for w in words[first:]):
        return "a material requirement on a datum"
    material = next((MATERIAL[w] for w in words[:first] if w in MATERIAL), "")
    return out | ({"material": material} if material else {}) | ({"datums": [datums[x] for x in letters]} if letters else {})  # fmt: skip


def _numbers(t: ToleranceStatement, least: int) -> list[float]:
    out = []
    for word in t.words:
        try:
            out.append(to_number(word))
        except ValueError:
            continue
    if len(out) < least or not all(is_usual(v) for v in out):
        raise DataError(f"{t.at}: T({t.name})=TOL/{t.kind} holds {len(out)} numbers; expected {least}")
    return out


def _limits(t: ToleranceStatement, low: float, high: float) -> list[str]:
    if not low < high:
        raise DataError(f"{t.at}: T({t.name}): the lower limit {low:g} is not below the upper one {high:g}")
    return [deg(t.rad * low), deg(t.rad * high)] if t.kind == "ANGLB" else [mm(t.mm * low), mm(t.mm * high)]
