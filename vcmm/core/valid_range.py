"""The range of temperatures in which a number that was learnt from a recording is valid: that of the recording."""

from __future__ import annotations

import re

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import T0_DEG_C, Array

NUMBER = r"(-?\d+(?:\.\d+)?)"
RANGE = re.compile(rf"{NUMBER} degC to {NUMBER} degC")
BEYOND = 0.1  # of the range: so far it may be left, for the straight line is known no worse there


def trained_range(low: float, high: float) -> str:
    """Return the text of a range, degC, rounded outwards to 0.01."""
    return f"{np.floor(low * 100) / 100:g} degC to {np.ceil(high * 100) / 100:g} degC"


def limits(text: str, what: str) -> tuple[float, float]:
    """Return (low, high) degC of the text of a range. Raises UsageError for another text or a range that is none."""
    match = RANGE.fullmatch(text)
    low, high = (float(match[1]), float(match[2])) if match else (0.0, 0.0)
    if not low < high:
        raise UsageError(f'{what}: trained = "{text}"; write for example trained = "18 degC to 31 degC"')
    return low, high


def check_range(text: str, what: str) -> None:
    """Raises UsageError for a text that is no range; "" states none."""
    if text:
        limits(text, what)


def checked_temperatures(text: str, what: str, sensor: str, temperature: Array) -> Array:
    """Return the temperatures (n,), after checking that they lie within the trained range. Raises ModelLimit where they lie beyond the
    trained range by more than a tenth of it.

    20 degC is no extrapolation: the drift is counted from there.
    """
    if not text:
        return temperature
    low, high = limits(text, what)
    span = BEYOND * (high - low)
    out = (temperature < low - span) | (temperature > high + span)
    wrong = np.flatnonzero(out & (np.abs(temperature - T0_DEG_C) > 1e-9))
    if len(wrong):
        raise ModelLimit(
            f"{what}: temp_{sensor}_C = {temperature[wrong[0]]:.4g} degC lies beyond the temperatures that it was learnt from "
            f"({text}); record the machine there and calibrate again, or take the key trained out"
        )
    return temperature
