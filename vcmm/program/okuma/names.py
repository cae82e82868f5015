"""Names of Okuma OSP instead of numbers of the G-code family: variables, sequence names, programs, and expressions of them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

FIRST_VARIABLE, FIRST_LABEL, FIRST_PROGRAM = 600, 900_000, 9_000
FUNCTIONS = (
    "SIN",
    "COS",
    "TAN",
    "ATAN",
    "SQRT",
    "ABS",
    "ROUND",
    "FIX",
    "FUP",
    "LN",
    "EXP",
    "LT",
    "LE",
    "EQ",
    "NE",
    "GT",
    "GE",
    "AND",
    "OR",
    "XOR",
    "MOD",
)
_NAME = re.compile(
    r"#([0-9A-F]+)H\b|\b(V(?:C|S)?\d+|[A-Z]{2,5}\d*|V[A-Z]{3,4}|P[A-Z])\b(?:\s*\[([^\[\]]*)\])?",
    re.IGNORECASE,
)
_SYSTEM = re.compile(r"V[A-Z]{3,4}\Z")


def is_system(name: str) -> bool:
    """Return whether a variable is one of the system: VZOFX, VTOFH, VAPAX; V12 and VC12 are the program's."""
    return _SYSTEM.match(name) is not None


@dataclass(eq=False)
class OkumaNames:
    """Numbers for the names of a text. assigned: variables that it sets; read: names that nothing sets, in order."""

    assignments: frozenset[str]
    variables: dict[str, int] = field(default_factory=dict)
    labels: dict[str, int] = field(default_factory=dict)
    programs: dict[str, int] = field(default_factory=dict)
    read: list[str] = field(default_factory=list)

    def variable(self, name: str) -> int:
        """Return the number of a variable: V12 is #612 plus an offset for each kind, names follow."""
        return self.variables.setdefault(name.upper(), FIRST_VARIABLE + len(self.variables))

    def label(self, name: str) -> int:
        """Return the number of a label: N10 is block 10; NGO gets a number that no program has."""
        name = name.upper()
        return int(name) if name.isdigit() else self.labels.setdefault(name, FIRST_LABEL + len(self.labels))

    def program(self, name: str) -> int:
        """Return the number of a program: O100 is program 100; OPOP gets a number."""
        name = name.upper()
        return (
            int(name)
            if name.isdigit()
            else self.programs.setdefault(name, FIRST_PROGRAM + len(self.programs))
        )

    def value(self, expression: str) -> str:
        """Return an expression with numbers instead of names; an unset name is 0."""
        return _NAME.sub(self._number, expression)

    def _number(self, match: re.Match[str]) -> str:
        if match[1]:
            return str(int(match[1], 16))
        name = match[2].upper()
        if name in FUNCTIONS:
            return match[0]
        if is_system(name) or name not in self.assignments:
            label = f"{name}[{match[3]}]" if match[3] else name
            if label not in self.read:
                self.read.append(label)
            return "0"
        return f"#{self.variable(name)}"
