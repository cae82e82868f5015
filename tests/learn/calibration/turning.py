"""Drawn rotary axes: harmonics (no spline, no code of the calibration) and location errors, and what is true about the average line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.physics.structure.squareness import RotaryLocation
from vcmm.task.instruments.laying import simulate_reading
from vcmm.task.instruments.rotary import index_axis, r_test
from vcmm.task.response.recording import Recording

ACROSS = {"A": "YZ", "B": "XZ", "C": "XY"}
TABLE, HEAD = "w C' b Y X Z t", "w b X Y Z B t"
ANGLES = np.radians(np.arange(0, 360, 10.0))
U = 0.2e-3


def bare(structure: str) -> Machine:
    chain = parse_structure(structure)
    turn = (-2 * np.pi, 2 * np.pi)
    axes = {
        a: Axis(
            a,
            turn if a in "ABC" else (-800.0, 800.0),
            centre=(10.0, -5.0, 0.0) if a in "ABC" else (0.0, 0.0, 0.0),
        )
        for a in chain.letters
    }
    return Machine("drawn", "cmm", chain, axes)


def draw(structure: str, axis: str, rng: np.random.Generator) -> Machine:
    """Three harmonics of a few um and 5 to 10 urad in all six components; location 20 um and 40 urad."""
    effects: list[RotaryCyclic | RotaryLocation] = []
    for kind in "XYZABC":
        size = 10e-6 if kind in "ABC" else 3e-3
        waves = size * rng.standard_normal(6) / np.repeat([1.0, 2.0, 3.0], 2)
        effects.append(RotaryCyclic(f"E{kind}{axis}", waves))
    first, second = ACROSS[axis]
    for letter in (first, second):
        effects.append(RotaryLocation(f"{letter}0{axis}", offset=20e-3 * rng.standard_normal()))
        turn = "ABC"["XYZ".index(letter)]
        effects.append(RotaryLocation(f"{turn}0{axis}", tilt=40e-6 * rng.standard_normal()))
    return bare(structure).with_effect(*effects)


def truth(machine: Machine, axis: str, angles: np.ndarray) -> dict[str, np.ndarray]:
    """Curves at angles (n,), location errors (1,), about the axis average line: the mean over a turn, seen where nothing turns.

    The moving frame of a tool-side axis has turned by +q, that of a table by -q. Sums over 720 angles, no harmonic analysis.
    """
    waves = {e.where: np.asarray(e.coefficients) for e in machine.effects if isinstance(e, RotaryCyclic)}
    fixed = {e.where: e.offset + e.tilt for e in machine.effects if isinstance(e, RotaryLocation)}
    out = {n: wave(c, angles) for n, c in waves.items()}
    q = np.arange(720) * np.pi / 360
    side = -1.0 if axis in machine.chain.work else 1.0
    for letters in (ACROSS[axis], "".join("ABC"["XYZ".index(a)] for a in ACROSS[axis])):
        turned = -side if axis == "B" else side  # X Z is left-handed about Y
        names = [f"E{a}{axis}" for a in letters]
        x, y = (wave(waves[n], q) for n in names)
        mean = np.array(
            [(np.cos(q) * x - turned * np.sin(q) * y).mean(), (turned * np.sin(q) * x + np.cos(q) * y).mean()]
        )
        back = np.cos(angles), turned * np.sin(angles)
        out[names[0]] = out[names[0]] - (back[0] * mean[0] + back[1] * mean[1])
        out[names[1]] = out[names[1]] - (-back[1] * mean[0] + back[0] * mean[1])
        for letter, moved in zip(letters, mean):
            out[f"{letter}0{axis}"] = np.array([fixed[f"{letter}0{axis}"] + moved])
    return out


def wave(coefficients: np.ndarray, q: np.ndarray) -> np.ndarray:
    """c1 cos q + s1 sin q + c2 cos 2q ..."""
    return sum(c * (np.sin if k % 2 else np.cos)((k // 2 + 1) * q) for k, c in enumerate(coefficients))  # type: ignore[return-value]


def set_ups(machine: Machine, axis: str) -> list[Recording]:
    """R-tests that see everything: of a table with the ball at three places, of a head with three lengths of the tool; and the angle."""
    table = axis in machine.chain.work
    balls = ((210, 0, 50), (-100, 150, 50), (10, -5, 300)) if table else ((0, 0, 0),) * 3
    tips = ((0, 0, -100),) * 3 if table else ((0, 0, -300), (120, 80, -150), (-150, 60, -150))
    out = [r_test(machine, axis, ANGLES, b, U, t) for b, t in zip(balls, tips)]
    out = [replace(one, name=f"R-test {i + 1}") for i, one in enumerate(out)]
    return [*out, index_axis(machine, axis, ANGLES, 0.5e-6)]


def recorded(machine: Machine, meant: Sequence[Recording], rng: np.random.Generator) -> list[Recording]:
    return [simulate_reading(one, machine, rng) for one in meant]


def errors_of(axis: str) -> list[str]:
    across = ACROSS[axis]
    turns = ["ABC"["XYZ".index(a)] for a in across]
    return [f"E{k}{axis}" for k in "XYZABC"] + [f"{k}0{axis}" for k in [*across, *turns]]
