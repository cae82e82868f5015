"""One line of a Sinumerik program as a SinumerikBlock: label, items (words, assignments, commands), flow control."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from vcmm.nc.expressions import Value
from vcmm.nc.faults import BlockFault
from vcmm.nc.sinumerik.text import SinumerikReader, number_of
from vcmm.nc.tokens import Token

JUMPS = ("GOTOF", "GOTOB", "GOTO", "GOTOC", "GOTOS")
ALONE = ("ELSE", "ENDIF", "ENDWHILE", "ENDFOR", "LOOP", "ENDLOOP", "RET")
ADDRESSES = (  # names that take "= value"
    "CR", "AR", "TURN", "ADIS", "ADISPOS", "RPL", "RND", "RNDM", "CHF", "CHR", "FRC", "FRCM", "LIMS", "AP", "RP", "CTOL", "DISC",
    "ANG", "SPOS", "OFFN", "FB", "FD", "FA", "SD", "PW", "PL",
)  # fmt: skip


class Item(NamedTuple):
    """A word, assignment or command. `name` is upper case; columns from 1 (first, one past the last).

    number: of I1=, M1=, R[..]; mode: AC or IC; text: of T="..." ; arguments: of NAME(...), None where there is no bracket.
    """

    name: str
    first: int
    last: int
    value: Value | None = None
    number: Callable[[object], int] | None = None
    mode: str = ""
    text: str = ""
    arguments: tuple[Value | None, ...] | None = None


class SinumerikFlow(NamedTuple):
    """SinumerikFlow control; `data` depends on the kind."""

    kind: str
    column: int
    data: tuple[Any, ...] = ()


@dataclass(slots=True)
class SinumerikBlock:
    """A line that has been read."""

    line: int
    first: int
    last: int
    number: str = ""
    label: str = ""
    items: list[Item] = field(default_factory=list)
    flow: SinumerikFlow | None = None
    skipped: bool = False


def parse_block(tokens: Sequence[Token], line: int) -> SinumerikBlock:
    """Read one line without blanks and comments. Raises BlockFault with the column."""
    if not tokens:
        return SinumerikBlock(line, 1, 1)
    reader = SinumerikReader(tokens)
    block = SinumerikBlock(line, tokens[0].column, tokens[-1].column + len(tokens[-1].text))
    if reader.accept("/"):
        block.skipped = True
        level = reader.upper()
        if len(level) == 1 and level.isdigit():  # /0 to /9: one of ten switches
            reader.at += 1
    _number_and_label(reader, block)
    while not reader.done:
        if block.flow is not None:
            raise reader.fault(
                f'"{reader.upper()}" stands behind {block.flow.kind}; write it in a block of its own'
            )
        _item(reader, block)
    return block


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
    if token.kind == "name":
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
    """X10, G1, R5=..., I1=..., M1=3, L100."""
    token = reader.peek()
    assert token is not None
    letter, number = token.text[0].upper(), token.text[1:].strip()
    if reader.upper(1) == "=" and number.isdigit():
        if letter == "R":
            return _parameter(reader, token)
        reader.at += 2
        value, mode, text = _value(reader)
        fixed = int(number)
        return Item(letter, token.column, reader.reached, value, lambda known: fixed, mode=mode, text=text)
    reader.at += 1
    return Item(letter, token.column, reader.reached, number_of(number), text=number)


def _parameter(reader: SinumerikReader, token: Token) -> Item:
    """R5=..., R[...]=..."""
    index = reader.index()
    reader.expect("=", "after the R parameter")
    value = reader.expression()
    return Item("R", token.column, reader.reached, value, index)


def _letter(reader: SinumerikReader) -> Item:
    """X=..., R[..]=..."""
    token = reader.peek()
    assert token is not None
    letter = token.text.upper()
    if letter == "R" and reader.upper(1) == "[":
        return _parameter(reader, token)
    reader.at += 1
    reader.expect("=", f"after {letter}, which has no number")
    value, mode, text = _value(reader)
    return Item(letter, token.column, reader.reached, value, mode=mode, text=text)


def _value(reader: SinumerikReader) -> tuple[Value | None, str, str]:
    """Expression, AC(...), IC(...) or a text."""
    token = reader.peek()
    if token is not None and token.kind == "string":
        reader.at += 1
        return None, "", token.text[1:-1]
    name = reader.upper()
    if name in ("AC", "IC") and reader.upper(1) == "(":
        reader.at += 1
        return reader.arguments()[0], name, ""
    if name in ("DC", "ACP", "ACN", "CAC", "CIC", "CDC") and reader.upper(1) == "(":
        raise reader.fault(f"{name}(...) is not understood; write AC(...) or IC(...)")
    return reader.expression(), "", ""


def _name(reader: SinumerikReader) -> Item:
    """NAME, NAME=value, NAME(arguments)."""
    token = reader.next()
    name = token.text.upper()
    if name in ("MSG", "SETAL"):
        _text(reader)
        return Item(name, token.column, reader.reached)
    if reader.upper() == "[":
        raise reader.fault(
            f"{token.text}[...]: arrays and system variables with an index are not understood", token.column
        )
    if reader.accept("="):
        value, mode, text = _value(reader)
        return Item(name, token.column, reader.reached, value, mode=mode, text=text)
    if reader.upper() == "(":
        arguments = tuple(reader.optional_arguments())
        return Item(name, token.column, reader.reached, arguments=arguments)
    return Item(name, token.column, reader.reached)


def _text(reader: SinumerikReader) -> None:
    """The brackets of MSG and SETAL with what is in them; words may stand behind them."""
    depth = 0
    while not reader.done:
        depth += (reader.upper() == "(") - (reader.upper() == ")")
        reader.at += 1
        if depth <= 0:
            return


def _flow(reader: SinumerikReader, block: SinumerikBlock) -> bool:
    """SinumerikFlow control; True where there was some."""
    name, column = reader.upper(), reader.column
    if name in ALONE:
        reader.at += 1
        block.flow = SinumerikFlow(name, column)
        return True
    if name in JUMPS:
        block.flow = _jump(reader)
        return True
    handler = _FLOWS.get(name)
    if handler is None or (name == "REPEAT" and reader.upper(1) == "="):
        return False
    reader.at += 1
    block.flow = handler(reader, column)
    return True


def _jump(reader: SinumerikReader, condition: Value | None = None) -> SinumerikFlow:
    token = reader.next()
    kind = token.text.upper()
    if kind == "GOTOS":
        return SinumerikFlow("JUMP", token.column, (kind, "", condition))
    return SinumerikFlow("JUMP", token.column, (kind, _target(reader), condition))


def _target(reader: SinumerikReader) -> str:
    token = reader.peek()
    if token is None or token.kind not in ("name", "word", "number"):
        raise reader.fault(
            "the target of a jump is due here: a label or a block number, as in GOTOF END_1 or GOTOF N90"
        )
    reader.at += 1
    return f"N{token.text}" if token.kind == "number" else token.text.upper()


def _if(reader: SinumerikReader, column: int) -> SinumerikFlow:
    condition = reader.expression()
    if reader.done:
        return SinumerikFlow("IF", column, (condition,))
    if reader.upper() not in JUMPS:
        raise reader.fault(
            f'behind IF a jump (GOTOF, GOTOB, GOTO) or nothing may stand, "{reader.upper()}" stands there; use IF ... ENDIF'
        )
    return _jump(reader, condition)


def _condition(kind: str) -> Callable[[SinumerikReader, int], SinumerikFlow]:
    return lambda reader, column: SinumerikFlow(kind, column, (reader.expression(),))


def _for(reader: SinumerikReader, column: int) -> SinumerikFlow:
    token = reader.peek()
    if token is not None and token.text[0] in "rR" and token.kind in ("word", "letter"):
        target: Any = reader.index()
    elif token is not None and token.kind == "name":
        target = reader.next().text.upper()
    else:
        raise reader.fault("FOR takes a variable, as in FOR R1 = 1 TO 10")
    reader.expect("=", "after the variable of FOR")
    start = reader.expression()
    reader.expect("TO", "after the first value of FOR")
    return SinumerikFlow("FOR", column, (target, start, reader.expression()))


def _repeat(reader: SinumerikReader, column: int) -> SinumerikFlow:
    if reader.done:
        return SinumerikFlow("REPEAT", column)
    labels = [_target(reader)]
    token = reader.peek()
    if token is not None and token.kind == "name":
        labels.append(_target(reader))
    return SinumerikFlow("REPEAT_PART", column, (tuple(labels), _times(reader)))


def _repeat_block(reader: SinumerikReader, column: int) -> SinumerikFlow:
    return SinumerikFlow("REPEATB", column, (_target(reader), _times(reader)))


def _times(reader: SinumerikReader) -> Value:
    """P=3 or P3; without it once."""
    token = reader.peek()
    if token is not None and token.kind == "word" and token.text[0] in "pP":
        reader.at += 1
        return number_of(token.text[1:])
    if reader.accept("P"):
        reader.expect("=", "after P")
        return reader.expression()
    return 1.0


def _case(reader: SinumerikReader, column: int) -> SinumerikFlow:
    value = reader.expression()
    reader.expect("OF", "after the expression of CASE")
    cases: list[tuple[Value | None, str, str]] = []
    while not reader.done:
        constant = None if reader.accept("DEFAULT") else reader.expression()
        kind = reader.upper()
        if kind not in JUMPS:
            raise reader.fault("a jump is due here, as in CASE R1 OF 1 GOTOF LABEL_1 DEFAULT GOTOF END_1")
        reader.at += 1
        cases.append((constant, kind, _target(reader)))
    return SinumerikFlow("CASE", column, (value, tuple(cases)))


def _def(reader: SinumerikReader, column: int) -> SinumerikFlow:
    kind = _type(reader, "DEF")
    variables: list[tuple[str, Value | None]] = []
    while True:
        token = reader.peek()
        if token is None or token.kind != "name":
            raise reader.fault(
                "the name of a variable is due here (two letters at least), as in DEF REAL depth=-5"
            )
        reader.at += 1
        if reader.upper() == "[":
            raise BlockFault(
                token.column, f"DEF ... {token.text}[...]: arrays are not understood; use R parameters"
            )
        variables.append((token.text.upper(), reader.expression() if reader.accept("=") else None))
        if not reader.accept(","):
            return SinumerikFlow("DEF", column, (kind, tuple(variables)))


def _type(reader: SinumerikReader, what: str) -> str:
    kind = reader.upper()
    if kind not in ("REAL", "INT", "BOOL"):
        raise reader.fault(f"{what} takes REAL, INT or BOOL{f', {kind} is not understood' if kind else ''}")
    reader.at += 1
    return kind


def _proc(reader: SinumerikReader, column: int) -> SinumerikFlow:
    token = reader.peek()
    if token is None or token.kind not in ("name", "word"):
        raise reader.fault("PROC takes the name of the subprogram")
    name = reader.next().text.upper()
    parameters: list[tuple[str, str, Value | None]] = []
    if reader.accept("(") and not reader.accept(")"):
        while True:
            if reader.upper() == "VAR":
                raise reader.fault(
                    "VAR parameters (call by reference) are not understood; pass values or use R parameters"
                )
            kind = _type(reader, "a parameter of PROC")
            parameters.append(
                (kind, reader.next().text.upper(), reader.expression() if reader.accept("=") else None)
            )
            if not reader.accept(","):
                break
        reader.expect(")", "after the parameters of PROC")
    while reader.upper() in ("SAVE", "DISPLOF", "DISPLON", "SBLOF", "SBLON"):
        if reader.upper() == "SAVE":
            raise reader.fault(
                "PROC ... SAVE (modal functions restored at the end) is not understood; leave SAVE out"
            )
        reader.at += 1
    return SinumerikFlow("PROC", column, (name, tuple(parameters)))


_FLOWS: dict[str, Callable[[SinumerikReader, int], SinumerikFlow]] = {
    "IF": _if, "WHILE": _condition("WHILE"), "UNTIL": _condition("UNTIL"), "FOR": _for, "REPEAT": _repeat,
    "REPEATB": _repeat_block, "CASE": _case, "DEF": _def, "PROC": _proc,
}  # fmt: skip
