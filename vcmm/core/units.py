"""Convert texts with a unit into canonical numbers: mm, rad, s, degC, N, kg inside; a bare number is refused.

    quantity("0.8 um", "length")              -> 0.0008   (mm)
    quantity("8.0 um/(m K)", "expansion")     -> 8.0e-6   (1/K)
    vector("0 0 20 mm", "length")             -> (0, 0, 20.0)

The dimension of a unit is derived from its text; DIMENSIONS only gives names to dimensions. One without a name is named by
the unit that states it: dimension_of("um/(m/s^2)") -> "um/(m/s^2)".

Conversion happens at the border only (files in, reports out); arrays inside are plain float64.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.text import LARGEST, brief, to_number
from vcmm.core.unit_words import closest_of, instead_of

# exponents of (length, angle, time, temperature, force, mass)
Dimension = tuple[int, int, int, int, int, int]
_NONE: Dimension = (0, 0, 0, 0, 0, 0)


def _dim(
    length: int = 0, angle: int = 0, time: int = 0, temperature: int = 0, force: int = 0, mass: int = 0
) -> Dimension:
    return (length, angle, time, temperature, force, mass)


DIMENSIONS: dict[str, Dimension] = {
    "number": _NONE,
    "slope": _NONE,
    "length": _dim(length=1),
    "angle": _dim(angle=1),
    "time": _dim(time=1),
    "frequency": _dim(time=-1),
    "temperature": _dim(temperature=1),
    "temperature difference": _dim(temperature=1),
    "speed": _dim(length=1, time=-1),
    "acceleration": _dim(length=1, time=-2),
    "jerk": _dim(length=1, time=-3),
    "angular speed": _dim(angle=1, time=-1),
    "angular acceleration": _dim(angle=1, time=-2),
    "angular jerk": _dim(angle=1, time=-3),
    "expansion": _dim(temperature=-1),
    "curvature": _dim(length=-1),
    "angle per length": _dim(angle=1, length=-1),
    "length per temperature": _dim(length=1, temperature=-1),
    "length per time": _dim(length=1, time=-1),
    "force": _dim(force=1),
    "compliance": _dim(length=1, force=-1),
    "mass": _dim(mass=1),
    "strain per mass": _dim(mass=-1),
    "length per mass": _dim(length=1, mass=-1),
    "angle per mass": _dim(angle=1, mass=-1),
    "length per volume": _dim(length=-2),
    "curvature per temperature": _dim(length=-1, temperature=-1),
    "angle per acceleration": _dim(angle=1, length=-1, time=2),
    "temperature rate": _dim(time=-1, temperature=1),
    "temperature gradient": _dim(length=-1, temperature=1),
}

# what a correct value looks like, for messages
EXAMPLES: dict[str, str] = {
    "number": "0.5", "slope": "5 um/m", "length": "0.8 um", "angle": "3 urad", "time": "30 s", "frequency": "40 1/s",
    "temperature": "20.4 degC", "temperature difference": "0.05 K", "speed": "5 mm/s",
    "acceleration": "2 m/s^2", "jerk": "50 m/s^3", "angular speed": "20 rpm",
    "angular acceleration": "10 rad/s^2", "angular jerk": "200 rad/s^3", "expansion": "8.0 um/(m K)", "curvature": "2 um/m^2",
    "angle per length": "3 urad/m", "length per temperature": "0.4 um/K", "length per time": "0.5 um/h",
    "force": "0.1 N", "compliance": "0.1 um/N", "mass": "20 kg",
    "strain per mass": "0.05 um/(m kg)", "length per mass": "0.01 um/kg", "angle per mass": "0.1 urad/kg", "length per volume": "200 um/m^3",
    "curvature per temperature": "10 um/(m^2 K)", "angle per acceleration": "5 urad/(m/s^2)",
    "temperature rate": "0.5 K/h", "temperature gradient": "0.3 K/m",
}  # fmt: skip

LONGEST_UNIT = 80  # characters
ABSOLUTE_ZERO = -273.15  # degC
_DEG = math.pi / 180.0
UNITS: dict[str, tuple[float, Dimension]] = {
    "nm": (1e-6, _dim(length=1)), "um": (1e-3, _dim(length=1)), "µm": (1e-3, _dim(length=1)), "mm": (1.0, _dim(length=1)),
    "cm": (10.0, _dim(length=1)), "m": (1e3, _dim(length=1)), "in": (25.4, _dim(length=1)),
    "rad": (1.0, _dim(angle=1)), "mrad": (1e-3, _dim(angle=1)), "urad": (1e-6, _dim(angle=1)), "µrad": (1e-6, _dim(angle=1)),
    "nrad": (1e-9, _dim(angle=1)), "deg": (_DEG, _dim(angle=1)), "arcmin": (_DEG / 60, _dim(angle=1)),
    "arcsec": (_DEG / 3600, _dim(angle=1)),
    "us": (1e-6, _dim(time=1)), "ms": (1e-3, _dim(time=1)), "s": (1.0, _dim(time=1)), "min": (60.0, _dim(time=1)),
    "h": (3600.0, _dim(time=1)), "d": (86400.0, _dim(time=1)), "Hz": (1.0, _dim(time=-1)), "rpm": (math.pi / 30, _dim(angle=1, time=-1)),
    "K": (1.0, _dim(temperature=1)), "mK": (1e-3, _dim(temperature=1)), "degC": (1.0, _dim(temperature=1)),
    "N": (1.0, _dim(force=1)), "mN": (1e-3, _dim(force=1)), "kN": (1e3, _dim(force=1)),
    "g": (1e-3, _dim(mass=1)), "kg": (1.0, _dim(mass=1)),
    "%": (0.01, _NONE), "ppm": (1e-6, _NONE), "1": (1.0, _NONE),
}  # fmt: skip

_JOINED = re.compile(
    r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)([A-Za-zµμ°%(].*)$"
)  # number and unit written together
_TOKEN = re.compile(r"\s*(?:(?P<name>[A-Za-zµ%]+)|(?P<number>[0-9]+)|(?P<op>[*/^().·]))")


@dataclass(frozen=True)
class Unit:
    """A parsed unit: multiply a number by `factor` to get the canonical unit of `dimension`."""

    factor: float
    dimension: Dimension


def parse_unit(text: str, due: str = "") -> Unit:
    """Parse a unit: 'um/(m K)' -> Unit. Products by space, '*' or '·', powers by '^', brackets allowed; both letters mu, °, °C.

    Raises UsageError for an unknown unit (with the closest one of the dimension `due`, where a single unit is) or bad syntax.
    """
    plain = text.replace("μ", "µ").replace("°C", "degC").replace("°", "deg")  # Greek mu -> micro sign
    if len(plain) > LONGEST_UNIT:
        raise UsageError(
            f'the unit "{brief(text)}" is longer than {LONGEST_UNIT} characters; write for example um/m'
        )
    tokens = _tokens(plain)
    if not tokens:
        raise UsageError("the unit is empty; write for example mm or um/m")
    alone = len(tokens) == 1 and tokens[0] not in UNITS and not instead_of(tokens[0])
    if alone and (fitting := _single_units(due)):
        raise UsageError(f'unknown unit "{tokens[0]}" in "{text}".{closest_of(tokens[0], fitting)}')
    unit, rest = _product(tokens, text)
    if rest:
        raise UsageError(f'unit "{text}" cannot be read after "{"".join(tokens[: len(tokens) - len(rest)])}"')
    return unit


def _single_units(due: str) -> list[str]:
    """Return the units of one word that fit a dimension: of a length nm, um, mm ...; a temperature is in degC, a difference of temperatures in K."""
    wanted = DIMENSIONS.get(due)
    fitting = [name for name, (_, dimension) in UNITS.items() if dimension == wanted and wanted != _NONE]
    left_out = {"temperature": ("K", "mK"), "temperature difference": ("degC",)}.get(due, ())
    return [name for name in fitting if name not in left_out]


def quantity(text: object, dimension: str, what: str = "value", example: str = "") -> float:
    """Convert a number with its unit to canonical units (a float).

    `what` names the key in the message, `example` shows a right value. Raises UsageError: no unit, a wrong unit, an
    unknown unit, not finite.
    """
    example = example or _example_of(dimension)
    numbers, unit = _split(text, dimension, what, example)
    if len(numbers) != 1:
        raise UsageError(
            f'{what} = {shorten(text)} has {len(numbers)} numbers, expected one; write for example {what} = "{example}"'
        )
    return numbers[0] * unit


def vector(text: object, dimension: str, what: str = "value", example: str = "") -> tuple[float, ...]:
    """Convert '0 0 20 mm', or a list of texts ['0 mm', '20 mm'], to canonical units."""
    if isinstance(text, list | tuple) and text and all(isinstance(item, str) for item in text):
        single = example and " ".join([example.split()[0], _unit_of(example).strip()])
        return tuple(quantity(item, dimension, what, single) for item in text)
    numbers, unit = _split(text, dimension, what, example or _example_of(dimension))
    return tuple(n * unit for n in numbers)


def in_unit(value: float, unit: str) -> float:
    """Return a canonical number expressed in `unit`: in_unit(0.0008, "um") -> 0.8."""
    return value / parse_unit(unit).factor


def dimension_of(unit: str) -> str:
    """Return the name of the dimension of a unit text: dimension_of("um/(m K)") -> 'expansion', "um/m" -> 'slope'; the text itself where
    the dimension has no name: dimension_of("um/(m/s^2)") -> 'um/(m/s^2)'. Raises UsageError as `parse_unit`."""
    given = parse_unit(unit).dimension
    if given == _NONE:
        return "number" if unit in ("1", "%") else "slope"
    return next((name for name, dimension in DIMENSIONS.items() if dimension == given), unit)


def _exponents(dimension: str) -> Dimension:
    """Return the exponents of a name that `dimension_of` gave."""
    return DIMENSIONS[dimension] if dimension in DIMENSIONS else parse_unit(dimension).dimension


def _example_of(dimension: str) -> str:
    return EXAMPLES.get(dimension, f"1 {dimension}")


def channel_unit(channel: str) -> str:
    """Return the unit stated in the name of a run column: temp_part_C -> K, speed_X_mm_s -> mm/s."""
    for ending, unit in (
        ("_C", "K"),
        ("_mm_s2", "mm/s^2"),
        ("_mm_s", "mm/s"),
        ("_rad", "rad"),
        ("_mm", "mm"),
        ("_kg", "kg"),
        ("_N", "N"),
        ("_s", "s"),
    ):
        if channel.endswith(ending):
            return unit
    raise UsageError(
        f'channel = "{channel}" states no unit; columns end in _C, _mm, _mm_s, _rad, _kg, _N or _s, for example temp_part_C'
    )


def _split(text: object, dimension: str, what: str, example: str) -> tuple[list[float], float]:
    """Return the numbers of a text and the factor to canonical units, after checking the unit against the expected dimension."""
    due = f'write for example {what} = "{example}"'
    if not isinstance(text, str):
        raise UsageError(_no_text(text, what, example))
    numbers, unit_text = _numbers_and_unit(text)
    if re.match(r"\s*[-+]?\d+,", text) or unit_text.startswith(","):
        raise UsageError(
            f"{what} = {shorten(text)} has a comma; decimals take a point, numbers are kept apart by blanks; {due}"
        )
    if not numbers:
        raise UsageError(f"{what} = {shorten(text)} has no number; {due}")
    if not all(math.isfinite(n) for n in numbers):
        raise UsageError(f"{what} = {shorten(text)} is not finite; {due}")
    if not unit_text and dimension != "number":
        raise UsageError(
            f'{what} = {shorten(text)} has no unit; write for example {what} = "{_per_million(text, dimension)}{_likely(numbers, dimension, example)}"'
        )
    try:
        unit = parse_unit(unit_text, dimension) if unit_text else Unit(1.0, _NONE)
    except UsageError as error:
        raise UsageError(f"{what} = {shorten(text)}: {error}") from None
    if unit.dimension != _exponents(dimension) and not _angle_as_slope(unit.dimension, dimension):
        raise UsageError(
            f'{what} = {shorten(text)} is not {_a(dimension)}: the unit "{unit_text}" does not fit; {due}'
        )
    if unit_text in ("degC", "°C") and dimension == "temperature difference":
        raise UsageError(f"{what} = {shorten(text)} is a temperature difference and takes K; {due}")
    if dimension == "temperature" and unit_text in ("K", "mK"):
        raise UsageError(f"{what} = {shorten(text)} is a temperature and takes degC; {due}")
    if max(map(abs, numbers)) * unit.factor > LARGEST * usual(dimension):
        raise UsageError(
            f"{what} = {shorten(text)} is {LARGEST:g} times what is usual, which no machine has; {due}"
        )
    if dimension == "temperature" and min(numbers) * unit.factor < ABSOLUTE_ZERO:
        raise UsageError(f"{what} = {shorten(text)} is below absolute zero ({ABSOLUTE_ZERO:g} degC); {due}")
    return numbers, unit.factor


@cache
def usual(dimension: str) -> float:
    """Return the size of the example of a dimension, in canonical units."""
    numbers, unit = _numbers_and_unit(_example_of(dimension))
    return abs(numbers[0]) * (parse_unit(unit).factor if unit else 1.0)


def _per_million(text: str, dimension: str) -> str:
    """Return a hint on a bare 11.5e-6, which is meant per kelvin: with the unit um/(m K) it must read 11.5, not 11.5e-6."""
    if dimension == "expansion" and all(abs(float(n)) < 1e-3 for n in text.split()):
        return " ".join(f"{float(n) * 1e6:g}" for n in text.split())
    return text.strip()


def _likely(numbers: list[float], dimension: str, example: str) -> str:
    """Return the unit of the example; mm for a bare length that would be large in micrometres."""
    unit = _unit_of(example)
    return " mm" if dimension == "length" and unit == " um" and max(map(abs, numbers)) >= 10.0 else unit


def _no_text(value: object, what: str, example: str) -> str:
    """Return the complaint about a value that is no text, with the corrected line where its numbers are plain."""
    items = list(value) if isinstance(value, list | tuple) else [value]
    plain = all(isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v) for v in items)
    if not plain or not items or len(items) != len(_numbers_and_unit(example)[0]):
        return f'{what} = {shorten(value)} is not a text with {_expected_text(example)}; write for example {what} = "{example}"'
    dimension = dimension_of(_unit_of(example).strip()) if _unit_of(example).strip() else "number"
    corrected = _per_million(" ".join(str(v) for v in items), dimension) + _unit_of(example)
    return f'{what} = {shorten(value)} has no unit; write for example {what} = "{corrected}"'


def shorten(value: object) -> str:
    """Return a value as written in a TOML file, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{brief(value, 80)}"'
    if isinstance(value, list | tuple):
        return "[" + ", ".join(shorten(v) for v in value[:6]) + (", ..." if len(value) > 6 else "") + "]"
    if isinstance(value, dict):
        inside = ", ".join(f"{k} = {shorten(v)}" for k, v in list(value.items())[:4])
        return "{ " + inside + " }" if inside else "{}"
    return str(value)


def _expected_text(example: str) -> str:
    return "numbers and a unit" if len(_numbers_and_unit(example)[0]) > 1 else "a number and its unit"


def _unit_of(example: str) -> str:
    """Return ' mm' of '0 0 20 mm'; '' of a plain number."""
    _, unit = _numbers_and_unit(example)
    return f" {unit}" if unit else ""


def _a(dimension: str) -> str:
    if dimension not in DIMENSIONS:
        return f"in {dimension} or another unit of that dimension"
    return f"an {dimension}" if dimension[0] in "aeiou" else f"a {dimension}"


def _angle_as_slope(given: Dimension, dimension: str) -> bool:
    """Return whether a slope is given where an angle is expected: workshops write angles as um/m, and this is accepted."""
    return dimension == "angle" and given == _NONE


def _numbers_and_unit(text: str) -> tuple[list[float], str]:
    """Split '0 0 20 mm' or '0 0 20mm' into ([0, 0, 20], 'mm')."""
    words = text.split()
    numbers: list[float] = []
    while words:
        try:
            numbers.append(to_number(words[0]))
        except ValueError:
            break
        words.pop(0)
    match = _JOINED.match(words[0]) if words else None
    if match:
        numbers.append(to_number(match[1]))
        words[0] = match[2]
    return numbers, " ".join(words)


def _tokens(text: str) -> list[str]:
    words, position = [], 0
    while position < len(text.rstrip()):
        match = _TOKEN.match(text, position)
        if not match:
            raise UsageError(f'unit "{brief(text)}" cannot be read at "{brief(text[position:])}"')
        words.append(match.group().strip())
        position = match.end()
    return words


def _product(tokens: list[str], text: str) -> tuple[Unit, list[str]]:
    factor, dimension, sign = 1.0, _NONE, 1
    while tokens and tokens[0] != ")":
        if tokens[0] in "*·.":
            tokens = tokens[1:]
            continue
        if tokens[0] == "/":
            sign, tokens = -1, tokens[1:]
            continue
        unit, tokens = _power(tokens, text)
        factor *= unit.factor**sign
        dimension = _add(dimension, unit.dimension, sign)
        sign = 1  # a/b c means (a/b) c; a/(b c) is written with brackets
    return Unit(factor, dimension), tokens


def _power(tokens: list[str], text: str) -> tuple[Unit, list[str]]:
    head, tokens = tokens[0], tokens[1:]
    if head == "(":
        unit, tokens = _product(tokens, text)
        if not tokens:
            raise UsageError(f'unit "{text}" has an open bracket')
        tokens = tokens[1:]
    elif head in UNITS:
        unit = Unit(*UNITS[head])
    elif instead_of(head):
        where = "" if head == text.strip() else f' in "{text}"'
        raise UsageError(f'"{head}"{where} is no unit: {instead_of(head)}')
    else:
        raise UsageError(f'unknown unit "{head}" in "{text}".{choose_from(head, UNITS)}')
    if tokens and tokens[0] == "^":
        if len(tokens) < 2 or not tokens[1].isdigit() or len(tokens[1]) > 1:
            raise UsageError(
                f'unit "{text}": expected a whole number after ^ (9 at most); write for example m/s^2'
            )
        exponent, tokens = int(tokens[1]), tokens[2:]
        unit = Unit(unit.factor**exponent, _add(_NONE, unit.dimension, exponent))
    return unit, tokens


def _add(a: Dimension, b: Dimension, sign: int) -> Dimension:
    d = tuple(x + sign * y for x, y in zip(a, b))
    return (d[0], d[1], d[2], d[3], d[4], d[5])


def significant_text(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits and, between 1e-4 and 1e7, without an exponent: 3750, 0.0125, 2.1e-06."""
    text = f"{value:.{digits}g}"
    if "e" not in text or not 1e-4 <= abs(value) < 1e7:
        return text
    return f"{float(text):.0f}"
