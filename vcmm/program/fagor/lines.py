"""Fagor 8055 and 8025, block by block, in the words of the G-code family: as many lines as before, so that every line keeps its number.

Source: FAGOR, CNC 8055 Programming manual (M and EN models), "Canned cycles" (G81: Z is the reference plane, I the depth, K a dwell in hundredths
of a second; G83: I the peck, J how many, back to 1 mm before the depth reached), G04, G11 to G13, G36, G39, G73; CNC 8025 GP, M for T1.1 and times
in seconds. Pockets: `pockets`. Unsupported parts are noted by name and line, and left out: its moves are missing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from vcmm.program.fagor.pockets import ROWS, WORDS

HOLE = "a hole in the path: its moves are missing"
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

    def tell(self, line: int, what: str, value: str = HOLE) -> str:
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
        """The length of the offset that comes into force with this block, where G43 is in force; the block may say G43 itself."""
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
