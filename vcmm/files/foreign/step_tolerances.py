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
    for entity in [*text.of(*DIMENSIONS), *text.of("GEOMETRIC_TOLERANCE", *ZONES)]:
        try:
            made = _dimension(aspects, drawn, entity) if _is_dimension(entity) else _zones(aspects, entity)
        except NotHere as why:
            drawn.notes.append(f"{entity.at}: {_label(entity)}: {why}; left out")
            continue
        bare += not made
        for table in made:
            drawn.characteristics.append({"name": drawn.free_name(_label(entity)), **table})
    if bare:
        drawn.notes.append(
            f"{text.path}: {bare} dimensions without limits (theoretically exact, or for information) are left out"
        )


def _is_dimension(entity: Entity) -> bool:
    return any(n in entity.parts for n in DIMENSIONS)


def _label(entity: Entity) -> str:
    """Return the name in the file, or the kind of entity with its number."""
    kind = next(iter(entity.parts))
    if given := entity.values("GEOMETRIC_TOLERANCE", *ZONES):
        plain = kind.lower().replace("_", " ").removesuffix(" tolerance")
        return str(given[0] or f"{plain} #{entity.number}").strip()
    words = next((v for v in entity.parts[kind] if isinstance(v, str) and v), "dimension")
    return f"{words} #{entity.number}"


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
    def relations(self) -> dict[int, list[int]]:
        """Aspects by the aspect that they are related to (parts of a composite one; the datum of a datum feature)."""
        out: dict[int, list[int]] = {}
        for relation in self.text.of("SHAPE_ASPECT_RELATIONSHIP"):
            whole, part = relation.values("SHAPE_ASPECT_RELATIONSHIP")[2:4]
            out.setdefault(whole, []).append(part)
        return out

    def features(self, aspect: int) -> list[str]:
        """Return the features of an aspect, each once. NotHere: none, or faces that are no features."""
        names: dict[str, None] = {}
        for face in self._faces(aspect, set()):
            if face not in self.names:
                raise NotHere(f"it is about #{face}, which is no feature here")
            names[self.names[face]] = None
        if not names:
            raise NotHere("no face is tied to it")
        return list(names)

    def _faces(self, aspect: int, visited: set[int]) -> Iterator[int]:
        visited.add(aspect)
        yield from self.items.get(aspect, [])
        for part in self.relations.get(aspect, []):
            if part not in visited:
                yield from self._faces(part, visited)

    def of_datum(self, datum: int) -> str:
        """Return the feature of a datum, from the datum features that are related to it."""
        letter = str(self.text[datum].values("DATUM")[-1])
        bearers = [whole for whole, parts in self.relations.items() if datum in parts]
        names = {name for b in [*bearers, datum] for name in self._known_names(b)}
        if len(names) != 1:
            raise NotHere(f"the datum {letter} has {len(names) or 'no'} features here")
        return names.pop()

    def _known_names(self, aspect: int) -> list[str]:
        return list(dict.fromkeys(self.names[f] for f in self._faces(aspect, set()) if f in self.names))


def _references(value: Any) -> list[int]:
    if isinstance(value, Ref):
        return [int(value)]
    return [n for v in value for n in _references(v)] if isinstance(value, list) else []


def _dimension(aspects: _Aspects, drawn: DrawnPart, dimension: Entity) -> list[dict[str, Any]]:
    """Return the characteristic of a dimension with limits; none of a dimension without."""
    limits = _limits(aspects.text, dimension.number)
    if limits is None:
        return []
    kind = next(n for n in DIMENSIONS if n in dimension.parts)
    values = dimension.parts[kind]
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


def _zones(aspects: _Aspects, tolerance: Entity) -> list[dict[str, Any]]:
    """Return a geometrical tolerance: one characteristic for all holes of a position, else one for every feature."""
    kind = next((n for n in ZONES if n in tolerance.parts), None)
    if kind is None:
        raise NotHere("no such tolerance here")
    if UNEQUAL in tolerance.parts:
        raise NotHere("a zone that is not disposed equally")
    values = tolerance.values("GEOMETRIC_TOLERANCE") or tolerance.parts[kind]
    if not isinstance(values[2], Ref) or not isinstance(values[3], Ref):
        raise NotHere("its width or its shape is missing")
    width = aspects.text.measure(values[2])
    more = {"zone": mm(_clean(width))} | _material(tolerance) | _datums(aspects, tolerance, values)
    features = aspects.features(_aspect(aspects.text, values[3]))
    if ZONES[kind] in ("position", "symmetry") and len(features) > 1:
        return [{"type": ZONES[kind], "of": features} | more]
    return [{"type": ZONES[kind], "of": name} | more for name in features]


def _aspect(text: Part21, number: int) -> int:
    """Return the aspect itself, or that of the dimension that bears the tolerance."""
    size = text[number].values("DIMENSIONAL_SIZE")
    return size[0] if size else number


def _material(tolerance: Entity) -> dict[str, Any]:
    stated = tolerance.values("GEOMETRIC_TOLERANCE_WITH_MODIFIERS", "MODIFIED_GEOMETRIC_TOLERANCE")[-1:]
    words = [w for v in stated for w in (v if isinstance(v, list) else [v])]
    unknown = [str(w) for w in words if w not in MATERIAL]
    if unknown:
        raise NotHere(f"the modifier {unknown[0].lower().replace('_', ' ')}")
    return {"material": MATERIAL[str(words[0])]} if words else {}


def _datums(aspects: _Aspects, tolerance: Entity, values: list[Any]) -> dict[str, Any]:
    """Return the features of the datum system in its order. NotHere: common datums, modifiers on a datum, a datum without feature."""
    given = tolerance.values("GEOMETRIC_TOLERANCE_WITH_DATUM_REFERENCE") or values[4:]
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
