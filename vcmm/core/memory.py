"""Keep freed memory in the process, so that the next arrays need no new pages.

The C library of Linux returns the top of its heap to the system as soon as 128 KB of it are free, and asks for it again, page by page, with
the next array. Blocks of trials are made of arrays of some 100 KB, of which each then costs the fetching of its pages: a tenth to a
fifth of a call of 10 ms (`python -m benchmarks.bench_public`). Once a block that was mapped by itself has been freed, twice its size
may lie free (mallopt(3), M_MMAP_THRESHOLD): so it is in every program that ever gave back a large array. Elsewhere this does nothing.
"""

from __future__ import annotations

import numpy as np

MAPPED_SIZE = 8 << 20  # bytes; never touched, so that none of them is ever fetched


def keep_in_hand() -> None:
    """Keep up to twice `MAPPED_SIZE` of the memory that this process frees from now on."""
    np.empty(MAPPED_SIZE, dtype=np.uint8)
