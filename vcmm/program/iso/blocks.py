"""One line of a G-code program as an IsoBlock: words, assignments, flow control. Read once, executed as often as needed."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import NamedTuple

from vcmm.program.dialects import Dialect
from vcmm.program.expressions import Evaluation, Value
from vcmm.program.faults import BlockFault
from vcmm.program.iso.expressions import LineReader

O_WORDS = (
    "endsub", "sub", "call", "return", "elseif", "endif", "else", "if", "endwhile", "while", "do", "endrepeat", "repeat",
    "break", "continue",
)  # fmt: skip
_MACRO = re.compile(r"(IF|WHILE|GOTO|END|DO)(?![A-Z])", re.IGNORECASE)
_KEYWORD = re.compile(r"[ \t]*([A-Za-z]+)")
_PLAIN_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_PLAIN = re.compile(rf"[ \t]*(?:N(\d+)[ \t]*)?(?:[A-MP-Z]{_PLAIN_NUMBER}[ \t]*)+\Z", re.IGNORECASE | re.ASCII)
_PLAIN_WORD = re.compile(rf"([A-MP-Z])({_PLAIN_NUMBER})", re.IGNORECASE | re.ASCII)
_BARE_EXPRESSION = re.compile(r"[ \t]*[-+]?[ \t]*#\d+[ \t]*[-+*/]")  # X#1/2, as some laser cutters take it
_CORNER = re.compile(r",[ \t]*[RC][ \t]*[-+.\d#\[]", re.IGNORECASE)
_LETTERS = "ABCDEFGHIJKLMNPQRSTUVWXYZ"
_OUTPUT = re.compile(r"[ \t]*(?:N\d+[ \t]*)?(DPRNT|BPRNT|POPEN|PCLOS|SETVN)\b", re.IGNORECASE)
_SECOND_BLOCK = re.compile(
    r"[ \t]*/?(?:[A-MP-Z][ \t]*[-+]?(?:\d+\.?\d*|\.\d+)[ \t]*)+;?[ \t]*\Z", re.IGNORECASE | re.ASCII
)
_MESSAGE = re.compile(r"[ \t]*M11[78]\b", re.IGNORECASE)
_CALL_BY_NAME = re.compile(
    r"[ \t]*(?:N\d+[ \t]*)?M[ \t]*1?98[ \t]*[(<][ \t]*([\w.-]+)[ \t]*[)>][ \t]*(?:L[ \t]*(\d+))?[ \t]*;?[ \t]*\Z",
    re.IGNORECASE,
)
_TITLE = re.compile(r"[ \t]*(?:[O:][ \t]*(\d*[A-Z_][\w-]*|(?=[ \t]*\Z))|<([\w.-]+)>)[ \t]*\Z", re.IGNORECASE)


class Word(NamedTuple):
    """A letter and its value; columns from 1: of the letter, one past the last character. `text` is the value as written."""

    letter: str
    value: Value
    first: int
    last: int
    text: str

    @property
    def has_point(self) -> bool:
        """Written with a decimal point, or computed."""
        return "." in self.text or callable(self.value)


class Assign(NamedTuple):
    """#target = value."""

    target: str | Value
    value: Value
    column: int


class IsoFlow(NamedTuple):
    """IsoFlow control. kind: an O-word, or of macro B: goto, if-goto, if-then, while, end, program.

    label: of an O-word (a name, a number as text, or a function that gives the number); else the number of DO or END.
    """

    kind: str
    label: str | Evaluation
    column: int
    values: tuple[Value, ...] = ()
    then: tuple[Assign, ...] = ()


@dataclass(slots=True)
class IsoBlock:
    """A line that has been read. `n` is its N number."""

    line: int
    text: str
    words: list[Word] = field(default_factory=list)
    assigns: list[Assign] = field(default_factory=list)
    flow: IsoFlow | None = None
    n: int | None = None
    percent: bool = False
    has_slash: bool = False
    optional: tuple[int, int] | None = (
        None  # how many words and assignments stand before a / within the block
    )
    blank_column: int = 0  # column of a number with blanks inside
    subprogram_call: tuple[str, int] | None = None  # M98 <NAME> L2: the subprogram by its name, and how often
    beside: str = (
        ""  # what it is, where no axis has to do with it: output to a printer, a command of the console
    )


def parse_block(text: str, line: int, dialect: Dialect) -> IsoBlock:
    """Read one line. Raises BlockFault with the column."""
    block = IsoBlock(line, text)
    plain = _PLAIN.match(text)
    if plain is not None:  # most lines: nothing but letters with numbers
        _plain_words(block, plain)
        return block
    if dialect.words == "macro" and (named := _CALL_BY_NAME.match(text)):
        block.subprogram_call = (named[1], int(named[2] or 1))
        return block
    clean = without_comments(text, dialect)
    _check_characters(clean)
    if clean.lstrip().startswith("%"):
        block.percent = True
        return block
    block.beside = _beside(clean, dialect)
    if block.beside:
        return block
    reader = LineReader(clean, dialect.words)
    if reader.accept("/"):
        block.has_slash = True
        if clean[reader.at : reader.at + 1].isdigit():  # /2: one of nine switches
            reader.at += 1
    while reader.skip():
        if reader.text[reader.at] == "/" and dialect.words == "macro" and block.optional is None:
            _rest(reader, block)
            continue
        _item(reader, block, dialect)
    return block


def _rest(reader: LineReader, block: IsoBlock) -> None:
    """Read the rest of a block, X1. /Y2.: the words from here on can be left out."""
    reader.at += 1
    if re.match(r"[1-9][ \t]*[A-Z#]", reader.text[reader.at :], re.IGNORECASE):  # one of nine switches
        reader.at += 1
    block.optional = (len(block.words), len(block.assigns))


def _beside(clean: str, dialect: Dialect) -> str:
    """Return the kind of a line without moves; "" for a block. A title without a number is such a line."""
    first = clean.strip()[:1]
    if first and dialect.survey and first in "$!~?":
        return f"{clean.split()[0]}, a command of the console"
    if dialect.survey and dialect.name == "grbl" and _MESSAGE.match(clean):
        return "M117, a message"
    if dialect.words != "macro":
        return ""
    if output := _OUTPUT.match(clean):
        return output[1].upper()
    title = _TITLE.match(clean) if dialect.survey else None
    return f"the title {title[1] or title[2] or ':'}" if title else ""


def _plain_words(block: IsoBlock, plain: re.Match[str]) -> None:
    begin = 0
    if plain[1] is not None:
        block.n, begin = int(plain[1]), plain.end(1)
    for match in _PLAIN_WORD.finditer(block.text, begin):
        number = float(match[2])
        if number - number != 0.0:
            raise BlockFault(match.start() + 1, f"the number of {match[1]} is too large; correct it")
        block.words.append(Word(match[1].upper(), number, match.start() + 1, match.end() + 1, match[2]))


def without_comments(text: str, dialect: Dialect) -> str:
    """Return the line with every comment blanked, so that columns stay. Raises BlockFault: never closed, nested, stray ')'."""
    if "(" not in text and ";" not in text and ")" not in text:
        return text
    out = list(text)
    at = 0
    while at < len(text):
        if text[at] == "(":
            end = _comment_end(text, at, dialect)
            out[at:end] = " " * (end - at)
            at = end
        elif text[at] == ")":
            raise BlockFault(at + 1, '")" without "(": remove it, or open the comment with "("')
        elif text[at] == ";":
            rest = text[at + 1 :]
            words = (
                _SECOND_BLOCK.match(rest)
                if dialect.survey
                else rest.strip() and not rest.lstrip().startswith(("(", ";"))
            )
            if not dialect.semicolon_comment and words:
                raise BlockFault(
                    at + 2, 'a second block follows ";" on the same line; write it on a line of its own'
                )
            if not dialect.semicolon_comment and dialect.survey and not rest.lstrip().startswith("("):
                out[at:] = " " * (len(text) - at)  # prose: a note
                break
            if not dialect.semicolon_comment:
                out[at] = " "
                at += 1
                continue
            out[at:] = " " * (len(text) - at)
            break
        else:
            at += 1
    return "".join(out)


def _comment_end(text: str, begin: int, dialect: Dialect) -> int:
    depth = 0
    for at in range(begin, len(text)):
        if text[at] == "(":
            depth += 1
            if depth > 1 and not dialect.nested_comments:
                raise BlockFault(
                    at + 1, "a comment inside a comment; close the first one before, or use other brackets"
                )
        elif text[at] == ")":
            depth -= 1
            if depth == 0:
                return at + 1
    first = text.find(")", begin)
    if (
        dialect.survey and dialect.nested_comments and first >= 0
    ):  # Fanuc itself ends a comment at the first ")"
        return first + 1
    raise BlockFault(begin + 1, 'the comment is never closed; add ")" on the same line')


def _check_characters(clean: str) -> None:
    if clean.isascii() and clean.replace("\t", " ").isprintable():
        return
    for at, character in enumerate(clean):
        if not (character == "\t" or (character.isascii() and character.isprintable())):
            raise BlockFault(
                at + 1,
                f"the character {character!r} (U+{ord(character):04X}) is not allowed outside comments; remove it",
            )


def _item(reader: LineReader, block: IsoBlock, dialect: Dialect) -> None:
    """Read one word, assignment or piece of flow control."""
    here = reader.skip()
    if here == "#":
        block.assigns.append(_assignment(reader))
        return
    if dialect.words == "macro" and (match := _MACRO.match(reader.text, reader.at)):
        block.flow = _macro(reader, match[1].upper(), block)
        return
    if here in "oO" or (here == ":" and dialect.words == "macro"):
        _o_word(reader, block, dialect)
        return
    if here == "," and dialect.words == "macro" and _CORNER.match(reader.text, reader.at):
        reader.at += 1
        reader.skip()
        _word(reader, block, ",")
        return
    if here == ",":
        raise reader.fault(
            "corner rounding and chamfers (,R ,C) are not understood; program the arc or the line itself"
        )
    if here == "%" and dialect.survey:  # the end of the record behind a last block
        reader.at = len(reader.text)
        return
    if here.upper() not in _LETTERS and not (here in "$@^" and dialect.words == "o"):
        raise reader.fault(
            f"{here!r} cannot be understood here; words are a letter and a number, as in X12.5"
        )
    _word(reader, block, open_value=dialect.survey and dialect.words == "macro")


def _word(reader: LineReader, block: IsoBlock, comma: str = "", open_value: bool = False) -> None:
    first = reader.at
    letter = comma + reader.text[first].upper()
    reader.at += 1
    before = reader.at
    try:
        open_value = open_value and _BARE_EXPRESSION.match(reader.text, reader.at) is not None
        value = reader.expression() if open_value else reader.value()
    except BlockFault as fault:
        text = f'the word "{letter}" has no number that can be read: {fault.text}'
        raise BlockFault(fault.column, text) from None
    text = reader.text[before : reader.at].strip()
    last = before + len(reader.text[before : reader.at].rstrip()) + 1
    if letter == "N":
        if block.words or block.n is not None:
            raise BlockFault(
                first + 1, "N must be the first word of a block; move it to the start of the line"
            )
        if callable(value) or value < 0:
            raise BlockFault(first + 1, f"N{text} is no block number; write a plain positive number")
        block.n = int(value)
        return
    if not callable(value) and re.search(r"\d[ \t]+[\d.]|\.[ \t]+\d", text):
        block.blank_column = first + 1
    block.words.append(Word(letter, value, first + 1, last, text))


def _assignment(reader: LineReader) -> Assign:
    column = reader.at + 1
    target = reader.target()
    reader.expect("=", "after the parameter to be set")
    value = reader.value() if reader.words == "o" else reader.expression()
    return Assign(target, value, column)


def _o_word(reader: LineReader, block: IsoBlock, dialect: Dialect) -> None:
    column = reader.at + 1
    reader.at += 1
    label = _label(reader, column)
    match = _KEYWORD.match(reader.text, reader.at)
    word = match[1].lower() if match else ""
    kind = next((k for k in O_WORDS if word.startswith(k)), "")
    if dialect.words == "o" and kind:
        assert match is not None
        reader.at = match.start(1) + len(kind)
        block.flow = _o_flow(reader, kind, label, column)
        return
    if callable(label):
        raise BlockFault(column, "the number of a program must be a plain number")
    block.flow = IsoFlow("program", label, column)


def _label(reader: LineReader, column: int) -> str | Evaluation:
    here = reader.skip()
    if here == "<":
        end = reader.text.find(">", reader.at)
        if end < 0:
            raise BlockFault(column, 'the name of an O-word is never closed; add ">"')
        name = "".join(reader.text[reader.at + 1 : end].split()).lower()
        reader.at = end + 1
        return name
    if here.isdigit():
        digits = re.match(r"\d+", reader.text[reader.at :])
        assert digits is not None
        reader.at += digits.end()
        return str(int(digits[0]))
    value = reader.value()
    if not callable(value):
        raise BlockFault(column, "an O-word takes a number or <name>; write for example o100 sub")
    return value


def _o_flow(reader: LineReader, kind: str, label: str | Evaluation, column: int) -> IsoFlow:
    values: list[Value] = []
    while reader.skip() == "[":
        values.append(reader.bracket())
    if reader.skip():
        raise reader.fault(
            f"nothing but expressions in [ ] may follow o{'' if callable(label) else label} {kind}"
        )
    if kind in ("if", "elseif", "while", "repeat") and len(values) != 1:
        raise BlockFault(column, f"{kind} takes one expression; write for example o100 {kind} [#1 GT 0]")
    return IsoFlow(kind, label, column, tuple(values))


def _macro(reader: LineReader, word: str, block: IsoBlock) -> IsoFlow:
    column = reader.at + 1
    reader.at += len(word)
    if word == "GOTO":
        return IsoFlow("goto", "", column, (reader.value(),))
    if word in ("END", "DO"):
        kind = "end" if word == "END" else "do"
        return IsoFlow(kind, _loop_number(reader, word), column)
    condition = reader.expression()
    if word == "WHILE":
        reader.expect("DO", "after WHILE[...]; write WHILE[#1 LT 5] DO1")
        return IsoFlow("while", _loop_number(reader, "DO"), column, (condition,))
    if reader.accept("GOTO"):
        return IsoFlow("if-goto", "", column, (condition, reader.value()))
    reader.expect("THEN", "after IF[...]; write IF[...] GOTO 10 or IF[...] THEN #1=2")
    then = [_assignment(reader)]
    while reader.skip() == "#":
        then.append(_assignment(reader))
    return IsoFlow("if-then", "", column, (condition,), tuple(then))


def _loop_number(reader: LineReader, word: str) -> str:
    here = reader.skip()
    if here not in ("1", "2", "3"):
        raise reader.fault(f"{word} takes the number 1, 2 or 3, as in {word}1")
    reader.at += 1
    return here
