"""Geometric parameters learnt from readings, not known: noise of 0.8 um and 1.5 urad at every node, then the paper's two kinds of model.

readings     the table as it was read, linear between the nodes
regression   a cubic polynomial over the axis for every parameter
network      one net per axis, position to its six parameters (the layout i, 2i+1, o of the twin echerfaoui2017)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from vcmm import Array, Machine, Run, calibration
from vcmm import effects as fx

from .chain import carriages, product, volumetric_error

LENGTH, ANGLE = 0.8e-3, 1.5e-6  # mm, rad: standard deviation of a reading
DEGREE, DRAWS, EPOCHS = 3, 8, 5000
METHODS = ("readings as they are", "cubic regression", "network i, 2i+1, o")


@dataclass(frozen=True)
class LearntGeometry:
    """What a model leaves over the volume, um, eq. 26: root mean square and largest of every draw of the noise."""

    method: str
    rms: tuple[float, ...]
    largest: tuple[float, ...]


def learnt_geometry(machine: Machine, run: Run, draws: int = DRAWS) -> tuple[LearntGeometry, ...]:
    """Every method on the same draws; run: places of the volume."""
    true, found = product(carriages(machine, run))[0], {m: ([], []) for m in METHODS}  # type: ignore[var-annotated]
    for seed in range(draws):
        rng = np.random.default_rng([seed, 20040522])
        read = readings(machine, rng)
        for method in METHODS:
            model = with_tables(machine, smoothed(machine, read, method, rng))
            left = volumetric_error(true - product(carriages(model, run))[0])
            found[method][0].append(1e3 * float(np.sqrt((left**2).mean())))
            found[method][1].append(1e3 * float(left.max()))
    return tuple(LearntGeometry(m, tuple(rms), tuple(largest)) for m, (rms, largest) in found.items())


def tables_of(machine: Machine) -> dict[str, fx.ComponentTable]:
    return {e.component: e for e in machine.effects if isinstance(e, fx.ComponentTable)}


def readings(machine: Machine, rng: np.random.Generator) -> dict[str, Array]:
    """Component -> what was read at its nodes, mm or rad."""
    out = {}
    for name, table in tables_of(machine).items():
        noise = ANGLE if name[1] in "ABC" else LENGTH
        out[name] = np.asarray(table.values) + noise * rng.standard_normal(np.size(table.values))
    return out


def smoothed(
    machine: Machine, read: Mapping[str, Array], method: str, rng: np.random.Generator
) -> dict[str, Array]:
    """Component -> values at its nodes by a method."""
    tables = tables_of(machine)
    if method == METHODS[0]:
        return dict(read)
    if method == METHODS[1]:
        return {n: _polynomial(np.asarray(tables[n].grids[0]), v) for n, v in read.items()}
    out: dict[str, Array] = {}
    for axis in sorted({n[2:] for n in read}):
        names = [n for n in read if n[2:] == axis]
        x = np.asarray(tables[names[0]].grids[0])[:, None]
        y = np.stack([read[n] for n in names], axis=1)
        out |= dict(zip(names, calibration.train_net(x, y, calibration.BEST_LAYOUT, rng, EPOCHS).at(x).T))
    return out


def _polynomial(x: Array, y: Array) -> Array:
    way = (x - x.mean()) / np.ptp(x)
    return np.asarray(np.polyval(np.polyfit(way, y, DEGREE), way))


def with_tables(machine: Machine, values: Mapping[str, Array]) -> Machine:
    """The machine with other numbers at the nodes of its tables."""
    effects = tuple(
        replace(e, values=values[e.component]) if isinstance(e, fx.ComponentTable) else e
        for e in machine.effects
    )
    return replace(machine, effects=effects)
