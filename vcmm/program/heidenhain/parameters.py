"""Q parameters of Klartext: assignment, FN functions, jumps, system data, texts.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Programming Q parameters". Values known only to the machine (SYSREAD, probing,
tables) are read as zero, with a remark.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from vcmm.core.errors import choose_from
from vcmm.program.faults import BlockFault
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.heidenhain.texts import KlartextTexts
from vcmm.program.recorder import Recorder

CONDITIONS: dict[str, Callable[[float, float], bool]] = {
    "EQU": lambda a, b: math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12),
    "NE": lambda a, b: not math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12),
    "GT": lambda a, b: a > b,
    "LT": lambda a, b: a < b,
}
OUTPUT = {
    15: "PRINT",
    16: "F-PRINT",
    19: "PLC",
    20: "WAIT FOR",
    29: "PLC",
    37: "EXPORT",
    38: "SEND",
}  # they move nothing
TABLES = {17: "SYSWRITE", 25: "PRESET", 26: "TABOPEN", 27: "TABWRITE", 28: "TABREAD"}
READ_IN = (28,)  # tables that are read into parameters
TEXT_FUNCTIONS = ("TONUMB", "STRLEN", "STRCOMP", "INSTR", "SUBSTR", "CFGREAD", "SYSREAD", "SYSSTR", "SQL")
ZERO = "0"


@dataclass(eq=False)
class KlartextParameters:
    """Values of Q, QL and QR."""

    recorder: Recorder
    values: dict[str, float] = field(default_factory=dict)
    texts: KlartextTexts = field(default_factory=KlartextTexts)
    is_guessing: bool = False  # a value has been taken that only the machine knows

    def unset(self, name: str) -> float:
        """Return a parameter that nothing has set: those that the control keeps, else zero."""
        r, tool = self.recorder, self.recorder.tool_data
        before: Mapping[str, float | None] = {
            "Q108": None if tool.radius is None else tool.radius / r.unit, "Q109": float(r.tool_axis), "Q113": float(r.unit > 1.0),
            "Q114": tool.length / r.unit, "Q111": 0.0, "Q112": 1.0, "Q110": {0: -1.0, 1: 0.0, -1: 1.0}[r.sense],
        }  # fmt: skip
        value = before.get(name)
        if value is not None:
            return value
        if r.setup.strict:
            r.remark(f"{name} is used before it is set; 0 is taken")
        else:
            r.assume(f"the value of {name}", ZERO)
            self.is_guessing = True
        return 0.0

    # -- assignment --
    def assign(self, reader: KlartextReader) -> None:
        """Assign Q1 = formula."""
        name = reader.parameter()
        reader.expect("=", f"after {name}")
        if reader.upper() in TEXT_FUNCTIONS:
            function = reader.upper()
            value = self.texts.number(reader.rest(), self.value_of)
            if value is None:
                refusal = f"{function}: what it gives hangs on a text or a table that is not known here"
                self.recorder.assume(f"{name}, which a text or a table gives", ZERO, refusal)
            self.values[name] = value or 0.0
        else:
            self.values[name] = self.formula(reader, name)
        if not reader.is_done:
            raise reader.fault(f'"{reader.upper()}" cannot be understood in a formula')

    def formula(self, reader: KlartextReader, name: str) -> float:
        """Return the value; 0 where it has none and depends on values of the machine alone."""
        column = reader.column
        try:
            return reader.formula()
        except BlockFault as fault:
            if not self.is_guessing or self.recorder.setup.strict or fault.column < column:
                raise
            self.recorder.assume(f"{name}, which hangs on what only the machine knows", ZERO)
            reader.rest()
            return 0.0

    def text(self, reader: KlartextReader) -> None:
        """Assign QS1 = "text"; an unknown text has no effect on the moves, and is noted."""
        what, number = f"the text {reader.upper()}{reader.upper(1)}", reader.upper(1)
        named = reader.accept("QS") and number.isdigit()
        reader.at += named
        if named and reader.accept("=") and self.texts.assign(number, reader.rest(), self.value_of):
            return
        self.recorder.assume(what, "passed over", f"{what} is not known here", matters=False)
        reader.rest()

    def declare(self, reader: KlartextReader) -> None:
        """DECLARE STRING QS1 = "text"."""
        reader.accept("STRING")
        self.text(reader)

    def value_of(self, written: str) -> float:
        """Return a number, or a parameter with its sign."""
        sign, name = (-1.0 if written.startswith("-") else 1.0), written.lstrip("+-").upper()
        if not name.startswith("Q"):
            return sign * float(name)
        return sign * (self.values[name] if name in self.values else self.unset(name))

    def function(self, reader: KlartextReader, code: int, column: int) -> bool:
        """Execute FN 0 to FN 8, FN 13 and what goes beyond the program; jumps are the reader's. True where the program ends."""
        if code == 18:
            self.system_data(reader, column)
        elif code in (0, 1, 2, 3, 4, 5, 6, 7, 8, 13):
            self.calculate(reader, code)
        elif code == 14:
            self.alarm(reader, column)
        else:
            self.outside(reader, code, column)
        return code == 14

    def calculate(self, reader: KlartextReader, code: int) -> None:
        name = reader.parameter()
        reader.expect("=", f"after {name}")
        bracketed = reader.upper() == "("
        first = reader.single() if bracketed else self.operand(reader, code)
        if code in (0, 5, 6, 7):
            value = {
                0: lambda x: x,
                5: math.sqrt,
                6: lambda x: math.sin(math.radians(x)),
                7: lambda x: math.cos(math.radians(x)),
            }[code](first)
        else:
            word = {1: "+", 2: "-", 3: "*", 4: "DIV", 8: "LEN", 13: "ANG"}[code]
            if not (reader.accept(word) or (code == 4 and reader.accept("/"))):
                raise reader.fault(f'"{word}" is required between the two values of FN {code}')
            second = reader.value("FN")
            if code == 4 and second == 0.0:
                raise reader.fault("division by zero; check the parameters used here")
            value = _two(code, first, second)
        self.values[name] = float(value)

    def operand(self, reader: KlartextReader, code: int) -> float:
        for word in {5: ("SQRT",), 6: ("SIN",), 7: ("COS",)}.get(code, ()):
            reader.accept(word)
        value = reader.value("FN")
        if code == 5 and value < 0:
            raise reader.fault(f"SQRT {value:g} has no real value; check the parameters")
        return value

    def condition(self, reader: KlartextReader) -> bool:
        """Evaluate IF a EQU | NE | GT | LT b GOTO LBL, IF Q5 IS [UN]DEFINED GOTO LBL, up to the name of the label."""
        reader.expect("IF", "in a jump, as in FN 9: IF +Q1 EQU +5 GOTO LBL 2")
        if reader.upper() == "QS" or any(t.kind == "string" for t in reader.tokens[: len(reader.tokens) - 1]):
            holds = False
            while not reader.is_done and reader.upper() != "GOTO":
                reader.at += 1
            self.recorder.assume("a condition on texts", "not met", "QS (text parameters) are not understood")
        elif reader.is_parameter() and reader.upper(2) == "IS":
            holds = (reader.parameter() in self.values) == (reader.upper(1) == "DEFINED")
            reader.at += 2
        else:
            first, word = reader.value("IF"), reader.upper()
            if word not in CONDITIONS:
                raise reader.fault(f"expected a condition.{choose_from(word, CONDITIONS)}")
            reader.at += 1
            holds = CONDITIONS[word](first, reader.value("IF"))
        reader.expect("GOTO", "after the condition")
        reader.expect("LBL", "after GOTO")
        return holds

    def alarm(self, reader: KlartextReader, column: int) -> None:
        """Stop at FN 14: ERROR = 1000."""
        reader.rest()
        self.recorder.assume(
            "an error that the program raises itself (FN 14)", "the program ends there",
            "FN 14 is not understood; use a formula (Q1 = ...) or remove it", column=column,
        )  # fmt: skip

    def outside(self, reader: KlartextReader, code: int, column: int) -> None:
        """Pass over print-outs, tables, the PLC."""
        name = OUTPUT.get(code) or TABLES.get(code)
        refusal = f"FN {code} is not understood; use a formula (Q1 = ...) or remove it"
        if name is None:
            raise reader.fault(refusal, column)
        value = "passed over" if code not in READ_IN else "passed over: what it reads stays as it is"
        reader.rest()
        self.recorder.assume(f"FN {code}: {name}", value, refusal, column=column, matters=code in TABLES)

    def system_data(self, reader: KlartextReader, column: int) -> None:
        """Read FN 18: SYSREAD Q1 = ID270 NR1 IDX1: the present position; nothing else is known before the machine runs."""
        reader.expect("SYSREAD", "after FN 18:")
        name = reader.parameter()
        reader.expect("=", f"after {name}")
        numbers: dict[str, int] = {}
        reader.expect("ID", "of SYSREAD, as in ID270 NR1 IDX3")
        numbers["ID"] = round(reader.value("ID"))
        for word in ("NR", "IDX"):
            if reader.accept(word):
                numbers[word] = round(reader.value(word))
        reader.rest()  # .SUB and the like
        value = self.present(numbers)
        if value is None:
            what = f"SYSREAD {' '.join(f'{k}{v}' for k, v in numbers.items())}"
            self.recorder.assume(
                what,
                ZERO,
                f"{what} is known to the machine only; set {name} in the program instead",
                column=column,
            )
            self.is_guessing = True
            self.recorder.states.machine_value = what
        self.values[name] = value or 0.0

    def present(self, numbers: Mapping[str, int]) -> float | None:
        """Return the system data that follow from the program: position (270, 240), tool (20, 50, 60); None: the machine's."""
        r, place = self.recorder, (numbers["ID"], numbers.get("NR", 0))
        axis = numbers.get("IDX", 0) - 1
        if place == (270, 1) and axis in (0, 1, 2):
            return r.p[axis] / r.unit
        if place == (240, 1) and axis in (0, 1, 2) and not r.setup.strict and r.moves:
            return r.q[axis] / r.unit
        if place == (20, 1) and r.tool:
            return float(r.tool)
        tool = r.setup.tools.get(numbers.get("IDX", r.tool))
        if numbers["ID"] == 50 and tool is not None and place[1] in (1, 2):
            size = tool.length if place[1] == 1 else tool.radius
            return None if size is None else size / r.unit
        return None


def _two(code: int, a: float, b: float) -> float:
    if code == 8:
        return math.hypot(a, b)
    if code == 13:
        return math.degrees(math.atan2(a, b)) % 360.0
    return {1: a + b, 2: a - b, 3: a * b}[code] if code != 4 else a / b
