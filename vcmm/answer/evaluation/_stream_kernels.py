"""Numba twin of vcmm.answer.evaluation.streams and of the inner product of vcmm.answer.evaluation.montecarlo: same rule, same bits, about 10 times faster.

Private; imported inside the functions that use it. No fastmath, so that no product and sum are contracted: every result is the
correctly rounded one of the numpy twin.

One strip of trials of many outputs: y += gain z with all sums held in vector registers.

Loops over arrays leave every sum in memory: numba cannot hold some outputs of some trials in registers over all lanes, and
a slice of an array costs more than the work on it. So the strip is written in the language of the compiler underneath
(LLVM): outputs are rows, trials the elements of a vector, a lane is read once for all rows. No fastmath: every product and
every sum is rounded, lane after lane.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit

ROWS = 8  # outputs at a time
# trials at a time: 8 sums and more fit the registers
WIDTH = 8 if binding.get_host_cpu_features().get("avx512f") else 4
_INDEX, _NUMBER = ir.IntType(64), ir.DoubleType()
_VECTOR = ir.VectorType(_NUMBER, WIDTH)


def _strip(typing: Any, y: Any, corner: Any, rows: Any, gain: Any, z: Any, at: Any) -> Any:
    """Return the strip kernel: y[k : k + rows, i : i + WIDTH] += gain[k : k + rows] @ z[:, at : at + WIDTH], float64, rows 1 to ROWS;
    corner = (k, i)."""

    def generate(context: Any, b: Any, signature: Any, values: Any) -> Any:
        arrays = [context.make_array(signature.args[n])(context, b, values[n]) for n in (0, 3, 4)]

        def place(array: int, *index: Any) -> Any:
            kind = (y, gain, z)[array]
            return cgutils.get_item_pointer(context, b, kind, arrays[array], index, wraparound=False)

        corner_of = cgutils.unpack_tuple(b, values[1], 2)
        lanes = cgutils.unpack_tuple(b, arrays[1].shape, 2)[1]
        end = b.append_basic_block("end")
        choice = b.switch(values[2], end)
        for n in range(1, ROWS + 1):
            case = b.append_basic_block(f"rows{n}")
            choice.add_case(_INDEX(n), case)
            b.position_at_end(case)
            _sums(b, place, n, (*corner_of, values[5]), lanes)
            b.branch(end)
        b.position_at_end(end)
        return context.get_dummy_value()

    return types.none(y, types.UniTuple(types.int64, 2), types.int64, gain, z, types.int64), generate


strip: Any = intrinsic(_strip)


def _sums(b: Any, place: Any, rows: int, corner: tuple[Any, Any, Any], lanes: Any) -> None:
    """Build the loop over lanes for so many rows: their sums are read before it and written after it."""
    k, i, at = corner
    row = [b.add(k, _INDEX(n)) for n in range(rows)]
    ends = [b.bitcast(place(0, r, i), _VECTOR.as_pointer()) for r in row]
    first, before = [b.load(p, align=8) for p in ends], b.block
    loop, done = b.append_basic_block("lanes"), b.append_basic_block("done")
    b.branch(loop)
    b.position_at_end(loop)
    j, sums = b.phi(_INDEX), [b.phi(_VECTOR) for _ in row]
    z = b.load(b.bitcast(place(2, j, at), _VECTOR.as_pointer()), align=8)
    added = [b.fadd(s, b.fmul(_spread(b, b.load(place(1, r, j))), z)) for r, s in zip(row, sums)]
    following = b.add(j, _INDEX(1))
    for phi, start, new in zip([j, *sums], [_INDEX(0), *first], [following, *added]):
        phi.add_incoming(start, before)
        phi.add_incoming(new, b.block)
    b.cbranch(b.icmp_signed("<", following, lanes), loop, done)
    b.position_at_end(done)
    for value, end in zip(added, ends):
        b.store(value, end, align=8)


def _spread(b: Any, number: Any) -> Any:
    """Return a vector of one number."""
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    places = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return b.shuffle_vector(b.insert_element(nothing, number, ir.IntType(32)(0)), nothing, places)


Array = NDArray[Any]

M0, M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
W0, W1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
MASK, HALF = np.uint64(0xFFFFFFFF), np.uint64(32)
ONE, SCALE = np.uint32(1), np.float32(2.0**-31)
SHIFT, BASE, LOW, REST = (
    np.int32(15),
    np.int32((127 - 31) << 8),
    np.int32((1 << 15) - 1),
    np.float32(2.0**-15),
)
COUNTERS, TILE = 128, 512  # a tile: so many counters of a block, four trials each
# trials between the words of a counter; trials and tiles of a block of counters
QUARTER, BLOCK, TILES = 512, 2048, 4
GROUP = 32  # lanes drawn at a time: 32 x 512 numbers stay in the second cache, beside those of another thread


@njit(cache=True, nogil=True)
def words(ids: Array, j: int, block: int, counter: int, out: Array) -> None:
    """Compute Philox4x32-10 words (512,) uint32 of 128 counters from `counter` on: their first words, their second words, ...

    ids (L, 4) uint32: key and lane, of which number j is taken.
    """
    for i in range(COUNTERS):
        a, b, c, d = np.uint64(counter + i), np.uint64(block), np.uint64(ids[j, 2]), np.uint64(ids[j, 3])
        ka, kb = np.uint64(ids[j, 0]), np.uint64(ids[j, 1])
        for _ in range(10):
            p, q = M0 * a, M1 * c
            a, b = ((q >> HALF) ^ b ^ ka) & MASK, q & MASK
            c, d = ((p >> HALF) ^ d ^ kb) & MASK, p & MASK
            ka, kb = (ka + W0) & MASK, (kb + W1) & MASK
        out[i] = a
        out[COUNTERS + i] = b
        out[2 * COUNTERS + i] = c
        out[3 * COUNTERS + i] = d


@njit(cache=True, nogil=True)
def lookup(nodes: Array, word: Array, work: Array, out: Array) -> None:
    """Compute standard values (512,) of random words, by the nodes of vcmm.answer.evaluation.streams.QuantileTable; work (3, 512) uint64.

    Value and slope of a node are one entry of 64 bits, fetched by plain loads: faster than the gathers a compiler makes of
    two tables.
    """
    v, k, indices = work[0].view(np.float32), work[1].view(np.uint32), work[2]
    for i in range(TILE):
        v[i] = np.float32(np.int32(word[i] >> ONE)) * SCALE
    pattern = v.view(np.int32)
    for i in range(TILE):
        k[i] = np.uint32(max((pattern[i] >> SHIFT) - BASE, np.int32(0)))
    for i in range(0, TILE, 4):
        a, b, c, d = nodes[k[i]], nodes[k[i + 1]], nodes[k[i + 2]], nodes[k[i + 3]]
        indices[i], indices[i + 1], indices[i + 2], indices[i + 3] = a, b, c, d
    node = indices.view(np.float32)
    for i in range(TILE):
        x = node[2 * i] + np.float32(pattern[i] & LOW) * REST * node[2 * i + 1]
        out[i] = x if word[i] & ONE else -x


@njit(cache=True, nogil=True)
def fill(nodes: Array, ids: Array, block: int, out: Array) -> None:
    """Fill out (L, 2048) with standard values of one block for lanes and keys ids (L, 4) uint32."""
    word, work, tile = np.empty(TILE, np.uint32), np.empty((3, TILE), np.uint64), np.empty(TILE)
    for j in range(ids.shape[0]):
        for t in range(TILES):
            words(ids, j, block, t * COUNTERS, word)
            lookup(nodes, word, work, tile)
            for q in range(4):
                at = q * QUARTER + t * COUNTERS
                out[j, at : at + COUNTERS] = tile[q * COUNTERS : (q + 1) * COUNTERS]


@njit(cache=True, nogil=True)
def trials(y: Array, first: int, tables: Array, which: Array, ids: Array, gain: Array, spans: Array) -> None:
    """Add to y (K, m) gain (K, L) @ z of the trials first, first + 1, ..., summed over L in order.

    Lane j draws by ids[j] (see `words`) from the nodes tables[which[j]]. spans (L / GROUP, 2): first and last + 1 of the quantities
    that the lanes of each group act on.
    """
    word, work = np.empty(TILE, np.uint32), np.empty((3, TILE), np.uint64)
    # lanes a little apart: 4096 bytes apart they would share places of the cache
    z = np.empty((GROUP, TILE + 8))
    lanes, count = ids.shape[0], y.shape[1]
    for tile in range(first // BLOCK * TILES, ((first + count - 1) // BLOCK + 1) * TILES):
        block, counter = tile // TILES, tile % TILES * COUNTERS
        at = block * BLOCK + counter - first  # column of the first trial of the tile
        if at >= count or at + 3 * QUARTER + COUNTERS <= 0:
            continue
        for j in range(0, lanes, GROUP):
            n, (a, b) = min(GROUP, lanes - j), spans[j // GROUP]
            for i in range(n):
                words(ids, j + i, block, counter, word)
                lookup(tables[which[j + i]], word, work, z[i])
            for q in range(4):
                low, high = max(0, -at - q * QUARTER), min(COUNTERS, count - at - q * QUARTER)
                if low < high:
                    part = z[:n, q * COUNTERS + low : q * COUNTERS + high]
                    accumulate(y[a:b], at + q * QUARTER + low, gain[a:b, j : j + n], part)


@njit(cache=True, nogil=True)
def accumulate(y: Array, at: int, gain: Array, z: Array) -> None:
    """Add to y[:, at : at + n] gain (K, L) @ z (L, n), summed over L in order; outputs in equal parts of at most ROWS."""
    outputs, lanes, n = gain.shape[0], gain.shape[1], z.shape[1]
    parts, whole = (outputs + ROWS - 1) // ROWS, n - n % WIDTH
    for part in range(parts):
        k, end = outputs * part // parts, outputs * (part + 1) // parts
        for i in range(0, whole, WIDTH):
            strip(y, (k, at + i), end - k, gain, z, i)
    for k in range(outputs):
        for i in range(whole, n):
            for j in range(lanes):
                y[k, at + i] += gain[k, j] * z[j, i]


@njit(cache=True, nogil=True)
def tally(values: Array, centre: float, factor: float, counts: Array, sums: Array) -> None:
    """Compute histogram and exact moments of values (m,), see vcmm.answer.evaluation.summary.Accumulator; sums: q, q^2 low and high."""
    half = counts.shape[0] // 2
    for i in range(values.shape[0]):
        q = np.int64(min(max(np.rint((values[i] - centre) * factor), -2147483648.0), 2147483648.0))
        counts[min(max((q >> np.int64(10)) + half, 0), counts.shape[0] - 1)] += 1
        if -2147483648 < q < 2147483648:
            square = q * q
            sums[0] += q
            sums[1] += square & np.int64(0xFFFFFFFF)
            sums[2] += square >> np.int64(32)
