"""Limits as people write them: "A = 8 um", "E0 = 1.9 um + L/300"."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from vcmm.calibrating.acceptance import Limit
from vcmm.certified.certificate import length_limit
from vcmm.core.errors import UsageError


def limits_of(texts: Sequence[str]) -> Mapping[str, Limit]:
    """Name -> limit in mm by length in mm. Raises UsageError for a text that is not understood."""
    out: dict[str, Limit] = {}
    for text in texts:
        name, mark, value = text.partition("=")
        if not mark or not name.strip():
            raise UsageError(f'--limit "{text}" is not understood; write for example --limit "A = 8 um"')
        figure = re.sub("_MP[EL]$", "", name.strip())  # as a machine file states it
        out[figure] = length_limit(value.strip(), name.strip())
    return out
