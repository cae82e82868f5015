"""Reader of Fagor programs of mills: it translates them into the words of the G-code family, which are read there.

Fagor 8055 and 8025 are translated block by block into as many lines as before, so that every line keeps its number.

Source: FAGOR, CNC 8055 Programming manual (M and EN models), "Canned cycles" (G81: Z is the reference plane, I the depth, K a dwell in hundredths
of a second; G83: I the peck, J how many, back to 1 mm before the depth reached), G04, G11 to G13, G36, G39, G73; CNC 8025 GP, M for T1.1 and times
in seconds. Parts that are not supported are noted by name and line, and left out: their moves are missing.

Pockets, G87 (rectangular) and G88 (circular), are rows of a table of cycles. Source: FAGOR, CNC 8055 Programming manual (M and EN models), 9.13 "G87. Rectangular pocket canned cycle"; CNC 8060 and 8070 for the sign of J: Z reference
plane, I depth, D from the plane to the part, J K half of length and width (G88: J radius), J+ clockwise, B infeed (positive: equal ones, no larger;
negative: as it is, the last the rest), C from ring to ring (3/4 of the diameter where it is left out), L left for a last way round at H, V feed of the infeed
(half of F). From the centre outwards, at each depth; then to the centre and on. How the rings follow one another and the tangential way onto the
last one are the control's own; an assumption says so.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from vcmm.program.clearing import PathPiece, circle, rectangle, shift_pieces
from vcmm.program.cutter import CycleCutter, equal_depths
from vcmm.program.cycle_tables import Cycle, Values, cycle, in_units
from vcmm.program.dialects import FANUC
from vcmm.program.drilling import Hole, depths_of
from vcmm.program.faults import ProgramFault
from vcmm.program.iso.program import run
from vcmm.program.levels import NOT_MOVED, Assumption
from vcmm.program.moves import Program
from vcmm.program.recorder import Recorder
from vcmm.program.setup import Setup, Tool

Ring = list[PathPiece]
GAP = 1.0  # mm above the milled surface, on the way to the centre
WORDS = "BCDHJKLV"
ROWS: dict[str, Cycle[str]] = {
    "87": cycle("J mm, K size, B mm, C size?, D size, H feed, L size, V feed", "rectangle"),
    "88": cycle("J mm, B mm, C size?, D size, H feed, L size, V feed", "circle"),
}


def mill(r: Recorder, hole: Hole, code: str, given: dict[str, float]) -> None:
    """Mill one pocket at the position of the tool at the reference plane. given: the words of its block."""
    row = ROWS[code]
    v = row.read(given, in_units(r.unit, 1.0))
    cutter, who = CycleCutter(r), f"G{code} of Fagor"
    r.tool_data = r.setup.tools.get(r.tool, Tool(r.tool))
    radius = cutter.radius(who)
    if not v["J"] or not v["B"] or (code == "87" and not v["K"]):
        r.fault(f"{who} needs J{', K' if code == '87' else ''} and B above or below zero; add them")
    step = v.without("C", 1.5 * radius)
    if radius and not 0.0 < step <= 2.0 * radius:
        r.fault(
            f"C of {who} is a way above zero and up to the diameter of the tool; the control stops here, correct it"
        )
    half = [abs(v["J"]), v["K"]] if code == "87" else [abs(v["J"])]
    if min(half) < radius + v["L"]:
        r.fault(
            f"the tool does not fit into the pocket of {who}: {min(half):g} mm to its side; take a smaller one"
        )
    r.assume(
        f"how {who} clears", "in rings from the centre outwards, straight onto the last one",
        f"how {who} clears is the control's own affair and not known; write its motion with G1 to G3",
    )  # fmt: skip
    top = hole.clearance - v["D"]
    rough, last = (
        _rings(half, radius + v["L"], step, v["J"] > 0),
        _rings(half, radius, 0.0, v["J"] > 0) if v["L"] else [],
    )
    _levels(cutter, v, (rough, last), (hole.clearance, _depths(v["B"], top, hole.bottom)))
    hole.leave()


def _depths(infeed: float, top: float, bottom: float) -> list[float]:
    return equal_depths(top, bottom, infeed) if infeed > 0 else depths_of(top, bottom, -infeed)


def _rings(half: Sequence[float], off: float, step: float, clockwise: bool) -> Ring:
    """Return the rings about the middle up to `off` from the wall; the last one alone where step is zero."""
    if len(half) == 1:
        return circle(half[0] - off, step, clockwise)
    return rectangle((half[0] - off, half[1] - off), step, clockwise=clockwise)


def _levels(
    cutter: CycleCutter, v: Values, rings: tuple[Ring, Ring], heights: tuple[float, Sequence[float]]
) -> None:
    """Mill all infeeds, from the middle."""
    r, middle = cutter.recorder, cutter.here()
    plane, depths = heights
    feed = r.feed or 0.0
    for k, depth in enumerate(depths):
        if k:
            cutter.to(None, min(depths[k - 1] + GAP, plane), True)
            cutter.to(middle, None, True)
        with cutter.feed_at(v["V"] or feed / 2.0):
            cutter.to(None, depth, False)
        cutter.follow(shift_pieces(rings[0], middle), depth)
        with cutter.feed_at(v["H"]):
            cutter.follow(shift_pieces(rings[1], middle), depth)
    cutter.to(None, min(depths[-1] + GAP, plane), True)
    cutter.to(middle, None, True)


UNCHANGED_CODES = {
    "0", "1", "2", "3", "17", "18", "19", "40", "41", "42", "43", "44", "54", "55", "56", "57", "58", "59", "53", "70", "71", "80", "90", "91", "92",
    "94", "95", "96", "97", "98", "99",
}  # fmt: skip
READ_CODES = {
    "4",
    "10",
    "11",
    "12",
    "13",
    "36",
    "39",
    "73",
}  # with a meaning of their own, which is translated
CORNERS = {"5", "7", "50", "51"}  # how a corner is passed, look-ahead: the programmed path stays
UNREAD = {"69"}  # in force until G80, and not read
ZONES = {"20", "21", "22"}
HOLES = {"81", "82", "83", "84", "85", "86", "87", "88", "89"}
MEANINGS = {
    "6": "absolute centres of arcs", "8": "an arc that goes on in tangent", "9": "an arc through three points", "14": "mirroring of programmed axes",
    "16": "a main plane of two axes", "33": "a thread", "37": "a tangential entry", "38": "a tangential exit", "69": "deep drilling with steps of its own",
    "72": "scaling", "74": "the way home", "75": "probing", "76": "probing", "79": "a change of a canned cycle",
    "93": "a polar origin", "60": "machining on a line", "61": "machining in a parallelogram", "62": "machining in a grid", "63": "machining on a circle",
    "64": "machining on an arc", "65": "machining on a chord",
}  # fmt: skip
_WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))?")
_STATEMENT = re.compile(
    r"\(\s*(?:IF|GOTO|RPT|CALL|PCALL|MCALL|MDOFF|SUB|RET|ERROR|WRITE|KEY|SYMBOL|WBUF|P\d+\s*=|MSG|DIGIT|TRACE|OPEN|NEXEC)",
    re.IGNORECASE,
)
_COMMENT = re.compile(r"\([^()\n]*\)|;.*")
LENGTHS = "XYZABCIJKRQ"  # 10 is 10 mm here, with and without its point
Words = list[tuple[str, str]]


@dataclass(eq=False)
class FagorLines:
    """A text under way. assumptions: line, the omitted word, its replacement."""

    text: str
    assumptions: list[tuple[int, str, str]] = field(default_factory=list)
    offset: str = ""  # number of the tool offset in force: that of T1.1 and D1, else of the tool
    at_t: bool = False  # no M6 in the text: T itself puts the tool into the spindle
    length: bool = False  # G43 is in force
    old: bool = False  # 8025: T1.1, times in seconds
    absolute: bool = True
    cycle: str = ""  # in force
    pockets: list[tuple[str, dict[str, float]]] = field(
        default_factory=list
    )  # code and words of each G87 and G88

    def __post_init__(self) -> None:
        code = _COMMENT.sub("", self.text).upper()
        self.old = re.search(r"T\s*\d+\.\d+", code) is not None
        self.at_t = re.search(r"M\s*0?6(?!\d)", code) is None

    def translate(self) -> str:
        """Return the whole text in words of the G-code family."""
        lines = self.text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        return "\n".join(self.block(k + 1, line) for k, line in enumerate(lines))

    def tell(self, line: int, what: str, value: str = NOT_MOVED) -> str:
        """Keep one remark for each, and return the emptied block."""
        if all(what != w for _, w, _ in self.assumptions):
            self.assumptions.append((line, what, value))
        return ""

    def block(self, line: int, text: str) -> str:
        """Translate one line: % NAME, statements in brackets, words."""
        if text.lstrip().startswith("%"):
            return "%"
        statement = _STATEMENT.search(text)
        if statement:
            name = re.sub(r"[^A-Z]", "", statement[0].upper())
            if name in ("MSG", "DIGIT", "TRACE", "SYMBOL", "WBUF", "OPEN"):
                return ""
            return self.tell(line, f"({name or 'P'} ...), a statement of high-level language")
        code = _COMMENT.sub("", text).strip().upper()
        skip = "/" if code.startswith("/") else ""
        code = re.sub(r"^/\d?\s*", "", code)
        words = [(m[1], m[2] or "") for m in _WORD.finditer(code)]
        if not words or "".join(re.sub(r"[-+.\w\s]", "", code)):
            return self.tell(line, f"the block {code}") if code else ""
        made = (
            (letter, number + "." * (letter[-1] in LENGTHS and number.lstrip("+-").isdigit()))
            for letter, number in self.words(line, words)
        )
        return skip + " ".join(letter + number for letter, number in made)

    def words(self, line: int, words: Words) -> Words:
        """Return the words of a block as the G-code family has them."""
        if words and words[0][0] == "N":
            words = words[1:] if not words[0][1] else words
        if not all(number for _, number in words):  # wrong in itself: the reader says so
            return words
        codes = {n.lstrip("0") or "0" for letter, n in words if letter == "G"}
        values = {letter: n for letter, n in words if letter != "G"}
        self.absolute = "91" not in codes and (self.absolute or "90" in codes)
        if (
            codes & ZONES and not self.old and not set(values) & set("XYZ")
        ):  # limits of a work zone move nothing
            words, codes = [w for w in words if w[0] != "G" or w[1].lstrip("0") not in ZONES], codes - ZONES
        for code in sorted(codes):
            self.cycle = code if code in UNREAD else self.cycle
            if code in MEANINGS:
                self.tell(line, f"G{code} of Fagor, {MEANINGS[code]}")
                return []
            if code not in UNCHANGED_CODES | CORNERS | HOLES | READ_CODES:
                self.tell(line, f"G{code} of Fagor")
                return []
        if (
            self.cycle
            and not codes & (HOLES | {"80"})
            and (
                codes & {"0", "1", "2", "3"}
                or set("ZIJK") & set(values)
                or (self.cycle in UNREAD and set("XY") & set(values))
            )
        ):
            self.tell(
                line,
                f"a block behind G{self.cycle} of Fagor and before G80 that is no plain X Y: whether it changes the cycle or moves alone",
            )
            return []
        self.cycle = "" if "80" in codes else next(iter(codes & HOLES), self.cycle)
        if "Q" in values and "R" in values and not codes & {"73"}:
            self.tell(line, "polar coordinates (R Q)")
            return []
        out: Words = []
        special = codes & {"4", "10", "11", "12", "13", "73"}
        for letter, number in words:
            code = number.lstrip("0") or "0"
            if letter == "G" and (code in CORNERS or code in special or code in ("36", "39")):
                continue
            out += self.word(letter, number)
        out += self.length_words(words, codes)
        if special:
            return self.alone(line, special.pop(), out, values)
        if codes & HOLES:
            return self.hole(line, out, codes, values)
        if codes & {"36", "39"}:  # a corner at the end of this block
            out = [w for w in out if w[0] != "R"] + [(",R" if "36" in codes else ",C", values.get("R", ""))]
        return out

    def word(self, letter: str, number: str) -> Words:
        """Translate one word: T1.12 and T1 D12 name a tool and its offset; G41, G42 and G43 take that offset, and G43 in force the next one too."""
        code = number.lstrip("0")
        if letter == "T":
            tool, _, offset = number.partition(".")
            self.offset = offset.lstrip("0") or tool
            return [("T", tool), *([("M", "6")] if self.at_t else [])]
        if letter == "D":
            self.offset = code or "0"
            return []
        if letter == "G" and code in ("41", "42", "43"):
            self.length = self.length or code == "43"
            return [("G", number), *([("H" if code == "43" else "D", self.offset)] if self.offset else [])]
        self.length = self.length and not (letter == "G" and code == "44")
        return [(letter, number)]

    def length_words(self, words: Words, codes: set[str]) -> Words:
        """Return the length of the offset that comes into force with this block, where G43 is in force; the block may say G43 itself."""
        letters = {letter for letter, n in words if letter != "M" or (n.lstrip("0") == "6")}
        comes = letters & ({"T", "D", "M"} if self.at_t else {"D", "M"})
        return (
            [("G", "43"), ("H", self.offset)]
            if comes and self.length and self.offset and not codes & {"43", "44"}
            else []
        )

    def alone(self, line: int, code: str, out: Words, values: dict[str, str]) -> Words:
        """Translate codes that have a block of their own: a dwell, mirrors, a turn of the pattern."""
        number = [w for w in out if w[0] == "N"]
        if code == "4":
            if set(values) & set("XYZ"):
                self.tell(line, "G4 of Fagor beside X, Y or Z")
                return []
            if not values.get("K"):
                return number  # blocks are not prepared ahead
            return [*number, ("G", "4"), ("P", _text(float(values["K"]) * (1000.0 if self.old else 10.0)))]
        if [w for w in out if w[0] not in ("N", "Q", "I", "J", "M")]:
            self.tell(line, f"G{code} of Fagor beside other words")
            return []
        if code == "10":
            return [*number, ("G", "50.1"), ("X", "0"), ("Y", "0"), ("Z", "0")]
        if code in ("11", "12", "13"):
            return [*number, ("G", "51.1"), ("XYZ"[int(code) - 11], "0")]
        if not self.absolute:
            self.tell(line, "G73 of Fagor under G91")
            return []
        if not values.get("Q"):
            return [*number, ("G", "69")]
        return [
            *number,
            ("G", "68"),
            ("X", values.get("I", "0")),
            ("Y", values.get("J", "0")),
            ("R", values["Q"]),
        ]

    def pocket(self, line: int, code: str, kept: Words, values: dict[str, str]) -> Words:
        """Translate a pocket: G87 and G88 become G287 with the number of their words in Q."""
        if "I" not in values or (self.absolute and "Z" not in values):
            self.tell(line, f"G{code} of Fagor without Z and I")
            return []
        self.pockets.append((code, {k: float(n) for k, n in values.items() if k in WORDS}))
        plain = [w for w in kept if w[0] not in WORDS and not (w[0] == "G" and w[1].lstrip("0") == code)]
        number, plain = [w for w in plain if w[0] == "N"], [w for w in plain if w[0] != "N"]
        made = [*number, ("G", "287"), *plain, ("Q", f"{len(self.pockets)}."), ("Z", values["I"])]
        return [*made, ("R", values["Z"])] if "Z" in values else made

    def hole(self, line: int, out: Words, codes: set[str], values: dict[str, str]) -> Words:
        """Translate a hole: G81 to G89: Z is the reference plane (R), I the depth (Z). G83: J pecks of I each below Z."""
        repeat = [n for letter, n in out[1:] if letter == "N"]
        if repeat:
            self.tell(line, f"N{repeat[0]} behind a canned cycle of Fagor, repeats")
            return []
        words = [w for w in out if w[0] not in "ZIJK"]
        if codes & set(ROWS):
            return self.pocket(line, (codes & set(ROWS)).pop(), words, values)
        if "I" not in values or (
            "83" in codes and ("J" not in values or (self.absolute and "Z" not in values))
        ):
            self.tell(
                line, f"G{(codes & HOLES).pop()} of Fagor without {'Z, I and J' if '83' in codes else 'I'}"
            )
            return []
        if "Z" in values:
            words.append(("R", values["Z"]))
        if "83" in codes:
            peck = abs(float(values["I"]))
            deep = peck * abs(float(values["J"]))
            return [
                *words,
                ("Z", _text((float(values["Z"]) if self.absolute else 0.0) - deep)),
                ("Q", _text(peck)),
            ]
        words.append(("Z", values["I"]))
        if values.get("K"):
            words.append(("P", _text(float(values["K"]) * (1000.0 if self.old else 10.0))))
            words = [("G", "82") if w[0] == "G" and w[1].lstrip("0") == "81" else w for w in words]
        return words


def _text(value: float) -> str:
    return f"{value:.6f}".rstrip("0").rstrip(".")


MILL = replace(
    FANUC, name="fagor", codes="fagor", peck_clearance=1.0
)  # G83: back to 1 mm before the depth reached


def _pocket(code: str, given: dict[str, float]) -> Callable[[Recorder, Hole], None]:
    """Return a pocket with its words."""
    return lambda r, hole: mill(r, hole, code, given)


def read(text: str, file: str, setup: Setup, trace: bool = False) -> Program:
    """Return the moves of a program. Raises ProgramFault for one of a lathe, and for what cannot be understood; columns are those of the
    line as it is read."""
    code = re.sub(r"\([^)\n]*\)|;.*|^%.*", "", text.upper(), flags=re.MULTILINE)
    if (
        re.search(r"X\s*[-+.\d]", code)
        and re.search(r"Z\s*[-+.\d]", code)
        and not re.search(r"Y\s*[-+.\d]", code)
    ):
        raise ProgramFault(
            file,
            1,
            1,
            "X and Z without Y: a Fagor program of a lathe (T model), which is not here; have it posted for fanuc-lathe",
        )
    lines = FagorLines(text)
    made = lines.translate()
    if setup.strict and lines.assumptions:
        line, what, _ = min(lines.assumptions)
        raise ProgramFault(file, line, 1, f"{what} is not understood; write its motion with G1 to G3")
    language = replace(MILL, pockets=tuple(_pocket(code, given) for code, given in lines.pockets))
    program = run(
        made, language, replace(setup, unit=setup.unit or 1.0), file, trace
    )  # a Fagor wakes up in mm: G71
    assumptions = [Assumption(line, what, value) for line, what, value in lines.assumptions]
    return replace(program, assumed=tuple(sorted([*program.assumed, *assumptions], key=lambda a: a.line)))
