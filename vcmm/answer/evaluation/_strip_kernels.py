"""One strip of trials of many outputs: y += gain z with all sums held in vector registers.

Loops over arrays leave every sum in memory: numba cannot hold some outputs of some trials in registers over all lanes, and
a slice of an array costs more than the work on it. So the strip is written in the language of the compiler underneath
(LLVM): outputs are rows, trials the elements of a vector, a lane is read once for all rows. No fastmath: every product and
every sum is rounded, lane after lane.
"""

from __future__ import annotations

from typing import Any

from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

ROWS = 8  # outputs at a time
# trials at a time: 8 sums and more fit the registers
WIDTH = 8 if binding.get_host_cpu_features().get("avx512f") else 4
_INDEX, _NUMBER = ir.IntType(64), ir.DoubleType()
_VECTOR = ir.VectorType(_NUMBER, WIDTH)


def _strip(typing: Any, y: Any, corner: Any, rows: Any, gain: Any, z: Any, at: Any) -> Any:
    """y[k : k + rows, i : i + WIDTH] += gain[k : k + rows] @ z[:, at : at + WIDTH], float64, rows 1 to ROWS; corner = (k, i)."""

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
    """The loop over lanes for so many rows: their sums are read before it and written after it."""
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
    """A vector of one number."""
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    places = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return b.shuffle_vector(b.insert_element(nothing, number, ir.IntType(32)(0)), nothing, places)
