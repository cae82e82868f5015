"""Scaling, mirror images and polar words of the G-code family: what they do to programmed points.

Sources: FANUC Series 30i operator's manual B-64304EN: "scaling", "programmable mirror image", "polar coordinate command"; Haas mill operator's manual: G51, G100, G101.
"""

from __future__ import annotations

from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import AXES, IsoControl, PolarWords
from vcmm.program.iso.lengths import length
from vcmm.program.iso.motion import CENTRE_WORDS
from vcmm.program.moves import Point


def scaling(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """G51 X Y Z P, or I J K along the axes: all programmed points about a centre; G50 ends it. Mach3: factors by axis, no centre.

    P and I J K without a point count thousandths (FANUC, parameter 5400); a negative factor mirrors.
    """
    c.free("the scale changes")
    if code == "G50":
        c.scale = None
        c.rebuild()
        return
    if c.language.codes == "mach3":
        factors = [w.take(axis) for axis in AXES]
        c.scale = ((0.0, 0.0, 0.0), _point([1.0 if f is None else f for f in factors]))
    else:
        centre = list(c.p)
        for i, axis in enumerate(AXES):
            number = w.take(axis)
            if number is not None:
                centre[i] = length(c, w, axis, number)
        c.scale = (_point(centre), _factors(w))
    if 0.0 in c.scale[1]:
        raise BlockFault(column, f"{code}: a scale of zero; correct its factor")
    c.rebuild()


def _factors(w: IsoWords) -> Point:
    common, own = _factor(w, "P"), [_factor(w, k) for k in CENTRE_WORDS]
    if common is None and own == [None, None, None]:
        return 1.0, 1.0, 1.0
    return _point([(1.0 if f is None else f) if common is None else common for f in own])


def _factor(w: IsoWords, letter: str) -> float | None:
    number = w.take(letter)
    return number if number is None or w.words[letter].has_point else number / 1000.0


def _point(values: list[float]) -> Point:
    return values[0], values[1], values[2]


def mirror(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """G51.1 X10: the programmed points mirrored at X 10; G50.1 X0 ends it, without axes of all. Haas: G101, ended by G100."""
    c.free("a mirror image changes")
    named = {i: w.take(axis) for i, axis in enumerate(AXES) if w.has(axis)}
    if code in ("G51.1", "G101"):
        if not named:
            raise BlockFault(column, f"{code} needs the axis to be mirrored, as in {code} X0")
        haas = code == "G101"
        c.mirrors |= {i: 0.0 if haas else length(c, w, AXES[i], n or 0.0) for i, n in named.items()}
    else:
        for i in named or dict(c.mirrors):
            c.mirrors.pop(i, None)
    c.rebuild()


def polar_words(c: IsoControl, code: str) -> None:
    """G16, G15."""
    c.polar = PolarWords() if code == "G16" else None
