"""Flow control of a Sinumerik line: jumps, loops, CASE, DEF, PROC."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from vcmm.program.expressions import Value
from vcmm.program.sinumerik.text import SinumerikReader, number_of

JUMPS = ("GOTOF", "GOTOB", "GOTO", "GOTOC", "GOTOS")
ALONE = ("ELSE", "ENDIF", "ENDWHILE", "ENDFOR", "LOOP", "ENDLOOP", "RET")
TYPES = ("REAL", "INT", "BOOL", "CHAR", "STRING", "AXIS", "FRAME")
BEFORE_TYPE = ("CHAN", "NCK", "SYNR", "SYNW", "SYNRW")  # they move nothing
BEHIND_PROC = (
    "SAVE",
    "DISPLOF",
    "DISPLON",
    "SBLOF",
    "SBLON",
    "ACTBLOCNO",
    "PREPRO",
    "ICYCOF",
    "ICYCON",
    "IPTRLOCK",
)


class SinumerikFlow(NamedTuple):
    """SinumerikFlow control; `data` depends on the kind."""

    kind: str
    column: int
    data: tuple[Any, ...] = ()


class Parameter(NamedTuple):
    """A parameter of PROC; by_reference: VAR, what it becomes is the caller's."""

    kind: str
    name: str
    default: Value | None = None
    by_reference: bool = False


def _jump(reader: SinumerikReader, condition: Value | None = None) -> SinumerikFlow:
    token = reader.next()
    kind = token.text.upper()
    if kind == "GOTOS":
        return SinumerikFlow("JUMP", token.column, (kind, "", condition))
    return SinumerikFlow("JUMP", token.column, (kind, _target(reader), condition))


def _target(reader: SinumerikReader) -> str:
    token = reader.peek()
    if token is not None and token.kind == "string":
        reader.at += 1
        return token.text[1:-1].upper()
    if token is None or token.kind not in ("name", "word", "number"):
        raise reader.fault(
            "expected the target of a jump: a label or a block number, as in GOTOF END_1 or GOTOF N90"
        )
    reader.at += 1
    return f"N{token.text}" if token.kind == "number" else token.text.upper()


def _if(reader: SinumerikReader, column: int) -> SinumerikFlow:
    condition = reader.expression()
    if reader.is_done:
        return SinumerikFlow("IF", column, (condition,))
    if reader.upper() not in JUMPS:
        raise reader.fault(
            f'after IF only a jump (GOTOF, GOTOB, GOTO) is allowed, found "{reader.upper()}"; use IF ... ENDIF'
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
    if reader.is_done:
        return SinumerikFlow("REPEAT", column)
    labels = [_target(reader)]
    token = reader.peek()
    if token is not None and token.kind == "name":
        labels.append(_target(reader))
    return SinumerikFlow("REPEAT_PART", column, (tuple(labels), _times(reader)))


def _repeat_block(reader: SinumerikReader, column: int) -> SinumerikFlow:
    return SinumerikFlow("REPEATB", column, (_target(reader), _times(reader)))


def _times(reader: SinumerikReader) -> Value:
    """Return the repetitions P=3 or P3; without it once."""
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
    while not reader.is_done:
        constant = None if reader.accept("DEFAULT") else reader.expression()
        kind = reader.upper()
        if kind not in JUMPS:
            raise reader.fault("expected a jump, as in CASE R1 OF 1 GOTOF LABEL_1 DEFAULT GOTOF END_1")
        reader.at += 1
        cases.append((constant, kind, _target(reader)))
    return SinumerikFlow("CASE", column, (value, tuple(cases)))


def _def(reader: SinumerikReader, column: int) -> SinumerikFlow:
    """Read DEF REAL depth=-5, field[3,2]; DEF STRING[20] name; data: kind, (name, first value, sizes)."""
    while reader.upper() in BEFORE_TYPE:
        reader.at += 1
    kind = _type(reader, "DEF")
    variables: list[tuple[str, Value | None, tuple[Value, ...]]] = []
    while True:
        while reader.upper() in ("PHU", "LLI", "ULI"):
            reader.at += 1
            reader.expression()
        token = reader.peek()
        if token is None or token.kind != "name":
            raise reader.fault(
                "expected the name of a variable (two letters at least), as in DEF REAL depth=-5"
            )
        reader.at += 1
        size = reader.indices() if reader.upper() == "[" else ()
        variables.append(
            (token.text.upper(), _first_value(reader, bool(size)) if reader.accept("=") else None, size)
        )
        if not reader.accept(","):
            return SinumerikFlow("DEF", column, (kind, tuple(variables)))


def _first_value(reader: SinumerikReader, many: bool) -> Value | None:
    """Return a value; of an array that of its elements, where SET(1, 2, 3) gives them the first."""
    if reader.upper() in ("SET", "REP"):
        reader.at += 1
        return next(iter(reader.optional_arguments()), None)
    if many and reader.upper() == "(":
        return next(iter(reader.optional_arguments()), None)
    return reader.expression()


def _type(reader: SinumerikReader, what: str) -> str:
    kind = reader.upper()
    if kind not in TYPES:
        raise reader.fault(f"{what} takes {', '.join(TYPES)}{f', {kind} is not understood' if kind else ''}")
    reader.at += 1
    if kind == "STRING" and reader.upper() == "[":
        reader.indices()
    return kind


def _proc(reader: SinumerikReader, column: int) -> SinumerikFlow:
    """Read PROC NAME(REAL depth, VAR INT count=3) SAVE; data: name, parameters, whether it restores modal functions."""
    token = reader.peek()
    if token is None or token.kind not in ("name", "word"):
        raise reader.fault("PROC takes the name of the subprogram")
    name = reader.next().text.upper()
    parameters: list[Parameter] = []
    if reader.accept("(") and not reader.accept(")"):
        while True:
            by_reference = reader.accept("VAR")
            kind = _type(reader, "a parameter of PROC")
            called = reader.next().text.upper()
            if reader.upper() == "[":
                reader.indices()
            default = reader.expression() if reader.accept("=") else None
            parameters.append(Parameter(kind, called, default, by_reference))
            if not reader.accept(","):
                break
        reader.expect(")", "after the parameters of PROC")
    saves = False
    while reader.upper() in BEHIND_PROC:
        saves |= reader.next().text.upper() == "SAVE"
        if reader.upper() == "(":
            reader.optional_arguments()
    return SinumerikFlow("PROC", column, (name, tuple(parameters), saves))


_FLOWS: dict[str, Callable[[SinumerikReader, int], SinumerikFlow]] = {
    "IF": _if, "WHILE": _condition("WHILE"), "UNTIL": _condition("UNTIL"), "FOR": _for, "REPEAT": _repeat,
    "REPEATB": _repeat_block, "CASE": _case, "DEF": _def, "PROC": _proc,
}  # fmt: skip


def flow_of(reader: SinumerikReader) -> SinumerikFlow | None:
    """Return the flow control of a line, where there is some."""
    name, column = reader.upper(), reader.column
    if name in ALONE:
        reader.at += 1
        return SinumerikFlow(name, column)
    if name in JUMPS:
        return _jump(reader)
    handler = _FLOWS.get(name)
    if handler is None or (name == "REPEAT" and reader.upper(1) == "="):
        return None
    reader.at += 1
    return handler(reader, column)
