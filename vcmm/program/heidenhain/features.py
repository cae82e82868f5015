"""FUNCTION and TRANS blocks of Klartext.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Special functions"; TNC7 for TRANS ROTATION, MIRROR and SCALE.
"""

from __future__ import annotations

import math

from vcmm.program.frames import AffineMap, stretch, translation
from vcmm.program.heidenhain.paths import KlartextPaths
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.heidenhain.transforms import MIRROR, SCALE, SHIFT, KlartextFrames

IDLE = {  # what a FUNCTION does, and whether the path hangs on it
    "MODE": False, "S-PULSE": False, "COUNT": False, "PROG": False, "FEED": False, "FILE": False, "SCREENSAVER": False, "LIFTOFF": False,
    "PARAXCOMP": True, "PARAXMODE": True, "TURNDATA": True, "CORRDATA": True, "POLARKIN": True, "TDATA": True, "DRESS": True, "CONTOUR": True,
    "AFC": False, "SPINDLE": False, "ROTATION": True,
}  # fmt: skip


def function(paths: KlartextPaths, reader: KlartextReader) -> None:
    """Read FUNCTION MODE, FUNCTION TCPM, FUNCTION DWELL ..."""
    word = reader.upper()
    if reader.accept("RESET") and reader.upper() == "TCPM":
        reader.rest()
        paths.tip(False)
    elif reader.accept("TCPM"):
        tool_centre(paths, reader)
    elif reader.accept("DWELL"):
        for sign in ("TIME", "S"):
            reader.accept(sign)
        paths.r.dwell(reader.value("DWELL"))
        reader.rest()
    elif word in ("MODE", "RESET"):
        kind = reader.rest().upper()
        if "TURN" in kind:
            _tell(paths, "FUNCTION MODE TURN", "read as milling", True)
    else:
        reader.rest()
        _tell(paths, f"FUNCTION {word}", "passed over", IDLE.get(word, True))


def _tell(paths: KlartextPaths, what: str, value: str, matters: bool) -> None:
    paths.r.assume(what, value, f"{what} is not understood; take it out", matters=matters)


def transform(frames: KlartextFrames, reader: KlartextReader) -> None:
    """Read TRANS DATUM AXIS X+10, TRANS DATUM RESET, TRANS ROTATION ROT+30, TRANS MIRROR AXIS X, TRANS SCALE SCL0.9, each with RESET."""
    kind = reader.upper()
    reader.at += 1
    if reader.accept("RESET"):
        reader.rest()
        _reset(frames, kind)
    elif kind == "DATUM" and reader.accept("AXIS"):
        frames.datum(reader)
    elif kind == "DATUM":
        what = f"{reader.rest()} of TRANS DATUM"
        frames.recorder.assume(
            what, "no shift", "TRANS DATUM TABLE is not understood; write TRANS DATUM AXIS X Y Z"
        )
    elif kind == "ROTATION":
        frames.rotate(reader)
    elif kind == "MIRROR":
        reader.accept("AXIS")
        frames.mirror(reader)
    elif kind == "SCALE":
        frames.enlarge(reader)
    else:
        raise reader.fault(f"TRANS takes DATUM, ROTATION, MIRROR or SCALE{f', found {kind}' if kind else ''}")


def _reset(frames: KlartextFrames, kind: str) -> None:
    if kind == "DATUM":
        frames.shifts[SHIFT] = [0.0] * 3
        frames.put(SHIFT, translation((0.0, 0.0, 0.0)))
    elif kind == "ROTATION":
        frames.turn_by(0.0)
    elif kind == "MIRROR":
        frames.mirror_axes = frozenset()
        frames.put(MIRROR, AffineMap())
    else:
        frames.scales = [1.0] * 3
        frames.put(SCALE, stretch((1.0, 1.0, 1.0)))


def tool_centre(paths: KlartextPaths, reader: KlartextReader) -> None:
    """Read FUNCTION TCPM F TCP or CONT, AXIS POS or SPAT, PATHCTRL AXIS or VECTOR, REFPNT; F1000 limits compensating motions.

     Source: HEIDENHAIN, TNC 640 User's Manual, "FUNCTION TCPM": AXIS SPAT takes A B C as spatial angles of the coordinate system in
    force; PATHCTRL VECTOR moves the tool axis in the plane of its directions at both ends of a block.
    """
    spatial = sweeps = False
    while not reader.is_done:
        word, place = reader.upper(), reader.column
        reader.at += 1
        kind = reader.upper()
        if word == "F" and kind in ("TCP", "CONT"):
            reader.at += 1
            if kind == "CONT":
                _refuse(paths, "F CONT of TCPM (the feed of the axes)", "the feed of the tip", place)
        elif word == "AXIS" and kind in ("POS", "SPAT"):
            reader.at += 1
            spatial = kind == "SPAT"
        elif word == "PATHCTRL" and kind in ("AXIS", "VECTOR"):
            reader.at += 1
            sweeps = kind == "VECTOR"
        elif word == "REFPNT":
            words = reader.rest().upper()
            if words != "TIP-TIP":
                _refuse(paths, f"REFPNT {words} of TCPM", "the tip leads and turns", place)
        elif word == "F":
            reader.value("F")
        elif word != "FMAX":
            _refuse(paths, f"{word} {reader.rest()}".strip() + " of TCPM", "passed over", place)
    paths.tip(True)
    paths.spatial = [math.nan] * 3 if spatial else None
    paths.r.sweeps = sweeps


def _refuse(paths: KlartextPaths, what: str, value: str, place: int) -> None:
    paths.r.assume(what, value, f"{what} is not understood; take it out", column=place)
