"""Find where all errors of a machine are known, and how well: grids within the nodes of a residual field, standard uncertainty of the tip error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vcmm.core.declaration import Tabulated
from vcmm.core.effect import Effect, known_range
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.kinematics import nominal_tip
from vcmm.core.knowledge import acted_on
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.response.carrier import Carrier, Sight

BLOCK = 200  # rows at a time: a field of hundreds of nodes fills memory otherwise


def known_rows(machine: Machine, run: Run) -> npt.NDArray[np.bool_]:
    """Return the rows whose tip lies where every effect is known, as (n,)."""
    tip = nominal_tip(machine.chain, machine.axes, run)
    out = np.ones(run.n, dtype=bool)
    for effect in machine.effects:
        covered = effect.covers(tip) if isinstance(effect, Tabulated) else None
        if covered is not None:
            out &= covered
    return out


def known_box(machine: Machine, letters: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return the range of each linear axis, mm, that is common to travels and boxes of the effects, rotary axes at zero and no stylus.

    Raises ModelLimit where there is no common range.
    """
    start = {a: np.zeros(len(letters) + 1) for a in machine.axes}
    for i, letter in enumerate(letters):
        start[letter][i + 1] = 1.0
    tip = nominal_tip(machine.chain, machine.axes, Run(start, np.zeros((len(letters) + 1, 3))))
    out = {a: machine.axes[a].travel for a in letters}
    for effect in machine.effects:
        limited = isinstance(effect, Tabulated) and effect.covers(tip) is not None
        for interval in known_range(effect) if limited else ():
            for i, letter in enumerate(letters):
                slope = float((tip[i + 1] - tip[0])[interval.direction])
                if abs(abs(slope) - 1) < 1e-9:
                    ends = sorted(
                        (v - float(tip[0, interval.direction])) / slope for v in (interval.low, interval.high)
                    )
                    out[letter] = (max(out[letter][0], ends[0]), min(out[letter][1], ends[1]))
    for letter, (low, high) in out.items():
        if not low < high:
            raise ModelLimit(
                f"the travel of {letter} and the nodes of the residual field have nothing in common; check the nodes, or measure others"
            )
    return out


def tip_uncertainty(machine: Machine, run: Run) -> tuple[Array, tuple[str, ...]]:
    """Return (u (n, 3) mm of one positioning in x, y, z; the Inputs that are not in it: those of readings, and of columns that a map lacks)."""
    left = tuple(i.id for i in machine.inputs if not _shows(machine, i))
    kept = [i for i in machine.inputs if _shows(machine, i)]
    run = machine.prepare(run)
    out = np.zeros((run.n, 3))
    for first in range(0, run.n, BLOCK):
        rows = slice(first, first + BLOCK)
        part = run.take(np.arange(run.n)[rows])
        for direction in range(3):
            along = np.tile(np.eye(3)[direction], (part.n, 1))
            carrier = Carrier(machine, part, Sight(along, motion=1.0, reading=0.0))
            for quantity in kept:
                gain = carrier.of_input(quantity, acted_on(machine, quantity))
                law, factor = quantity.spread(gain.shape[1])
                out[rows, direction] += _variance(gain @ factor, np.asarray(law.u, dtype=float), quantity)
    return np.sqrt(out), left


def _variance(gain: Array, u: Array, quantity: Input) -> Array:
    covariance = getattr(quantity.law, "covariance", None)
    if covariance is not None and u.ndim:  # rows of samples, drawn together
        return np.asarray(np.einsum("nk,kl,nl->n", gain, covariance, gain))
    return np.asarray(((gain * u) ** 2).sum(axis=1))


def _shows(machine: Machine, quantity: Input) -> bool:
    """Return whether an Input moves the tip at a bare position; a column of the run has no value there."""
    return not quantity.is_channel and any(e.link != "reading" for e in _effects(machine, quantity))


def _effects(machine: Machine, quantity: Input) -> tuple[Effect, ...]:
    return tuple(e for m in (quantity.members or (quantity,)) for e in acted_on(machine, m))


def without_unknown(machine: Machine, run: Run) -> Run:
    """Return the rows where every effect is known. Raises ModelLimit where there is none."""
    kept = known_rows(machine, run)
    if not kept.any():
        raise ModelLimit(
            "no point of the grid lies within the nodes of the residual field; choose more with --nodes"
        )
    return run if kept.all() else run.take(np.flatnonzero(kept))
