"""Random numbers that are a pure function of (seed, input name, component, copy, trial).

THE RULE (final: files and published results depend on it; changing it needs a new major version)

    key      the first 8 bytes of BLAKE2b-64 of the text "<seed>\\n<name>" (UTF-8), as two little-endian uint32
    counter  (trial mod 512, trial div 2048, component, copy), four uint32
    word     Philox4x32-10 (Salmon et al., SC 2011) of counter and key gives four words; the trial takes word
             number (trial mod 2048) div 512. So one block of 2048 trials is 512 counters, whose first words stand
             first, then the second words ...: contiguous for vector instructions
    value    symmetric laws: bit 0 of the word is the sign (1: plus), v = float32(word >> 1) 2^-31 is twice the tail
             probability; |value| is interpolated linearly between the quantiles at v = 2^-e (1 + j / 256),
             e = 1..31, j = 0..255, in float32 (`QuantileTable`)
             `Samples` and `MultivariateSamples`: value number (word * m) div 2^32 of m (rows: the word of
             component 0, so that all components of one copy take the same row; values of `Samples` sorted)

`component` numbers the quantities of one input (nodes, spline coefficients), `copy` its independent repetitions
(touch, pose, tool ... see `copy_code`). Consequences: adding an input, a component, a row or more trials changes no
other number; any block, thread, shard or tier of calculation sees the same trial; two backends (numpy, numba)
give the same bits, since every step is exact or correctly rounded in a fixed order. The words are the same on every
computer; a quantile could differ there in the last bit of its float32, should the computers' libraries differ.
The tail is cut at probability 2^-32 on each side (t with 4 degrees of freedom: +-340 times the scale), quantiles
are right to 2e-6 of their value (t with nu = 1: 5e-6), and so is u (nu = 4: 1e-5, nu = 3: 4e-4 too small).
"""

from __future__ import annotations

import functools
import hashlib
import sys
from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import Array, Law, MultivariateSamples, Samples

BLOCK = 2048  # trials per counter block
_QUARTER = 512
_BITS = 8  # table nodes per octave: 2^8
_OCTAVES = 31
_M0, _M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_W0, _W1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_MASK, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)
_WORTH_NUMBA = 20_000_000  # numbers from which loading numba (0.4 s) pays; measured, see benchmarks/
_WORTH_CALL = 4_000  # the same once numba is loaded


def key(seed: int, name: str) -> tuple[int, int]:
    """Return the 64-bit Philox key of an input: see the rule in the docstring of this module."""
    digest = hashlib.blake2b(f"{int(seed)}\n{name}".encode(), digest_size=8).digest()
    return int.from_bytes(digest[:4], "little"), int.from_bytes(digest[4:], "little")


@functools.lru_cache(maxsize=1 << 14)
def copy_code(label: str | int) -> int:
    """Return a stable uint32 of a label value (pose "B", touch 17), so that adding rows does not change the others.

    Whole numbers 0..2^31-1, given as numbers or as text, are their own code (no collisions among row numbers);
    any other text is 2^31 + 31 bits of its BLAKE2b hash.
    """
    text = str(label)
    if text.isascii() and text.isdigit() and str(int(text)) == text and int(text) < 2**31:
        return int(text)
    return 2**31 | int.from_bytes(hashlib.blake2b(text.encode(), digest_size=4).digest(), "little") >> 1


def _philox(counter: Array, block: int, lanes: Array, keys: Array) -> Array:
    """Return Philox4x32-10 words, (4, L, m) uint64, of counters (counter[m], block, lanes[L]) under keys (L, 2)."""
    words = np.empty((4, len(lanes), len(counter)), np.uint64)
    words[0], words[1], words[2], words[3] = counter, block, lanes[:, :1], lanes[:, 1:]
    a, b, c, d = words
    p, q = np.empty_like(a), np.empty_like(a)
    ka, kb = keys[:, :1].astype(np.uint64), keys[:, 1:].astype(np.uint64)
    for _ in range(10):  # in place: the loop is bound by the cache
        np.multiply(a, _M0, out=p)
        np.multiply(c, _M1, out=q)
        np.right_shift(q, _HALF, out=a)
        a ^= b
        a ^= ka
        np.right_shift(p, _HALF, out=c)
        c ^= d
        c ^= kb
        np.bitwise_and(q, _MASK, out=b)
        np.bitwise_and(p, _MASK, out=d)
        ka, kb = (ka + _W0) & _MASK, (kb + _W1) & _MASK
    return words


def _block_words(keys: Array, lanes: Array, block: int, first: int, last: int) -> Array:
    """Return words (L, last - first) uint32 of trials first..last-1 of one block, on as few counters as possible."""
    if last - first >= _QUARTER:
        words = np.empty((len(lanes), 4, _QUARTER), np.uint32)
        words[:] = np.moveaxis(_philox(np.arange(_QUARTER), block, lanes, keys), 0, 1)
        return words.reshape(len(lanes), BLOCK)[:, first:last]
    trial = np.arange(first, last)
    words = _philox(trial % _QUARTER, block, lanes, keys)
    return words[trial // _QUARTER, :, np.arange(len(trial))].T.astype(np.uint32)


def check_range(start: int, count: int) -> None:
    """Raises ModelLimit where trials start..start+count-1 leave 0..2^43: their counters would come again."""
    if start < 0 or count < 0 or start + count > 2**43:
        raise ModelLimit(
            f"Trials {start} to {start + count} leave the range 0 to 2^43; use another seed instead."
        )


def _spans(start: int, count: int) -> list[tuple[int, int, int, int]]:
    """Return (block, first, last, column): the parts of trials start..start+count-1 that lie in one block each."""
    check_range(start, count)
    spans, at = [], start
    while at < start + count:
        block, first = divmod(at, BLOCK)
        last = min(BLOCK, first + start + count - at)
        spans.append((block, first, last, at - start))
        at += last - first
    return spans


def bits(key: tuple[int, int], component: int, copy: int, start: int, count: int) -> NDArray[np.uint32]:
    """Return the random words (count,) uint32 of trials start..start+count-1 of one component and copy."""
    keys, lanes = np.array([key], np.uint32), np.array([[component, copy]], np.uint32)
    parts = [
        _block_words(keys, lanes, block, first, last)[0] for block, first, last, _ in _spans(start, count)
    ]
    return np.concatenate([np.empty(0, np.uint32), *parts])


@dataclass(frozen=True, eq=False)
class QuantileTable:
    """Quantiles of a symmetric law at v = 2^(o - 31) (1 + j / 256), o = 0..30: `value` and `slope` (7937,) float32.

    The index of v is exponent and upper 8 mantissa bits of its float32, the rest of the mantissa interpolates.
    """

    value: Array
    slope: Array

    @functools.cached_property
    def nodes(self) -> Array:
        """Value and slope of every node side by side, as one uint64: what the numba twin fetches."""
        return np.stack([self.value, self.slope], axis=1).view(np.uint64).ravel()

    def lookup(self, words: Array) -> Array:
        """Return standard values (float32) of random words (uint32), elementwise."""
        v = (words >> np.uint32(1)).view(np.int32).astype(np.float32)
        v *= np.float32(2.0**-31)
        pattern = v.view(np.int32)
        k = (pattern >> (23 - _BITS)).astype(np.intp)
        k -= (127 - _OCTAVES) << _BITS
        np.maximum(k, 0, out=k)
        x = (pattern & ((1 << (23 - _BITS)) - 1)).astype(np.float32)
        x *= np.float32(2.0 ** (_BITS - 23))
        x *= self.slope.take(k)
        x += self.value.take(k)
        x.view(np.uint32)[...] ^= (~words & np.uint32(1)) << np.uint32(31)  # the sign, without a branch
        return x


@functools.lru_cache(maxsize=256)
def table(shape: Law) -> QuantileTable:
    """Return the quantile table of a symmetric standard law (`law.shape`); made once per shape."""
    if isinstance(shape, Samples):
        raise UsageError("A law of samples has no quantile table: its values are drawn by index.")
    k = np.arange((_OCTAVES << _BITS) + 1)
    v = np.ldexp(1 + (k % 2**_BITS) / 2**_BITS, (k >> _BITS) - _OCTAVES)
    value = shape.isf(v / 2)  # the last node, v = 1, is the median
    return QuantileTable(value.astype(np.float32), np.append(np.diff(value), 0.0).astype(np.float32))


@functools.cache
def _load_kernels() -> ModuleType | None:
    """Return the compiled twin, or None where numba is missing or cannot keep its cache."""
    try:
        import numba

        from vcmm.answer.evaluation import _stream_kernels
        from vcmm.core._compile_kernels import KEPT
    except (ImportError, RuntimeError, OSError):
        return None
    return _stream_kernels if KEPT and not vars(numba.config)["DISABLE_JIT"] else None


def kernel_state() -> tuple[str, str]:
    """Return whether compiled kernels can be used, and "ok" or what to do: a row of `vcmm doctor`."""
    if _load_kernels():
        return "yes", "ok"
    return (
        "no",
        "install numba and let ~/.cache/vcmm be written; numpy gives the same numbers, about 10 times slower",
    )


def kernels(numbers: int) -> ModuleType | None:
    """Return the numba twin (vcmm.answer.evaluation._stream_kernels) if sampling so many numbers is worth it, else None: use numpy."""
    loaded = "vcmm.answer.evaluation._stream_kernels" in sys.modules
    return _load_kernels() if numbers > (_WORTH_CALL if loaded else _WORTH_NUMBA) else None


Drawable = Law | MultivariateSamples


def is_tabled(shape: Drawable) -> bool:
    """Return whether values are sampled through a quantile table; else by index of a sample."""
    return isinstance(shape, Law) and not isinstance(shape, Samples)


def standard(
    shape: Drawable, keys: Array, lanes: Array, start: int, out: Array, fast: ModuleType | None
) -> None:
    """Fill out (L, count) with values of unit scale of trials start, start + 1, ...

    `lanes` (L, 2) = (component, copy) and their `keys` (L, 2) are uint32. `fast` is the numba twin or None (see
    `kernels`); the bits are the same.
    """
    for block, first, last, at in _spans(start, out.shape[1]):
        part = out[:, at : at + last - first]
        if fast and is_tabled(shape) and last - first >= _QUARTER:
            _fill_block(fast, table(shape), (keys, lanes), block, first, part)
            continue
        rows = max(1, 16 * _QUARTER // min(_QUARTER, last - first))  # lanes per pass: what fits the cache
        for j in range(0, len(lanes), rows):
            s = slice(j, j + rows)
            part[s] = _values(shape, keys[s], lanes[s], block, first, last)


def _fill_block(
    fast: ModuleType, source: QuantileTable, drawn: tuple[Array, Array], block: int, first: int, part: Array
) -> None:
    """Sample trials first, first + 1, ... of one block into part (L, m), by the numba twin, which makes whole blocks.

    drawn: keys and lanes, (L, 2) each.
    """
    ids = np.concatenate(drawn, axis=1)
    whole = part if part.shape[1] == BLOCK and part.flags.c_contiguous else np.empty((len(ids), BLOCK))
    fast.fill(source.nodes, ids, block, whole)
    if whole is not part:
        part[:] = whole[:, first : first + part.shape[1]]


def _values(shape: Drawable, keys: Array, lanes: Array, block: int, first: int, last: int) -> Array:
    """Return values (L, last - first) of unit scale within one block."""
    if isinstance(shape, MultivariateSamples):
        common = lanes * np.array([0, 1], np.uint32)  # component 0: one row for all components of a copy
        return shape.values[_index(_block_words(keys, common, block, first, last), shape), lanes[:, :1]]
    words = _block_words(keys, lanes, block, first, last)
    if isinstance(shape, Samples):
        return np.asarray(shape.values[_index(words, shape)])
    return table(shape).lookup(words)


def _index(words: Array, law: Samples | MultivariateSamples) -> Array:
    """Return the row numbers 0..m-1 from words: the multiply-shift rule."""
    return (words.astype(np.uint64) * np.uint64(len(law.values))) >> _HALF


def draw(seed: int, name: str, lanes: Array, law: Drawable, start: int, count: int) -> NDArray[np.float64]:
    """Return deviations (count, L) of the input `name` in trials start..start+count-1.

    `lanes` (L, 2) uint32 lists (component, copy) of each column. For `MultivariateSamples` the component names the
    column of its values; a `MultivariateNormal` is sampled as Normal(1) for components 0..r-1 and multiplied by its
    `factor`. Raises ModelLimit when trials leave 0..2^43.
    """
    lanes = np.ascontiguousarray(lanes, np.uint32).reshape(-1, 2)
    keys = np.tile(np.array(key(seed, name), np.uint32), (len(lanes), 1))
    out = np.empty((len(lanes), count))
    standard(law.shape if isinstance(law, Law) else law, keys, lanes, start, out, kernels(out.size))
    return (law.scale * out if isinstance(law, Law) else out).T
