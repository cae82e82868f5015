"""PLANE functions of Klartext and cycle 19: read as a tilted plane, in which the coordinates that follow lie.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "The PLANE function". Where the rotary axes then stand hangs on
the kinematics of the machine: they are left where they are, and that is told.
"""

from __future__ import annotations

import math

from vcmm.nc.frames import AffineMap, rotation
from vcmm.nc.heidenhain.text import KlartextReader
from vcmm.nc.heidenhain.transforms import PLANE, KlartextFrames, turned_about, with_axes

WORDS = {
    "SPATIAL": ("SPA", "SPB", "SPC"), "RELATIV": ("SPA", "SPB", "SPC"), "RELATIVE": ("SPA", "SPB", "SPC"), "AXIAL": ("A", "B", "C"),
    "EULER": ("EULPR", "EULNU", "EULNUT", "EULROT"), "PROJECTED": ("PROPR", "PROMIN", "ROT", "PROROT"),
    "VECTOR": ("BX", "BY", "BZ", "NX", "NY", "NZ"), "POINTS": ("P1X", "P1Y", "P1Z", "P2X", "P2Y", "P2Z", "P3X", "P3Y", "P3Z"), "RESET": (),
}  # fmt: skip


def plane(frames: KlartextFrames, reader: KlartextReader) -> None:
    """One PLANE block."""
    kind = reader.upper()
    if kind not in WORDS:
        raise reader.fault(f"PLANE takes {', '.join(WORDS)}{f', {kind} stands there' if kind else ''}")
    reader.at += 1
    values = _values(reader, WORDS[kind])
    reader.rest()  # MOVE, TURN, STAY and how: the rotary axes
    if kind == "RESET":
        frames.tilt(AffineMap())
        return
    made = _map(kind, values, frames)
    if made is None:
        raise reader.fault(f"the directions of PLANE {kind} are parallel or zero; correct them")
    _tell(frames)
    frames.tilt(made)


def _values(reader: KlartextReader, names: tuple[str, ...]) -> dict[str, float]:
    """The words that say how the plane lies. P1X is a letter, a number and a letter."""
    out: dict[str, float] = {}
    while not reader.done:
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
    """The plane as a rotation; None where its directions do not make one."""
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
    """19.1: A B C, spatial angles; none, or zeros, end it."""
    angles = _values(reader, ("A", "B", "C"))
    reader.rest()  # F, ABST: how the axes get there
    made = turned_about(*(angles.get(a, 0.0) for a in "ABC"))
    if made != AffineMap():
        _tell(frames)
    frames.tilt(made)
