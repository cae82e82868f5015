"""The words of a Klartext positioning block: coordinates, radius compensation, feed, M functions."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from vcmm.program.heidenhain.codes import PARAMETERS
from vcmm.program.heidenhain.text import KlartextReader

AXES, ROTARY, BESIDE = "XYZ", "ABC", "UVW"  # BESIDE: axes that no machine here has
NAMING = (94, 138)  # M functions with names of axes behind them
SIDES = {"R0": None, "RL": "left", "RR": "right"}


@dataclass
class KlartextWords:
    """Words of a block. Coordinates as programmed; keys with I before the axis are incremental."""

    values: dict[str, float] = field(default_factory=dict)
    columns: dict[str, int] = field(default_factory=dict)
    side: str | None = None
    has_side: bool = False
    clockwise: bool | None = None
    rapid: bool = False
    feed: float | None = None
    feed_kind: str = ""
    m: list[int] = field(default_factory=list)
    has_moved: bool = False
    away: float | None = None  # M140 MB: as programmed, infinite for MAX

    def has(self, *names: str) -> bool:
        return any(n in self.values for n in names)

    def take(self, name: str) -> float | None:
        return self.values.pop(name, None)


def read_words(reader: KlartextReader, addresses: tuple[str, ...], bare: str = "") -> KlartextWords:
    """Return all words to the end of the block. addresses: besides axes; bare: the address of a plain number."""
    words = KlartextWords()
    axes = (*AXES, *ROTARY, *BESIDE)
    names = (*axes, *(f"I{a}" for a in axes), *addresses)
    while not reader.is_done:
        name, column = reader.upper(), reader.column
        token = reader.peek()
        assert token is not None
        if token.kind != "name":
            if not bare or bare in words.values:
                raise reader.fault(
                    f'"{token.text}" cannot be understood here; words are an address and a value, as in X+12.5'
                )
            begin = reader.at
            words.values[bare], words.columns[bare] = reader.value("the block"), column
            reader.spans[bare] = (begin, begin, reader.at)
        elif _modal(reader, words, name):
            continue
        elif name in names:
            reader.at += 1
            if name in words.values:
                raise reader.fault(f"{name} appears twice in this block; remove one", column)
            begin = reader.at
            words.values[name], words.columns[name] = reader.value(name), column
            reader.spans[name] = (begin - 1, begin, reader.at)
        else:
            raise reader.fault(
                f"{token.text} is not understood in this block; rewrite it with L, C, CR and plain coordinates"
            )
    return words


def _modal(reader: KlartextReader, words: KlartextWords, name: str) -> bool:
    """Read R0 RL RR, DR+ DR-, F, M; True where one of them was read."""
    if name in ("RL", "RR"):
        reader.at += 1
        words.side, words.has_side = SIDES[name], True
        return True
    if name == "R" and reader.upper(1) == "0" and "R" not in words.values:
        reader.at += 2
        words.side, words.has_side = None, True
        return True
    if name == "DR" and not _oversize(reader):
        sign = reader.upper(1)
        if sign not in ("+", "-"):
            raise reader.fault("DR takes the sense of rotation, DR+ (counterclockwise) or DR-")
        reader.spans["DR"] = (reader.at, reader.at + 1, reader.at + 2)
        reader.at += 2
        words.clockwise = sign == "-"
        return True
    if name == "FMAX":
        reader.at += 1
        words.rapid = True
        return True
    if name in ("F", "FU", "FZ", "FAUTO"):
        _feed(reader, words, name)
        return True
    if name == "M":
        column = reader.column
        reader.at += 1
        words.m.append(round(reader.value("M")))
        words.columns[f"M{words.m[-1]}"] = column
        _parameters(reader, words, words.m[-1])
        return True
    return False


def _parameters(reader: KlartextReader, words: KlartextWords, m: int) -> None:
    """Read words that belong to an M function: M128 F1000 is no feed of the contour, M118 X1 no coordinate."""
    while m in NAMING and reader.upper() in (*AXES, *ROTARY):
        reader.at += 1  # M94 C, M138 A C: names without numbers
    while reader.upper() in PARAMETERS.get(m, ()) or (m in (128, 140) and reader.upper() == "FMAX"):
        name = reader.upper()
        reader.at += 1
        if name == "FMAX" or reader.accept("MAX"):
            value = math.inf
        else:
            value = reader.value(name)
        if name == "MB":
            words.away = value
        elif m == 140:
            words.rapid, words.feed, words.feed_kind = value == math.inf, value, "F"


def _oversize(reader: KlartextReader) -> bool:
    """Return whether it is DR+0.1 or DR0. of TOOL CALL, not the sense of rotation DR+."""
    signed = 1 + (reader.upper(1) in ("+", "-"))
    token = reader.peek(signed)
    return token is not None and (token.kind == "number" or reader.is_parameter(signed))


def _feed(reader: KlartextReader, words: KlartextWords, name: str) -> None:
    reader.at += 1
    if name == "FAUTO" or (name == "F" and reader.accept("AUTO")):
        words.feed_kind = "AUTO"
    elif name == "F" and reader.accept("MAX"):
        words.rapid = True
    else:
        begin = reader.at
        words.feed, words.feed_kind = reader.value(name), name
        reader.spans["F"] = (begin - 1, begin, reader.at)
