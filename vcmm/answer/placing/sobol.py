"""Points of Sobol in up to six dimensions, as `scipy.stats.qmc.Sobol` gives them, number for number, without importing scipy.stats.

That package takes longer to import (half a second) than all the points of a placement to make; a test compares the two.
Direction numbers: Joe and Kuo, "Constructing Sobol sequences with better two-dimensional projections", SIAM J. Sci. Comput. 30 (2008),
new-joe-kuo-6.21201. Scrambling: a random lower triangular matrix and a shift of the bits (Matousek, J. Complexity 14, 1998).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array

BITS = 30
Bits = npt.NDArray[np.uint32]
# of each dimension but the first: coefficients of its primitive polynomial without the first, and the first numbers m
DIRECTIONS = (
    ((1,), (1,)),
    ((1, 1), (1, 3)),
    ((0, 1, 1), (1, 3, 1)),
    ((1, 0, 1), (1, 1, 1)),
    ((0, 0, 1, 1), (1, 1, 3, 3)),
)
MOST_DIMENSIONS = 1 + len(DIRECTIONS)


def sobol(d: int, count: int, rng: np.random.Generator | None = None) -> Array:
    """Return the first points (count, d) of the sequence in the unit cube, scrambled by rng where one is given; d at most MOST_DIMENSIONS."""
    numbers = np.stack([_numbers(k) for k in range(d)])
    shift = np.zeros(d, dtype=np.uint32)
    if rng is not None:
        shift, numbers = _scramble(numbers, rng)
    index = np.arange(count, dtype=np.uint32)
    gray, out = index ^ (index >> np.uint32(1)), np.tile(shift, (count, 1))
    for j in range(max(1, count - 1).bit_length()):
        out ^= (gray >> np.uint32(j) & np.uint32(1))[:, None] * numbers[:, j]
    return np.asarray(out * (1.0 / 2**BITS))


def _numbers(k: int) -> Bits:
    """Return the direction numbers (BITS,) of dimension k, the j-th with its highest bit at BITS - 1 - j."""
    polynomial, first = DIRECTIONS[k - 1] if k else ((), ())
    m = list(first) or [1] * BITS
    while len(m) < BITS:  # m_j = 2 a_1 m_j-1 ^ 4 a_2 m_j-2 ^ ... ^ 2^s m_j-s ^ m_j-s
        new = m[-len(polynomial)]
        for power, a in enumerate(polynomial, 1):
            new ^= a * (m[-power] << power)
        m.append(new)
    return np.array([number << (BITS - 1 - j) for j, number in enumerate(m)], dtype=np.uint32)


def _scramble(numbers: Bits, rng: np.random.Generator) -> tuple[Bits, Bits]:
    """Shift (d,), and direction numbers (d, BITS) whose bits went through a random lower triangular matrix with ones on its diagonal."""
    d, place = len(numbers), np.arange(BITS, dtype=np.uint32)
    shift = rng.integers(2, size=(d, BITS), dtype=np.uint32) @ (np.uint32(1) << place)
    matrix = np.tril(rng.integers(2, size=(d, BITS, BITS), dtype=np.uint32))
    matrix[:, place, place] = 1
    falling = place[::-1]  # bits from the highest to the lowest
    bits = numbers[:, None, :] >> falling[:, None] & np.uint32(1)
    mixed = (matrix @ bits) % np.uint32(2)
    return shift, (mixed << falling[:, None]).sum(axis=1, dtype=np.uint32)
