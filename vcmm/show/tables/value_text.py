"""A number with its standard uncertainty as text. Separate from the tables of other jobs, so that one job does not import the modules of another."""

from __future__ import annotations

from vcmm.core.units import plain


def value_text(value: tuple[float, float] | None, unit: str) -> str:
    """Return 1.50 ± 0.12 um: standard uncertainty to two digits."""
    if value is None:
        return "not found"
    if value[1] is None or not value[1] > 0:
        return f"{plain(value[0])} {unit}".rstrip()
    u = float(f"{value[1]:.2g}")
    digits = max(0, 1 - int(f"{u:e}".split("e")[1]))
    return f"{value[0]:.{digits}f} ± {u:.{digits}f} {'' if unit == '1' else unit}".rstrip()
