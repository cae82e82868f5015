"""Read [certificate.measured] of a machine file: results of the acceptance test, in words to `Findings`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.units import quantity
from vcmm.task.certification.findings import Finding, Findings, LimitShare

FIGURES: Mapping[str, str] = {
    "R0": "R0",
    "P_Form": "form", "P_Form_Sph_1x25": "form", "PFTU": "form",
    "P_Size": "size", "P_Size_Sph_1x25": "size", "PSTU": "size",
}  # fmt: skip
KEYS = ("E0", "E0_largest", *FIGURES)
# of several styli, heads and scans: the machines that are drawn have one stylus, which touches
NO_EFFECT = (
    "P_Form_Sph_5x25", "P_Size_Sph_5x25", "L_Dia_5x25", "PFTE", "PSTE", "PLTE", "P_FTE", "P_STE", "P_LTE", "PFTM", "PSTM", "PLTM", "P_FTM", "P_STM", "P_LTM", "THP",
    "P_Form_Sph_Scan", "P_Size_Sph_Scan",
)  # fmt: skip
EXAMPLE = 'E0_largest = { error = "1.1 um", u = "0.15 um" }'
OF_LENGTHS = 'E0 = [{ length = "100 mm", error = "0.6 um", u = "0.1 um" }]'


def findings_in(table: Mapping[str, Any], problems: list[tuple[str, str]]) -> Findings:
    """Adds (key, text) of every entry that is not understood to `problems`."""
    values: dict[str, Any] = {}
    for key, stated in table.items():
        try:
            _take(key, stated, values)
        except UsageError as error:
            problems.append(("measured", str(error)))
    return Findings(**values)


def _take(key: str, stated: object, values: dict[str, Any]) -> None:
    if key in NO_EFFECT:
        _figure(key, stated)
        return
    if key == "E0_largest" and (worst := _share(stated)) is not None:
        values["worst"] = worst
        return
    if key == "E0":
        values["lengths"] = _lengths(stated)
        return
    if key not in KEYS:
        raise UsageError(f'measured: no figure "{key}".{choose_from(key, (*KEYS, *NO_EFFECT))}')
    name = "largest" if key == "E0_largest" else FIGURES[key]
    if name in values:
        raise UsageError(f'measured: "{key}" is stated twice, by two of its names; keep one')
    finding = _figure(key, stated)
    if finding.error < 0:
        raise UsageError(f"measured {key} is never negative")
    values[name] = finding


def _share(stated: object) -> LimitShare | None:
    """Parse "60 %", "60 % of MPE", or { error = "60 %", u = "0.15 um" } (u also in %); None: no share."""
    table = {"error": stated} if isinstance(stated, str) else stated
    if not isinstance(table, dict) or "%" not in str(table.get("error", "")) or set(table) - {"error", "u"}:
        return None
    share, u = _percent(str(table["error"])), str(table.get("u", "0 um"))
    if share < 0:
        raise UsageError("measured E0_largest is never negative")
    if "%" in u:
        return LimitShare(share, u_share=_percent(u))
    return LimitShare(share, quantity(u, "length", "measured E0_largest u", "0.15 um"))


def _percent(text: str) -> float:
    match = re.fullmatch(r"\s*(-?\d+(?:\.\d+)?)\s*%\s*(?:of\s+(?:the\s+)?(?:E0_)?MPE)?\s*", text)
    if not match:
        raise UsageError(
            f'measured E0_largest = "{text}" cannot be read: write "60 %" of MPE, or the error itself, such as "0.8 um"'
        )
    return float(match[1]) / 100.0


def _lengths(stated: object) -> tuple[tuple[float, Finding], ...]:
    if not isinstance(stated, list) or not stated or not all(isinstance(row, dict) for row in stated):
        raise UsageError(f"measured E0 is a list, one entry a length: write for example {OF_LENGTHS}")
    out = []
    for row in stated:
        if "length" not in row:
            raise UsageError(f"measured E0: an entry states no length; write for example {OF_LENGTHS}")
        length = quantity(row["length"], "length", "measured E0 length", "100 mm")
        if not length > 0:
            raise UsageError(f'measured E0: a length of "{row["length"]}" is none; it is above 0')
        out.append((length, _figure("E0", {k: v for k, v in row.items() if k != "length"})))
    return tuple(out)


def _figure(key: str, stated: object) -> Finding:
    """Parse "0.8 um", or { error = "0.8 um", u = "0.1 um" }; u is a standard uncertainty."""
    if isinstance(stated, str):
        return Finding(quantity(stated, "length", f"measured {key}", "0.8 um"))
    if not isinstance(stated, dict) or "error" not in stated or set(stated) - {"error", "u"}:
        raise UsageError(
            f'measured {key} is a value such as "0.8 um" or a table with error and u (standard uncertainty), such as {EXAMPLE}'
        )
    error = quantity(stated["error"], "length", f"measured {key} error", "0.8 um")
    u = quantity(stated.get("u", "0 um"), "length", f"measured {key} u", "0.1 um")
    if u < 0:
        raise UsageError(f'measured {key}: u = "{stated["u"]}" is a standard uncertainty and never negative')
    return Finding(error, u)
