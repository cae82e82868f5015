"""Mutations of one file, drawn with a seed. Those that break a stated limit, type or unit say so: they must be refused."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from random import Random

QUANTITY = re.compile(r'"([-+]?[\d.]+(?:e[-+]?\d+)?)((?: [-+\d.e]+)*) ([a-zA-Z][\w/() ^]*)"')
PLAIN = re.compile(r"(?<![\w\".\[-])-?\d+(?:\.\d+)?(?![\w\".])")
WORD = re.compile(r'= "([A-Za-z][\w .-]*)"')
KEY = re.compile(r"^([a-z_]+)(?= =)", re.MULTILINE)
HUGE = ("1e308", "-1e308", "1e18")
NO_NUMBER = ("nan", "inf", "1e999", "1_000", "１２", "٣", "0x10", "1,5", "abc", "--1", "1e")
OTHER_UNIT = {"kg": "s"}  # for all others a mass is wrong


@dataclass(frozen=True)
class Mutation:
    """The new bytes of the file, what was done, and whether it breaks a stated limit, type or unit."""

    content: bytes
    what: str
    wrong: bool


def mutated(rng: Random, name: str, text: str, survey: bool = False) -> Mutation:
    """One mutation of a file."""
    kinds: list[tuple[Callable[..., tuple[str, str, bool] | None], int]] = list(ANY)
    kinds += TOML if name.endswith(".toml") else [] if survey else CELLS
    kinds += [(_other_dialect, 8)] if name.endswith(PROGRAMS) else []
    if rng.random() < 0.15:
        return _bytes(rng, text)
    while True:
        make = rng.choices([k for k, _ in kinds], [w for _, w in kinds])[0]
        made = make(rng, text)
        if made is not None and made[0] != text:
            return Mutation(made[0].encode("utf-8", "surrogatepass"), made[1], made[2] and not survey)


def _spot(rng: Random, text: str, pattern: re.Pattern[str]) -> re.Match[str] | None:
    found = list(pattern.finditer(text))
    return rng.choice(found) if found else None


def _put(text: str, match: re.Match[str], new: str) -> str:
    return text[: match.start()] + new + text[match.end() :]


# ---------------------------------------------------------------- TOML
def _quantity(rng: Random, text: str) -> tuple[str, str, bool] | None:
    """Another unit, no unit, no text, no number, or nonsense for a value with a unit."""
    at = _spot(rng, text, QUANTITY)
    if at is None:
        return None
    first, rest, unit = at.groups()
    other = OTHER_UNIT.get(unit, "kg")
    new = rng.choice([
        f'"{first}{rest} {other}"', f'"{first}{rest}"', first, "true", "[]", "{}", '""', '"mm"', f'"{unit}"', "nan",
        *(f'"{bad}{rest} {unit}"' for bad in NO_NUMBER), *(f'"{big}{rest} {unit}"' for big in HUGE),
        f'"{first} {first}{rest} {unit}"', f'"{first}{rest} {unit} K"', f'"{first}{rest} {"(" * 5000}{unit}"',
        '"-400 degC"' if unit == "degC" else f'"{first}{rest} mm^{"9" * 30}"', '"' + "9" * 200_000 + f' {unit}"',
    ])  # fmt: skip
    return _put(text, at, new), f"{at[0]} -> {new[:60]}", True


def _number(rng: Random, text: str) -> tuple[str, str, bool] | None:
    """A plain number as text, truth value, list, table or not finite; a count that no machine can hold."""
    at = _spot(rng, text, re.compile(r"(?<== )-?\d+(?:\.\d+)?(?=\s*[,}\n])"))
    if at is None:
        return None
    new = rng.choice(['"8"', "true", "[]", "{}", "nan", "inf", "-7", "1" + "0" * 30, "0x" + "f" * 40, '""'])
    return _put(text, at, new), f"{at[0]} -> {new[:60]}", True


def _word(rng: Random, text: str) -> tuple[str, str, bool] | None:
    """An empty text, a number or a list where a word is due."""
    at = _spot(rng, text, WORD)
    if at is None:
        return None
    new = rng.choice(["3", "true", "{}", '["\\u0000"]', "1979-05-27", '"' + "x" * 100_000 + '"', '""'])
    free = '"' in new and re.search(r"(name|evidence|data|table|rigid) $", text[: at.start()]) is not None
    return _put(text, at, f"= {new}"), f"{at[0]} -> {new[:40]}", not free


def _key(rng: Random, text: str) -> tuple[str, str, bool] | None:
    at = _spot(rng, text, KEY)
    if at is None:
        return None
    new = rng.choice([f"{at[1]}x", "ж".encode().hex(), '""', '"' + "k" * 10_000 + '"'])
    return _put(text, at, new), f"key {at[1]} -> {new[:40]}", True


def _nested(rng: Random, text: str) -> tuple[str, str, bool] | None:
    deep = rng.choice([500, 5000, 100_000])
    new = rng.choice([
        "zz = " + "[" * deep + "]" * deep, "zz = " + "{a=" * deep + "1" + "}" * deep, ".".join(["a"] * deep) + " = 1",
        "[" + ".".join(["b"] * deep) + "]",
    ])  # fmt: skip
    lines = text.split("\n")
    lines.insert(rng.randrange(1, len(lines)), new)
    return "\n".join(lines), f"{new[:20]}... {deep} deep", True


# ---------------------------------------------------------------- tables
def _cell(rng: Random, text: str) -> tuple[str, str, bool] | None:
    """A cell that is no finite number, or one beyond anything that a machine has."""
    at = _spot(rng, text, re.compile(r"(?<=[ ,;\n])-?\d+(?:\.\d+)?(?:e-?\d+)?(?=[ ,;\n])(?! :)"))
    if at is None:
        return None
    new = rng.choice([*NO_NUMBER, *HUGE, "1" * 131_073, '"', "=1+1", "\x00", " ", "-", "\x1b[2J"])
    return _put(text, at, new), f"cell {at[0]} -> {new[:20]!r}", new not in ("=1+1",) and new.strip() != ""


def _separator(rng: Random, text: str) -> tuple[str, str, bool] | None:
    at = _spot(rng, text, re.compile(r"[,;]|(?<=\d) (?=\d)"))
    if at is None:
        return None
    new = rng.choice(["", at[0] * 2 if at[0] in ",;" else " 1 ", at[0] + "1" + at[0]])
    return _put(text, at, new), f"separator {at[0]!r} -> {new!r}", False


def _header(rng: Random, text: str) -> tuple[str, str, bool] | None:
    head, _, rest = text.partition("\n")
    words = re.split(r"([ ,;])", head)
    i = rng.randrange(0, len(words), 2)
    new = rng.choice(["", "Q_mm", words[0], "x" * 50_000, "Х_mm", words[i] + "\t"])
    what = f"column {words[i]} -> {new[:20]!r}"
    words[i] = new
    return "".join(words) + "\n" + rest, what, False


def _unit(rng: Random, text: str) -> tuple[str, str, bool] | None:
    """A column of the header in another unit, or two columns with their units exchanged."""
    head, newline, rest = text.partition("\n")
    found = list(re.finditer(r"_(mm|um|deg|rad|C|s|hPa|arcsec)(?=[,;\t ]|$)", head))
    if not found:
        return None
    one, two = rng.choice(found), rng.choice(found)
    new = rng.choice(["m", "um", "mm", "K", "kg", "deg", "nonsense", "", two[1]])
    return (
        _put(head, one, f"_{new}") + newline + rest,
        f"unit {one[1]} of the column at {one.start()} -> {new}",
        new == "kg",
    )


def _columns(rng: Random, text: str) -> tuple[str, str, bool] | None:
    """The columns in another order, with their cells or without."""
    rows = [line.split(",") for line in text.split("\n")]
    if len(rows[0]) < 2:
        return None
    order = rng.sample(range(len(rows[0])), len(rows[0]))
    last = rng.choice([1, len(rows)])
    moved = [[row[k] for k in order] if len(row) == len(order) else row for row in rows[:last]]
    return (
        "\n".join(",".join(row) for row in [*moved, *rows[last:]]),
        f"columns in the order {order}, {last} lines",
        False,
    )


def _rows(rng: Random, text: str) -> tuple[str, str, bool] | None:
    """A row twice, every row twice, the header once more in the middle, the rows backwards."""
    head, *rows = text.rstrip("\n").split("\n")
    if not rows:
        return None
    i = rng.randrange(len(rows))
    new = rng.choice(
        [
            [*rows[:i], rows[i], *rows[i:]],
            [r for r in rows for _ in range(2)],
            [*rows[:i], head, *rows[i:]],
            rows[::-1],
        ]
    )
    return "\n".join([head, *new]) + "\n", "rows doubled or turned round", False


# ---------------------------------------------------------------- programs
OTHER_WORDS = (
    "L X+10 R0 FMAX", "CYCL DEF 200 DRILLING", "CYCL CALL", "MCALL CYCLE81(5,0,2,-5)", "o100 while [#1 LT 5]", "o100 endwhile", "CALL OO88", "G54.1 P500",
    "TRAORI", "DIAMON", "M128", "G05.1 Q1", "WHILE R1>0", "ENDWHILE", "CALL LBL 1 REP999999999", "GOTO 1", "GOTOB L1", "G65 P9810 X1", "VC1=SIN[45", "NLAP",
    "G68.2 X0 Y0 Z0 I10 J10 K10", "G43.4 H1", "G12.1", "G96 S200", "G76 P010060 Q100 R50", "M98 P1000 L99999", "#1=#1+1", "R1=R1/0", "Q1 = SQRT -1",
    "G51 X0 Y0 P0", "G10 L2 P1 X1e9", "SETMS(7)", "FN 14: ERROR = 1", "G31 X1", "G38.2 Z-1", "TCH PROBE 412", "CYCLE977(1)", "G0 X#[#[1]]", "G2 X1 Y1 R0", "G91 G28 Z0",
)  # fmt: skip


def _other_dialect(rng: Random, text: str) -> tuple[str, str, bool] | None:
    """A block as another control writes it."""
    lines = text.split("\n")
    if len(lines) < 3:
        return None
    new = rng.choice(OTHER_WORDS)
    i = rng.randrange(1, len(lines) - 1)
    return "\n".join([*lines[:i], new, *lines[i:]]), f"line {i + 1}: {new}", False


# ---------------------------------------------------------------- any text
def _line(rng: Random, text: str) -> tuple[str, str, bool] | None:
    lines = text.split("\n")
    i = rng.randrange(len(lines))
    j = rng.randrange(len(lines))
    new = rng.choice([[], [lines[i]] * 2, [lines[j]], [lines[i][: len(lines[i]) // 2]], [lines[i], ""], [lines[i] + " \x00"], ["(" * 5000], [lines[i] + "#" * 200_000]])  # fmt: skip
    return "\n".join([*lines[:i], *new, *lines[i + 1 :]]), f"line {i + 1} -> {str(new)[:60]}", False


def _character(rng: Random, text: str) -> tuple[str, str, bool] | None:
    i = rng.randrange(len(text))
    new = rng.choice(
        list("\x00\x07\x1b\"'[]{}()#=,.;\\\r\n-+eE9%&<>|") + ["\u202e", "\ufeff", "\u2028", "é", "٣", "𝟘"]
    )
    return text[:i] + new + text[i + rng.randrange(2) :], f"character {i} -> {new!r}", False


def _digits(rng: Random, text: str) -> tuple[str, str, bool] | None:
    at = _spot(rng, text, re.compile(r"\d+(?:\.\d+)?"))
    if at is None:
        return None
    new = rng.choice(["0", "-1", "9" * 25, "1e12", "1e-300", "0.5", "7", "1e6"])
    return _put(text, at, new), f"number {at[0]} at {at.start()} -> {new}", False


def _shuffled(rng: Random, text: str) -> tuple[str, str, bool] | None:
    lines = text.split("\n")
    rng.shuffle(lines)
    return "\n".join(lines), "lines in another order", False


def _much(rng: Random, text: str) -> tuple[str, str, bool] | None:
    """500 times the same mistake."""
    lines = text.rstrip("\n").split("\n")
    return "\n".join([*lines, *[lines[-1] + "x"] * 500]) + "\n", "500 wrong lines", False


def _bytes(rng: Random, text: str) -> Mutation:
    raw = text.encode()
    i = rng.randrange(1, len(raw))
    made, what = rng.choice([
        (raw[:i], f"cut after {i} bytes"), (b"", "empty"), (b"\n\n\n", "blank lines"), (raw[:i] + b"\xff\xfe" + raw[i:], "not UTF-8"),
        (text.encode("utf-16"), "UTF-16"), (b"\xef\xbb\xbf" + raw, "with a byte order mark"), (raw.replace(b"\n", b"\r"), "old line ends"),
        (raw.replace(b"\n", b"\r\n"), "other line ends"), (b"\x00" * 4096, "zeros"), (bytes(rng.randrange(256) for _ in range(300)), "noise"),
        (b"PK\x03\x04" + raw, "a zip file"), (b"\x1f\x8b" + raw, "a gzip file"), (raw[:i] + bytes([rng.randrange(256)]) + raw[i + 1 :], f"byte {i}"),
    ])  # fmt: skip
    return Mutation(made, what, False)


ANY = [(_line, 3), (_character, 4), (_digits, 4), (_shuffled, 1), (_much, 1)]
TOML = [(_quantity, 10), (_number, 4), (_word, 4), (_key, 3), (_nested, 1)]
CELLS = [(_cell, 10), (_separator, 2), (_header, 3), (_unit, 3), (_columns, 2), (_rows, 2)]
PROGRAMS = (".nc", ".mpf", ".h", ".min", ".ngc")
