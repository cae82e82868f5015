"""Write quantities: in the terminal with their unit; on pages mm and µm bare, angles with theirs.

A number that does not exist (NaN, infinity, None) is a dash, never "nan".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from vcmm.core.units import significant_text
from vcmm.show.tables.table import FINE_UNITS, Unit, Writing, written_out

DASH = "–"
LEAST_SMALL = 5e-4  # µm, µrad
SMALL_SCALE = {"mm": 1e3, "rad": 1e6}  # to µm, µrad


def _missing(value: float | None) -> bool:
    return value is None or not math.isfinite(value)


def length_text(value: float, unit: Unit) -> str:
    """Return a value: 30.00012 mm, or an angle 90.00001 deg."""
    if _missing(value):
        return DASH
    return f"{value:.5f} mm" if unit == "mm" else f"{math.degrees(value):.6f} deg"


def value_on_page(value: float, unit: Unit) -> str:
    """Return a length in mm with 5 decimals, an angle in deg with 6."""
    return f"{value:.5f}" if unit == "mm" else f"{math.degrees(value):.6f}°"


def deviation_text(value: float, unit: Unit, signed: bool = True) -> str:
    """Return a small difference: +0.12 µm or +3.4 µrad."""
    if _missing(value):
        return DASH
    rounded = round(value * SMALL_SCALE[unit], 2) + 0.0  # no minus before a zero
    number = f"{rounded:{'+' if signed else ''}.2f}"
    return f"{number} {'µm' if unit == 'mm' else 'µrad'}"


def departure_on_page(value: float, unit: Unit) -> str:
    """Return a small difference in µm (a plain number) or µrad, three significant digits."""
    from vcmm.show.report.text import number

    if _missing(value):
        return DASH
    return number(_clean(value * SMALL_SCALE[unit]), 3) + ("" if unit == "mm" else f" {FINE_UNITS[unit]}")


def _clean(value: float) -> float:
    """Return zero for a value below half a nanometre (nanoradian)."""
    return 0.0 if abs(value) < LEAST_SMALL else value


def percent_text(share: float | None) -> str:
    return DASH if share is None or not math.isfinite(share) else f"{share * 100:.1f} %"


def fine_text(value: float, unit: Unit) -> str:
    """Return a very small difference: 0.12 nm or 0.003 µrad; "not checked" when unknown."""
    if not math.isfinite(value):
        return "not checked"
    return f"{value * 1e6:.2g} nm" if unit == "mm" else f"{value * 1e6:.2g} µrad"


def _fine_on_page(value: float, unit: Unit) -> str:
    from vcmm.show.report.text import number

    if not math.isfinite(value):
        return "not checked"
    return f"{number(value * 1e6, 2)} {'nm' if unit == 'mm' else 'µrad'}"


def span_text(ends: Sequence[float] | None, unit: Unit) -> str:
    """Return two ends of an interval as departures: [-0.12, +0.31] µm; a dash where there is none, as of a tolerance not stated."""
    if ends is None:
        return DASH
    word = "µm" if unit == "mm" else "µrad"
    low, high = (round(x * SMALL_SCALE[unit], 2) + 0.0 for x in ends)  # no minus before a zero
    return f"[{low:+.2f}, {high:+.2f}] {word}"


def span(ends: Sequence[float] | None, unit: Unit) -> str:
    """Return two ends as departures, µm or µrad."""
    from vcmm.show.report.text import number

    return DASH if ends is None else " … ".join(number(_clean(x * SMALL_SCALE[unit]), 3) for x in ends)


def whole_percent(share: float) -> str:
    return f"{share:.0%}"


LENGTH = Writing(length_text, value_on_page)
DEVIATION = Writing(deviation_text, departure_on_page)
SIZE = Writing(lambda value, unit: deviation_text(value, unit, signed=False), departure_on_page)
FINE = Writing(fine_text, _fine_on_page)
SPAN = Writing(span_text, span)
SHARE = Writing(
    lambda value, unit: percent_text(value), lambda value, unit: DASH if _missing(value) else f"{value:.1%}"
)


def fixed(decimals: int, unit: str = "", scale: float = 1.0, signed: bool = False) -> Writing:
    """Return a number with so many decimals, times `scale`, with the word of its unit: fixed(2, "um", 1e3). A value that rounds to zero
    has no minus."""
    sign, word = "+" if signed else "", f" {unit}" if unit else ""
    word = word.replace(" um", " µm").replace(" urad", " µrad")

    def text_of(value: Any, word: str) -> str:
        return DASH if _missing(value) else f"{value * scale:{sign}z.{decimals}f}{word}"

    return Writing(lambda value, unit: text_of(value, word), lambda value, unit: text_of(value, word))


def percent(decimals: int, signed: bool = False) -> Writing:
    """Return a share: 0.247 as 24.7%."""
    sign = "+" if signed else ""
    return Writing(lambda value, unit: DASH if _missing(value) else f"{value:{sign}z.{decimals}%}")


def in_file(decimals: int, scale: float = 1.0) -> Any:
    """Return, for CSV files, a number with so many decimals, empty where there is none."""
    return lambda value, unit: "" if _missing(value) else f"{value * scale:z.{decimals}f}"


def small_in_file(value: float | None, unit: Unit) -> str:
    """Return, for CSV files, µm or µrad, six significant digits."""
    return written_out(None if value is None else value * SMALL_SCALE[unit], unit)


def value_text(value: tuple[float, float] | None, unit: str) -> str:
    """Return 1.50 ± 0.12 um: standard uncertainty to two digits."""
    if value is None:
        return "not found"
    if value[1] is None or not value[1] > 0:
        return f"{significant_text(value[0])} {unit}".rstrip()
    u = float(f"{value[1]:.2g}")
    digits = max(0, 1 - int(f"{u:e}".split("e")[1]))
    return f"{value[0]:.{digits}f} ± {u:.{digits}f} {'' if unit == '1' else unit}".rstrip()
