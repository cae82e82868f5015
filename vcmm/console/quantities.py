"""How numbers are written for people: mm with um beside them, angles in deg with urad."""

from __future__ import annotations

import math


def length_text(value: float, unit: str) -> str:
    """A value: 30.00012 mm, or an angle 90.00001 deg."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.5f} mm" if unit == "mm" else f"{math.degrees(value):.6f} deg"


def deviation_text(value: float, unit: str, signed: bool = True) -> str:
    """A small difference: +0.12 um or +3.4 urad."""
    if not math.isfinite(value):
        return "–"
    number = f"{value * (1e3 if unit == 'mm' else 1e6):{'+' if signed else ''}.2f}"
    return f"{number} {'um' if unit == 'mm' else 'urad'}"


def percent_text(share: float) -> str:
    return f"{share * 100:.1f} %" if math.isfinite(share) else "–"


def fine_text(value: float, unit: str) -> str:
    """A very small difference: 0.12 nm or 0.003 urad; "not checked" when unknown."""
    if not math.isfinite(value):
        return "not checked"
    return f"{value * 1e6:.2g} nm" if unit == "mm" else f"{value * 1e6:.2g} urad"


def span_text(ends: list[float], unit: str) -> str:
    """Two ends of an interval as departures: [-0.12, +0.31] um."""
    scale, word = (1e3, "um") if unit == "mm" else (1e6, "urad")
    return f"[{ends[0] * scale:+.2f}, {ends[1] * scale:+.2f}] {word}"
