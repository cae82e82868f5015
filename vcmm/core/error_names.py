"""Names of component errors in other literatures, translated to ISO 230-1.

    canonical("xty") -> "EYX"      canonical("δy(x)") -> "EYX"      canonical("roll of X") -> "EAX"

The same straightness of axis X in direction Y has many names, and the order of the letters is not always the same:

    ISO 230-1            E_YX      direction, axis
    delta / epsilon      δy(x)     direction, axis     translations δ, rotations ε about the direction
    VDI/VDE 2617-3       xty       axis, t, direction  xtx or xpx positioning, xry rotation about y, xwy squareness
    compact T / R        Txy       axis, direction     Rxy rotation of axis x about y, Wxy squareness

Only the name is translated. Signs and units stay those of the file that is read: mm and rad, right-hand rotations,
squareness as in vcmm.physics.structure.squareness.
"""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

from vcmm.core.axes import LETTERS as DIRECTIONS
from vcmm.core.axes import LINEAR, NAME, ROTARY
from vcmm.core.errors import UsageError, choose_from

SQUARE = {"C0Y": "XY", "B0Z": "XZ", "A0Z": "YZ"}  # the two axes, primary first

_ISO = re.compile(rf"E?_?\{{?(?P<direction>[{DIRECTIONS}])(?P<nought>[0O]?)(?P<axis>{NAME})\}}?")
_DELTA = re.compile(
    r"(?P<kind>δ|Δ|delta|d|ε|eps|epsilon)_?\{?(?P<direction>[xyz])\}?"
    r"(?:\((?P<argument>[xyzabc])\)|_?(?P<axis>[xyzabc]))\}?",
    re.IGNORECASE,
)
_VDI = re.compile(r"(?P<axis>[xyz])(?P<kind>[tprw])(?P<direction>[xyz])", re.IGNORECASE)
_COMPACT = re.compile(r"(?P<kind>[TRW])_?(?P<axis>[xyz])_?(?P<direction>[xyz])", re.IGNORECASE)


def canonical(name: str) -> str:
    """Return the ISO 230-1 name of a component, squareness or location error: "EYX", "C0Y", "X0C".

    Raises UsageError with the closest known name.
    """
    word = name.strip()
    name_of_iso = (
        _iso(word) or _delta(word) or _vdi(word) or _compact(word) or _by_words().get(word.lower(), "")
    )
    if not name_of_iso:
        raise UsageError(f'unknown error name "{name}".{choose_from(word, _examples(word))}')
    return name_of_iso


def is_known(name: str) -> bool:
    """Return whether `canonical` can translate a name."""
    try:
        canonical(name)
    except UsageError:
        return False
    return True


def table() -> list[tuple[str, str, str, str]]:
    """Return rows (ISO 230-1, VDI/VDE 2617-3, delta/epsilon, plain words): 18 component errors, 3 squareness, 12 rotary locations."""
    rows = [_component_row(direction, axis) for axis in LINEAR for direction in DIRECTIONS]
    rows += [_square_row(name) for name in SQUARE]
    return rows + [_location_row(f"{d}0{axis}") for axis in ROTARY for d in _location_directions(axis)]


class DescribedError(NamedTuple):
    """An ISO 230-1 error in words: other names, sign, unit of files, role of the effect that holds it in a machine file."""

    name: str
    words: str
    also: str
    sign: str
    unit: str


def describe_error(name: str) -> DescribedError:
    """Describe a canonical name in words. Raises UsageError for other names."""
    row = next((r for r in table() if r[0] == name), None)
    if row is None:
        raise UsageError(f'unknown error name "{name}".{choose_from(name, _examples(name))}')
    also = ", ".join(text for text in row[1:3] if text != "–") or "–"
    direction = name[0] if name in SQUARE or name[1] == "0" else name[1]
    about = LINEAR[ROTARY.index(direction)] if direction in ROTARY else ""
    sign = f"+ is a right-hand rotation about {about}" if about else f"+ is a motion towards +{direction}"
    return DescribedError(name, row[3], also, sign, "urad" if about else "um")


def _iso(word: str) -> str:
    """Return the ISO 230-1 name of EXX, E_XX, E_{XX}; C0Y, COY, EC0Y, E_C0Y; X0C. A component error needs its E: XX alone is ambiguous."""
    match = _ISO.fullmatch(word)
    if not match:
        return ""
    direction, nought, axis = match["direction"], match["nought"], match["axis"]
    if not nought:
        return f"E{direction}{axis}" if word.startswith("E") else ""
    return f"{direction}0{axis}" if _is_location(direction, axis) else ""


def _is_location(direction: str, axis: str) -> bool:
    """Return whether a direction and an axis can name a location: squareness turns a linear axis about another line; a rotary axis may be
    shifted or turned."""
    if axis in LINEAR:
        return direction in ROTARY and LINEAR[ROTARY.index(direction)] != axis
    return True


def _delta(word: str) -> str:
    match = _DELTA.fullmatch(word)
    if not match:
        return ""
    rotation = match["kind"].lower() in ("ε", "eps", "epsilon")
    return _component(match["direction"], match["argument"] or match["axis"], rotation)


def _vdi(word: str) -> str:
    match = _VDI.fullmatch(word)
    if not match:
        return ""
    axis, kind, direction = match["axis"], match["kind"].lower(), match["direction"]
    if kind == "w":
        return _square(axis, direction)
    if kind == "p" and axis.lower() != direction.lower():
        return ""  # p is the position deviation, along the axis itself
    return _component(direction, axis, kind == "r")


def _compact(word: str) -> str:
    match = _COMPACT.fullmatch(word)
    if not match:
        return ""
    if match["kind"].upper() == "W":
        return _square(match["axis"], match["direction"])
    return _component(match["direction"], match["axis"], match["kind"].upper() == "R")


def _component(direction: str, axis: str, rotation: bool) -> str:
    d = direction.upper()
    return f"E{ROTARY[LINEAR.index(d)] if rotation else d}{axis.upper()}"


def _square(first: str, second: str) -> str:
    pair = "".join(sorted((first.upper(), second.upper())))
    return next((name for name, axes in SQUARE.items() if axes == pair), "")


def _component_row(direction: str, axis: str) -> tuple[str, str, str, str]:
    rotation = direction in ROTARY
    d = LINEAR[ROTARY.index(direction)] if rotation else direction
    vdi = f"{axis}r{d}" if rotation else f"{axis}p{d}, {axis}t{d}" if d == axis else f"{axis}t{d}"
    delta = f"{'ε' if rotation else 'δ'}{d}({axis})"
    return f"E{direction}{axis}", vdi.lower(), delta.lower(), _words(direction, axis)


def words_of(name: str) -> str:
    """Return a name in words: EXX -> "positioning of X", C0Y -> "squareness of Y to X", X0C -> "location of C"; an unknown name unchanged."""
    if name in SQUARE:
        return _square_row(name)[3]
    if len(name) == 3 and name[0] == "E":
        return _words(name[1], name[2])
    return f"location of {name[2]}, {name[0]}" if len(name) == 3 and name[1] == "0" else name


def _words(direction: str, axis: str) -> str:
    if direction == axis:
        return f"positioning of {axis}"
    if direction in LINEAR:
        return f"straightness of {axis} in {direction}"
    about = LINEAR[ROTARY.index(direction)]
    return f"roll of {axis}" if about == axis else f"tilt of {axis} about {about}"


def _square_row(name: str) -> tuple[str, str, str, str]:
    first, second = SQUARE[name][0], SQUARE[name][1]
    return (
        name,
        f"{first}w{second}".lower(),
        f"S{first}{second}".lower(),
        f"squareness of {second} to {first}",
    )


def _location_directions(axis: str) -> list[str]:
    """Return the offsets and tilts that the centre line of an axis can have: two of each, none along itself."""
    along = LINEAR[ROTARY.index(axis)]
    return [d for d in LINEAR if d != along] + [d for d in ROTARY if d != axis]


def _location_row(name: str) -> tuple[str, str, str, str]:
    direction, axis = name[0], name[2]
    if direction in LINEAR:
        words = f"offset of the centre line of {axis} in {direction}"
    else:
        words = f"tilt of the centre line of {axis} about {LINEAR[ROTARY.index(direction)]}"
    return name, "–", "–", words


@cache
def _by_words() -> dict[str, str]:
    """Return canonical names by plain words, in lower case, and by the few names that follow no pattern."""
    words = {row[3].lower(): row[0] for row in table()}
    words |= {f"s{axes}".lower(): name for name, axes in SQUARE.items()}
    return words | {f"squareness {axes[0]}-{axes[1]}".lower(): name for name, axes in SQUARE.items()}


def _examples(word: str) -> list[str]:
    """Return names to choose from: those of the literature that the word resembles, else those of ISO 230-1."""
    column = 1 if re.fullmatch(r"[xyz]\w{2}", word) else 2 if re.match(r"[δεΔd]|eps", word) else 0
    return [name for row in table()[:21] for name in row[column].split(", ")]
