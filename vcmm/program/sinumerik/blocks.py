"""One line of a Sinumerik program as a SinumerikBlock: label, items (words, assignments, commands), flow control."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

from vcmm.program.expressions import Value
from vcmm.program.faults import BlockFault
from vcmm.program.sinumerik.heads import SinumerikFlow, flow_of
from vcmm.program.sinumerik.text import SinumerikReader, line_tokens, number_of
from vcmm.program.tokens import Token

ADDRESSES = (  # names that take "= value"
    "CR", "AR", "TURN", "ADIS", "ADISPOS", "RPL", "RND", "RNDM", "CHF", "CHR", "FRC", "FRCM", "LIMS", "AP", "RP", "CTOL", "DISC",
    "ANG", "SPOS", "OFFN", "FB", "FD", "FA", "SD", "PW", "PL", "SF", "DISR", "DISCL", "DISRP", "FAD", "FP", "SPOSA", "SVC", "SCC", "ACC", "PM", "POLF",
    "A2", "B2", "C2", "A3", "B3", "C3", "A4", "B4", "C4", "A5", "B5", "C5", "LEAD", "TILT", "THETA", "DC", "OVR", "OVRRAP", "POSP", "DL", "SPINU", "MEAS", "MEAW", "STAT", "TU",
)  # fmt: skip
ACTIONS = ("WHENEVER", "WHEN", "EVERY", "FROM", "DO")  # synchronised actions
AXIAL = (
    "AX",
    "POS",
    "POSA",
    "POSP",
    "FA",
    "FL",
    "ACC",
    "OVRA",
    "VELOLIM",
    "SPOS",
    "SPOSA",
    "PO",
    "S",
    "M",
    "JERKLIM",
    "FXS",
    "FXST",
    "FXSW",
    "FDA",
)


_VALUE = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_PLAIN = re.compile(
    rf"[ \t]*(?:N(\d+)[ \t]*)?(?:G0?([01])(?![\d.=])[ \t]*)?((?:[XYZ]{_VALUE}(?![\dE])[ \t]*)+)(?:F(\d+\.?\d*|\.\d+)[ \t]*)?(?:;.*)?\Z"
)
_PLAIN_AXIS = re.compile(rf"([XYZ])({_VALUE})")


class Item(NamedTuple):
    """A word, assignment or command. `name` is upper case; columns from 1 (first, one past the last).

    number: of I1=, M1=, R[..]; mode: AC, IC, DC, ACP, ACN; text: of T="..." ; arguments: of NAME(...), None where there is no
    bracket; indices: of NAME[...].
    """

    name: str
    first: int
    last: int
    value: Value | None = None
    number: Callable[[object], int] | None = None
    mode: str = ""
    text: str = ""
    arguments: tuple[Value | None, ...] | None = None
    indices: tuple[Value, ...] = ()


class PlainSinumerik(NamedTuple):
    """A block of nothing but N, G0 or G1, X, Y, Z and F with plain numbers: what most lines are."""

    motion: str | None
    axes: tuple[tuple[int, float], ...]
    feed: float | None


class SinumerikBlock:
    """A line that has been read; the items of a plain line are read when somebody asks for them."""

    __slots__ = ("_items", "first", "flow", "label", "last", "line", "number", "plain", "skipped", "text")

    def __init__(self, line: int, first: int, last: int) -> None:
        self.line, self.first, self.last = line, first, last
        self.number = self.label = self.text = ""
        self.flow: SinumerikFlow | None = None
        self.skipped = False
        self.plain = False
        self._items: list[Item] | None = []

    @property
    def items(self) -> list[Item]:
        """Words, assignments and commands."""
        if self._items is None:
            self._items = parse_block(line_tokens(self.text), self.line).items
        return self._items

    def read(self) -> PlainSinumerik | None:
        """Return the words of a plain line; None for others."""
        match = _PLAIN.match(self.text) if self.plain else None
        if match is None:
            return None
        axes = tuple(("XYZ".index(w[1]), float(w[2])) for w in _PLAIN_AXIS.finditer(match[3]))
        motion = f"G{match[2]}" if match[2] else None
        return PlainSinumerik(motion, axes, None if match[4] is None else float(match[4]))


def plain_block(text: str, line: int) -> SinumerikBlock | None:
    """Return a plain line; None for others, and for one that names an axis twice."""
    match = _PLAIN.match(text)
    if match is None or any(match[3].count(axis) > 1 for axis in "XYZ"):
        return None
    first = len(text) - len(text.lstrip()) + 1
    end = match.end(4 if match[4] else 3)
    block = SinumerikBlock(line, first, len(text[:end].rstrip()) + 1)
    block.number = f"N{match[1]}" if match[1] else ""
    block.text, block.plain, block._items = text, True, None
    return block


def parse_line(tokens: Sequence[Token], line: int) -> list[SinumerikBlock]:
    """Read one line: several blocks where words follow a jump with a condition. Raises BlockFault."""
    blocks = [SinumerikBlock(line, 1, 1)] if not tokens else []
    while tokens:
        block, rest = _block(tokens, line)
        blocks.append(block)
        if rest and (block.flow is None or block.flow.kind != "JUMP" or block.flow.data[2] is None):
            raise BlockFault(
                rest[0].column,
                f'"{rest[0].text.upper()}" follows {block.flow.kind if block.flow else "a block"}; write it in a block of its own',
            )
        tokens = rest
    return blocks


def parse_block(tokens: Sequence[Token], line: int) -> SinumerikBlock:
    """Return the first block of a line without blanks and comments. Raises BlockFault with the column."""
    return parse_line(tokens, line)[0]


def _block(tokens: Sequence[Token], line: int) -> tuple[SinumerikBlock, Sequence[Token]]:
    """Return one block, and the rest of its line."""
    reader = SinumerikReader(tokens)
    block = SinumerikBlock(line, tokens[0].column, tokens[-1].column + len(tokens[-1].text))
    if reader.accept("/"):
        block.skipped = True
        level = reader.upper()
        if len(level) == 1 and level.isdigit():  # /0 to /9: one of ten switches
            reader.at += 1
    _number_and_label(reader, block)
    if _is_action(reader):
        block.items.append(Item("WHENEVER", reader.column, reader.read_to))
        return block, ()
    while not reader.is_done and block.flow is None:
        _item(reader, block)
    return block, tokens[reader.at :]


def _is_action(reader: SinumerikReader) -> bool:
    """Read [ID=1] WHENEVER $A_IN[1] DO OVR=0: a synchronised action, to the end of the block."""
    texts = [reader.upper(k) for k in range(4)]
    return texts[0] in ACTIONS or (texts[0] in ("ID", "IDS") and texts[1] == "=" and texts[3] in ACTIONS)


def _number_and_label(reader: SinumerikReader, block: SinumerikBlock) -> None:
    token = reader.peek()
    if token is not None and token.kind == "word" and token.text[0] in "nN" and reader.upper(1) != "=":
        block.number = f"N{token.text[1:].strip()}"
        reader.at += 1
    token = reader.peek()
    if token is not None and token.kind in ("name", "word") and reader.upper(1) == ":":
        block.label = token.text.upper()
        reader.at += 2
    elif token is not None and reader.accept("ENDLABEL"):
        reader.expect(":", "after ENDLABEL")
        block.label = "ENDLABEL"


def _item(reader: SinumerikReader, block: SinumerikBlock) -> None:
    token = reader.peek()
    assert token is not None
    if token.kind == "name" and _flow(reader, block):
        return
    if token.kind in ("name", "letter") and reader.upper(1) == "[" and token.text.upper() != "R":
        block.items.append(_read_indexed(reader))
    elif token.kind == "name":
        block.items.append(_name(reader))
    elif token.kind == "word":
        block.items.append(_word(reader))
    elif token.kind == "letter":
        block.items.append(_letter(reader))
    else:
        raise reader.fault(
            f'"{token.text}" cannot be understood here; words are an address and a value, as in X12.5 or X=R1'
        )


def _word(reader: SinumerikReader) -> Item:
    """Read X10, G1, R5=..., I1=..., M1=3, L100."""
    token = reader.peek()
    assert token is not None
    letter, number = token.text[0].upper(), token.text[1:].strip()
    if reader.upper(1) == "=" and number.isdigit():
        if letter == "R":
            return _parameter(reader, token)
        reader.at += 2
        value, mode, text = _value(reader)
        fixed = int(number)
        return Item(
            letter, token.column, reader.read_to, value, lambda variables: fixed, mode=mode, text=text
        )
    reader.at += 1
    arguments = tuple(reader.optional_arguments()) if letter == "L" and reader.upper() == "(" else None
    return Item(letter, token.column, reader.read_to, number_of(number), text=number, arguments=arguments)


def _parameter(reader: SinumerikReader, token: Token) -> Item:
    """Read R5=..., R[...]=..."""
    index = reader.index()
    reader.expect("=", "after the R parameter")
    value = reader.expression()
    return Item("R", token.column, reader.read_to, value, index)


def _read_indexed(reader: SinumerikReader) -> Item:
    """Read AX[_Z]=5, POS[X]=10, $P_UIFR[1,X,TR]=3, FIELD[2]=R1."""
    token = reader.next()
    index = reader.indices()
    reader.expect("=", f"after {token.text}[...]")
    if token.text.upper() == "PO":  # a polynomial: end point and coefficients
        value: Value | None = reader.optional_arguments()[0]
        return Item("PO", token.column, reader.read_to, value, indices=index)
    value, mode, text = _value(reader)
    return Item(token.text.upper(), token.column, reader.read_to, value, mode=mode, text=text, indices=index)


def _letter(reader: SinumerikReader) -> Item:
    """Read X=..., R[..]=..."""
    token = reader.peek()
    assert token is not None
    letter = token.text.upper()
    if letter == "R" and reader.upper(1) == "[":
        return _parameter(reader, token)
    reader.at += 1
    reader.expect("=", f"after {letter}, which has no number")
    if letter == "R":
        raise reader.fault("R needs a number, as in R1=5; the radius of an arc is CR=", token.column)
    value, mode, text = _value(reader)
    return Item(letter, token.column, reader.read_to, value, mode=mode, text=text)


def _value(reader: SinumerikReader) -> tuple[Value | None, str, str]:
    """Return the value of a word: expression, AC(...), IC(...) or a text."""
    token = reader.peek()
    if token is not None and token.kind == "string" and reader.upper(1) != "<<":
        reader.at += 1
        return None, "", token.text[1:-1]
    name = reader.upper()
    if name in ("AC", "IC", "DC", "ACP", "ACN") and reader.upper(1) == "(":
        reader.at += 1
        return reader.arguments()[0], name, ""
    if name in ("CAC", "CIC", "CDC", "CACP", "CACN") and reader.upper(1) == "(":
        raise reader.fault(f"{name}(...) is not understood; write AC(...) or IC(...)")
    return reader.expression(), "", ""


def _name(reader: SinumerikReader) -> Item:
    """Read NAME, NAME=value, NAME(arguments)."""
    token = reader.next()
    name = token.text.upper()
    if name in ("MSG", "SETAL"):
        _text(reader)
        return Item(name, token.column, reader.read_to)
    if name == "EXTERN":
        reader.at = len(reader.tokens)
        return Item(name, token.column, reader.read_to)
    if name in ("CALL", "PCALL", "EXTCALL", "ISOCALL", "MCALL") and (called := _called_text(reader)):
        return Item(name, token.column, reader.read_to, text=called)
    if reader.accept("="):
        value, mode, text = _value(reader)
        return Item(name, token.column, reader.read_to, value, mode=mode, text=text)
    if reader.upper() == "(":
        arguments = tuple(reader.optional_arguments())
        return Item(name, token.column, reader.read_to, arguments=arguments)
    return Item(name, token.column, reader.read_to)


def _called_text(reader: SinumerikReader) -> str:
    """Return the name of CALL "NAME", EXTCALL("NAME"); nothing is read where there is none."""
    ahead = 1 if reader.upper() == "(" else 0
    token = reader.peek(ahead)
    if token is None or token.kind != "string":
        return ""
    reader.at += 1 + 2 * ahead
    return token.text[1:-1]


def _text(reader: SinumerikReader) -> None:
    """Read the brackets of MSG and SETAL with their contents; words may follow."""
    depth = 0
    while not reader.is_done:
        depth += (reader.upper() == "(") - (reader.upper() == ")")
        reader.at += 1
        if depth <= 0:
            return


def _flow(reader: SinumerikReader, block: SinumerikBlock) -> bool:
    """Read flow control; True where there was some."""
    block.flow = flow_of(reader)
    return block.flow is not None
