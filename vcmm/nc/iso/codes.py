"""G and M codes by modal group, and the words of one block sorted by them. Two codes of one group are refused."""

from __future__ import annotations

from vcmm.core.errors import did_you_mean
from vcmm.nc.expressions import evaluate
from vcmm.nc.faults import BlockFault
from vcmm.nc.iso.blocks import IsoBlock, Word
from vcmm.nc.iso.control import IsoControl

_GROUPS = {
    "motion": "G0 G1 G2 G3 G33 G33.1 G73 G74 G76 G80 G81 G82 G83 G84 G85 G86 G87 G88 G89",
    "plane": "G17 G18 G19",
    "distance": "G90 G91",
    "arc": "G90.1 G91.1",
    "feed": "G93 G94 G95",
    "compensation": "G40 G41 G42 G41.1 G42.1",
    "length": "G43 G43.1 G43.2 G49",
    "retract": "G98 G99",
    "offset": "G54 G55 G56 G57 G58 G59 G59.1 G59.2 G59.3 G54.1",
    "path": "G61 G61.1 G64",
    "spindle": "G96 G97",
    "diameter": "G7 G8",
    "dwell": "G4",
    "other": "G10 G28 G28.1 G30 G30.1 G52 G92 G92.1 G92.2 G92.3",
    "machine": "G53",
}
_LINUXCNC = _GROUPS | {"offset": "G54 G55 G56 G57 G58 G59 G59.1 G59.2 G59.3"}
_FANUC = {
    **{k: v for k, v in _GROUPS.items() if k not in ("diameter", "arc")},
    "motion": "G0 G1 G2 G3 G33 G32 G73 G74 G76 G80 G81 G82 G83 G84 G85 G86 G87 G88 G89",
    "length": "G43 G44 G49",
    "path": "G61 G62 G63 G64",
    "rotation": "G68 G69",
    "exact": "G9",
    "macro": "G65 G66 G67",
    "harmless": "G22 G23 G25 G26 G5.1 G8 G15 G50 G50.1 G13.1 G40.1 G69.1",
}
_FANUC_LATHE = {
    **{k: v for k, v in _FANUC.items() if k not in ("retract", "distance", "spindle", "feed")},
    "motion": "G0 G1 G2 G3 G32 G33 G80",
    "feed": "G98 G99",
    "spindle": "G96 G97",
    "other": "G10 G28 G30 G50 G52 G92.1",
    "harmless": "G22 G23 G25 G26 G8 G13.1 G40.1 G69.1 G18.1",
}
REFUSED = {
    "G5": "splines", "G5.1": "quadratic splines", "G5.2": "NURBS", "G5.3": "NURBS", "G6.2": "NURBS interpolation", "G6.1": "splines",
    "G31": "the skip function: where it stops is decided by a probe", "G38.2": "probing", "G38.3": "probing",
    "G38.4": "probing", "G38.5": "probing", "G51": "scaling", "G51.1": "mirroring", "G16": "polar coordinates",
    "G12.1": "polar coordinate interpolation", "G112": "polar coordinate interpolation", "G7.1": "cylindrical interpolation",
    "G107": "cylindrical interpolation", "G43.4": "tool centre point control", "G43.5": "tool centre point control",
    "G68.2": "tilted working planes", "G53.1": "tilted working planes", "G54.2": "dynamic work offsets",
    "G60": "single direction positioning", "G34": "threads of variable lead", "G35": "circular threads", "G36": "circular threads",
    "G77": "turning cycles", "G78": "threading cycles", "G79": "facing cycles", "G70": "turning cycles", "G71": "turning cycles",
    "G72": "turning cycles", "G75": "turning cycles", "G45": "tool offset increments", "G46": "tool offset increments",
    "G47": "tool offset increments", "G48": "tool offset increments", "G12": "circular pockets", "G13": "circular pockets",
}  # fmt: skip
M_GROUPS = {
    "stop": (0, 1, 2, 30, 60), "call": (98, 99), "tool": (6, 61), "spindle": (3, 4, 5, 19, 13, 14), "override": (48, 49),
    "state": (70, 71, 72, 73),
}  # fmt: skip
HARMLESS_M = {
    "linuxcnc": {7, 8, 9, 50, 51, 52, 53, 62, 63, 64, 65, 66, 67, 68},
    "fanuc": {7, 8, 9, 10, 11, 15, 16, 18, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 31, 32, 33, 34, 35, 36, 40, 41, 42, 43, 44, 45, 50, 51, 52, 53, 68, 69, 88, 89, 97},
}  # fmt: skip
_M_OF = {code: group for group, codes in M_GROUPS.items() for code in codes}


def _table(groups: dict[str, str]) -> dict[str, str]:
    return {code: group for group, codes in groups.items() for code in codes.split()}


TABLES = {"linuxcnc": _table(_LINUXCNC), "fanuc": _table(_FANUC), "fanuc-lathe": _table(_FANUC_LATHE)}
LATHE_TURNING_CYCLES = ("G90", "G92", "G94")


def groups_of(c: IsoControl) -> dict[str, str]:
    """Code -> group of the dialect."""
    return TABLES[c.language.name] | dict.fromkeys(c.language.unit_codes, "unit")


def code_text(number: float) -> str:
    """The name of a G code: 54.1 -> "G54.1"."""
    return f"G{round(number, 3):g}"


class IsoWords:
    """The words of a block with their numbers now. `take` hands one out and notes that it has been used."""

    def __init__(self, c: IsoControl, block: IsoBlock) -> None:
        self.block = block
        self.g: dict[str, str] = {}  # group -> code
        self.g_columns: dict[str, int] = {}
        self.m: dict[str, int] = {}
        self.m_columns: dict[str, int] = {}
        self.values: dict[str, float] = {}
        self.words: dict[str, Word] = {}
        self.repeated: list[tuple[str, float]] = []  # all letters in order, for macro arguments
        self.used: set[str] = set()
        groups = groups_of(c)
        for word in block.words:
            number = number_of(c, word)
            if number is None:  # a vacant variable: the word does not count
                continue
            if word.letter == "G":
                self._add_g(c, groups, number, word.first)
            elif word.letter == "M":
                self._add_m(c, number, word.first)
            else:
                self._add(word, number)

    def _add(self, word: Word, number: float) -> None:
        self.repeated.append((word.letter, number))
        if word.letter in self.values and not ({"G65", "G66"} & set(self.g.values())):
            raise BlockFault(
                word.first, f'the word "{word.letter}" stands twice in this block; remove one of them'
            )
        self.values[word.letter], self.words[word.letter] = number, word

    def _add_g(self, c: IsoControl, groups: dict[str, str], number: float, column: int) -> None:
        code = code_text(number)
        group = groups.get(code)
        if group is None:
            raise BlockFault(column, unknown_code(c, code, groups))
        if group == "harmless":
            c.remark(f"{code} changes no path here and is passed over", column, code)
            self.used |= {"P", "Q", "R"}
            return
        if group in self.g:
            both = f"{self.g[group]} and {code}"
            raise BlockFault(column, f"{both} belong to one group and exclude each other; keep one of them")
        self.g[group], self.g_columns[group] = code, column

    def _add_m(self, c: IsoControl, number: float, column: int) -> None:
        if number != int(number) or number < 0:
            raise BlockFault(column, f"M{number:g} does not exist; M codes are whole numbers")
        code = int(number)
        group = _M_OF.get(code)
        family = "linuxcnc" if c.language.words == "o" else "fanuc"
        if (family == "linuxcnc" and (code in (13, 14))) or (
            family == "fanuc" and code in (61, 70, 71, 72, 73)
        ):
            group = None
        if group is None and code not in HARMLESS_M[family]:
            user = ", a code of the machine builder or user: what it does is not known" if code >= 100 else ""
            raise BlockFault(
                column, f"M{code} is unknown in {c.language.name}{user}; remove it, or expand what it does"
            )
        if group is None:
            self.used |= (
                {"P", "Q", "E", "L"}
                if family == "linuxcnc" and code >= 50
                else {"P"}
                if code >= 50
                else set()
            )
            return
        if group in self.m:
            raise BlockFault(
                column, f"M{self.m[group]} and M{code} exclude each other in one block; keep one of them"
            )
        self.m[group], self.m_columns[group] = code, column

    def has(self, letter: str) -> bool:
        return letter in self.values

    def take(self, letter: str) -> float | None:
        """The number of a word, None when it is absent."""
        self.used.add(letter)
        return self.values.get(letter)

    def column(self, letter: str) -> int:
        word = self.words.get(letter)
        return word.first if word else 1

    def need(self, letter: str, why: str, column: int) -> float:
        """The number of a word that must be there."""
        number = self.take(letter)
        if number is None:
            raise BlockFault(column, f'the word "{letter}" is missing: {why}')
        return number

    def whole(self, letter: str, column: int, lowest: int = 0) -> int | None:
        number = self.take(letter)
        if number is None:
            return None
        if abs(number - round(number)) > 1e-4 or round(number) < lowest:
            raise BlockFault(
                self.column(letter), f"{letter}{number:g} must be a whole number, {lowest} or more"
            )
        return round(number)

    @property
    def any_axis(self) -> bool:
        return any(a in self.values for a in "XYZABC")


def number_of(c: IsoControl, word: Word) -> float | None:
    """The number of a word now; complaints of expressions get a column."""
    if not callable(word.value):
        return word.value
    try:
        return evaluate(word.value, c.parameters)
    except BlockFault as fault:
        raise BlockFault(fault.column or word.first, fault.text) from None


def unknown_code(c: IsoControl, code: str, groups: dict[str, str]) -> str:
    """Why a G code is refused."""
    if c.language.lathe and code in LATHE_TURNING_CYCLES:
        return f"{code} is a turning cycle of G-code system A and is not expanded; program its moves with G0, G1 and G32"
    if code in REFUSED:
        return f"{code} ({REFUSED[code]}) is not understood by vcmm; have the program posted without it"
    return f"{code} is unknown in the dialect {c.language.name}.{did_you_mean(code, groups)} Correct it, or name the dialect with --dialect"
