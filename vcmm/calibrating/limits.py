"""Limits as people write them: "A = 8 um", "E0 = 1.9 um + L/300"."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from vcmm.calibrating.acceptance import Limit
from vcmm.core.errors import UsageError
from vcmm.core.units import quantity

_GROWING = re.compile(r"(?P<fixed>.+?)\s*\+\s*L\s*/\s*(?P<per>[\d.]+)\s*$")


def limits_of(texts: Sequence[str]) -> Mapping[str, Limit]:
    """Name -> limit in mm by length in mm. Raises UsageError for a text that is not understood."""
    out: dict[str, Limit] = {}
    for text in texts:
        name, mark, value = text.partition("=")
        if not mark or not name.strip():
            raise UsageError(f'--limit "{text}" is not understood; write for example --limit "A = 8 um"')
        out[name.strip()] = _limit(value.strip(), name.strip())
    return out


def _limit(text: str, name: str) -> Limit:
    """1.9 um + L/300: L in mm gives um, as on certificates of ISO 10360-2."""
    match = _GROWING.fullmatch(text)
    fixed = quantity(match["fixed"] if match else text, "length", name, "1.9 um + L/300")
    per = float(match["per"]) if match else float("inf")
    if fixed < 0 or per <= 0:
        raise UsageError(f'--limit "{name} = {text}": a limit is positive')
    return lambda length: fixed + 1e-3 * length / per
