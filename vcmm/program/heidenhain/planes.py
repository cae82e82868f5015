"""PLANE functions of Klartext and cycle 19: read as a tilted plane, in which the coordinates that follow lie.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "The PLANE function", "Specifying the positioning behavior"; TNC7,
"Tilting solution", for SYM. Where the rotary axes then stand, the machine knows (vcmm.shop.motion.posture).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vcmm.program.frames import AffineMap, rotation, with_axes
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.heidenhain.transforms import PLANE, KlartextFrames, turned_about
from vcmm.program.leading import column
from vcmm.program.moves import ORIGIN, Posture

WORDS = {
    "SPATIAL": ("SPA", "SPB", "SPC"), "RELATIV": ("SPA", "SPB", "SPC"), "RELATIVE": ("SPA", "SPB", "SPC"), "AXIAL": ("A", "B", "C"),
    "EULER": ("EULPR", "EULNU", "EULNUT", "EULROT"), "PROJECTED": ("PROPR", "PROMIN", "ROT", "PROROT"),
    "VECTOR": ("BX", "BY", "BZ", "NX", "NY", "NZ"), "POINTS": ("P1X", "P1Y", "P1Z", "P2X", "P2Y", "P2Z", "P3X", "P3Y", "P3Z"), "RESET": (),
}  # fmt: skip


SAID_ROTARY = ("120", "121", "122")  # Q120 to Q122: A, B and C of the plane in force
TURNS = ("MOVE", "TURN", "STAY")


class Positioning(NamedTuple):
    """Movement of the rotary axes into a plane. kind: MOVE, TURN, STAY, or "" where none is programmed."""

    kind: str = ""
    posture: Posture | None = None
    has_table_rot: bool = False


def plane(frames: KlartextFrames, reader: KlartextReader) -> None:
    """Read one PLANE block."""
    kind = reader.upper()
    if kind not in WORDS:
        raise reader.fault(f"PLANE takes {', '.join(WORDS)}{f', found {kind}' if kind else ''}")
    reader.at += 1
    values = _values(reader, WORDS[kind])
    how = _positioning(frames, reader)
    if kind == "RESET":
        frames.tilt(AffineMap())
        _home(frames, how.kind)
        return
    made = _map(kind, values, frames)
    if made is None:
        raise reader.fault(f"the directions of PLANE {kind} are parallel or zero; correct them")
    _tell(frames)
    posture = how.posture
    if how.kind == "MOVE":
        posture = (posture or Posture())._replace(keeps_tip=True)
    frames.tilt(made, posture, stays=how.kind == "STAY")
    r = frames.recorder
    if how.has_table_rot and kind != "AXIAL":  # without effect there, as COORD ROT
        r.posture = (posture or Posture())._replace(along=column(r.world, 0))
    if how.kind == "STAY":
        r.remark("STAY: the rotary axes stand until a block turns them, as L A+Q120 B+Q121 C+Q122 does")


def _home(frames: KlartextFrames, kind: str) -> None:
    """Execute PLANE RESET TURN, MOVE: the rotary axes go to zero in this block, MOVE keeping the tip where it is on the workpiece."""
    r = frames.recorder
    if kind not in ("TURN", "MOVE") or not r.unmoved_axes:
        return
    led, r.is_tcp_on, r.rotary = r.is_tcp_on, kind == "MOVE", ORIGIN
    for letter in "ABC":
        r.release(letter)
    r.straight(r.p, True, ORIGIN)
    r.is_tcp_on = led


def _positioning(frames: KlartextFrames, reader: KlartextReader) -> Positioning:
    """Read how the axes go into the plane: MOVE DIST50, TURN, STAY; F; SEQ+ SEQ-, SYM+ SYM-; TABLE ROT, COORD ROT; MB."""
    kind, posture, table = "", None, False
    while not reader.is_done:
        word, place = reader.upper(), reader.column
        reader.at += 1
        if word in TURNS:
            kind = word
        elif word in ("SEQ", "SYM"):
            sense = reader.upper()
            if sense not in ("+", "-"):
                raise reader.fault(f"{word} takes + or -, as in {word}+")
            reader.at += 1
            sign = 1 if sense == "+" else -1
            posture = Posture(sign=sign) if word == "SEQ" else Posture(larger=sign)
            posture = posture._replace(words=f"{word}{sense}")
        elif word in ("TABLE", "COORD"):
            reader.expect("ROT", f"after {word}")
            table = word == "TABLE"
        elif word == "DIST":
            reader.value("DIST")
        elif word == "MB":
            _retracting(frames, reader, place)
        elif word == "F":
            if not (reader.accept("MAX") or reader.accept("AUTO")):
                reader.value("F")
        elif word not in ("FMAX", "FAUTO", "~"):
            reader.at -= 1
            what = f"{reader.rest()} behind PLANE"
            frames.recorder.assume(
                what, "passed over",
                f"{what} is not understood; known are MOVE, TURN, STAY, DIST, MB, F, SEQ, SYM, TABLE ROT and COORD ROT", column=place,
            )  # fmt: skip
    return Positioning(kind, posture, table)


def _retracting(frames: KlartextFrames, reader: KlartextReader, place: int) -> None:
    """Retract by MB: the tool goes back along its axis before the rotary axes turn."""
    if not reader.accept("MAX"):
        away = reader.value("MB")
        if not away:
            return
    frames.recorder.assume(
        "MB of PLANE (back along the tool before the axes turn)", "passed over: X, Y and Z stand",
        "MB of PLANE is not understood; program M140 MB in a block before it", column=place,
    )  # fmt: skip


def asks_for_plane_angles(frames: KlartextFrames, reader: KlartextReader) -> bool:
    """Return whether a block turns the rotary axes to the angles of the plane: A+Q120, B+Q121, C+Q122 behind PLANE ... STAY."""
    texts = [t.text.upper() for t in reader.tokens]
    named = any(texts[k] == "Q" and texts[k + 1] in SAID_ROTARY for k in range(len(texts) - 1))
    return named and (frames.waits or frames.recorder.is_plane_tilted)


def _values(reader: KlartextReader, names: tuple[str, ...]) -> dict[str, float]:
    """Return the words that determine the plane. P1X is a letter, a number and a letter."""
    out: dict[str, float] = {}
    while not reader.is_done:
        name = "".join(reader.upper(k) for k in range(3)) if reader.upper() == "P" else reader.upper()
        if name not in names:
            break
        reader.at += 3 if reader.upper() == "P" else 1
        out[name] = reader.value(name)
    return out


def _tell(frames: KlartextFrames) -> None:
    r = frames.recorder
    r.assume(
        "how the machine tilts (PLANE, cycle 19)", "points lie in the tilted plane of the workpiece, the tool square to it",
        matters=False,
    )  # fmt: skip


def _map(kind: str, v: dict[str, float], frames: KlartextFrames) -> AffineMap | None:
    """Return the plane as a rotation; None where its directions do not make one."""
    if kind in ("SPATIAL", "AXIAL"):
        a, b, c = (v.get(n, 0.0) for n in WORDS[kind])
        return turned_about(a, b, c)
    if kind in ("RELATIV", "RELATIVE"):
        a, b, c = (v.get(n, 0.0) for n in WORDS[kind])
        return frames.maps.get(PLANE, AffineMap()).then(turned_about(a, b, c))
    if kind == "EULER":
        first, second = v.get("EULPR", 0.0), v.get("EULNU", v.get("EULNUT", 0.0))
        made = rotation(2, math.radians(first)).then(rotation(0, math.radians(second)))
        return made.then(rotation(2, math.radians(v.get("EULROT", 0.0))))
    if kind == "VECTOR":
        return with_axes([v.get(f"B{a}", 0.0) for a in "XYZ"], [v.get(f"N{a}", 0.0) for a in "XYZ"])
    if kind == "POINTS":
        p = [[v.get(f"P{k}{a}", 0.0) for a in "XYZ"] for k in (1, 2, 3)]
        u, w = ([q - o for q, o in zip(p[k], p[0])] for k in (1, 2))
        return with_axes(u, [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]])
    slope, across = math.radians(v.get("PROPR", 0.0)), math.radians(v.get("PROMIN", 0.0))
    x, y = (math.cos(slope), 0.0, math.sin(slope)), (0.0, math.cos(across), math.sin(across))
    tilted = with_axes(x, (x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]))
    turn = math.radians(v.get("ROT", v.get("PROROT", 0.0)))
    return None if tilted is None else tilted.then(rotation(2, turn))


def working_plane(frames: KlartextFrames, reader: KlartextReader) -> None:
    """Tilt the plane by cycle 19, block 19.1: A B C, spatial angles; none, or zeros, end it."""
    angles = _values(reader, ("A", "B", "C"))
    reader.rest()  # F, ABST: how the axes get there
    made = turned_about(*(angles.get(a, 0.0) for a in "ABC"))
    if made != AffineMap():
        _tell(frames)
    frames.tilt(made)
