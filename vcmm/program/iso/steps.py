"""Places of the words of a G-code block, and the block without expressions, parameters, calls and jumps."""

from __future__ import annotations

import re

from vcmm.program.iso.blocks import IsoBlock
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.flow import IsoRunner
from vcmm.program.trace import ExecutedBlock, TextCut, WordAt
from vcmm.program.tracer import written_out

_BLOCK_NUMBER = re.compile(r"[ \t]*(?:/[ \t]*\d?)?[ \t]*(?:N[ \t]*\d+)?[ \t]*", re.IGNORECASE)
_PROGRAM = re.compile(r"[O:][ \t]*\d+", re.IGNORECASE)


def words_of(w: IsoWords) -> dict[str, WordAt]:
    """Return the words by letter, without G and M."""
    return {
        letter: WordAt(
            letter, word.first, word.last, word.text, not callable(word.value), _decimals(word.text)
        )
        for letter, word in w.words.items()
    }


def _decimals(text: str) -> int | None:
    return len(text.rstrip().partition(".")[2].replace(" ", "")) if "." in text else None


def step_of(r: IsoRunner, block: IsoBlock, index: int) -> ExecutedBlock:
    """Return the block as it is executed now."""
    call = len(r.calls)
    computed = any(callable(w.value) for w in block.words)
    called = _codes(block)
    if not computed and not called and not block.assigns and block.flow is None:
        return ExecutedBlock(r.text.name, index + 1, index + 1, call, ())
    return ExecutedBlock(r.text.name, index + 1, index + 1, call, tuple(_cuts(r, block, index + 1, called)))


def _codes(block: IsoBlock) -> set[str]:
    """Return calls and returns among the codes of a block."""
    codes = {f"{w.letter}{w.value:g}" for w in block.words if w.letter in "GM" and not callable(w.value)}
    return codes & {"M98", "M99", "G65", "G66", "G67"}


def _cuts(r: IsoRunner, block: IsoBlock, line: int, called: set[str]) -> list[TextCut]:
    end = len(_code(block.text)) + 1
    flow = block.flow
    if flow is not None and flow.kind != "program":
        head = _BLOCK_NUMBER.match(block.text)
        return [TextCut(line, head.end() + 1 if head else 1, end, "")]
    out = [_assignment(block, a.column, line, end) for a in block.assigns]
    if flow is not None and r.calls:
        number = _PROGRAM.search(block.text)
        if number:
            out.append(TextCut(line, number.start() + 1, number.end() + 1, ""))
    gone = _words_of_call(r, called)
    for word in block.words:
        name = (
            word.letter if word.letter not in "GM" or callable(word.value) else f"{word.letter}{word.value:g}"
        )
        if gone == "all" or name in gone:
            out.append(TextCut(line, word.first, word.last, ""))
        elif callable(word.value):
            value = r.compute(word.value, word.first)
            out.append(
                TextCut(
                    line,
                    word.first,
                    word.last,
                    "" if value is None else word.letter + _text(value, word.letter),
                )
            )
    return out


def _text(value: float, letter: str) -> str:
    """Return the text with a point where it is a length: an expression counts in mm on every control."""
    text = written_out(value)
    return text + "." if "." not in text and letter in "XYZUVWIJKRQ" else text


def _words_of_call(r: IsoRunner, called: set[str]) -> str | frozenset[str]:
    """Return the words that go with a call or return."""
    if called & {"G65", "G66", "G67"}:
        return "all"
    if "M98" in called:
        return frozenset(("M98", "P", "L"))
    if "M99" in called and r.calls:
        return frozenset(("M99", "P"))
    return frozenset()


def _assignment(block: IsoBlock, column: int, line: int, end: int) -> TextCut:
    """Return the cut of #1=... up to what follows it."""
    starts = [w.first for w in block.words] + [a.column for a in block.assigns]
    return TextCut(line, column, min([s for s in starts if s > column], default=end), "")


def _code(text: str) -> str:
    """Return the line without a comment at its end."""
    return re.sub(r"(?:[ \t]*(?:\([^()]*\)|;.*))+[ \t]*\Z", "", text).rstrip()
