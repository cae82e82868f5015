"""Drawn error tables of three linear axes: smooth curves, as effects and as the text of a file."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.kinematics import Axis
from vcmm.core.run import Array
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness

NODES = 11


def shape(rng: np.random.Generator) -> Array:
    """A smooth error curve (NODES,) of about unit size, zero where the measurement starts; half waves, so not periodic."""
    s = np.linspace(0.0, 1.0, NODES)
    waves = [rng.normal() / k * (np.cos(np.pi * k * s) - 1.0) for k in (1, 2, 3, 4)]
    return np.asarray(rng.normal() * s + np.sum(waves, axis=0))


def effects_of(tables: Mapping[str, Array], axes: Mapping[str, Axis]) -> tuple[Effect, ...]:
    """The tables as effects, rounded as they stand in files: 1 nm and 1 nrad."""
    out: list[Effect] = []
    for name, values in tables.items():
        if name[1] == "0":
            out.append(Squareness(name, float(np.round(values[0], 9))))
        else:
            nodes = np.linspace(*axes[name[2]].travel, NODES)
            decimals = 9 if name[1] in "ABC" else 6
            out.append(ComponentTable(name, (name[2],), (nodes,), np.round(values, decimals)))
    return tuple(out)


def table_text(tables: Mapping[str, Array], axes: Mapping[str, Axis], said: str) -> str:
    """The same as an ISG volumetric CSV: 1 nm and 1 nrad; squareness last, where there is any."""
    lines = [f"// {said}"]
    for axis in axes:
        names = [f"E{d}{axis}" for d in "XYZABC"]
        lines.append(" ".join([axis, *names]))
        for k, q in enumerate(np.linspace(*axes[axis].travel, NODES)):
            cells = [f"{tables[n][k]:.6f}" if n[1] in "XYZ" else f"{tables[n][k]:.9f}" for n in names]
            lines.append(" ".join([f"{q:g}", *cells]))
        lines.append("#")
    pairs = [n for n in tables if n[1] == "0"]
    if pairs:
        lines += [" ".join(pairs), " ".join(f"{tables[n][0]:.9f}" for n in pairs)]
    return "\n".join(lines if pairs else lines[:-1]) + "\n"
