"""Tolerances of AP242 (semantic PMI, ISO 10303-47 and -242) as characteristics of part/1; the rest becomes notes with their lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from vcmm.files.foreign.drawing import DrawnPart, NotHere, deg, mm
from vcmm.files.foreign.part21 import Entity, Part21, Ref

ZONES = {
    "FLATNESS_TOLERANCE": "flatness", "STRAIGHTNESS_TOLERANCE": "straightness", "ROUNDNESS_TOLERANCE": "roundness",
    "CYLINDRICITY_TOLERANCE": "cylindricity", "PARALLELISM_TOLERANCE": "parallelism",
    "PERPENDICULARITY_TOLERANCE": "perpendicularity", "ANGULARITY_TOLERANCE": "angularity", "POSITION_TOLERANCE": "position",
    "COAXIALITY_TOLERANCE": "coaxiality", "CONCENTRICITY_TOLERANCE": "coaxiality", "SYMMETRY_TOLERANCE": "symmetry",
    "CIRCULAR_RUNOUT_TOLERANCE": "circular_runout", "TOTAL_RUNOUT_TOLERANCE": "total_runout",
    "LINE_PROFILE_TOLERANCE": "line_profile", "SURFACE_PROFILE_TOLERANCE": "surface_profile",
}  # fmt: skip
DIMENSIONS = ("DIMENSIONAL_SIZE", "DIMENSIONAL_SIZE_WITH_DATUM_FEATURE", "DIMENSIONAL_LOCATION", "DIRECTED_DIMENSIONAL_LOCATION", "ANGULAR_LOCATION", "ANGULAR_SIZE")  # fmt: skip
SIZES = {
    "diameter": 1.0,
    "spherical diameter": 1.0,
    "radius": 2.0,
    "spherical radius": 2.0,
}  # diameters per value
MATERIAL = {"MAXIMUM_MATERIAL_REQUIREMENT": "M", "LEAST_MATERIAL_REQUIREMENT": "L"}
UNEQUAL = "UNEQUALLY_DISPOSED_GEOMETRIC_TOLERANCE"


def add_tolerances(text: Part21, drawn: DrawnPart, names: Mapping[int, str]) -> None:
    """Add every dimension with limits and every geometrical tolerance to `drawn`. names: of the features by number of the face."""
    aspects = _Aspects(text, names)
    bare = 0
    for one in [*text.of(*DIMENSIONS), *text.of("GEOMETRIC_TOLERANCE", *ZONES)]:
        try:
            made = _dimension(aspects, drawn, one) if _is_dimension(one) else _zones(aspects, one)
        except NotHere as why:
            drawn.notes.append(f"{one.at}: {_label(one)}: {why}; left out")
            continue
        bare += not made
        for table in made:
            drawn.characteristics.append({"name": drawn.free_name(_label(one)), **table})
    if bare:
        drawn.notes.append(
            f"{text.path}: {bare} dimensions without limits (theoretically exact, or for information) are left out"
        )


def _is_dimension(one: Entity) -> bool:
    return any(n in one.parts for n in DIMENSIONS)


def _label(one: Entity) -> str:
    """Return the name in the file, or the kind of entity with its number."""
    kind = next(iter(one.parts))
    if given := one.values("GEOMETRIC_TOLERANCE", *ZONES):
        plain = kind.lower().replace("_", " ").removesuffix(" tolerance")
        return str(given[0] or f"{plain} #{one.number}").strip()
    words = next((v for v in one.parts[kind] if isinstance(v, str) and v), "dimension")
    return f"{words} #{one.number}"


@dataclass(frozen=True, eq=False)
class _Aspects:
    """The features that an aspect of the shape represents."""

    text: Part21
    names: Mapping[int, str]

    @cached_property
    def items(self) -> dict[int, list[int]]:
        """Numbers of the faces by number of the aspect, as directly related."""
        out: dict[int, list[int]] = {}
        for use in self.text.of("GEOMETRIC_ITEM_SPECIFIC_USAGE", "ITEM_IDENTIFIED_REPRESENTATION_USAGE"):
            values = use.values("GEOMETRIC_ITEM_SPECIFIC_USAGE", "ITEM_IDENTIFIED_REPRESENTATION_USAGE")
            if len(values) > 4 and isinstance(values[2], Ref):
                out.setdefault(values[2], []).extend(_references(values[4]))
        return out

    @cached_property
    def related(self) -> dict[int, list[int]]:
        """Aspects by the aspect that they are related to (parts of a composite one; the datum of a datum feature)."""
        out: dict[int, list[int]] = {}
        for one in self.text.of("SHAPE_ASPECT_RELATIONSHIP"):
            whole, part = one.values("SHAPE_ASPECT_RELATIONSHIP")[2:4]
            out.setdefault(whole, []).append(part)
        return out

    def features(self, aspect: int) -> list[str]:
        """Return the features of an aspect, each once. NotHere: none, or faces that are no features."""
        found: dict[str, None] = {}
        for face in self._faces(aspect, set()):
            if face not in self.names:
                raise NotHere(f"it is about #{face}, which is no feature here")
            found[self.names[face]] = None
        if not found:
            raise NotHere("no face is tied to it")
        return list(found)

    def _faces(self, aspect: int, seen: set[int]) -> Iterator[int]:
        seen.add(aspect)
        yield from self.items.get(aspect, [])
        for part in self.related.get(aspect, []):
            if part not in seen:
                yield from self._faces(part, seen)

    def of_datum(self, datum: int) -> str:
        """Return the feature of a datum, from the datum features that are related to it."""
        letter = str(self.text[datum].values("DATUM")[-1])
        bearers = [whole for whole, parts in self.related.items() if datum in parts]
        found = {name for b in [*bearers, datum] for name in self._known_names(b)}
        if len(found) != 1:
            raise NotHere(f"the datum {letter} has {len(found) or 'no'} features here")
        return found.pop()

    def _known_names(self, aspect: int) -> list[str]:
        return list(dict.fromkeys(self.names[f] for f in self._faces(aspect, set()) if f in self.names))


def _references(value: Any) -> list[int]:
    if isinstance(value, Ref):
        return [int(value)]
    return [n for v in value for n in _references(v)] if isinstance(value, list) else []


def _dimension(aspects: _Aspects, drawn: DrawnPart, one: Entity) -> list[dict[str, Any]]:
    """Return the characteristic of a dimension with limits; none of a dimension without."""
    limits = _limits(aspects.text, one.number)
    if limits is None:
        return []
    kind = next(n for n in DIMENSIONS if n in one.parts)
    values = one.parts[kind]
    if "LOCATION" in kind:
        features = [f for a in values[2:4] for f in aspects.features(a)]
        if len(features) != 2:
            raise NotHere(f"between {len(features)} features, expected two")
        angle = kind.startswith("ANGULAR")
        if limits.code or limits.nominal is None:
            raise NotHere("limits without a nominal value")
        table = {"type": "angle" if angle else "distance", "between": drawn.reference_first(features)}
        return [table | {"limits": [deg(v) if angle else mm(_clean(v)) for v in limits.ends]}]
    factor = SIZES.get(str(values[-1] if kind == "ANGULAR_SIZE" else values[1]).lower())
    if factor is None:
        raise NotHere(f'a size of the kind "{values[1]}"')
    return [_size(drawn, name, limits, factor) for name in aspects.features(values[0])]


def _size(drawn: DrawnPart, name: str, limits: _Limits, factor: float) -> dict[str, Any]:
    """Return limits from the diameter as drawn: where the dimension states another nominal, they are shifted."""
    written = drawn.features[name].get("diameter")
    if written is None or drawn.features[name]["type"] not in ("cylinder", "sphere", "circle"):
        raise NotHere(f"{name} has no diameter")
    if limits.code:
        return {"type": "size", "of": name, "limits": limits.code}
    diameter = float(written.split()[0])
    shift = 0.0 if limits.nominal is None else factor * limits.nominal - diameter
    if limits.absolute:
        shift = -diameter
    return {"type": "size", "of": name, "limits": [mm(_clean(factor * v + shift)) for v in limits.ends]}


@dataclass(frozen=True)
class _Limits:
    """Two ends from the nominal value (or `absolute`), in mm or rad; or a code of ISO 286."""

    ends: tuple[float, float]
    nominal: float | None
    absolute: bool = False
    code: str = ""


def _limits(text: Part21, dimension: int) -> _Limits | None:
    stated: dict[str, int] = {}
    for link in text.of("DIMENSIONAL_CHARACTERISTIC_REPRESENTATION"):
        owner, representation = link.values("DIMENSIONAL_CHARACTERISTIC_REPRESENTATION")[:2]
        if owner == dimension:
            items = _references(
                text[representation].values("SHAPE_DIMENSION_REPRESENTATION", "REPRESENTATION")[1:2]
            )
            stated |= {_item_name(text[i]): i for i in items}
    nominal = text.measure(stated["nominal value"]) if "nominal value" in stated else None
    if "upper limit" in stated and "lower limit" in stated:
        low, high = (text.measure(stated[f"{w} limit"]) for w in ("lower", "upper"))
        return _Limits(
            (low, high) if nominal is None else (low - nominal, high - nominal),
            nominal,
            absolute=nominal is None,
        )
    for link in text.of("PLUS_MINUS_TOLERANCE"):
        spread, owner = link.values("PLUS_MINUS_TOLERANCE")[:2]
        if owner == dimension:
            return _plus_minus(text, text[spread], nominal)
    return None


def _plus_minus(text: Part21, spread: Entity, nominal: float | None) -> _Limits:
    if fit := spread.values("LIMITS_AND_FITS"):
        return _Limits((0.0, 0.0), nominal, code=f"{fit[0]}{fit[2]}")
    ends = spread.values("TOLERANCE_VALUE")
    if len(ends) != 2:
        raise NotHere("its tolerance is neither two values nor a fit")
    low, high = (text.measure(e) for e in ends)
    if not low < high:
        raise NotHere(f"its limits {low:g} and {high:g} hold nothing between them")
    return _Limits((low, high), nominal)


def _item_name(item: Entity) -> str:
    """Return the name of an item of a representation: its first text."""
    for values in item.parts.values():
        for value in values:
            if isinstance(value, str) and value:
                return value.lower()
    return ""


def _zones(aspects: _Aspects, one: Entity) -> list[dict[str, Any]]:
    """Return a geometrical tolerance: one characteristic for all holes of a position, else one for every feature."""
    kind = next((n for n in ZONES if n in one.parts), None)
    if kind is None:
        raise NotHere("no such tolerance here")
    if UNEQUAL in one.parts:
        raise NotHere("a zone that is not disposed equally")
    values = one.values("GEOMETRIC_TOLERANCE") or one.parts[kind]
    if not isinstance(values[2], Ref) or not isinstance(values[3], Ref):
        raise NotHere("its width or its shape is missing")
    width = aspects.text.measure(values[2])
    more = {"zone": mm(_clean(width))} | _material(one) | _datums(aspects, one, values)
    features = aspects.features(_aspect(aspects.text, values[3]))
    if ZONES[kind] in ("position", "symmetry") and len(features) > 1:
        return [{"type": ZONES[kind], "of": features} | more]
    return [{"type": ZONES[kind], "of": name} | more for name in features]


def _aspect(text: Part21, number: int) -> int:
    """Return the aspect itself, or that of the dimension that bears the tolerance."""
    size = text[number].values("DIMENSIONAL_SIZE")
    return size[0] if size else number


def _material(one: Entity) -> dict[str, Any]:
    stated = one.values("GEOMETRIC_TOLERANCE_WITH_MODIFIERS", "MODIFIED_GEOMETRIC_TOLERANCE")[-1:]
    words = [w for v in stated for w in (v if isinstance(v, list) else [v])]
    unknown = [str(w) for w in words if w not in MATERIAL]
    if unknown:
        raise NotHere(f"the modifier {unknown[0].lower().replace('_', ' ')}")
    return {"material": MATERIAL[str(words[0])]} if words else {}


def _datums(aspects: _Aspects, one: Entity, values: list[Any]) -> dict[str, Any]:
    """Return the features of the datum system in its order. NotHere: common datums, modifiers on a datum, a datum without feature."""
    given = one.values("GEOMETRIC_TOLERANCE_WITH_DATUM_REFERENCE") or values[4:]
    out = []
    for system in _references(given):
        entity = aspects.text[system]
        for compartment in _references(entity.values("DATUM_SYSTEM")[-1:]) or [system]:
            out.append(_datum(aspects, aspects.text[compartment]))
    return {"datums": out} if out else {}


def _datum(aspects: _Aspects, compartment: Entity) -> str:
    if older := compartment.values("DATUM_REFERENCE"):
        return aspects.of_datum(older[1])
    base, modifiers = (compartment.values("DATUM_REFERENCE_COMPARTMENT")[4:6] + [None, None])[:2]
    if not isinstance(base, Ref):
        raise NotHere("a common datum")
    if modifiers:
        raise NotHere("a modifier on a datum")
    return aspects.of_datum(base)


def _clean(value: float) -> float:
    """Return the value without the noise of subtraction and of pi / 180: to 1e-9 mm."""
    return round(value, 9) + 0.0
