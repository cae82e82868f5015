"""The title procedure: 52 nodes, 14 approaches each, followed by a LaserTracer from five stations one after the other.

Published: nodes, the 14 directions, five stations, U = 0.2 um + 0.3 um/m (eq. 1). Drawn, because unpublished: where the stations
stood, how much of the scatter is hysteresis of the approach (the same each time the sequence is run) and how much changes from one
run to the next, how much of U is noise of a single length and how much one wavelength for a whole station.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm import Array, Axis, Machine, Recording, calibration, instruments, kinematics
from vcmm import effects as fx

from .nodes import NODES

AXES = tuple((s * np.eye(3)[i]).astype(int) for i in range(3) for s in (1, -1))
DIAGONALS = tuple(np.array([x, y, z]) for x in (1, -1) for y in (1, -1) for z in (1, -1))
DIRECTIONS = np.array([*AXES, *DIAGONALS])  # (14, 3): senses of the motion towards the node
STATIONS = (
    (-180.0, -140.0, 60.0), (1010.0, -150.0, 140.0), (980.0, 780.0, 40.0), (-160.0, 760.0, 180.0), (470.0, 330.0, 1010.0),
)  # fmt: skip
U_CONSTANT, U_LENGTH = 0.2e-3, 0.3e-6  # mm, mm/mm: eq. 1, k = 2
RETRO = (0.0, 0.0, -150.0)  # the cat's eye below the ram
TRAVEL = {"X": (0.0, 1200.0), "Y": (0.0, 1000.0), "Z": (0.0, 700.0)}
SYSTEMATIC = 0.4e-3  # mm: rms of what the correction matrix leaves at the nodes
# The part of U that grows with the length is one wavelength of a whole station, or noise of every length.
READINGS = ("station", "length")


def bare() -> Machine:
    """What the owner knows of the machine: structure and travels."""
    axes = {a: Axis(a, ends) for a, ends in TRAVEL.items()}
    return Machine("Leitz PMM 12106 (twin)", "cmm", kinematics.parse_structure("w Y' b X Z t"), axes)


def senses() -> Array:
    """(14, 3): sense in which each axis moved last. An axis that stands still keeps what the approach before left."""
    out = np.zeros(DIRECTIONS.shape)
    last = np.ones(3)
    for i, way in enumerate(DIRECTIONS):
        last = np.where(way != 0, way, last)
        out[i] = last
    return out


@dataclass(frozen=True)
class Approached:
    """d (52, 3) mm: standard deviation of one approach; hysteresis: share of its variance that the sense of the approach makes.

    length_u: of READINGS.
    """

    d: Array
    hysteresis: float = 0.5
    length_u: str = READINGS[0]


def hysteresis_of(drawn: Approached) -> Array:
    """(52, 14, 3) mm less the mean: half a lost motion times the sense, so large that its standard deviation is that share of d."""
    sense = senses()
    centred = sense - sense.mean(axis=0)
    unit = centred / centred.std(axis=0, ddof=1)
    return np.asarray(np.sqrt(drawn.hysteresis) * drawn.d[:, None, :] * unit)


def planned() -> Recording:
    """What is meant: 5 x 52 x 14 lengths with labels of station and approach and the senses of motion, nothing read yet."""
    free = {"station": "setup", "zero": "setup"}
    tips = np.repeat(NODES, len(DIRECTIONS), axis=0)
    parts = [
        instruments.lengths_to(
            bare(), "tracer", tips, place, RETRO, nuisance=free, u=U_CONSTANT / 2, label=f"{k + 1}"
        )
        for k, place in enumerate(STATIONS)
    ]
    whole = instruments.join_layouts("tracer", parts)
    count = len(STATIONS) * len(NODES)
    names = np.tile([_named(w) for w in DIRECTIONS], count)
    sense = np.tile(senses(), (count, 1))
    run = whole.run.with_columns({f"sense_{a}": sense[:, i] for i, a in enumerate("XYZ")})
    return replace(whole, run=replace(run, labels={**run.labels, "repeat": names}))


def _named(way: Array) -> str:
    return "".join(f"{a}{'+' if s > 0 else '-'}" for a, s in zip("XYZ", way) if s)


def read(drawn: Approached, rng: np.random.Generator) -> Recording:
    """The lengths that the LaserTracer reads on a machine with this scatter; its residual field at the nodes is drawn too."""
    meant = planned()
    left = SYSTEMATIC * rng.standard_normal(NODES.shape)
    truth = bare().with_effect(fx.ResidualField(nodes=NODES, interpolation="columns-linear", values=left))
    alone = drawn.length_u == READINGS[1]
    certificate = instruments.InstrumentCertificate(
        instruments.LASER_TRACER, {"scale": 0.0 if alone else U_LENGTH / 2}, "setup"
    )
    seen = instruments.simulate_reading(meant, truth, rng, certificate)
    value = seen.value + _approach_error(drawn, seen, rng)
    if alone:
        u = (U_CONSTANT + U_LENGTH * seen.run.column("length_mm")) / 2
        more = np.sqrt(u**2 - (U_CONSTANT / 2) ** 2)  # the constant part is in `seen`
        return replace(seen, value=value + more * rng.standard_normal(seen.m), u=u)
    return replace(seen, value=value)


def _approach_error(drawn: Approached, recording: Recording, rng: np.random.Generator) -> Array:
    """(m,) mm: hysteresis, the same from every station, and what differs from run to run, seen along the beams."""
    fixed = np.tile(hysteresis_of(drawn).reshape(-1, 3), (len(STATIONS), 1))
    wide = np.sqrt(1 - drawn.hysteresis) * np.repeat(drawn.d, len(DIRECTIONS), axis=0)
    moved = fixed + np.tile(wide, (len(STATIONS), 1)) * rng.standard_normal(fixed.shape)
    return np.asarray(recording.sign * (recording.direction * moved[recording.row]).sum(axis=1))


def found_by(drawn: Approached, seed: int) -> calibration.NodeScatter:
    """The whole procedure on one draw."""
    return calibration.node_scatter(read(drawn, np.random.default_rng([seed, 20140814])), bare())


def untold(found: calibration.NodeScatter, nodes: int = 10, level: float = 0.05) -> float:
    """Probability that so many nodes, picked at random, have no test below the level (hypergeometric); the paper's ten had none."""
    from math import comb

    count = len(found.place)
    clean = count - int((found.test < level).any(axis=1).sum())
    return comb(clean, nodes) / comb(count, nodes)
