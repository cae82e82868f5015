"""The drawn lathe: structure w C' X' b Z t, every error of X and C drawn, the four of the selective model with the published sizes.

Published: E_ZX 52.6 nm over 38 mm at the height of the spindle (Abbe share included), E_ZC 4.4 nm, E_B0C 0.08 arcsec, E_BC with two
lobes. Drawn: everything else, among it the size of E_BC (shown as a picture only) and all errors that the selective model leaves out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.physics.structure.squareness import RotaryLocation

NM, ARCSEC, TURN = 1e-6, np.pi / 180 / 3600, 2 * np.pi
STRAIGHT, AXIAL, SQUARE = 52.6 * NM, 4.4 * NM, 0.08 * ARCSEC  # published
HALF, RADIUS = 19.0, 10.0  # mm: scanned 38 mm; radius of the mirror's measured part
CARRIAGE = 150.0  # mm that the slide runs below the spindle (drawn)
ROLL, YAW = 0.15e-6, 0.3e-6  # rad, rms of EAX and of EBX, ECX (drawn)
OTHERS = 60 * NM  # rms of EXX and EYX
SMOOTH = (9.0, 16.0)  # mm
TWO_LOBES = (0.5e-6, 0.9e-6)  # rad, amplitude of E_BC at two per turn
ORDERS = 8
NODES = np.linspace(-HALF, HALF, 153)
CIRCLE = np.arange(360) * TURN / 360
SELECTED = ("EZX", "EZC", "EBC", "B0C")


@dataclass(frozen=True, eq=False)
class DrawnLathe:
    """machine: all errors; asynchronous: rms of the spindle's axial (mm) and tilt (rad) motion that does not repeat."""

    machine: Machine
    asynchronous: tuple[float, float]


def drawn_lathe(rng: np.random.Generator) -> DrawnLathe:
    """One lathe. E_ZX is scaled at the height of the spindle, its slope over 38 mm counts as squareness."""
    roll = ROLL * _level(_smooth(rng))
    carriage = rng.uniform(20, 50) * NM * _smooth(rng)
    seen = _without_line(carriage + CARRIAGE * roll)
    scale = STRAIGHT / float(np.ptp(seen))
    curves = {
        "EZX": scale * (carriage - (carriage + CARRIAGE * roll - seen)),
        "EAX": scale * roll,
        "EXX": OTHERS * _smooth(rng),
        "EYX": OTHERS * _smooth(rng),
        "EBX": YAW * _level(_smooth(rng)),  # its mean is squareness
        "ECX": YAW * _level(_smooth(rng)),
    }
    tables = [ComponentTable(name, ("X",), (NODES,), values) for name, values in curves.items()]
    turning = [RotaryCyclic(name, values) for name, values in _spindle(rng).items()]
    sign = rng.choice([-1.0, 1.0])
    tilts = [
        RotaryLocation("B0C", tilt=sign * SQUARE),
        RotaryLocation("A0C", tilt=rng.uniform(-1, 1) * 2 * SQUARE),
    ]
    axes = {
        "X": Axis("X", (-HALF, HALF), measured_at=(0.0, -CARRIAGE, 0.0)),
        "C": Axis("C", (-1e4, 1e4), error_frame="fixed"),
        "Z": Axis("Z", (-50.0, 50.0)),
    }
    machine = Machine(
        "lathe of the paper's figures",
        "lathe",
        parse_structure("w C' X' b Z t"),
        axes,
        (*tables, *turning, *tilts),
    )
    return DrawnLathe(machine, (rng.uniform(0.5, 1.5) * NM, rng.uniform(0.02, 0.06) * 1e-6))


def _smooth(rng: np.random.Generator) -> Array:
    """(153,) of rms about 1."""
    length = rng.uniform(*SMOOTH)
    kernel = np.exp(-((NODES[:, None] - NODES) ** 2) / (2 * length**2)) + 1e-8 * np.eye(len(NODES))
    return np.asarray(np.linalg.cholesky(kernel) @ rng.standard_normal(len(NODES)))


def _level(values: Array) -> Array:
    return np.asarray(values - values.mean())


def _without_line(values: Array) -> Array:
    return np.asarray(values - np.polyval(np.polyfit(NODES, values, 1), NODES))


def _spindle(rng: np.random.Generator) -> dict[str, Array]:
    """Orders 1 to 8, falling with the order; axial scaled to its range, tilt with its two lobes."""
    fall = np.repeat(1.0 / np.arange(1, ORDERS + 1), 2)
    drawn = {
        name: fall * rng.standard_normal(2 * ORDERS) for name in ("EXC", "EYC", "EZC", "EAC", "EBC", "ECC")
    }
    axial = drawn["EZC"] * AXIAL / float(np.ptp(wave(drawn["EZC"], CIRCLE)))
    lobes = rng.uniform(*TWO_LOBES)
    out = {
        "EXC": 10 * NM * drawn["EXC"],
        "EYC": 10 * NM * drawn["EYC"],
        "EZC": axial,
        "ECC": 0.5e-6 * drawn["ECC"],
    }
    for name in ("EAC", "EBC"):
        tilt, phase = 0.15 * lobes * drawn[name], rng.uniform(0, TURN)
        tilt[2:4] = lobes * np.cos(phase), lobes * np.sin(phase)
        out[name] = tilt
    return out


def wave(coefficients: Array, angle: Array) -> Array:
    """(n,) of cosine and sine of order 1, 2, ... at angles (n,) rad."""
    k = np.arange(1, len(coefficients) // 2 + 1)
    turns = np.outer(angle, k)
    return np.asarray(np.cos(turns) @ coefficients[::2] + np.sin(turns) @ coefficients[1::2])


def surface_motion(machine: Machine, x: Array, angle: Array, probe: Sequence[float] = (0.0, 0.0)) -> Array:
    """(n,) mm: how the surface under the probe moves to +Z, by all errors of the machine: eq. 5, third row.

    x (n,) mm, angle (n,) rad; probe (2,) mm: how far it stands off the spindle's centre in X and Y.
    """
    offset = np.tile([probe[0], probe[1], 0.0], (len(x), 1))
    return -machine.tip_error(Run({"X": x, "C": angle, "Z": np.zeros(len(x))}, offset))[:, 2]


def only(machine: Machine, names: Sequence[str]) -> Machine:
    """The machine with these errors alone, E_ZX as it is seen at the height of the spindle."""
    kept = tuple(e for e in machine.effects if str(getattr(e, "component", "")) in names)
    if "EZX" not in names or "EAX" in names:
        return replace(machine, effects=kept)
    tables = {e.component: e for e in machine.effects if isinstance(e, ComponentTable)}
    whole = np.asarray(tables["EZX"].values) + CARRIAGE * np.asarray(tables["EAX"].values)
    others = tuple(e for e in kept if str(getattr(e, "component", "")) != "EZX")
    return replace(machine, effects=(ComponentTable("EZX", ("X",), (NODES,), whole), *others))


def selective(x: Array, straight: Array, axial: Array, tilt: Array, square: float) -> Array:
    """(n,) mm: what the four errors do to a reading; minus the error terms of eq. 6, which is minus eq. 5: z - E_Z."""
    return np.asarray(straight + axial - x * tilt - x * square)
