"""Units that are taken for those of a heading: factors and zeros of what is meant."""

from __future__ import annotations

# the speed in mm/s (or rad/s) over the number that is written in another unit
PER_MINUTE, METRES_PER_MINUTE, METRES_PER_SECOND = 1.0 / 60.0, 1000.0 / 60.0, 1000.0


def unit_forms() -> dict[str, tuple[tuple[float, float, str], ...]]:
    """Return, by the beginning of a column, (factor, zero, words) of every unit that may be meant: the quantity is factor (value - zero)."""
    from scipy.constants import convert_temperature, degree_Fahrenheit, g, zero_Celsius

    freezing = float(convert_temperature(0.0, "Celsius", "Fahrenheit"))
    return {
        "temp_": (
            (degree_Fahrenheit, freezing, "the values are degF"),
            (1.0, zero_Celsius, "the values are K"),
        ),
        "speed_": (
            (PER_MINUTE, 0.0, "the values are 60 times too large, as per minute"),
            (60.0, 0.0, "the values are 60 times too small"),
            (METRES_PER_MINUTE, 0.0, "the values are 1000/60 times too small, as m/min"),
            (METRES_PER_SECOND, 0.0, "the values are 1000 times too small, as m/s"),
        ),
        "load_": ((1.0 / g, 0.0, "the values are N"), (g, 0.0, "the values are 9.81 times too small")),
    }
