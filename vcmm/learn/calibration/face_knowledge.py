"""Knowledge of a machine file about a face scanned on it: the apparent rise of the surface, and its uncertainty.

    rise = -(tip error along Z)          J: its change per draw of unit variance of every Input, sampled once for the scan
    cov(L d) = (L J) (L J)' + L diag(v) L'          of any linear figures L of the readings d; v: Inputs sampled anew for every reading

One squareness moves all rings of a face together, so that the u of a cone is that of the squareness and no mean of rings (JCGM 102:2011, 6.2.1.3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.knowledge import acted_on
from vcmm.core.laws import MultivariateNormal
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.instruments.face_scan import FaceScan
from vcmm.task.response.carrier import Carrier, Sight
from vcmm.task.response.known_volume import BLOCK
from vcmm.task.response.volumetric import with_defaults

EVERY_READING = "touch"  # redraw of what is drawn anew for every row


@dataclass(frozen=True, eq=False)
class KnownRise:
    """value (n,) mm; joint (n, m) mm per draw; alone (n,) mm^2, of readings by themselves. machine: its name, "" for none."""

    value: Array
    joint: Array
    alone: Array
    machine: str


def known_rise(scan: FaceScan, machine: Machine | None) -> KnownRise:
    """Return the known rise by the machine file; without one no rise is known, and no u includes it."""
    n = len(scan.x)
    if machine is None:
        return KnownRise(np.zeros(n), np.zeros((n, 0)), np.zeros(n), "")
    second = "C" if scan.spiral else "Y"
    missing = [a for a in ("X", second) if a not in machine.axes]
    if missing:
        raise UsageError(
            f"the machine {machine.name} has no axis {missing[0]}, along which the face was scanned"
        )
    position = {a: np.zeros(n) for a in machine.axes} | {"X": scan.x, second: scan.across}
    run = with_defaults(machine, Run(position, np.zeros((n, 3))))
    value = -machine.tip_error(run)[:, 2]
    kept = [i for i in machine.inputs if _moves_the_tip(machine, i)]
    run = machine.prepare(run)
    blocks, alone = [], np.zeros(n)
    for first in range(0, n, BLOCK):
        part = run.take(np.arange(first, min(first + BLOCK, n)))
        along = np.tile([0.0, 0.0, 1.0], (part.n, 1))
        carrier = Carrier(machine, part, Sight(along, motion=-1.0, reading=0.0))
        columns = {item.id: _columns(carrier, machine, item) for item in kept}
        once = [columns[i.id] for i in kept if i.redraw != EVERY_READING]
        blocks.append(np.concatenate([np.zeros((part.n, 0)), *once], axis=1))
        for item in kept:
            if item.redraw == EVERY_READING:
                alone[first : first + part.n] += (columns[item.id] ** 2).sum(axis=1)
    return KnownRise(value, np.concatenate(blocks), alone, machine.name)


def _columns(carrier: Carrier, machine: Machine, item: Input) -> Array:
    """Return columns (n, r) mm per draw of unit variance."""
    gain = carrier.of_input(item, acted_on(machine, item))
    law, factor = item.spread(gain.shape[1])
    covariance, u = getattr(law, "covariance", None), np.asarray(law.u, dtype=float)
    if covariance is not None and u.ndim:  # rows of samples, drawn together
        return np.asarray(gain @ factor @ MultivariateNormal(covariance).factor)
    return np.asarray(gain @ factor * u)


def _moves_the_tip(machine: Machine, item: Input) -> bool:
    """Return whether an Input moves the tip; a column of the run has no value in a scan; errors of a reading alone are in its scatter."""
    effects = [e for m in (item.members or (item,)) for e in acted_on(machine, m)]
    return not item.is_channel and any(e.link != "reading" for e in effects)
