"""Words and numbers for a report: escaping, rounding, and the width of texts.

A number that does not exist (NaN, infinity, None) is shown as an en dash, never as "nan".
"""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterable
from decimal import ROUND_HALF_UP, Decimal

from vcmm.core.errors import UsageError

DASH = "–"  # means "not available"
MINUS = "−"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

# Advance widths of a common sans serif (Helvetica metrics), 1/1000 em, characters 32 to 126.
_WIDTHS = (
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
    556, 556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,
    1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,
    333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,
    556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
)  # fmt: skip
_MARGIN = 1.2  # the reader's font is unknown; the widest common one (DejaVu) is up to 20 % wider


def escape(text: object) -> str:
    """Return the text made safe for HTML and SVG, in content and in attributes."""
    return html.escape(str(text), quote=True)


_MICRO = re.compile(r"(?<=[\d)\]]) u(m|rad)\b")


def micro(text: str) -> str:
    """Convert 0.76 um -> 0.76 µm, as people write it; text in quotation marks is quoted from files, and does not change."""
    return '"'.join(_MICRO.sub(r" µ\1", t) if k % 2 == 0 else t for k, t in enumerate(text.split('"')))


def unit_word(unit: str) -> str:
    """Convert um/m -> µm/m, as people write it; documents and files keep um/m."""
    return re.sub(r"\bu(m|rad)\b", r"µ\1", unit)


def number(value: float | None, digits: int = 3) -> str:
    """Return `value` with `digits` significant digits, a true minus sign, no loss of integer digits.

    0.01234 -> "0.0123", 12345.6 -> "12346", 1.2e-7 -> "1.20 × 10⁻⁷"; not finite -> en dash.
    UsageError: digits < 1.
    """
    if digits < 1:
        raise UsageError(f"number() needs at least 1 significant digit, got {digits}; pass digits=3.")
    if value is None or not math.isfinite(value):
        return DASH
    if value == 0:
        return "0"
    mantissa, power = f"{value:.{digits - 1}e}".split("e")  # rounds first: 9.996 becomes 1.00e+01
    exponent = int(power)
    if -5 <= exponent < 7:
        return f"{value:.{max(0, digits - 1 - exponent)}f}".replace("-", MINUS)
    return f"{mantissa} × 10{str(exponent).translate(_SUPERSCRIPT)}".replace("-", MINUS)


def align_decimals(values: Iterable[float | None], digits: int = 3) -> list[str]:
    """Return the numbers of one column with common decimals: the largest shows `digits` significant digits.

    What would round to zero keeps its one significant digit.
    """
    column = [math.nan if v is None else float(v) for v in values]
    largest = max((abs(v) for v in column if math.isfinite(v)), default=0.0)
    if largest == 0 or not 1e-5 <= largest < 1e7:
        return [number(v, digits) for v in column]
    decimals = len(number(largest, digits).partition(".")[2])
    return [_in_column(v, decimals) for v in column]


def _in_column(value: float, decimals: int) -> str:
    if not math.isfinite(value):
        return DASH
    if value != 0 and round(value, decimals) == 0:
        return number(value, 1)
    return f"{value + 0.0:.{decimals}f}".replace("-", MINUS)


def as_written(value: float | None) -> str:
    """Return a given number (a limit, a nominal value) as it was written: up to 10 significant digits, no padding."""
    if value is None or not math.isfinite(value):
        return DASH
    return f"{value + 0.0:.10g}".replace("-", MINUS)


def _place(u: float) -> Decimal:
    """Return the decimal place of the second significant digit of u after rounding (0.0996 -> 0.01)."""
    exponent = int(f"{u:.1e}".split("e")[1])
    return Decimal(1).scaleb(exponent - 1)


def with_uncertainty(value: float | None, u: float | None) -> str:
    """Return "110.0004 ± 0.0011": u to two significant digits, the value to the same place.

    Ordinary rounding of two digits lowers u by less than 5 %, which EA-4/02 (6.3) allows.
    A zero u prints the value as it is; a missing value or u prints an en dash. UsageError: u < 0.
    """
    if value is None or u is None or not (math.isfinite(value) and math.isfinite(u)):
        return DASH
    if u < 0:
        raise UsageError(f"An uncertainty cannot be negative, got {u:g}; pass its absolute value.")
    if u == 0:
        return f"{value:.10g} ± 0".replace("-", MINUS)
    place = _place(u)
    rounded, half = (_quantise(Decimal(repr(float(x))), place) for x in (value, u))
    return f"{rounded} ± {half}".replace("-", MINUS)


def _quantise(value: Decimal, place: Decimal) -> str:
    rounded = (value / place).quantize(Decimal(1), rounding=ROUND_HALF_UP) * place
    return f"{abs(rounded) if rounded == 0 else rounded:f}"


def text_width(text: str, size: float) -> float:
    """Return the estimated width of `text` in pixels at font size `size` (pixels), on the safe side."""
    units = sum(_WIDTHS[ord(c) - 32] if 32 <= ord(c) <= 126 else 600 for c in text)
    return units * size / 1000 * _MARGIN


def shorten(text: str, size: float, width: float) -> str:
    """Return `text` with an ellipsis in its middle so that it fits into `width` pixels: long names often differ in their last word only.

    Whole words are left out, first those before the last; only what no two words fit into is cut in a word.
    """
    if text_width(text, size) <= width:
        return text
    words = text.split()
    for kept in range(len(words) - 1, 1, -1):
        for last in range(max(1, kept // 2), 0, -1):
            short = " ".join([*words[: kept - last], "…", *words[len(words) - last :]])
            if text_width(short, size) <= width:
                return short
    for kept in range(len(text) - 1, 0, -1):
        short = f"{text[: kept - kept // 2].rstrip()}…{text[len(text) - kept // 2 :].lstrip()}"
        if text_width(short, size) <= width:
            return short
    return "…"
