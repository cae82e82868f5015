"""Two levels of reading: strict refuses missing data of a program, survey assumes values that the machine would have in its memory, with remarks.

A reader calls `Recorder.assume` wherever a program leaves open what tool table, work offsets, caller or builder of the machine
would settle. What is wrong in itself (a malformed word, an impossible arc) is a fault on both levels.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, NoReturn, Protocol

from vcmm.core.errors import DataError

NOT_MOVED = (
    "a hole in the path: its moves are missing"  # what is assumed of a cycle or subprogram that is not read
)


class SetupEntry(NamedTuple):
    """A number that the set-up file can give: table "tools.3", key "diameter", example '"10 mm"' (as TOML writes it).

    name: of the tool, where the program calls it so.
    """

    table: str
    key: str
    example: str
    name: str = ""

    def __str__(self) -> str:
        where = f"[{self.table}] " if self.table else ""
        name = f"name = {toml_text(self.name)}, " if self.name else ""
        return f"{where}{name}{self.key} = {self.example}"


class Assumption(NamedTuple):
    """Assumption: line of the program, its subject, the assumed value.

    blank: how the set-up file gives it, None where it cannot. matters: whether the path of the tool depends on it.
    refusal: the sentence with which a strict reading stops here, "" where it has none.
    """

    line: int
    what: str
    value: str
    blank: SetupEntry | None = None
    matters: bool = True
    refusal: str = ""


class UnusedWord(NamedTuple):
    """A word of the program that nothing uses, as written: "K-2."."""

    line: int
    column: int
    word: str
    text: str


class Telling(Protocol):
    """Receiver of assumptions: vcmm.program.recorder.Recorder."""

    @property
    def setup(self) -> Any: ...

    @property
    def line(self) -> int: ...

    def remark(self, text: str, column: int | None = None, kind: str = "") -> None: ...

    def assume(
        self,
        what: str,
        value: str,
        otherwise: str = "",
        *,
        blank: SetupEntry | None = None,
        column: int | None = None,
        matters: bool = True,
    ) -> None: ...


class Listening(Telling, Protocol):
    """Receiver that also keeps words without use."""

    unused_words: dict[tuple[int, str], UnusedWord]

    def fault(self, text: str, column: int | None = None) -> NoReturn: ...


def pass_over(r: Listening, word: str, column: int, refused: bool = False, name: str = "") -> None:
    """Pass over a word without use in its block. Strict (or where the control stops, `refused`): a fault. Survey: kept with its line, and
    noted once for each letter, or `name` where words have longer ones."""
    letter = name or (word[:2] if word.startswith(",") else word[:1])
    text = f'nothing in this block uses the word "{letter}"'
    if r.setup.strict or refused:
        r.fault(f"{text}; remove it, or add the code that it belongs to", column)
    text += "; it is passed over"
    r.unused_words.setdefault((r.line, word), UnusedWord(r.line, column, word, text))
    r.remark(text, column, f"unused {letter}")


def tell_unknown_axes(r: Telling, now: Sequence[float], then: Sequence[float]) -> None:
    """Note rotary axes (rad, A B C) that a block turns while no machine is named: whether they exist is unknown; once for each."""
    if r.setup.axes is None:
        for axis, before, after in zip("ABC", now, then):
            if before != after:
                what = f"whether the machine has an axis {axis}"
                r.assume(
                    what, 'taken as there; machine = "machine.toml" in the set-up settles it', matters=False
                )


def toml_text(text: str) -> str:
    """Return a text in the form of TOML."""
    return json.dumps(text, ensure_ascii=False)


def unknown_tool(r: Telling, number: int, called: str, column: int | None = None, *, free: int = 0) -> None:
    """Note a tool that the set-up does not have, the same in every language: a survey goes on with a tool without length.

    Strict: refused where the set-up has tools and lacks this one; without any it is a remark. called: how the program calls it.
    number 0: it is called by its name; free: the number that it gets.
    """
    tools = sorted(r.setup.tools)
    entry = SetupEntry(f"tools.{number or free}", "length", '"80 mm"', "" if number else called)
    what = f"tool {number}" if number else f"the tool {called}"
    if r.setup.strict and not tools:
        r.remark(
            f"the length of {what} is not known and taken as 0 mm; give the tools with --setup",
            column,
            "no tools",
        )
        return
    numbers = ", ".join(str(n) for n in tools[:12])
    add = f"[tools.{number}]" if number else f'a tool with name = "{called}"'
    otherwise = (
        f"{what} ({called}) is not in the set-up file, which has {numbers}; add {add}" if tools else ""
    )
    r.assume(what, "a tool without length", otherwise, blank=entry, column=column)


def demand(assumptions: Iterable[Assumption], name: str, job: str) -> None:
    """Refuse to go on with a path that depends on what was assumed. Raises DataError, one sentence for each missing number.

    name: of the program, for messages; job: who asks, as in "cut".
    """
    missing = [a for a in assumptions if a.matters]
    if missing:
        raise DataError([f"{name}:{a.line}:1: {_sentence(a, job)}" for a in missing])


def _sentence(a: Assumption, job: str) -> str:
    if a.blank is not None:
        return f"{job} needs {a.what}: write {a.blank} in the set-up file (vcmm nc --write-setup writes it with blanks)"
    survey = f'the survey of vcmm nc goes on with "{a.value}", which does not give {job} the path'
    word = a.what.split()[0]
    if word[0].isupper() and a.refusal.startswith(word):  # a code: no job needs it, it is in the way
        return f"{a.refusal}. {survey[0].upper()}{survey[1:]}"
    return f"{job} needs {a.what}: {survey}; put it into the program, or add the file that has it"
