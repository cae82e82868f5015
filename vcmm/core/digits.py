"""Find the step to which the numbers of a file were rounded when they were written."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, InvalidOperation

# different last digits in a column: numbers that happen to be round (nominal ones) have fewer
MOST_DIGITS = 5
LEAST_DECIMALS = 2  # decimals that are written on purpose; 15.0 may be an exact number as a program prints it


def written_step(columns: Sequence[Sequence[str]]) -> float:
    """Return the step of the finest column, in the unit of the file: 0.01 of "12.34", 0.005 of "0.015", "0.020" ...; 0 where no step is found.

    Numbers that were rounded before they were written with more digits ("12.340000") have the step at which their digits end,
    where the digits before it vary. Only steps of 1, 2 and 5 in a decade are returned.
    """
    steps = [_step([d for d in map(_decimal, column) if d is not None]) for column in columns]
    return min((s for s in steps if s > 0.0), default=0.0)


def _decimal(cell: str) -> Decimal | None:
    try:
        number = Decimal(cell.replace(",", "."))
    except InvalidOperation:
        return None
    return number if number.is_finite() else None


def _step(numbers: Sequence[Decimal]) -> float:
    if not numbers:
        return 0.0
    written = min(_exponent(d) for d in numbers)
    used = min((_exponent(d.normalize()) for d in numbers if d), default=written)
    last = [int(abs(d).scaleb(-used)) for d in numbers]
    if len({n % 10 for n in last}) >= MOST_DIGITS:
        return 10.0**used
    coarse = next((m for m in (5, 2) if len(last) >= 4 * MOST_DIGITS and all(n % m == 0 for n in last)), 1)
    varied = len({n // coarse % 10 for n in last}) >= MOST_DIGITS
    if coarse > 1 and varied:
        return coarse * 10.0**used
    return 10.0**written if -written >= LEAST_DECIMALS else 0.0


def _exponent(d: Decimal) -> int:
    exponent = d.as_tuple().exponent
    return exponent if isinstance(exponent, int) else 0
