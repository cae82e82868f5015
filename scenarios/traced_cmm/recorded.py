"""A bridge CMM that has never been calibrated: what `vcmm new traced_cmm` copies.

    lengths.csv     a LaserTracer at six places, 86 positions each, tips of different lengths: it identifies all 21 errors
    diagonal.csv    a laser along two body diagonals that the calibration does not use: the test
    warm_up.csv     a morning: the bridge warms, the air wanders, a fixed sphere is touched every five minutes

The machine is made of sines over its travels, its bridge of one time constant; no code of the calibration is used.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm import Array, Axis, Effect, Machine, Recording, instruments, kinematics
from vcmm import effects as fx

TRAVEL = {"X": (0.0, 600.0), "Y": (0.0, 500.0), "Z": (-400.0, 0.0)}
STATIONS = (
    (-200, -150, -500), (800, -150, -450), (300, 700, -550), (-150, 650, 100), (750, 600, 150), (300, -300, -100),
)  # fmt: skip
TIPS = (
    (0, 0, -100), (0, 0, -250), (120, 0, -100), (0, 120, -100), (-120, 0, -150), (0, -120, -200),
)  # fmt: skip
TRACER_U, LASER_U, TOUCH_U = 0.3e-3, 0.2e-3, 0.4e-3  # mm
SQUARE = {"C0Y": 14e-6, "B0Z": -9e-6, "A0Z": 6e-6}  # rad
SEED, LEVELS = 2026, 7
BEND, LAG = 1.8e-3, 2600.0  # mm/K, s: the bridge pushes the tip along z


def bare() -> Machine:
    """What the owner knows: structure and travels."""
    axes = {a: Axis(a, ends) for a, ends in TRAVEL.items()}
    return Machine("bridge CMM, never calibrated", "cmm", kinematics.parse_structure("w b Y X Z t"), axes)


def truth() -> Machine:
    """Its errors: for each a sine of one to two periods over the travel and half as much of another, 1 to 4 um, 2 to 8 urad."""
    rng = np.random.default_rng(SEED)
    table, angle = fx.ComponentTable, fx.Squareness
    effects: list[Effect] = []
    for axis, (low, high) in TRAVEL.items():
        q = np.linspace(low, high, 61)
        for kind in "XYZABC":
            size = rng.uniform(2e-6, 8e-6) if kind in "ABC" else rng.uniform(1e-3, 4e-3)
            first, second = rng.uniform(0.6, 1.2), rng.uniform(1.2, 2.0)
            turn = 2 * np.pi * (q - low) / (high - low)
            values = np.sin(first * turn + rng.uniform(0, 6)) + 0.5 * np.sin(
                second * turn + rng.uniform(0, 6)
            )
            effects.append(table(f"E{kind}{axis}", (axis,), (q,), size * (values - values.mean())))
    effects += [angle(pair, value) for pair, value in SQUARE.items()]
    return bare().with_effect(*effects)


def tracer() -> Recording:
    """Lengths from six stations to every fourth place of a grid of 7 x 7 x 7."""
    steps = [np.linspace(*TRAVEL[a], LEVELS).round(3) for a in "XYZ"]
    every = np.stack([m.ravel() for m in np.meshgrid(*steps, indexing="ij")], axis=1)
    number = np.indices((LEVELS,) * 3).reshape(3, -1)
    grid = every[number.sum(axis=0) % 4 == 0]
    free = {"station": "setup", "zero": "setup"}
    parts = [
        instruments.lengths_to(
            bare(),
            "LaserTracer",
            grid + np.array(tip),
            place,
            tip,
            nuisance=free,
            u=TRACER_U,
            label=f"{k + 1}",
        )
        for k, (place, tip) in enumerate(zip(STATIONS, TIPS))
    ]
    rng = np.random.default_rng([SEED, 1])
    return replace(
        instruments.join_layouts("lengths", [instruments.simulate_reading(p, truth(), rng) for p in parts]),
        name="lengths",
    )


def diagonals() -> Recording:
    """A laser along two body diagonals, 13 places each."""
    parts, share = [], np.linspace(0.05, 0.95, 13)
    for k, reverse in enumerate((False, True)):
        ends = {a: (high, low) if a == "Y" and reverse else (low, high) for a, (low, high) in TRAVEL.items()}
        place = {a: low + share * (high - low) for a, (low, high) in ends.items()}
        way = np.array([high - low for low, high in ends.values()])
        run = instruments.rows(place, np.array([0.0, 0.0, -150.0]), {"setup": [f"{k + 1}"] * len(share)})
        meant = instruments.layout(
            "diagonal", "displacement", run, way / np.linalg.norm(way), {"zero": "setup"}, LASER_U
        )
        parts.append(instruments.simulate_reading(meant, truth(), np.random.default_rng([SEED, 2, k])))
    return replace(instruments.join_layouts("diagonal", parts), name="diagonal")


def warm_up() -> str:
    """CSV: indicated z of a fixed sphere less the first, over six hours; bridge and air."""
    rng = np.random.default_rng([SEED, 3])
    time = np.arange(0.0, 6 * 3600.0 + 1, 300.0)
    bridge = 20.4 + 3.2 * -np.expm1(-time / 7000.0) + 0.6 * np.sin(time / 4000.0)
    air = 20.8 + 0.5 * np.sin(time / 1700.0 + 1.0) + 0.05 * rng.standard_normal(len(time))
    shift = BEND * (_behind(time, bridge) - 20.0)
    indicated = -(shift - shift[0]) + TOUCH_U * rng.standard_normal(len(time))
    head = "X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,time_s,temp_bridge_C,temp_air_C"
    lines = [
        f"300,250,-200,0,0,1,{1e3 * d:.3f},{t:.0f},{b:.3f},{a:.3f}"
        for d, t, b, a in zip(indicated, time, bridge, air)
    ]
    return "\n".join([head, *lines]) + "\n"


def _behind(time: Array, temperature: Array) -> Array:
    """First-order lag by steps of one second."""
    fine = np.arange(time[0], time[-1] + 1.0)
    drive = np.interp(fine, time, temperature)
    out = np.empty(len(fine))
    out[0] = drive[0]
    for i in range(1, len(fine)):
        out[i] = out[i - 1] + (drive[i] - out[i - 1]) / LAG
    return np.asarray(np.interp(time, fine, out))


def texts() -> dict[str, str]:
    """Name -> text of the data files beside scenarios/traced_cmm.toml."""
    out = {}
    for recording in (tracer(), diagonals()):
        out[f"{recording.name}.csv"] = instruments.recording_texts(recording, recording.name)[
            f"{recording.name}.csv"
        ]
    return out | {"warm_up.csv": warm_up()}
