"""Reader of Okuma OSP programs: it translates them into the words of the G-code family, which are read there.

Programs are translated line by line into as many lines as before, so that every line keeps its number.

Source: Okuma, OSP-P200L / P20L Programming Manual 5238-E, "Lathe auto-programming function (LAP)", "User task", "Mathematical operation
functions"; OSP-P200M Programming Manual for G15, G56, G71 and M52 to M54. Parts that are not supported are noted, and left out.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

from vcmm.program.dialects import FANUC, FANUC_LATHE_B
from vcmm.program.faults import ProgramFault
from vcmm.program.iso.program import run
from vcmm.program.levels import NOT_MOVED, Assumption
from vcmm.program.moves import Program
from vcmm.program.okuma.names import OkumaNames, is_system
from vcmm.program.setup import Setup

_COMMENT = re.compile(r"\([^)\n]*\)")
_ASSIGNMENT = re.compile(r"(?<![A-Z0-9])([A-Z]{2,5}\d*|V(?:C|S)?\d+|P[A-Z])\s*=", re.IGNORECASE)
_ASSIGN = re.compile(r"([A-Z]{2,5}\d*|V(?:C|S)?\d+)(?:\s*\[([^\]]*)\])?\s*=\s*(.+)", re.IGNORECASE)
_CALL = re.compile(r"CALL\s+O(\w+)\s*(.*)", re.IGNORECASE)
_ARGUMENT = re.compile(r"([A-Z]{2,5}\d*)\s*=\s*([^\s=]+(?:\s*\[[^\]]*\])?)|Q(\d+)", re.IGNORECASE)
_JUMP = re.compile(r"(?:GOTO\s*)?N(\w+)\s*\Z", re.IGNORECASE)
_WORD = re.compile(
    r"(?<![A-Z])([A-Z])\s*=\s*((?:\[[^\]]*\]|[-+]?[\w.#]+)(?:\s*[-+*/]\s*(?:\[[^\]]*\]|[\w.#]+))*)",
    re.IGNORECASE,
)
_NAME = re.compile(r"\s*(/?\d?\s*)N([A-Z][A-Z0-9]{0,3}|\d+)(?=\s|\Z|[A-Z])", re.IGNORECASE)
_TITLE = re.compile(r"\s*O([A-Z0-9]{1,5})\s*\Z", re.IGNORECASE)
_G85 = re.compile(r"G8([567])\s*N(\w+)\s*(.*)", re.IGNORECASE)
_IDLE = ("DRAW", "CLEAR", "DEF", "PS", "PT", "CO", "END", "PRINT", "PUT", "WRITE", "READ", "TITLE")
LEFT_OUT = ("MODIN", "MODOUT", "NCYL", "OMIT", "RESTART")
MILL_CODES = {
    "30": ("G30 of Okuma", NOT_MOVED), "11": ("G11 (the coordinates are shifted and turned, until G10)", "passed over: what follows lies where it lay"),
    "62": ("G62 (mirrored axes)", "passed over: what follows is not mirrored"),
}  # fmt: skip
MILL_HAS = {  # codes of OSP-P200M and P300M that mean what they mean in the family, or are brought into its words here
    *range(5), 9, 10, 11, 15, 16, *range(17, 24), 30, 31, 40, 41, 42, 50, 51, 53, 56, 60, 61, 62, 64, 71, 73, 74, 76, *range(80, 88), *range(89, 93), *range(94, 98), 116,
}  # fmt: skip
ALONG = {"54": "X", "55": "Y", "57": "the fourth axis", "58": "the fifth axis", "59": "the sixth axis"}
LATHE_HAS = {
    *range(5), 9, 13, 14, *range(17, 36), 40, 41, 42, 50, 61, 62, 64, 65, *range(71, 79), *range(80, 89), 90, 91, *range(94, 98), *range(100, 200),
}  # fmt: skip
_NUMBER = re.compile(r"(?<![A-Z])G0*(\d+)(\.\d)?")
_G = r"(?<![A-Z])G"  # of a code, also right behind a number: N10G71
CYCLES = {"1": "G71", "2": "G72"}


@dataclass(eq=False)
class OkumaLines:
    """A text under way. assumptions: omissions and assumptions: line, what, value, whether the path depends on it."""

    text: str
    lathe: bool
    names: OkumaNames = field(init=False)
    assumptions: list[tuple[int, str, str, bool]] = field(default_factory=list)
    contours: dict[str, tuple[int, int, str]] = field(
        default_factory=dict
    )  # label -> first block, last block, G71 or G72
    marks: dict[int, str] = field(default_factory=dict)  # line -> the block number or jump that it gets
    tool: int = 0

    def __post_init__(self) -> None:
        code = _COMMENT.sub("", self.text).upper()
        self.names = OkumaNames(frozenset(m[1] for m in _ASSIGNMENT.finditer(code)))

    def tell(self, line: int, what: str, value: str, matters: bool = True) -> None:
        if all(what != t[1] for t in self.assumptions):
            self.assumptions.append((line, what, value, matters))

    def translate(self) -> str:
        """Return all lines in words of the G-code family. A line that begins with $ goes on with the one before."""
        lines = self.text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        for k in range(len(lines)):
            if lines[k].lstrip().startswith("$"):
                rest = lines[k].lstrip()[1:]
                lines[k] = ""
                if k and "%" not in rest:
                    lines[k - 1] += " " + rest
        self._find_contours(lines)
        return "\n".join(self._line(k, line) for k, line in enumerate(lines))

    def _find_contours(self, lines: list[str]) -> None:
        """Find contours: NLAP1 G81 ... G80: the blocks between are the contour; the flow jumps over them."""
        start: tuple[int, str, str] | None = None
        for k, line in enumerate(lines):
            code = _COMMENT.sub("", line).upper()
            head = re.match(r"\s*N([A-Z0-9]+)\s+(?:G83\s+)?G8([12])\b\s*\Z", code)
            if head:
                start = (k, head[1], head[2])
            elif start is not None and re.search(rf"{_G}80(?!\d)", code):
                first, last = (self.names.label(f"{start[1]}.{n}") for n in ("A", "B"))
                self.contours[start[1]] = (first, last, CYCLES[start[2]])
                number = self.names.label(start[1])
                self.marks[start[0]] = f"N{number} GOTO {last}"
                self.marks[start[0] + 1] = f"N{first}"
                self.marks[k] = f"N{last}"
                start = None

    def _line(self, k: int, line: str) -> str:
        notes = "".join(_COMMENT.findall(line))
        code = _COMMENT.sub(" ", line)
        mark = self.marks.get(k, "")
        if mark and ("GOTO" in mark or re.search(rf"{_G}80(?!\d)", code.upper())):
            return mark + notes
        if mark:
            code = f"{mark} {_NAME.sub('', code)}"
        return self._code(k + 1, code) + notes

    def _code(self, line: int, code: str) -> str:
        """Return one line without its comments."""
        title = _TITLE.match(code)
        if title:
            return f"O{self.names.program(title[1])}"
        head = _NAME.match(code)
        before = f"{head[1]}N{self.names.label(head[2])} " if head else ""
        rest = (code[head.end() :] if head else code).strip()
        upper = rest.upper()
        word = re.match(r"[A-Z]*", upper)
        first = word[0] if word else ""
        if first == "NOEX":
            return before + self._code(line, rest[4:])
        if first in LEFT_OUT or (first in _IDLE and "=" not in upper):
            self.tell(line, first, "passed over", first in LEFT_OUT)
            return before
        if first == "RTS":
            return before + "M99"
        if match := _CALL.match(rest):
            return before + self._call(match)
        if first == "GOTO" and (match := _JUMP.match(rest)):
            return f"{before}GOTO {self.names.label(match[1])}"
        if first == "IF":
            return before + self._if(rest)
        if match := _ASSIGN.match(rest):
            return before + self._assign(line, match)
        if match := _G85.match(rest):
            return before + self._lap(line, match)
        return before + self._words(line, rest)

    def _call(self, match: re.Match[str]) -> str:
        """Translate CALL OSUB PAXI=4 Q2: the variables, and the subprogram so often."""
        sets, times = [], ""
        for a in _ARGUMENT.finditer(match[2]):
            if a[3]:
                times = f" L{a[3]}"
            else:
                sets.append(f"#{self.names.variable(a[1])}=[{self.names.value(a[2])}]")
        return f"{' '.join(sets)} M98 P{self.names.program(match[1])}{times}".strip()

    def _if(self, rest: str) -> str:
        """Translate IF [V1 EQ 5] N10, IF [..] GOTO NEND."""
        depth, end = 0, len(rest)
        for at, sign in enumerate(rest, 1):
            depth += (sign == "[") - (sign == "]")
            if sign == "]" and depth == 0:
                end = at
                break
        condition, then = rest[2:end], rest[end:].strip()
        match = _JUMP.match(then)
        goal = f"GOTO {self.names.label(match[1])}" if match else then
        return f"IF{self.names.value(condition)} {goal}"

    def _assign(self, line: int, match: re.Match[str]) -> str:
        name = match[1].upper()
        if is_system(name):
            label = f"{name}[{match[2]}]" if match[2] else name
            self.tell(line, f"the setting of {label}", "passed over")
            return ""
        if name == "HP":
            self.tell(line, "the home position", NOT_MOVED)
            return ""
        return f"#{self.names.variable(name)}=[{self.names.value(match[3])}]"

    def _lap(self, line: int, match: re.Match[str]) -> str:
        """Translate G85 NLAP1 D4 F0.3 U0.2 W0.1: D and U are diameters; G87 NLAP1 finishes."""
        label = match[2].upper()
        if label not in self.contours:
            self.tell(line, f"the contour {label} of LAP", NOT_MOVED)
            return ""
        first, last, code = self.contours[label]
        if match[1] == "7":
            return f"G70 P{first} Q{last} {self._words(line, match[3])}"
        if match[1] == "6":
            self.tell(line, "G86 (copy turning)", NOT_MOVED)
            return ""
        words = dict(re.findall(r"([A-Z])\s*=?\s*([-+]?[\d.]+)", re.split(r"G84", match[3].upper())[0]))
        depth = float(words.pop("D", 0.0)) / 2.0
        return " ".join(
            [
                code,
                f"P{first}",
                f"Q{last}",
                f"D{depth:.4f}",
                *(f"{k}{v}" for k, v in words.items() if k in "UWFS"),
            ]
        )

    def _words(self, line: int, rest: str) -> str:
        """Translate X=V1 is X[#601]; codes that the family writes in another way."""
        code = _WORD.sub(lambda m: f"{m[1]}[{self.names.value(m[2])}]", rest)
        return self._lathe(line, code) if self.lathe else self._mill(line, code)

    def _lathe(self, line: int, code: str) -> str:
        """Translate G50 S, G4 F, T010203, L as radius of an arc; G20 HP is the home position."""
        code = code.upper()
        self._tell_others(line, code, LATHE_HAS)
        code = re.sub(rf"{_G}50(?!\d)(?=.*S)", "G92", code)
        code = re.sub(r"(?<![A-Z])T(\d\d)(\d\d\d\d)(?!\d)", r"T\2", code)
        if re.search(rf"{_G}0?[23](?!\d)", code):
            code = re.sub(r"(?<![A-Z])L(?=[-+.\d\[])", "R", code)
        if match := re.search(rf"{_G}20(?!\d).*HP|{_G}13\d", code):
            self.tell(line, match[0].split()[0], NOT_MOVED)
            return ""
        if match := re.search(rf"{_G}7([56])(?!\d)", code):
            return self._corner(line, code, match[1] == "6")
        if match := re.search(rf"{_G}3([1235])(?!\d)", code):
            return self._thread(line, code, match[1])
        spindle = re.search(
            rf"{_G}14([01])(?!\d)", code
        )  # which holds the part: of the family G15 the first, G14 the second
        code = re.sub(rf"{_G}(?:1[34]|14[01])(?!\d)", "", code)  # which turret and which spindle
        code += "" if spindle is None else " G14" if spindle[1] == "1" else " G15"
        if match := re.search(r"(?<![A-Z])(G7[1-478]|G8[3-68]|G1[78]\d)(?!\d)", code):
            self.tell(line, f"the cycle {match[1]}", NOT_MOVED)
            return ""
        return _dwell(code)

    def _tell_others(self, line: int, code: str, codes: set[int]) -> None:
        """Note codes of the family that an OSP control has not, or that mean something else on it."""
        for number, point in _NUMBER.findall(code):
            if int(number) not in codes or point:
                what = f"G{number}{point} (no code of an OSP control in that sense)"
                self.tell(line, what, "read as on a FANUC")

    def _corner(self, line: int, code: str, is_round: bool) -> str:
        """Translate G75 G1 X20 L2 and G76 G1 Z-10 L2: the corner at the end of the block is cut, rounded; the sign of L is the way of the next block."""
        code = re.sub(rf"{_G}7[56](?!\d)", "", code)
        size = re.search(r"(?<![A-Z])L\s*([-+]?[\d.]+)", code)
        if size is None or re.search(r"(?<![A-Z])[AIK]\s*[-+.\d\[]", code):
            self.tell(line, f"G7{6 if is_round else 5} without L, or at an angle", NOT_MOVED)
            return ""
        word = f",{'R' if is_round else 'C'}{abs(float(size[1])):g}"
        return code.replace(size[0], word + ("" if "." in word else "."))

    def _thread(self, line: int, code: str, number: str) -> str:
        """Translate G31 and G33: a whole pass of a longitudinal thread, there and back, as G78 of the family; F/J is the lead. Source: OSP-P200L
        Programming Manual, "Fixed thread cutting cycle: longitudinal"."""
        if number in "25" or re.search(r"(?<![A-Z])[AEIK]\s*[-+.\d\[]", code):
            self.tell(
                line, f"G3{number} of Okuma" + (" with A, E, I or K" if number in "13" else ""), NOT_MOVED
            )
            return ""
        code = re.sub(rf"{_G}3[13](?!\d)", "G78", code)
        starts, lead = (re.search(rf"(?<![A-Z]){c}\s*([\d.]+)", code) for c in "JF")
        if starts and lead:
            code = code.replace(starts[0], "").replace(lead[0], f"F{float(lead[1]) / float(starts[1]):g}")
        for letter, what in (("L", "the pull-out L of a thread"), ("C", "the phase C of a thread")):
            word = re.search(rf"(?<![A-Z]){letter}\s*[-+]?[\d.]+", code)
            if word:
                self.tell(line, f"{what} of Okuma", "passed over", False)
                code = code.replace(word[0], "")
        return code

    def _mill(self, line: int, code: str) -> str:
        """Translate G15 H (work offset), G56 H (length of the tool), G53 (no length), G71 and M52 to M54 (where cycles return to)."""
        code = code.upper()
        for number, axis in ALONG.items():
            if re.search(rf"{_G}{number}(?!\d)", code):
                self.tell(line, f"G{number} of Okuma (the length of the tool along {axis})", "passed over")
                code = re.sub(rf"{_G}{number}(?!\d)", "", code)
        self._tell_others(line, code, MILL_HAS)
        if match := re.search(r"(?<![A-Z])T(\d+)", code):
            self.tool = int(match[1])
        if re.search(rf"{_G}116(?!\d)", code):  # the tool change
            code = re.sub(rf"{_G}116(?!\d)", "", code) + " M6"
        code = re.sub(rf"{_G}1([56])\s*H(\d+)", lambda m: self._offset(line, m[1] == "6", int(m[2])), code)
        if re.search(rf"{_G}56(?!\d)", code):
            code = re.sub(r"(?<![A-Z])H[A-Z](?!\d)", f"H{self.tool}", re.sub(rf"{_G}56(?!\d)", "G43", code))
        code = re.sub(rf"{_G}53(?!\d)", "G49", code)
        if re.search(rf"{_G}71(?!\d)", code) and not re.search(rf"{_G}8\d(?!\d)", code):
            self.tell(line, "G71 (level to which cycles return)", "the level before the cycle")
            return ""
        code = re.sub(r"(?<![A-Z])M5[23](?!\d)", "G98", re.sub(r"(?<![A-Z])M54(?!\d)", "G99", code))
        for number, (what, value) in MILL_CODES.items():
            if re.search(rf"{_G}{number}(?!\d)", code):
                self.tell(line, what, value)
                return ""
        return _dwell(code)

    def _offset(self, line: int, once: bool, number: int) -> str:
        if once:
            self.tell(line, "G16 (work offset for one block)", "kept, as with G15")
        return f"G{53 + number}" if 1 <= number <= 6 else f"G54.1 P{max(number - 6, 1)}"


def _dwell(code: str) -> str:
    """Translate a dwell: G4 F2 and G4 P2. are seconds."""
    return re.sub(r"\b(G0?4)\s*F", r"\1 P", code)


MILL = replace(FANUC, name="okuma", dwell=1.0)
LATHE = replace(FANUC_LATHE_B, name="okuma", codes="lathe-b", dwell=1.0, part_spindles={"G14": 2, "G15": 1})


def read(text: str, file: str, setup: Setup, trace: bool = False) -> Program:
    """Return the moves of a program. Without Y, and without a work offset G15 H, it is one of a lathe: X counts diameters.

    Raises ProgramFault for what cannot be understood; its columns are those of the line as it is read.
    """
    lathe = is_turning(text)
    lines = OkumaLines(text, lathe)
    made = lines.translate()
    assumptions = [
        Assumption(line, what, value, matters=matters) for line, what, value, matters in lines.assumptions
    ]
    assumptions += [Assumption(1, f"the value of {name}", "0") for name in lines.names.read]
    lost = [a for a in assumptions if a.matters]
    if setup.strict and lost:
        first = min(lost, key=lambda a: a.line)
        raise ProgramFault(file, first.line, 1, f"{first.what} is not known here; give it in the program")
    program = run(made, LATHE if lathe else MILL, setup, file, trace)
    names = {number: name for name, number in lines.names.programs.items()}
    assumed = [a._replace(what=_program_name(a.what, names)) for a in program.assumed]
    return replace(program, assumed=tuple(sorted([*assumed, *assumptions], key=lambda a: a.line)))


def is_turning(text: str) -> bool:
    """Return whether a program turns: X and Z without Y, no work offset of a mill."""
    code = re.sub(r"\([^)\n]*\)", "", text.upper())
    mill = re.search(r"\bG1[56]\s*H|\bG56\s*H|(?<![A-Z])Y[-+.\d\[=]", code)
    return mill is None and re.search(r"(?<![A-Z])X[-+.\d\[=]", code) is not None


def _program_name(what: str, programs: dict[int, str]) -> str:
    """Return the name of a program instead of the number that it was given."""
    return re.sub(r"\bO(\d+)\b", lambda m: f"O{programs.get(int(m[1]), m[1])}", what)
