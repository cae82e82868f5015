"""Characteristics of a drawing: the toleranced features, their datums, and the words of the requirement."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from vcmm.core.errors import DataError, choose_from


@dataclass(frozen=True)
class Roles:
    """Numbers of features of a type of characteristic, (least, most), in `of`, `between` and `datums`."""

    of: tuple[int, int] = (1, 1)
    between: tuple[int, int] = (0, 0)
    datums: tuple[int, int] = (0, 0)


_PAIR, _FORM, _ONE_DATUM = Roles(of=(0, 0), between=(2, 2)), Roles(), Roles(datums=(1, 1))
TYPES: Mapping[str, Roles] = MappingProxyType(
    {
        "size": Roles(), "distance": _PAIR, "angle": _PAIR,
        "straightness": _FORM, "flatness": _FORM, "roundness": _FORM, "cylindricity": _FORM,
        "line_profile": Roles(datums=(0, 3)), "surface_profile": Roles(datums=(0, 3)),
        "parallelism": _ONE_DATUM, "perpendicularity": _ONE_DATUM, "angularity": _ONE_DATUM,
        "position": Roles(of=(1, 99), datums=(0, 3)), "coaxiality": _ONE_DATUM,
        "symmetry": Roles(of=(1, 2), datums=(1, 2)),
        "circular_runout": Roles(datums=(1, 2)), "total_runout": Roles(datums=(1, 2)),
    }
)  # fmt: skip


@dataclass(frozen=True)
class Filter:
    """Filter of a profile (ISO 16610). kind: "gaussian" or "spline"; upr: cut-off of a closed profile, undulations per revolution;
    cutoff: of an open one, mm.
    """

    kind: str
    upr: float | None = None
    cutoff: float | None = None


@dataclass(frozen=True)
class Characteristic:
    """One requirement. `limits` (lower, upper) count from nominal; `zone` is the width of a tolerance zone.

    `datums` may hold tuples of names: one common datum of several features (ISO 5459, A-B). `projected`: position of the axis
    over this length beyond the end of the feature (negative: beyond its beginning). `zones` of a position of several features: CZ,
    one pattern, or SZ, each by itself. `material`: "M" or "L", maximum or least material requirement (ISO 2692), with `size_limits`,
    the absolute limits of the size in mm. `filter`: what a roundness or straightness keeps of its profile.

    mm, or rad for an angle. `criterion` and `datum_criterion`: the association of features and datums, words of
    vcmm.part.gps.criteria (GG, G = least squares).
    """

    name: str
    type: str
    of: tuple[str, ...] = ()  # a single name may be given as it is
    between: tuple[str, ...] = ()
    datums: tuple[str, ...] = ()
    criterion: str = "GG"
    limits: tuple[float, float] | None = None
    zone: float | None = None
    datum_criterion: str = "G"
    common: tuple[tuple[str, tuple[str, ...]], ...] = ()  # common datums: (name, features)
    projected: float | None = None
    zones: str = "CZ"
    material: str = ""
    size_limits: tuple[float, float] | None = None
    filter: Filter | None = None

    def __post_init__(self) -> None:
        common = dict(self.common)
        for role in ("of", "between", "datums"):
            names = getattr(self, role)
            names = (names,) if isinstance(names, str) else tuple(names)
            for name in names:
                if not isinstance(name, str):
                    common["-".join(name)] = tuple(name)
            object.__setattr__(self, role, tuple(n if isinstance(n, str) else "-".join(n) for n in names))
        object.__setattr__(self, "common", tuple(common.items()))
        problems = list(_characteristic_problems(self))
        if problems:
            raise DataError(f'Characteristic "{self.name}": {problem}' for problem in problems)

    @property
    def features(self) -> tuple[str, ...]:
        """Names of all features that must be measured, those of common datums among them, without repetition."""
        datums = (m for d in self.datums for m in members(self, d))
        return tuple(dict.fromkeys((*self.of, *self.between, *datums)))


def _characteristic_problems(c: Characteristic) -> Iterable[str]:
    if c.type not in TYPES:
        yield f'unknown type "{c.type}".{choose_from(c.type, TYPES)}'
        return
    roles = TYPES[c.type]
    for role, (least, most) in (("of", roles.of), ("between", roles.between), ("datums", roles.datums)):
        given = len(getattr(c, role))
        if not least <= given <= most:
            wanted = f"{least}" if least == most else f"{least} to {most}"
            yield f'{c.type} takes {wanted} feature(s) in "{role}", not {given}.'
    names = (*c.of, *c.between, *c.datums)
    twice = next((n for i, n in enumerate(names) if n in names[:i]), None)
    if twice is not None:
        yield f'it compares "{twice}" with itself, which is always perfect; name another feature in one place.'
    if c.limits is not None and not c.limits[0] < c.limits[1]:
        yield f"the lower limit {c.limits[0]:g} is not below the upper limit {c.limits[1]:g}; exchange them."
    if c.limits is not None and c.limits[0] != 0.0 and c.type not in ("size", "distance", "angle"):
        yield (
            f'a {c.type} has no lower limit but zero; write zone = "{c.limits[1]:g} mm" in place of limits.'
        )
    if c.zone is not None and not (math.isfinite(c.zone) and c.zone > 0.0):
        yield f"zone must be positive and finite, not {c.zone:g}."
    yield from _drawing_problems(c)
    if c.zone is not None and (c.limits is not None or c.type in ("size", "distance", "angle")):
        yield "give zone for form, orientation and location, limits for size, distance and angle; never both."


OF_SIZE = ("circle", "cylinder", "sphere")  # kinds of features that a material requirement may be of
SIZE_TYPES = (
    "position",
    "coaxiality",
    "symmetry",
    "straightness",
    "parallelism",
    "perpendicularity",
    "angularity",
)


def _drawing_problems(c: Characteristic) -> Iterable[str]:
    """Yield what is wrong with the further words of a drawing."""
    if c.zones not in ("CZ", "SZ"):
        yield f'zones = "{c.zones}" is CZ (combined, one pattern) or SZ (separate).'
    if c.projected is not None and (c.type != "position" or c.projected == 0.0):
        yield "projected is a length other than 0, of a position."
    if c.material not in ("", "M", "L"):
        yield f'material = "{c.material}": write "M" (maximum) or "L" (least material requirement).'
    elif c.material and c.type not in SIZE_TYPES:
        yield f"a material requirement goes with {', '.join(SIZE_TYPES)}, not with {c.type}; leave it out."
    elif c.material and c.size_limits is None:
        yield "a material requirement needs the limits of the size of the feature; add its size characteristic with limits."
    named = [n for n in c.datums if n in c.of]
    if named:
        yield f'"{named[0]}" is toleranced to itself; name another datum.'
    if len(set(c.between)) < len(c.between):
        yield f'it is between "{c.between[0]}" and itself; name two features.'
    if len(set(c.of)) < len(c.of) or len(set(c.datums)) < len(c.datums):
        yield "a feature is named twice; name each once."


def members(c: Characteristic, datum: str) -> tuple[str, ...]:
    """Return the features of a datum: itself, or those of a common datum."""
    return dict(c.common).get(datum, (datum,))
