"""Limits as people write them: "A = 8 um", "E0 = 1.9 um + L/300"."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial

from vcmm.core.errors import UsageError
from vcmm.core.units import quantity
from vcmm.learn.calibration.acceptance import Limit
from vcmm.task.certified.certificate import length_limit

TURNING = ("tilt", "angle")  # figures that are angles


def limits_of(texts: Sequence[str], angles: bool = False) -> Mapping[str, Limit]:
    """Name -> limit in mm by length in mm; angles: limits of tilts may be stated, in rad.

    Raises UsageError for a text that is not understood, a length for a tilt and an angle for another figure.
    """
    out: dict[str, Limit] = {}
    for text in texts:
        name, mark, value = text.partition("=")
        if not mark or not name.strip():
            raise UsageError(f'--limit "{text}" is not understood; write for example --limit "A = 8 um"')
        figure = re.sub("_MP[EL]$", "", name.strip())  # as a machine file states it
        if angles and any(word in figure for word in TURNING):
            size = quantity(value.strip(), "angle", name.strip(), "0.5 urad")
            if not size > 0:
                raise UsageError(f"{text}: a limit is positive; write for example {name.strip()} = 0.5 urad")
            out[figure] = partial(_always, size)
        else:
            out[figure] = length_limit(value.strip(), name.strip())
    return out


def _always(size: float, length: float) -> float:
    return size
