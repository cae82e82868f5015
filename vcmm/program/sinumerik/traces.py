"""Places of the words of a Sinumerik block, and the block without expressions, calls and jumps."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise, zip_longest
from typing import Any, Protocol

from vcmm.program.expressions import number
from vcmm.program.faults import BlockFault
from vcmm.program.sinumerik.blocks import Item, SinumerikBlock
from vcmm.program.sinumerik.text import SinumerikReader, lines_of
from vcmm.program.tokens import Token
from vcmm.program.trace import TextCut, WordAt
from vcmm.program.tracer import is_plain_decimal, word_at, written_out

_HEAD = re.compile(r"[ \t]*(?:/[ \t]*\d?)?[ \t]*(?:N[ \t]*\d+)?[ \t]*", re.IGNORECASE)
_WORD = re.compile(
    r"(?:[A-Za-z_$][A-Za-z0-9_$]*[ \t]*=[ \t]*(?:(?P<mode>AC|IC|DC|ACP|ACN)[ \t]*\((?P<inside>.*)\)|(?P<value>.*))|[A-Za-z][ \t]*(?P<number>.*))\Z",
    re.IGNORECASE,
)
ARGUMENTS = ("RTP", "RFP", "SDIS", "DP", "DPR")
DEEP = (*ARGUMENTS, "FDEP", "FDPR", "DAM", "DTB", "DTS", "FRF", "VARI")
_KEYS = {"CR": "R"}


class Running(Protocol):
    """Interface of a program under way."""

    @property
    def sections(self) -> Mapping[str, Any]: ...

    @property
    def parameters(self) -> Mapping[int, float]: ...

    def parameter(self, index: int) -> float: ...

    def variable(self, name: str, column: int) -> float: ...

    def is_defined(self, name: str) -> bool: ...


def span_of(item: Item, line: str) -> tuple[int, int, str] | None:
    """Return the columns of the value of a word, and AC, IC, or the way of a rotary axis: DC, ACP, ACN."""
    match = _WORD.match(line[item.first - 1 : item.last - 1])
    if match is None:
        return None
    group = next(g for g in ("inside", "value", "number") if match[g] is not None)
    return item.first + match.start(group), item.first + match.end(group), (match["mode"] or "").upper()


def words_of(block: SinumerikBlock, line: str) -> dict[str, WordAt]:
    """Return SinumerikWords by address: CR= as "R", I1= as "I1", A3= as "A3"."""
    out: dict[str, WordAt] = {}
    for item in block.items:
        span = None if item.name == "R" or item.value is None else span_of(item, line)
        if span is None:
            continue
        numbered = item.number is not None and item.name in "IJKXYZABC"
        key = _KEYS.get(item.name, item.name)
        if numbered:
            key = re.sub(r"\s", "", line[item.first - 1 : span[0] - 1].split("=")[0]).upper()
        out[key] = word_at(key, line, block.line, (item.first, item.last), (span[0], span[1]), span[2])
    return out


def argument_spans(item: Item, line: str) -> list[tuple[int, int]]:
    """Return the columns of the arguments of NAME(a, , b), without the blanks around them."""
    begin = line.index("(", item.first - 1) + 1
    out, depth, start, quoted = [], 0, begin, False
    for at in range(begin, item.last - 1):
        letter = line[at]
        quoted ^= letter == '"'
        if quoted:
            continue
        if depth == 0 and letter in ",)":
            text = line[start:at]
            lead = len(text) - len(text.lstrip())
            out.append((start + lead + 1, start + lead + 1 + len(text.strip())))
            start = at + 1
        depth += (letter == "(") - (letter == ")")
    return out


def cycle_words(item: Item, line: str, at: int) -> dict[str, WordAt]:
    """Return the arguments of a drilling cycle by name."""
    if item.arguments is None:
        return {}
    names = DEEP if item.name == "CYCLE83" else ARGUMENTS
    arguments = {
        name: word_at(name, line, at, span, span)
        for name, span in zip(names, argument_spans(item, line))
        if span[1] > span[0]
    }
    return arguments | {"cycle": WordAt("cycle", item.first, item.last, item.name, False, None, line=at)}


def cuts_of(runner: Running, block: SinumerikBlock, line: str, call: int) -> list[TextCut]:
    """Return the replacements when the block is written out at its execution."""
    out: list[TextCut] = []
    for item in block.items:
        text = _replacement(runner, item, line, call)
        if text is not None:
            out.append(TextCut(block.line, *text))
    head = _HEAD.match(line)
    begin = head.end() + 1 if head else 1
    if block.label:
        end = line.index(":", begin - 1) + 2
        out.append(TextCut(block.line, begin, end, ""))
        begin = end
    if block.flow is not None:
        out.append(TextCut(block.line, max([begin, *(i.last for i in block.items)]), block.last, ""))
    return out


def _replacement(runner: Running, item: Item, line: str, call: int) -> tuple[int, int, str] | None:
    """Return the columns and text of a replaced item."""
    if item.name in ("MSG", "SETAL"):
        return _message(runner, item, line)
    if item.name == "R" or (item.value is not None and runner.is_defined(item.name)):
        return item.first, item.last, ""
    if item.name in runner.sections or (item.name == "L" and f"L{item.text}" in runner.sections):
        return item.first, item.last, ""
    if item.name == "M" and call and item.text in ("17", "2", "02"):
        return item.first, item.last, ""
    if item.arguments is not None:
        return _arguments(runner, item, line)
    span = None if item.value is None else span_of(item, line)
    if span is None or item.value is None or is_plain_decimal(line[span[0] - 1 : span[1] - 1]):
        return None
    return span[0], span[1], written_out(number(item.value, runner))


def _message(runner: Running, item: Item, line: str) -> tuple[int, int, str] | None:
    """Return MSG("PASS "<<R2) with the number that R2 has now, as a text of its own: the assignment of R2 goes."""
    tokens = [t for t in lines_of(line[: item.last - 1])[0] if t.column > item.first][1:-1]
    borders = [-1, *(i for i, t in enumerate(tokens) if t.text in ("<<", ",")), len(tokens)]
    text = line[: item.last - 1]
    for before, behind in reversed(list(pairwise(borders))):
        piece = tokens[before + 1 : behind]
        value = _number_in(runner, piece)
        if value is not None:
            end = piece[-1].column + len(piece[-1].text) - 1
            text = f'{text[: piece[0].column - 1]}"{written_out(value)}"{text[end:]}'
    new = text[item.first - 1 :]
    return None if new == line[item.first - 1 : item.last - 1] else (item.first, item.last, new)


def _number_in(runner: Running, piece: Sequence[Token]) -> float | None:
    """Return the value of a part of a message that depends on parameters of the program; None for any other part."""
    names = [t for t in piece if t.kind == "name" and runner.is_defined(t.text.upper())]
    words = [t for t in piece if t.kind == "word" and t.text[0] in "Rr"]
    are_set = all(t.text[1:].strip().isdigit() and int(t.text[1:]) in runner.parameters for t in words)
    if not (names or words) or not are_set:
        return None
    try:
        reader = SinumerikReader(list(piece))
        value = number(reader.expression(), runner)
    except BlockFault:
        return None
    return value if reader.is_done else None


def _arguments(runner: Running, item: Item, line: str) -> tuple[int, int, str] | None:
    spans: Sequence[tuple[int, int]] = argument_spans(item, line)
    texts = [line[a - 1 : b - 1] for a, b in spans]
    stays = [
        not t or is_plain_decimal(t) or t.startswith('"') for t in texts
    ]  # a text ("TC1" of CYCLE800) has no number
    if all(stays):
        return None
    values = [
        t if stay or a is None else written_out(number(a, runner))
        for t, stay, a in zip_longest(
            texts, stays, item.arguments or ()
        )  # what is empty at the end has no argument
    ]
    return (
        item.first,
        item.last,
        f"{line[item.first - 1 : line.index('(', item.first - 1)]}({','.join(values)})",
    )
