"""G and M codes by modal group, and the words of one block sorted by them. Two codes of one group are refused."""

from __future__ import annotations

from functools import cache

from vcmm.core.errors import did_you_mean
from vcmm.program.expressions import evaluate
from vcmm.program.faults import BlockFault
from vcmm.program.iso.blocks import IsoBlock, Word
from vcmm.program.iso.control import IsoControl, mirrored_for
from vcmm.program.iso.groups import (
    HARMLESS_M,
    M_GROUPS,
    NOT_OF,
    PROBING,
    REFUSED_CODES,
    REFUSED_OF,
    STAND_INS,
    TABLES,
)
from vcmm.program.levels import NOT_MOVED
from vcmm.program.setup import has_driven

NO_WAY = {"G22", "G50.1", "G102"}  # X Y Z are limits of a zone, mirrored axes, positions that are printed
PALLETS = {36: "pallet ready", 50: "change of the pallet", 60: "change of the pallet"}
_M_OF = {code: group for group, codes in M_GROUPS.items() for code in codes}


def groups_of(c: IsoControl) -> dict[str, str]:
    """Return the code -> group of the dialect."""
    language = c.language
    return _groups(
        language.codes or ("fanuc" if language.words == "macro" else "linuxcnc"), tuple(language.unit_codes)
    )


@cache
def _groups(table: str, units: tuple[str, ...]) -> dict[str, str]:
    return TABLES[table] | dict.fromkeys(units, "unit")


def code_text(number: float) -> str:
    """Return the name of a G code: 54.1 -> "G54.1"."""
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
        self.macro = c.language.words == "macro"
        self.next_tool: float | None = None
        self.passed = False  # a code is passed over: its words are too
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
        if word.letter == "T" and "T" in self.values and self.macro:  # T2 T3 M6: the next tool
            self.next_tool = number
            return
        if word.letter in self.values and not ({"G65", "G66", "G66.1"} & set(self.g.values())):
            raise BlockFault(
                word.first, f'the word "{word.letter}" appears twice in this block; remove one of them'
            )
        self.values[word.letter], self.words[word.letter] = number, word

    def _add_g(self, c: IsoControl, groups: dict[str, str], number: float, column: int) -> None:
        code = code_text(number)
        group = groups.get(code)
        if group is None:
            code, group = self._unknown_g(c, groups, code, column)
        spindle = c.language.part_spindles.get(code)
        if spindle is not None:
            c.hold(spindle)
            if c.language.haas:
                mirrored_for(c, spindle)
            return
        if group == "harmless":
            if not self.passed:  # a hole in the path or a replacement by another code is noted already
                c.remark(f"{code} changes no path here and is passed over", column, code)
            self.used |= {"P", "Q", "R", "E", "L", "D", "I", "J", "K"}
            if code in NO_WAY:
                self.used |= {"X", "Y", "Z", "U", "W"}
            return
        beside = group in self.g and c.language.words == "o" and "G80" in (code, self.g[group])
        if beside and code == "G80":
            return  # the interpreter of LinuxCNC goes by the other motion code of the block, in either order
        if (
            group in self.g and not beside and not (c.language.survey and self.macro)
        ):  # Fanuc: the last one counts
            both = f"{self.g[group]} and {code}"
            raise BlockFault(column, f"{both} belong to one group and exclude each other; keep one of them")
        self.g[group], self.g_columns[group] = code, column

    def _unknown_g(self, c: IsoControl, groups: dict[str, str], code: str, column: int) -> tuple[str, str]:
        """Return the replacement of a code that is not modelled in a survey, and its group."""
        if code in PROBING and c.setup.surfaces:
            return code, "motion"
        refusal = unknown_code(c, code, groups)
        remapped = c.language.words == "o" and not c.language.codes
        meaning = meaning_of(c, code)
        if not meaning and not remapped:
            raise BlockFault(column, refusal)
        stand_in = STAND_INS.get(code, "")
        treatment = (
            f"{stand_in} to its end point" if stand_in == "G1" else stand_in or "passed over with its words"
        )
        if code in REFUSED_OF.get(c.language.codes, ()):
            treatment = NOT_MOVED
        what = f"{code} ({meaning})" if meaning else f"{code}, a remapped code"
        c.assume(what, treatment, refusal, column=column)
        if not stand_in:
            self.passed = True
            return code, "harmless"
        self.passed = True
        return stand_in, groups[stand_in]

    def _add_m(self, c: IsoControl, number: float, column: int) -> None:
        if number != int(number) or number < 0:
            raise BlockFault(column, f"M{number:g} does not exist; M codes are whole numbers")
        code, family = int(number), c.language.words
        group = None if int(number) in NOT_OF[family] else _M_OF.get(code)
        if group is None and code not in HARMLESS_M[family]:
            user = ", a code of the machine builder or user: what it does is not known" if code >= 100 else ""
            if c.language.lathe and has_driven(c.setup):
                c.remark(f"M{code} belongs to the machine builder; it is taken to move nothing", column)
                self.used |= {"P", "Q", "E", "L", "R"}
                return
            refusal = f"M{code} is unknown in {c.language.name}{user}; remove it, or expand what it does"
            c.assume(
                f"M{code}, a code of the machine builder", "passed over: no motion", refusal, column=column
            )
            self.used |= {"P", "Q", "E", "L", "R"}
            return
        if code in PALLETS and family == "macro" and not c.language.lathe and (code == 60 or c.language.haas):
            c.remark(
                f"M{code} ({PALLETS[code]}): what follows may be another part; its work offset is taken unchanged",
                column,
            )
        if c.language.codes == "haas":
            self._note_haas(c, code, column)
        if group is None:
            self.used |= (
                {"P", "Q", "E", "L"} if family == "o" and code >= 50 else {"P"} if code >= 50 else set()
            )
            return
        if group in self.m:
            raise BlockFault(
                column, f"M{self.m[group]} and M{code} exclude each other in one block; keep one of them"
            )
        self.m[group], self.m_columns[group] = code, column

    def _note_haas(self, c: IsoControl, code: int, column: int) -> None:
        """Note M39 and M46 of a Haas mill (mill operator's manual, "M39 rotate tool turret", "M46 jump if pallet loaded")."""
        if code == 39:
            c.remark(
                "M39 turns the tool changer to the pocket of T; no tool is changed and no axis of the path moves",
                column,
            )
        elif code == 46:
            c.assume(
                "whether the pallet of M46 Q is loaded", "no: the program goes on with the next block",
                "M46 jumps to the block of P where the pallet of Q is loaded, and that is not known; write the blocks that are to be run",
                column=column,
            )  # fmt: skip
            self.used |= {"P", "Q"}

    def has(self, letter: str) -> bool:
        return letter in self.values

    def take(self, letter: str) -> float | None:
        """Return the number of a word, None when it is absent."""
        self.used.add(letter)
        return self.values.get(letter)

    def column(self, letter: str) -> int:
        word = self.words.get(letter)
        return word.first if word else 1

    def need(self, letter: str, why: str, column: int) -> float:
        """Return the number of a required word."""
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
        return any(a in self.values for a in "XYZABC@^")


def number_of(c: IsoControl, word: Word) -> float | None:
    """Return the number of a word now; complaints of expressions get a column."""
    if not callable(word.value):
        return word.value
    try:
        return evaluate(word.value, c.parameters)
    except BlockFault as fault:
        raise BlockFault(fault.column or word.first, fault.text) from None


def meaning_of(c: IsoControl, code: str) -> str:
    """Return the meaning on this control of a code that is not modelled; "" where it is unknown."""
    return REFUSED_OF.get(c.language.codes, {}).get(code) or REFUSED_CODES.get(code, "")


def unknown_code(c: IsoControl, code: str, groups: dict[str, str]) -> str:
    """Return the reason for the refusal of a G code."""
    meaning = meaning_of(c, code)
    if meaning:
        if code in PROBING:
            return (
                f"{code} ({meaning}): where the probe stops is not known; state what it touches in the set-up file, as [stock] "
                'with box, or [[surfaces]] with point = "0 0 0 mm" and normal = [0, 0, 1]'
            )
        if code == "G95" and c.language.codes == "lathe":
            return f"{code} ({meaning} in G-code system A) is not understood by vcmm; a feed per turn is G99 there: write G99, or name the dialect fanuc-lathe-b, where it is G95"
        return f"{code} ({meaning}) is not understood by vcmm; have the program posted without it"
    return f"{code} is unknown in the dialect {c.language.name}.{did_you_mean(code, groups)} Correct it, or name the dialect with --dialect"
