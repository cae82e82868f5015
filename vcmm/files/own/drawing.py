"""Limits as drawings state them: ISO 286 codes, general tolerances of ISO 2768 and ISO 22081, material requirements."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vcmm.core.errors import UsageError
from vcmm.core.units import quantity, shorten
from vcmm.files.problems import Problems
from vcmm.files.toml import Location
from vcmm.part.characteristic import OF_SIZE, SIZE_TYPES, Filter
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.contradictions import contradictions
from vcmm.part.gps.general import classes, general_limits, general_zone
from vcmm.part.gps.iso286 import is_code, limits_of_code
from vcmm.part.part import Characteristic, Feature, kind_text

Pair = tuple[float, float]


@dataclass(frozen=True)
class GeneralTolerances:
    """General tolerances: a standard by name, or the numbers of an ISO 22081 note (mm, rad)."""

    standard: str = ""
    size: float | None = None
    angle: float | None = None
    profile: float | None = None


def general_from(table: Any) -> GeneralTolerances:
    """Return the general tolerances. UsageError for a standard that is not known."""
    if table is None:
        return GeneralTolerances()
    if isinstance(table, str):
        classes(table)
        return GeneralTolerances(table)
    if table.standard != "ISO 22081":
        raise UsageError(
            f'standard = "{table.standard}": a table of numbers is for ISO 22081; write "ISO 2768-mK" as a text'
        )
    return GeneralTolerances("", table.size, table.angle, table.profile)


def stated_limits(t: Any, features: Mapping[str, Feature]) -> Pair | None:
    """Return limits from nominal in mm or rad: two numbers with units, an ISO 286 code, or the name of a general tolerance."""
    if t.limits is None:
        return None
    if isinstance(t.limits, str):
        return _by_name(t, features)
    dimension, example = ("angle", "0.1 deg") if t.type == "angle" else ("length", "0.021 mm")
    low, high = (quantity(v, dimension, "limits", example) for v in t.limits)
    if not low < high:
        raise UsageError(
            f"limits = {shorten(t.limits)}: the lower limit is not below the upper one; exchange them"
        )
    if low != 0.0 and t.type not in ("size", "distance", "angle"):
        raise UsageError(
            f'limits = {shorten(t.limits)}: a {t.type} has no lower limit but zero; write zone = "{t.limits[1]}"'
        )
    return low, high


def _by_name(t: Any, features: Mapping[str, Feature]) -> Pair:
    text = str(t.limits)
    if text.startswith("ISO"):
        limits = general_limits(text, t.type, _nominal(t, features))
        if limits is None:
            raise UsageError(f'limits = "{text}" has no class for sizes; write for example "ISO 2768-m"')
        return limits
    if not is_code(text):
        raise UsageError(
            f'limits = "{text}" is neither a tolerance code such as "H7" nor two limits such as ["0 mm", "0.021 mm"]'
        )
    of = features.get(_first(t.of))
    if t.type != "size" or of is None:
        raise UsageError(f'limits = "{text}": a tolerance code is of a size')
    return limits_of_code(text, _nominal(t, features), of.inside)


def _first(of: str | Sequence[str]) -> str:
    return of if isinstance(of, str) else next(iter(of), "")


def _nominal(t: Any, features: Mapping[str, Feature]) -> float:
    """Return the nominal value in mm; of an angle the shorter side of its features."""
    of = (t.of,) if isinstance(t.of, str) else tuple(t.of)
    if t.type == "angle":
        return min(max(features[n].extent or (1e9,)) for n in t.between if n in features)
    return gps.nominal(Characteristic(t.name, t.type, of, tuple(t.between)), features)


def _read(t: Any, features: Mapping[str, Feature]) -> bool:
    """Return whether all features of a characteristic were read; one that was not has a complaint of its own."""
    of = (t.of,) if isinstance(t.of, str) else tuple(t.of)
    return all(n in features for n in (*of, *t.between))


def general_of(
    t: Any, features: Mapping[str, Feature], general: GeneralTolerances
) -> tuple[Pair | None, float | None]:
    """Return (limits, zone) of a characteristic that states neither; (None, None) where nothing general holds."""
    if not _read(t, features):
        return None, None
    if t.type in ("size", "distance", "angle"):
        half_width = general.angle if t.type == "angle" else general.size
        if half_width is not None:
            return (-half_width, half_width), None
        return (
            general_limits(general.standard, t.type, _nominal(t, features)) if general.standard else None
        ), None
    if t.type in ("surface_profile", "line_profile"):
        return None, general.profile
    return None, _zone(t, features, general.standard) if general.standard else None


def _zone(t: Any, features: Mapping[str, Feature], standard: str) -> float | None:
    feature = features[_first(t.of)]
    longest = max(feature.extent) if feature.extent else 2.0 * float(max(feature.sizes, default=0.5))
    if t.type == "perpendicularity":
        datums = [features[d] for d in t.datums if isinstance(d, str) and d in features]
        longest = min([longest, *(max(d.extent) for d in datums if d.extent)])
    zone = general_zone(standard, t.type, longest)
    size = _diameter_tolerance(feature, standard)
    if zone is None or size is None:
        return zone
    if t.type == "roundness":
        return min(zone, size)
    return max(zone, size) if t.type == "parallelism" else zone


def _diameter_tolerance(feature: Feature, standard: str) -> float | None:
    if feature.kind not in ("circle", "cylinder", "sphere"):
        return None
    limits = general_limits(standard, "size", 2.0 * float(feature.sizes[0]))
    return None if limits is None else limits[1] - limits[0]


def size_limits(
    t: Any, tables: Sequence[Any], features: Mapping[str, Feature], limits: Callable[[Any], Pair | None]
) -> Pair | None:
    """Return absolute limits in mm of the size of a feature with a material requirement, from its size characteristic. UsageError: of a
    feature that has no size.
    """
    if not t.material:
        return None
    name = _first(t.of)
    if name in features and t.type in SIZE_TYPES and features[name].kind not in OF_SIZE:
        raise UsageError(
            f'a material requirement is of a feature of size ({", ".join(OF_SIZE)}), and "{name}" is {kind_text(features[name].kind)}; leave it out'
        )
    for other in tables if name in features else ():
        if other.type == "size" and _first(other.of) == name and (stated_limits := limits(other)) is not None:
            nominal = _nominal(other, features)
            return nominal + stated_limits[0], nominal + stated_limits[1]
    return None


def reciprocal(t: Any, tables: Sequence[Any], features: Mapping[str, Feature], limits: Pair) -> Pair:
    """Return limits of a size that may use the unused share of a geometrical tolerance with reciprocity (ISO 2692): at its material limit."""
    for other in tables if _first(t.of) in features else ():
        if other.reciprocity and _first(other.of) == _first(t.of) and other.zone is not None:
            zone = quantity(other.zone, "length", "zone", "0.01 mm")
            lower = features[_first(t.of)].inside == (other.material == "M")
            return (limits[0] - zone, limits[1]) if lower else (limits[0], limits[1] + zone)
    return limits


def note_contradictions(
    characteristics: Sequence[Characteristic],
    features: Mapping[str, Feature],
    problems: Problems,
    at: Location,
) -> None:
    """Note requirements that no part keeps together, each at its place in the file."""
    if problems.found:
        return
    for i, text in contradictions(characteristics, features):
        problems.add((*at, "characteristics", i), text)


def stated_filter(t: Any) -> Filter | None:
    """Return the filter of a form, with its cut-off in mm or undulations per revolution."""
    if not t.filter and (t.upr is not None or t.cutoff):
        raise UsageError('upr and cutoff are of a filter; add filter = "gaussian" or "spline"')
    cutoff = quantity(t.cutoff, "length", "cutoff", "0.8 mm") if t.cutoff else None
    return Filter(t.filter, t.upr, cutoff) if t.filter else None


def compared_with_itself(t: Any) -> list[tuple[str, str]]:
    """Return (role, complaint) of a feature that is named twice."""
    datums = [m for d in t.datums for m in ([d] if isinstance(d, str) else d)]
    given = {"of": [t.of] if isinstance(t.of, str) else t.of, "between": t.between, "datums": datums}
    problems: list[tuple[str, str]] = []
    letters: set[str] = set()
    for role, names in given.items():
        for name in names:
            if name in letters:
                problems.append(
                    (role, f'it compares "{name}" with itself; name another feature in one place')
                )
            letters.add(name)
    return problems
