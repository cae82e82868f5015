"""STEP files (AP203, AP214, AP242) as parts: planes, cylinders, cones, spheres and tori become features.

The geometry is read by Open CASCADE (`pip install vcmm[step]`), tolerances by `step_tolerances` from the text. Faces of one
surface (the halves of a bore) are one feature; free-form faces, fillets and chamfers without a tolerance are left out, with a note.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.files.foreign.drawing import DrawnPart, deg, mm, unit
from vcmm.files.foreign.part21 import Part21, read_part21
from vcmm.files.foreign.scenario_text import features_of
from vcmm.files.foreign.step_faces import SAME_SURFACE_MM, SURFACE_WORDS, SurfaceFace, read_faces
from vcmm.files.foreign.step_tolerances import add_tolerances

SURFACES = {
    "PLANE": "plane", "CYLINDRICAL_SURFACE": "cylinder", "CONICAL_SURFACE": "cone", "SPHERICAL_SURFACE": "sphere",
    "TOROIDAL_SURFACE": "torus", "DEGENERATE_TOROIDAL_SURFACE": "torus",
}  # fmt: skip
WHOLE = 2.0 * math.pi * 0.98  # rad of a round feature that the standard plan can touch all around


def read_step(path: str | Path) -> DrawnPart:
    """Raises DataError (no STEP file, no faces that vcmm has, broken tolerances), Environment (Open CASCADE is missing)."""
    text = read_part21(path)
    read = read_faces(text.path)
    faces, left = _number_faces(text, read.faces, read.kinds), read.others
    drawn = DrawnPart(Path(path).name, _name(text))
    names, part_of = _add_features(drawn, faces)
    if not names:
        raise DataError(f"{text.path}:1: this file has no plane, cylinder, cone, sphere or torus")
    drawn.notes.extend(
        f"{n} {kind} faces: no such feature here, left out" for kind, n in sorted(left.items())
    )
    add_tolerances(text, drawn, names)
    if min(names) < 0:
        drawn.notes.append(
            "Open CASCADE has changed the faces of this file: no tolerance can be tied to them"
        )
    if not drawn.characteristics:
        _ask_plainly(drawn)
    _leave_out_fillets(drawn, part_of)
    return drawn


def _name(text: Part21) -> str:
    product = next(text.of("PRODUCT"), None)
    words = [
        v for v in (product.values("PRODUCT")[:2] if product else []) if isinstance(v, str) and v.strip()
    ]
    return words[-1].strip() if words else text.path.stem


def _number_faces(text: Part21, faces: list[SurfaceFace], kinds: list[str]) -> list[SurfaceFace]:
    """Return faces with their numbers in the file: Open CASCADE keeps the order of the shells. Numbers below 0 where it did not.

    Checked by the kind of every surface, and by the radii of all round ones.
    """
    notes = [
        n for s in text.of("CLOSED_SHELL", "OPEN_SHELL") for n in s.values("CLOSED_SHELL", "OPEN_SHELL")[1]
    ]
    surfaces = [_surface(text, n) for n in notes]
    same = [SURFACE_WORDS.get(k, "") for k in kinds] == [SURFACES.get(name, "") for name, _ in surfaces]
    ratios = (
        [surfaces[f.number][1] / f.sizes[0] for f in faces if f.kind in ("cylinder", "sphere")]
        if same
        else []
    )
    if not same or (ratios and max(ratios) > min(ratios) * (1.0 + SAME_SURFACE_MM)):
        return [replace(f, number=-1 - f.number) for f in faces]
    return [replace(f, number=notes[f.number]) for f in faces]


def _surface(text: Part21, face: int) -> tuple[str, float]:
    """Return the kind of surface of a face and its third value (the radius of round ones)."""
    surface = text[text[face].values("ADVANCED_FACE", "FACE_SURFACE")[2]]
    name, values = next(iter(surface.parts.items()))
    return name, float(values[2]) if len(values) > 2 and isinstance(values[2], float) else 0.0


def _add_features(drawn: DrawnPart, faces: Iterable[SurfaceFace]) -> tuple[dict[int, str], dict[str, float]]:
    """Add features to `drawn`, one for all faces of one round surface; return names by number of the face, and the angle in rad of those
    that do not go all around.
    """
    groups: list[list[SurfaceFace]] = []
    for face in faces:
        group = next((g for g in groups if _same(g[0], face)), None)
        if group is None:
            groups.append([face])
        else:
            group.append(face)
    counts: Counter[str] = Counter()
    names: dict[int, str] = {}
    part_of: dict[str, float] = {}
    for group in groups:
        word = {"cylinder": "bore" if group[0].inside else "shaft"}.get(group[0].kind, group[0].kind)
        counts[word] += 1
        name = f"{word}_{counts[word]}"
        whole = _join_faces(group)
        drawn.features[name] = _table(whole)
        turn = whole.reach[1] - whole.reach[0]
        if whole.kind in ("cylinder", "cone") and turn < WHOLE:
            part_of[name] = turn
        if group[0].touches is not None:
            drawn.targets[name] = _on(group[0], group[0].touches)
        names |= {f.number: name for f in group}
    return names, part_of


def _on(face: SurfaceFace, touches: Array) -> Array:
    """Return the places and outward normals (n, 6) of touches in u and v."""
    places = face.place + touches @ face.frame[:2]
    return np.hstack([places, np.broadcast_to(face.axis, places.shape)])


def _same(a: SurfaceFace, b: SurfaceFace) -> bool:
    """Return whether two faces are of one round surface and touch or overlap along its axis."""
    if (
        a.kind != b.kind
        or a.kind == "plane"
        or a.inside != b.inside
        or not np.allclose(a.sizes, b.sizes, rtol=0, atol=SAME_SURFACE_MM)
    ):
        return False
    between = b.place - a.place
    if a.kind == "sphere":
        return bool(np.linalg.norm(between) < SAME_SURFACE_MM)
    if np.linalg.norm(np.cross(a.axis, b.axis)) > SAME_SURFACE_MM or (
        a.kind != "cylinder" and np.linalg.norm(between) > SAME_SURFACE_MM
    ):
        return False
    if a.kind != "cylinder":
        return bool(a.axis @ b.axis > 0)
    if np.linalg.norm(np.cross(between, a.axis)) > SAME_SURFACE_MM:
        return False
    low, high = sorted(float(between @ a.axis) + v * float(np.sign(a.axis @ b.axis)) for v in b.reach[2:])
    return low < a.reach[3] + SAME_SURFACE_MM and high > a.reach[2] - SAME_SURFACE_MM


def _join_faces(group: list[SurfaceFace]) -> SurfaceFace:
    """Join the faces into one: the angles together, from the lowest to the highest place along the axis."""
    first = group[0]
    if len(group) == 1:
        return first
    ends = [
        float((f.place - first.place) @ first.axis) + v * float(np.sign(first.axis @ f.axis) or 1.0)
        for f in group for v in f.reach[2:]
    ]  # fmt: skip
    along = (min(ends), max(ends)) if first.kind in ("cylinder", "cone") else first.reach[2:]
    turn = min(sum(f.reach[1] - f.reach[0] for f in group), 2 * math.pi)
    return replace(first, reach=(first.reach[0], first.reach[0] + turn, *along))


def _table(face: SurfaceFace) -> dict[str, Any]:
    """Return the table of part/1."""
    side = {"inside": True} if face.inside else {}
    if face.kind == "plane":
        u0, u1, v0, v1 = face.reach
        middle = face.place + 0.5 * (u0 + u1) * face.frame[0] + 0.5 * (v0 + v1) * face.frame[1]
        return {"type": "plane", "point": mm(*_clean(middle)), "normal": unit(list(face.axis)), "size": mm(u1 - u0, v1 - v0), "u": unit(list(face.frame[0]))}  # fmt: skip
    if face.kind == "sphere":
        return {"type": "sphere", "point": mm(*_clean(face.place)), "diameter": mm(2 * face.sizes[0])} | side
    if face.kind == "torus":
        ring, tube = face.sizes
        return {"type": "torus", "point": mm(*_clean(face.place)), "axis": unit(list(face.axis)), "diameter": mm(2 * ring), "tube": mm(2 * tube)} | side  # fmt: skip
    low, high = face.reach[2:]
    if face.kind == "cylinder":
        at = _clean(face.place + low * face.axis)
        return {"type": "cylinder", "point": mm(*at), "axis": unit(list(face.axis)), "diameter": mm(2 * face.sizes[0]), "length": mm(high - low)} | side  # fmt: skip
    return _cone(face) | side


def _cone(face: SurfaceFace) -> dict[str, Any]:
    """Return the table of a cone from its narrow end: Open CASCADE counts v along the slope, from the reference radius."""
    radius, half = face.sizes
    ends = sorted((radius + v * math.sin(half), v * math.cos(half)) for v in face.reach[2:])
    (narrow, near), (wide, far) = ends
    if narrow < 0.05 * wide:  # the tip of a drill: touched from a twentieth of its radius on
        near, narrow = near + (far - near) * (0.05 * wide - narrow) / (wide - narrow), 0.05 * wide
    axis = face.axis if far > near else -face.axis
    at = _clean(face.place + near * face.axis)
    return {
        "type": "cone", "point": mm(*at), "axis": unit(list(axis)), "diameter": mm(2 * narrow), "angle": deg(2 * abs(half)),
        "length": mm(abs(far - near)),
    }  # fmt: skip


def _clean(place: Array) -> Array:
    """Return a place without the noise of the modeller: 1e-9 mm."""
    return np.round(place, 9) + 0.0


def _ask_plainly(drawn: DrawnPart) -> None:
    """Add diameters of round features and flatness of planes, without limits, where no tolerance could be read."""
    for name, table in drawn.features.items():
        kind = table["type"]
        if kind in ("cylinder", "sphere"):
            drawn.characteristics.append({"name": f"{name} diameter", "type": "size", "of": name})
        elif kind == "plane":
            drawn.characteristics.append({"name": f"{name} flatness", "type": "flatness", "of": name})
    drawn.notes.append(
        "no tolerance was read: diameters and flatness are listed without limits; delete what you do not need"
    )


def _leave_out_fillets(drawn: DrawnPart, part_of: Mapping[str, float]) -> None:
    """Remove characteristics of round features that do not go all around (`part_of`: name -> rad); with a note where one bears a tolerance."""
    kept = []
    for c in drawn.characteristics:
        part = [n for n in features_of(c) if n in part_of]
        if not part:
            kept.append(c)
        elif "limits" in c or "zone" in c:
            drawn.notes.append(
                f"{c['name']}: {part[0]} goes round by {math.degrees(part_of[part[0]]):.0f} deg only; left out"
            )
    drawn.characteristics[:] = kept
