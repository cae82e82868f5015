"""Measuring programs in DMIS (ISO 22093): features, tolerances, datums, and the touches of MEAS ... PTMEAS ... ENDMES.

Read are the nominal statements that most systems export:

    F(name)=FEAT/POINT|LINE|PLANE|CIRCLE|CYLNDR|CONE|SPHERE,...     CART coordinates
    T(name)=TOL/DIAM|RAD|DISTB|ANGLB|FLAT|STRGHT|CIRLTY|CYLCTY|PARLEL|PERP|ANGLR|POS|CONCEN|CRNOUT|TRNOUT|PROFS|PROFL,...
    DATDEF/FA(name),DAT(A)     OUTPUT/FA(name)[,FA(name)],TA(name)...     EVAL/FA(...),T(...)
    MEAS/kind,F(name),n     PTMEAS/CART,x,y,z[,i,j,k]     ENDMES     UNITS/MM|CM|INCH,ANGDEC|ANGRAD

Other statements move the machine, change sensors or print; they do not say what the part is and are counted in a note. A
statement of the list above that is not understood is refused with its line.
Source: DMIS 5.3, ISO 22093:2022, statements FEAT, TOL, DATDEF, MEAS, PTMEAS, OUTPUT.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.text import brief, is_usual, lines_of, read_text, to_number
from vcmm.files.foreign.dmis_tolerances import TOLERANCES, ToleranceStatement, tables_of
from vcmm.files.foreign.drawing import DEFAULT_EXTENT, DrawnPart, deg, mm, spanned_plane, unit

LENGTHS = {"MM": 1.0, "CM": 10.0, "M": 1000.0, "INCH": 25.4, "FEET": 304.8}
ANGLES = {"ANGDEC": math.pi / 180.0, "ANGDEG": math.pi / 180.0, "ANGRAD": 1.0}
READ = ("UNITS", "FEAT", "TOL", "DATDEF", "MEAS", "PTMEAS", "ENDMES", "OUTPUT", "EVAL", "DMISMN")
_LABEL = re.compile(r"\s*(?:([A-Z]{1,3})\(([^)]*)\)\s*=\s*)?([A-Z0-9]+)\s*(?:/(.*))?$", re.IGNORECASE)


@dataclass(frozen=True)
class DmisStatement:
    """One statement of a program: kind[/words] with its label and place: F(C1)=FEAT/CIRCLE,INNER,... -> ("F", "C1"), "FEAT", ["CIRCLE",
    "INNER", ...]."""

    at: str
    label: tuple[str, str]
    kind: str
    words: tuple[str, ...]


@dataclass(eq=False)
class _Program:
    """The contents of a program read so far."""

    part: DrawnPart
    mm: float = 0.0  # of one unit of length; 0: not stated yet
    rad: float = math.pi / 180.0
    tolerances: dict[str, ToleranceStatement] = field(default_factory=dict)
    datums: dict[str, str] = field(default_factory=dict)
    touches: dict[str, list[list[float]]] = field(default_factory=dict)
    measuring: str = ""
    requests: list[tuple[str, list[str], list[str]]] = field(default_factory=list)
    others: dict[str, int] = field(default_factory=dict)
    features_with_extent: set[str] = field(default_factory=set)  # features whose extent the program states


def read_dmis(path: str | Path) -> DrawnPart:
    """Raises DataError with file and line: no DMIS, units missing, statements of the part that are not understood."""
    path = Path(path)
    program = _Program(DrawnPart(path.name, path.stem))
    for statement in _statements(path):
        _take(program, statement)
    if not program.part.features:
        raise DataError(
            f"{path}:1: no F(name)=FEAT/... statement is in this file; DMIS programs with nominals are read"
        )
    if program.others:
        listed = ", ".join(f"{k} ({n})" for k, n in sorted(program.others.items()))
        program.part.notes.append(f"statements that say nothing of the part: {listed}")
    for name, rows in program.touches.items():
        program.part.targets[name] = np.array(rows)
        if name not in program.features_with_extent:
            _span_feature(program.part, name, np.array(rows))
    _note_assumptions(program)
    for at, features, tolerances in program.requests:
        for tolerance in tolerances:
            tables_of(program.part, program.tolerances[tolerance], features, (at, program.datums))
    _note_unused(program)
    return program.part


def _note_assumptions(program: _Program) -> None:
    """Add a note for every extent that neither a statement nor touches determine."""
    for name, table in program.part.features.items():
        open_ended = table["type"] in ("plane", "line", "cylinder", "cone")
        if open_ended and name not in program.features_with_extent and name not in program.touches:
            program.part.notes.append(
                f"F({name}): the program states no extent; {mm(DEFAULT_EXTENT)} is assumed, correct it"
            )


def _note_unused(program: _Program) -> None:
    used = {t for _, _, tolerances in program.requests for t in tolerances}
    for name, tolerance in program.tolerances.items():
        if name not in used:
            program.part.notes.append(
                f"{tolerance.at}: T({name}) is not asked for by OUTPUT or EVAL: left out"
            )


def _statements(path: Path) -> list[DmisStatement]:
    """Split a file into statements: lines ended by $ go on, $$ begins a comment."""
    out: list[DmisStatement] = []
    text, start = "", 0
    for number, raw in enumerate(lines_of(read_text(path)), 1):
        line = raw.split("$$")[0].rstrip()
        start = start if text else number
        if line.endswith("$"):
            text += line[:-1]
            continue
        text += line
        if text.strip():
            out.append(_statement(f"{path}:{start}", text))
        text = ""
    if text.strip():
        raise DataError(f"{path}:{start}: the last statement goes on ($) and the file ends")
    return out


def _statement(at: str, text: str) -> DmisStatement:
    match = _LABEL.match(text)
    if not match:
        return DmisStatement(at, ("", ""), "?", (text.strip(),))
    label, name, kind, rest = match.groups()
    words = _split(rest or "")
    return DmisStatement(at, ((label or "").upper(), (name or "").strip()), kind.upper(), tuple(words))


def _split(rest: str) -> list[str]:
    """Split words at commas outside of quotes."""
    cells = re.findall(r"(?:'[^']*'|[^,'])+|(?<=,)(?=,|$)", rest)
    return [c.strip() for c in cells]


def _take(program: _Program, s: DmisStatement) -> None:
    handler: Callable[[_Program, DmisStatement], None] | None = {
        "UNITS": _units, "FEAT": _feature, "TOL": _tolerance, "DATDEF": _datum, "MEAS": _measure, "PTMEAS": _touch,
        "ENDMES": _end, "OUTPUT": _output, "EVAL": _output,
    }.get(s.kind)  # fmt: skip
    if handler is not None and not (s.kind in ("FEAT", "TOL") and s.label[0] in ("FA", "TA")):
        handler(program, s)
    elif s.kind not in READ:
        program.others[s.kind] = program.others.get(s.kind, 0) + 1


def _units(program: _Program, s: DmisStatement) -> None:
    words = [w.upper() for w in s.words]
    if not words or words[0] not in LENGTHS:
        raise DataError(
            f"{s.at}: UNITS/{brief(','.join(s.words))}: the length is one of {', '.join(LENGTHS)}"
        )
    angle = next((w for w in words[1:] if w in ANGLES), "ANGDEC")
    if any(w.startswith("ANG") and w not in ANGLES for w in words[1:]):
        raise DataError(f"{s.at}: UNITS/{brief(','.join(s.words))}: angles as ANGDEC or ANGRAD are read")
    program.mm, program.rad = LENGTHS[words[0]], ANGLES[angle]


def _feature(program: _Program, s: DmisStatement) -> None:
    if s.label[0] != "F" or not s.label[1]:
        raise DataError(f"{s.at}: a feature needs its name: F(name)=FEAT/...")
    if not program.mm:
        raise DataError(
            f"{s.at}: there is no UNITS/ statement before the first feature, so no length has a unit"
        )
    name, kind = s.label[1], s.words[0].upper() if s.words else ""
    maker = FEATURES.get(kind)
    if maker is None:
        program.part.notes.append(f"{s.at}: FEAT/{kind} {name}: no such feature here, left out")
        return
    if name in program.part.features:
        raise DataError(f"{s.at}: F({name}) is defined twice")
    try:
        program.part.features[name] = maker(program, s)
    except (IndexError, ValueError) as error:
        raise DataError(
            f"{s.at}: F({name})=FEAT/{kind} is not complete ({error}); the form is {FORMS[kind]}"
        ) from None


def _numbers(s: DmisStatement, after: str, least: int) -> list[float]:
    """Return the numbers behind a word such as CART. ValueError: another coordinate system, too few, no numbers."""
    words = [w.upper() for w in s.words]
    if after not in words:
        raise ValueError(
            f"{after} is missing; polar coordinates (POL) are not read"
            if "POL" in words
            else f"{after} is missing"
        )
    cells = s.words[words.index(after) + 1 :]
    out = []
    for cell in cells:
        try:
            out.append(to_number(cell))
        except ValueError:
            break
    if len(out) < least or not all(is_usual(v) for v in out):
        raise ValueError(f"{len(out)} numbers after {after}, expected {least}")
    return out


def _inside(s: DmisStatement) -> dict[str, Any]:
    words = [w.upper() for w in s.words[:3]]
    if not {"INNER", "OUTER"} & set(words):
        raise ValueError("INNER or OUTER is missing")
    return {"inside": True} if "INNER" in words else {}


def _point(p: _Program, s: DmisStatement) -> dict[str, Any]:
    x = _numbers(s, "CART", 6)
    return {"type": "point", "point": mm(*(p.mm * v for v in x[:3])), "normal": unit(x[3:6])}


def _plane(p: _Program, s: DmisStatement) -> dict[str, Any]:
    x = _numbers(s, "CART", 6)
    return {"type": "plane", "point": mm(*(p.mm * v for v in x[:3])), "normal": unit(x[3:6]), "size": mm(DEFAULT_EXTENT, DEFAULT_EXTENT)}  # fmt: skip


def _line(p: _Program, s: DmisStatement) -> dict[str, Any]:
    bounded = len(s.words) > 1 and s.words[1].upper() == "BND"
    x = _numbers(s, "CART", 9 if bounded else 6)
    way = [b - a for a, b in zip(x[:3], x[3:6])] if bounded else x[3:6]
    long = p.mm * float(np.linalg.norm(way)) if bounded else DEFAULT_EXTENT
    if bounded:
        p.features_with_extent.add(s.label[1])
    out = {
        "type": "line",
        "point": mm(*(p.mm * v for v in x[:3])),
        "direction": unit(way),
        "length": mm(long),
    }
    return out | ({"normal": unit(x[6:9])} if len(x) >= 9 else {})


def _circle(p: _Program, s: DmisStatement) -> dict[str, Any]:
    x = _numbers(s, "CART", 7)
    return {"type": "circle", "point": mm(*(p.mm * v for v in x[:3])), "axis": unit(x[3:6]), "diameter": mm(p.mm * x[6])} | _inside(s)  # fmt: skip


def _cylinder(p: _Program, s: DmisStatement) -> dict[str, Any]:
    x = _numbers(s, "CART", 7)
    long = p.mm * x[7] if len(x) > 7 else DEFAULT_EXTENT
    if len(x) > 7:
        p.features_with_extent.add(s.label[1])
    return _circle(p, s) | {"type": "cylinder", "length": mm(long)}


def _cone(p: _Program, s: DmisStatement) -> dict[str, Any]:
    """Return the table of a cone; the point of a DMIS cone is its vertex; part/1 needs a diameter: that at 20 mm from it, where the
    touches move it."""
    x = _numbers(s, "CART", 7)
    axis, full = unit(x[3:6]), p.rad * x[6]
    if not 0.0 < full < math.pi:
        raise ValueError(f"an included angle of {math.degrees(full):g} deg")
    start = [p.mm * v + DEFAULT_EXTENT * a for v, a in zip(x[:3], axis)]
    wide = 2.0 * DEFAULT_EXTENT * math.tan(full / 2.0)
    return {"type": "cone", "point": mm(*start), "axis": axis, "diameter": mm(wide), "angle": deg(full), "length": mm(DEFAULT_EXTENT)} | _inside(s)  # fmt: skip


def _sphere(p: _Program, s: DmisStatement) -> dict[str, Any]:
    x = _numbers(s, "CART", 4)
    return {"type": "sphere", "point": mm(*(p.mm * v for v in x[:3])), "diameter": mm(p.mm * x[3])} | _inside(
        s
    )


FEATURES: dict[str, Callable[[_Program, DmisStatement], dict[str, Any]]] = {
    "POINT": _point, "PLANE": _plane, "LINE": _line, "CIRCLE": _circle, "CYLNDR": _cylinder, "CONE": _cone, "SPHERE": _sphere,
}  # fmt: skip
FORMS = {
    "POINT": "FEAT/POINT,CART,x,y,z,i,j,k", "PLANE": "FEAT/PLANE,CART,x,y,z,i,j,k",
    "LINE": "FEAT/LINE,BND,CART,x1,y1,z1,x2,y2,z2,i,j,k or FEAT/LINE,UNBND,CART,x,y,z,i,j,k,ni,nj,nk",
    "CIRCLE": "FEAT/CIRCLE,INNER,CART,x,y,z,i,j,k,diameter", "CYLNDR": "FEAT/CYLNDR,INNER,CART,x,y,z,i,j,k,diameter[,length]",
    "CONE": "FEAT/CONE,INNER,CART,x,y,z,i,j,k,included angle", "SPHERE": "FEAT/SPHERE,OUTER,CART,x,y,z,diameter",
}  # fmt: skip


def _tolerance(program: _Program, s: DmisStatement) -> None:
    if s.label[0] != "T" or not s.label[1]:
        raise DataError(f"{s.at}: a tolerance needs its name: T(name)=TOL/...")
    kind = s.words[0].upper() if s.words else ""
    if kind not in TOLERANCES:
        program.part.notes.append(f"{s.at}: TOL/{kind} {s.label[1]}: no such characteristic here, left out where it is used")  # fmt: skip
    program.tolerances[s.label[1]] = ToleranceStatement(s.at, s.label[1], kind, s.words[1:], program.mm or 1.0, program.rad)  # fmt: skip


def _datum(program: _Program, s: DmisStatement) -> None:
    feature = _names("FA|F", s)
    letter = _names("DAT", s)
    if len(feature) != 1 or len(letter) != 1:
        raise DataError(f"{s.at}: DATDEF/{brief(','.join(s.words))}: the form is DATDEF/FA(feature),DAT(A)")
    program.datums[letter[0]] = feature[0]


def _measure(program: _Program, s: DmisStatement) -> None:
    name = _names("F", s)
    if len(name) != 1 or name[0] not in program.part.features:
        program.measuring = ""
        return
    program.measuring = name[0]


def _touch(program: _Program, s: DmisStatement) -> None:
    if not program.measuring:
        return
    feature = program.part.features[program.measuring]
    try:
        x = _numbers(s, "CART", 3)
        if len(x) < 6:
            raise DataError(
                f"{s.at}: PTMEAS without its vector i,j,k: write the normal of a {feature['type']} at this place"
            )
        row = [*(program.mm * v for v in x[:3]), *unit(x[3:6])]
    except ValueError as error:
        raise DataError(f"{s.at}: PTMEAS: {error}; the form is PTMEAS/CART,x,y,z,i,j,k") from None
    program.touches.setdefault(program.measuring, []).append(row)


def _end(program: _Program, _s: DmisStatement) -> None:
    program.measuring = ""


def _output(program: _Program, s: DmisStatement) -> None:
    features, tolerances = _names("FA|F", s), _names("TA|T", s)
    named = [t for t in tolerances if t in program.tolerances]
    unknown = [t for t in tolerances if t not in program.tolerances]
    if unknown:
        raise DataError(f"{s.at}: the tolerance T({unknown[0]}) is not defined before")
    if named:
        program.requests.append((s.at, features, named))


def _names(kinds: str, s: DmisStatement) -> list[str]:
    """Return the names in words such as FA(C1) of the kinds given."""
    matches = (re.fullmatch(rf"(?:{kinds})\(([^)]*)\)", w, re.IGNORECASE) for w in s.words)
    return [f[1].strip() for f in matches if f]


def _span_feature(drawn: DrawnPart, name: str, rows: Any) -> None:
    """Compute the extent of a plane, bore or cone from its touches (n, 6)."""
    table = drawn.features[name]
    place = np.array([float(v) for v in table["point"].removesuffix(" mm").split()])
    if table["type"] in ("cylinder", "cone"):
        axis = np.array(table["axis"])
        along = (rows[:, :3] - place) @ axis
        if np.ptp(along) > 0.0:
            if table["type"] == "cone":
                slope = 2.0 * math.tan(math.radians(float(table["angle"].removesuffix(" deg"))) / 2.0)
                wide = float(table["diameter"].removesuffix(" mm")) + slope * along.min()
                table["diameter"] = mm(wide)
            table |= {"point": mm(*(place + axis * along.min())), "length": mm(np.ptp(along))}
    elif table["type"] == "plane":
        table |= spanned_plane(place, np.array(table["normal"]), rows[:, :3])
