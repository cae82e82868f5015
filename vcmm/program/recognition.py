"""The dialect of a program, by scored evidence: header, comment signs, words, cycles, end; never one sign alone.

Every sign that a text has adds its weight to a dialect once. The deciding signs and the runner-up are reported. A weight is the
exclusiveness of a sign: 1 habit, 3 rare elsewhere, 6 and more: no other control reads it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

READ = 300_000  # characters that are looked at
MILLS = ("fanuc", "haas", "mazak")
LATHES = ("fanuc-lathe", "haas-lathe")
HOBBY = ("grbl", "mach3")
_B = r"^[ \t]*/?(?:N?\d+[ \t]*)?"  # begin of a block


_COMMENT = re.compile(
    r"(?<![A-Z]{2})(?<![A-Z]{2}\d\d)(?<![A-Z]{3}\d)\([^()\n]*\)|;[^\n]*"
)  # MSG( and CYCLE81( are none


class Sign(NamedTuple):
    """Sign of dialects: a pattern in upper case, in the text without comments (or in its comments, or in both)."""

    dialects: tuple[str, ...]
    weight: float
    pattern: str
    what: str
    where: str = "code"


SIGNS: tuple[Sign, ...] = (
    Sign(("heidenhain",), 12, r"^[ \t]*\d*[ \t]*BEGIN[ \t]+PGM", "BEGIN PGM"),
    Sign(("heidenhain",), 5, _B + r"(?:L[ \t]+[XYZABCQR][-+I\d]|TOOL (?:CALL|DEF)|CYCL DEF|BLK FORM|CALL LBL|FN[ \t]*\d+:|LBL[ \t]+\d)", "Klartext blocks"),
    Sign(("sinumerik",), 10, r"^%_N_|^;?\$PATH", "a Sinumerik header", "all"),
    Sign(("sinumerik",), 5, _B + r"(?:DEF[ \t]+(?:REAL|INT|BOOL|STRING|AXIS|FRAME)|A?TRANS\b|A?ROT[ \t]+[XYZR]|A?MIRROR\b|EXTERN\b|PROC\b|WORKPIECE[ \t]*\(|STOPRE\b|TRAFOOF\b|SUPA\b)", "Sinumerik words"),
    Sign(("sinumerik",), 5, r"\b(?:CYCLE\d+[ \t]*\(|POCKET\d[ \t]*\(|HOLES\d[ \t]*\(|MSG[ \t]*\(\"|CR[ \t]*=|AC[ \t]*\(|IC[ \t]*\()", "Sinumerik words with brackets"),
    Sign(("sinumerik",), 3, r"^[ \t]*(?:N\d+[ \t]*)?R\d+[ \t]*=|\bGOTO[FB]?[ \t]+[A-Z_]|\bIF[ \t]+[$R(]|\bT[ \t]*=[ \t]*\"|\bS\d*[ \t]*=[ \t]*\d|\bM17\b", "R parameters, GOTOF, T="),
    Sign(("okuma",), 12, r"^\$[ \t]*[\w.+()\[\] \t-]+\.(?:MIN|SSB|SUB|LIB|MSB)(?![A-Z])%?", "the name of an Okuma file at its head", "all"),
    Sign(("okuma",), 6, r"\bG8[5-7][ \t]*N[A-Z]|^[ \t]*N[A-Z][A-Z0-9]{0,3}[ \t]+[GXZTSM\d]|\bIF[ \t]*\[[^\]]*\][ \t]*N[A-Z0-9]|\bG56[ \t]*H", "sequence names and LAP"),
    Sign(("okuma",), 6, r"\bCALL[ \t]+O|\bVZOF[XZ]|\bG15[ \t]*H\d|\bLAP\b|\bV[CL]?\d*[ \t]*=|\bNOEX\b|\bMODIN\b|\bRTS\b", "words of Okuma"),
    Sign(("linuxcnc",), 8, _B + r"O[ \t]*(?:<[^>]*>|\d+)[ \t]*(?:SUB|CALL|IF|WHILE|DO|REPEAT|ENDSUB|RETURN)\b", "O-words"),
    Sign(("linuxcnc",), 6, r"#[ \t]*<\w+", "named parameters"),
    Sign(("linuxcnc",), 3, r"\bG(?:64[ \t]*P|59\.[123]|92\.[23]|33\.1|41\.1|42\.1|43\.2|61\.1)", "a code of LinuxCNC"),
    Sign(("linuxcnc",), 2, r"\((?:DEBUG|PRINT|PROBEOPEN|LOGOPEN|AXIS,)", "comments that LinuxCNC obeys", "all"),
    Sign(("linuxcnc", "mach3", "grbl"), 2, r"\bG(?:91\.1|90\.1|38\.[2345]|43\.1|92\.1|28\.1)", "a code of EMC and its kin"),
    Sign(("mach3",), 7, r"MACH[ ]?[34]\b|TORMACH|PATHPILOT", "the name of the control", "comments"),
    Sign(("mach3",), 3, r"\bG90[ \t]+G94[ \t]+G91\.1|G50[ \t]+G17|G64[ \t]+G50|G80[ \t]+G50|\bM47\b", "a header of Mach3"),
    Sign(("grbl",), 7, r"GRBL|SHAPEOKO|CARBIDE|X-?CARVE|EASEL|SNAPMAKER|MARLIN|NOMAD|FLUIDNC|UGS\b|ESTLCAM|CNCJS|JSCUT|FLATCAM|GCODETOOLS", "the name of the control", "all"),
    Sign(("grbl",), 12, r"#</", "settings of FluidNC as parameters"),
    Sign(("grbl",), 3, r"^[ \t]*\$(?:[HXGIN#$]\b|\d+=)|^[ \t]*[!~?][ \t]*$", "commands of a console"),
    Sign(("grbl", "linuxcnc", "mach3"), 2, r"^[^;(\n%]*;[ \t]*[A-Za-z(]|^[ \t]*;", "notes behind ;", "all"),
    Sign(("fanuc", "haas", "mazak", "fanuc-lathe", "haas-lathe"), 4, _B + r"(?:IF[ \t]*\[|WHILE[ \t]*\[|GOTO[ \t]*[\d#])|G65[ \t]*P|G66[ \t]*P|\bDPRNT|\bPOPEN", "macro B"),
    Sign(("fanuc", "haas", "mazak", "fanuc-lathe", "haas-lathe"), 3, r"\A\s*(?:%[ \t]*\s+)?[:O][ \t]*\d{3,}", "a program number at its head"),
    Sign(("fanuc", "haas", "mazak", "fanuc-lathe", "haas-lathe"), 1, r"\A\s*%[ \t]*$", "% at its head"),
    Sign(("fanuc", "haas", "mazak", "mach3", "fanuc-lathe", "haas-lathe"), 2, r"\bM98[ \t]*P|\bM99\b", "M98 and M99"),
    Sign(("fanuc", "haas", "mazak"), 2, r"\bG28[^\n]*G91|\bG91[^\n]*G28", "G28 and G91 in one block"),
    Sign(("fanuc", "haas", "mazak", "mach3"), 1.5, r"\bG43[^\n]*H\d|\bH\d+[^\n]*G43", "G43 H"),
    Sign(("fanuc",), 4, r"\bG0?5\.1[ \t]*Q|\bG54\.1[ \t]*P|\bG0?5[ \t]*P10000|\bG68\.2|\bG43\.[45]|\bG10\.6|#[ \t]*\d{6}\b", "codes of Fanuc"),
    Sign(("fanuc",), 1, r"[GXYZM]", "nothing but words that all controls have"),
    Sign(("fanuc",), 20, r"\bG291\b", "G291, the ISO mode of Sinumerik, which reads as Fanuc does"),
    Sign(("haas",), 6, r"\bG(?:154[ \t]*P|187\b|150\b|103\b|12[ \t][^\n]*I|13[ \t][^\n]*I|70[ \t]*I|71[ \t]*I|72[ \t]*I)|\bM97[ \t]*P|\bG47[ \t]*P", "codes of Haas"),
    Sign(("haas", "haas-lathe"), 6, r"\bHAAS\b|\bVF-?\d|\bST-?\d\dY?\b", "the name of the control", "comments"),
    Sign(("haas", "haas-lathe"), 2, r"\bG53[ \t]*G0+[ \t]*Z0|\bG0+[ \t]*G53[ \t]*Z0|SAFE ?START", "a header of Haas", "all"),
    Sign(("mazak",), 6, r"\bMAZAK|MAZATROL|\bVQC\b|VARIAXIS|INTEGREX", "the name of the control", "comments"),
    Sign(("mazak",), 5, r"\bT\d+[ \t]*T\d+[ \t]*M0?6|\bG61\.1\b[^\n]*\n(?s:.)*\bG43\b", "two tools before M6"),
    Sign((*MILLS, "fanuc-lathe-b"), 4, r"\bG9[01][ \t]*G0?[0-3](?!\d)|\bG0?[0-3][ \t]+G9[01](?![\d.])", "G90 or G91 with a motion"),
    Sign(LATHES, 5, r"\bG7[0-6][^\n]*P\d+[ \t]*Q\d+", "turning cycles with P and Q"),
    Sign(LATHES, 4, r"\bG50[ \t]*S\d|\bG28[ \t]*U|\bG0?0[ \t]*T\d{3,4}\b|^[ \t]*(?:N\d+[ \t]*)?T\d{4}\b", "words of a lathe"),
    Sign((*LATHES, "fanuc-lathe-b"), 3, r"\bG96[ \t]*S|\bG9[67]\b[^\n]*S\d", "constant cutting speed"),
    Sign(LATHES, 2, r"\bG99\b|\bG0?[01][^\n]*[UW][ \t]*[-+.\d]", "feed per turn, U and W"),
    Sign(("haas-lathe",), 6, r"\bG7[12][ \t]+P\d+[ \t]*Q\d+[^\n]*\bD[ \t]*\.?\d", "turning cycles in one block"),
    Sign(("fanuc-lathe-b",), 7, r"\bG92[ \t]*S\d", "G92 S"),
    Sign(("fanuc-lathe-b",), 3, r"\bG9[45]\b", "G94 and G95"),
    Sign(("fagor",), 20, r"^%[^,\n]{1,24},[ \t]*[MVX]{1,3}[ \t-]*,", "% with a name and attributes, as in %NAME,MX--,", "all"),
    Sign(("fagor",), 12, r"\bT\d+\.\d+[ \t]*(?:M0?6|$)", "tool and offset as T1.1"),
    Sign(("fagor",), 6, r"^%\d{5}[ \t]*$", "a five-digit number behind %"),
    Sign(("fagor",), 5, r"^[ \t]*\(RPT|^[ \t]*\(P\d+=|\bP\d+=P\d+|#PATH ORIGIN|\$IF\b", "Fagor words", "all"),
    # controls that are not here: named, and refused
    Sign(("Brother",), 20, r"\bG100[ \t]*T\d", "G100 T, which changes the tool and moves"),
    Sign(("NC-110 of Balt-System",), 14, r"^[ \t]*(?:N\d+[ \t]*)?\((?:UAO|UCG|UTO|DIS|UIO)[ \t]*,", "three-letter commands in brackets", "all"),
    Sign(("HEIDENHAIN DIN/ISO",), 14, r"^%[^\n]*\bG7[01][ \t]*\*?[ \t]*$|^N?\d+[ \t]+G99[ \t]+T\d+[ \t]+L", "% with G70 or G71 behind it, G99 T L"),
    Sign(("Acramatic of Cincinnati",), 14, r"^[ \t]*:?[ \t]*\((?:PGM|MSG)[ \t]*,[ \t]*NAME", "(PGM, NAME=", "all"),
    Sign(("a control with ACC words",), 14, r"\bACC[ \t]*\d+|^%NPG", "ACC and %NPG"),
    Sign(("BeagleG",), 12, r"#[A-Z]\w*[ \t]*=", "parameters with names as in #r=50"),
    Sign(("a list of blocks with a table",), 20, r"¶", "columns between ¶", "all"),
    Sign(("a protocol of a console",), 20, r"^(?:->|<-|<~) ", "arrows before its lines", "all"),
)  # fmt: skip
HERE = {
    "fanuc", "haas", "mazak", "fanuc-lathe", "fanuc-lathe-b", "haas-lathe", "linuxcnc", "mach3", "grbl", "sinumerik", "heidenhain", "okuma",
    "fagor",
}  # fmt: skip
ENDINGS: dict[str, tuple[tuple[str, ...], float]] = {
    "ngc": (("linuxcnc",), 8), "mpf": (("sinumerik",), 6), "spf": (("sinumerik",), 6), "arc": (("sinumerik",), 3), "h": (("heidenhain",), 6),
    "tap": (("mach3",), 1.5), "gcode": (("grbl",), 1), "eia": (("mazak",), 4), "min": (("okuma",), 8), "ssb": (("okuma",), 8),
    "sub": (("okuma",), 2), "lib": (("okuma",), 3),
}  # fmt: skip
SURE = 0.6  # of the best score: a runner-up at least so strong leaves doubt


@dataclass(frozen=True)
class Candidate:
    """A dialect, its score, and the signs of it in order of weight."""

    dialect: str
    score: float
    signs: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.dialect} ({self.score:g}: {', '.join(self.signs[:3]) or 'no sign'})"


def candidates(text: str, path: Path | None) -> list[Candidate]:
    """Return all dialects that a text has signs of, the best first."""
    views = _views(text[:READ].upper())
    signs_of: dict[str, list[tuple[float, str]]] = {}
    for sign in SIGNS:
        if _compile(sign.pattern).search(views[sign.where]):
            _add(signs_of, sign.dialects, sign.weight, sign.what)
    suffix = path.suffix.lstrip(".").lower() if path else ""
    if suffix in ENDINGS:
        dialects, weight = ENDINGS[suffix]
        _add(signs_of, dialects, weight, f"the file ends in .{suffix}")
    _axes(views["code"], signs_of)
    out = [
        Candidate(d, sum(w for w, _ in signs), tuple(what for _, what in sorted(signs, reverse=True)))
        for d, signs in signs_of.items()
    ]
    order = [s for sign in SIGNS for s in sign.dialects]
    return sorted(out, key=lambda c: (-c.score, order.index(c.dialect)))


@cache
def _compile(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern, re.MULTILINE)


def _views(text: str) -> dict[str, str]:
    """Return the text, without its comments, and its comments alone."""
    comments = re.findall(r"\([^()\n]*\)|;[^\n]*", text)
    plain = _COMMENT.sub("", _COMMENT.sub("", text))
    return {"all": text, "code": plain, "comments": "\n".join(comments)}


def _add(
    signs_of: dict[str, list[tuple[float, str]]], dialects: Iterable[str], weight: float, what: str
) -> None:
    for dialect in dialects:
        signs_of.setdefault(dialect, []).append((weight, what))


def _axes(code: str, signs_of: dict[str, list[tuple[float, str]]]) -> None:
    """Score the axes: a turning program has X and Z and no Y, unless a driven tool has its say; a milling program has Y."""
    x, y, z = (len(re.findall(rf"{a}[ \t]*[-+.\d#\[]", code)) for a in "XYZ")
    arcs = re.search(r"G0?[23](?!\d)[^\n]*[IK][ \t]*[-+.\d]", code)
    if x and z and not y:
        _add(signs_of, (*LATHES, "fanuc-lathe-b"), 4 if x > 3 or arcs else 2, "X and Z without Y")
    elif y > 0.05 * (x + z):
        for dialect in (*LATHES, "fanuc-lathe-b"):
            if dialect in signs_of:
                signs_of[dialect].append((-8.0, "Y words"))


def ranking_text(ranking: list[Candidate]) -> str:
    """Return the reason for the first dialect, and the runner-up; doubt is stated."""
    best = ranking[0]
    if best.score <= 1:
        return "nothing distinguishes it, so name it with --dialect where that is wrong"
    other = next((c for c in ranking[1:] if kin(c.dialect) != kin(best.dialect)), None)
    second = f"; runner-up {ranking[1]}" if len(ranking) > 1 else ""
    near = other is not None and other.score >= SURE * best.score
    doubt = ", so name it with --dialect where that is wrong" if near or best.score < 3 else ""
    if not doubt and unsure(ranking) and {best.dialect, ranking[1].dialect} == set(LATHES):
        doubt = ", which differs in words such as a bare G28 and G4 P1.: name the dialect with --dialect where they stand"
    return f"it has {', '.join(best.signs[:4])} (score {best.score:g}){second}{doubt}"


def kin(dialect: str) -> str:
    """Return the dialects with the same common words."""
    kin = {"mill": MILLS, "lathe": LATHES, "router": (*HOBBY, "linuxcnc")}
    return next((name for name, members in kin.items() if dialect in members), dialect)


def unsure(ranking: list[Candidate]) -> bool:
    """Return whether the runner-up is nearly as likely."""
    return len(ranking) > 1 and ranking[1].score >= SURE * ranking[0].score
