"""Tolerance codes of ISO 286 for linear sizes up to 500 mm: "H7", "g6", "JS9", "p6" to limits from nominal.

Standard tolerances IT01 to IT16 and fundamental deviations c d e f g h js k m n p r s of shafts (ISO 286-1:2010, tables 1, 4, 5),
of holes by the rules of clause 4.3.2.5.4: EI = -es up to H, ES = -ei + Delta for K, M, N up to IT8 and P to S up to IT7.
Numbers in um, ranges "over ... up to and including" in mm.
"""

from __future__ import annotations

import re
from bisect import bisect_left

from vcmm.core.errors import UsageError

UP_TO = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)
IT: dict[str, tuple[float, ...]] = {
    "01": (0.3, 0.4, 0.4, 0.5, 0.6, 0.6, 0.8, 1, 1.2, 2, 2.5, 3, 4),
    "0": (0.5, 0.6, 0.6, 0.8, 1, 1, 1.2, 1.5, 2, 3, 4, 5, 6),
    "1": (0.8, 1, 1, 1.2, 1.5, 1.5, 2, 2.5, 3.5, 4.5, 6, 7, 8),
    "2": (1.2, 1.5, 1.5, 2, 2.5, 2.5, 3, 4, 5, 7, 8, 9, 10),
    "3": (2, 2.5, 2.5, 3, 4, 4, 5, 6, 8, 10, 12, 13, 15),
    "4": (3, 4, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20),
    "5": (4, 5, 6, 8, 9, 11, 13, 15, 18, 20, 23, 25, 27),
    "6": (6, 8, 9, 11, 13, 16, 19, 22, 25, 29, 32, 36, 40),
    "7": (10, 12, 15, 18, 21, 25, 30, 35, 40, 46, 52, 57, 63),
    "8": (14, 18, 22, 27, 33, 39, 46, 54, 63, 72, 81, 89, 97),
    "9": (25, 30, 36, 43, 52, 62, 74, 87, 100, 115, 130, 140, 155),
    "10": (40, 48, 58, 70, 84, 100, 120, 140, 160, 185, 210, 230, 250),
    "11": (60, 75, 90, 110, 130, 160, 190, 220, 250, 290, 320, 360, 400),
    "12": (100, 120, 150, 180, 210, 250, 300, 350, 400, 460, 520, 570, 630),
    "13": (140, 180, 220, 270, 330, 390, 460, 540, 630, 720, 810, 890, 970),
    "14": (250, 300, 360, 430, 520, 620, 740, 870, 1000, 1150, 1300, 1400, 1550),
    "15": (400, 480, 580, 700, 840, 1000, 1200, 1400, 1600, 1850, 2100, 2300, 2500),
    "16": (600, 750, 900, 1100, 1300, 1600, 1900, 2200, 2500, 2900, 3200, 3600, 4000),
}
FINER = (
    3,
    6,
    10,
    18,
    30,
    40,
    50,
    65,
    80,
    100,
    120,
    140,
    160,
    180,
    200,
    225,
    250,
    280,
    315,
    355,
    400,
    450,
    500,
)
ABOVE: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {  # es of shafts below the zero line, magnitude: (ranges, um)
    "c": (FINER, (60, 70, 80, 95, 110, 120, 130, 140, 150, 170, 180, 200, 210, 230, 240, 260, 280, 300, 330, 360, 400, 440, 480)),
    "d": (UP_TO, (20, 30, 40, 50, 65, 80, 100, 120, 145, 170, 190, 210, 230)),
    "e": (UP_TO, (14, 20, 25, 32, 40, 50, 60, 72, 85, 100, 110, 125, 135)),
    "f": (UP_TO, (6, 10, 13, 16, 20, 25, 30, 36, 43, 50, 56, 62, 68)),
    "g": (UP_TO, (2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 18, 20)),
    "h": (UP_TO, (0,) * 13),
}  # fmt: skip
BELOW: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {  # ei of shafts above the zero line: (ranges, um)
    "k": (UP_TO, (0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5)),
    "m": (UP_TO, (2, 4, 6, 7, 8, 9, 11, 13, 15, 17, 20, 21, 23)),
    "n": (UP_TO, (4, 8, 10, 12, 15, 17, 20, 23, 27, 31, 34, 37, 40)),
    "p": (UP_TO, (6, 12, 15, 18, 22, 26, 32, 37, 43, 50, 56, 62, 68)),
    "r": (FINER, (10, 15, 19, 23, 28, 34, 34, 41, 43, 51, 54, 63, 65, 68, 77, 80, 84, 94, 98, 108, 114, 126, 132)),
    "s": (FINER, (14, 19, 23, 28, 35, 43, 43, 53, 59, 71, 79, 92, 100, 108, 122, 130, 140, 158, 170, 190, 208, 232, 252)),
}  # fmt: skip
_CODE = re.compile(r"(?P<letters>JS|js|[A-Za-z]+?)(?P<grade>01|0|[1-9]|1[0-6])$")


def is_code(text: str) -> bool:
    """Return whether a text looks like a tolerance code."""
    return bool(_CODE.fullmatch(text.strip()))


def limits_of_code(code: str, size: float, inside: bool) -> tuple[float, float]:
    """Return (lower, upper) mm from a nominal size in mm. UsageError: unknown letter, size out of range, a hole's code on a shaft."""
    match = _CODE.fullmatch(code.strip())
    if not match:
        raise UsageError(f'"{code}" is no tolerance code of ISO 286; write for example "H7" or "g6"')
    letters, grade = match["letters"], match["grade"]
    if letters.isupper() != inside:
        due = letters.upper() if inside else letters.lower()
        kind = "a bore takes capitals" if inside else "a shaft takes small letters"
        raise UsageError(f'"{code}": {kind}, for example "{due}{grade}"')
    if not 0.0 < size <= 500.0:
        raise UsageError(
            f'"{code}": codes are held for sizes up to 500 mm, not for {size:g} mm; write the limits'
        )
    letter, row = letters.lower(), bisect_left(UP_TO, size)
    width = IT[grade][row]
    if letter == "js":
        return -5e-4 * width, 5e-4 * width
    if letter in ABOVE:
        low, high = _beyond(letter, size, width)
    elif letter in BELOW:
        low, high = (
            _through(letter, grade, size, width) if not inside else _hole_through(letter, grade, size, width)
        )
    else:
        allowed = ", ".join([*ABOVE, "js", *BELOW])
        raise UsageError(
            f'"{code}": the deviation "{letters}" is not held here; known are {allowed} (capitals for bores), or write the limits'
        )
    if inside and letter in ABOVE:
        low, high = -high, -low
    return 1e-3 * low, 1e-3 * high


def _read(table: tuple[tuple[int, ...], tuple[int, ...]], size: float) -> float:
    return float(table[1][bisect_left(table[0], size)])


def _beyond(letter: str, size: float, width: float) -> tuple[float, float]:
    upper = -_read(ABOVE[letter], size)
    return upper - width, upper


def _through(letter: str, grade: str, size: float, width: float) -> tuple[float, float]:
    """Return the limits of k to s of a shaft; k is 0 beside IT4 to IT7."""
    lower = _read(BELOW[letter], size)
    if letter == "k" and grade not in ("4", "5", "6", "7"):
        lower = 0.0
    return lower, lower + width


def _hole_through(letter: str, grade: str, size: float, width: float) -> tuple[float, float]:
    """Return the limits of K to S of a hole: the shaft's deviation mirrored, plus Delta = IT(n) - IT(n - 1) for fine grades above 3 mm."""
    number, row = int(grade) if grade != "01" else 0, bisect_left(UP_TO, size)
    finest = 8 if letter in "kmn" else 7
    if letter == "k" and number > 8:
        raise UsageError(f'"K{grade}": ISO 286 has no K coarser than K8; write the limits')
    delta = width - IT[str(number - 1)][row] if size > 3.0 and 3 <= number <= finest else 0.0
    upper = -_read(BELOW[letter], size) + delta
    if letter == "k" and size <= 3.0:
        upper = 0.0
    if letter == "n" and number > 8 and size > 3.0:
        upper = 0.0
    if letter == "m" and number == 6 and 250.0 < size <= 315.0:
        upper = -9.0  # the one exception of the standard
    return upper - width, upper
