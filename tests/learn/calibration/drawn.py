"""Drawn machines and complete designs. The machine is made of dense linear tables: no spline, no code of the calibration."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.learn.calibration.job import calibrate
from vcmm.learn.calibration.result import Calibration
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.instruments.artefact import grid_of_balls, plate
from vcmm.task.instruments.laser import six_d
from vcmm.task.instruments.laying import simulate_reading
from vcmm.task.instruments.tracker import lengths_to
from vcmm.task.response.recording import Recording

TRAVEL = {"X": (0.0, 600.0), "Y": (0.0, 500.0), "Z": (-400.0, 0.0)}
STRUCTURE = "w b Y X Z t"
U = {"linear": 0.2e-3, "straightness": 0.3e-3, "angle": 0.3e-6}


def bare(structure: str = STRUCTURE) -> Machine:
    axes = {a: Axis(a, (low - 50.0, high + 50.0)) for a, (low, high) in TRAVEL.items()}
    return Machine("drawn", "cmm", parse_structure(structure), axes)


def draw(rng: np.random.Generator, structure: str = STRUCTURE, length: float = 0.0) -> Machine:
    """21 errors: Gaussian processes of 1-5 um and 2-10 urad, correlation length 100-250 mm, 61 nodes; squareness 10 urad."""
    effects: list[ComponentTable | Squareness] = []
    for axis, (low, high) in TRAVEL.items():
        q = np.linspace(low - 50, high + 50, 61)
        for kind in "XYZABC":
            size = rng.uniform(2e-6, 10e-6) if kind in "ABC" else rng.uniform(1e-3, 5e-3)
            smooth = length or rng.uniform(100.0, 250.0)
            kernel = np.exp(-((q[:, None] - q) ** 2) / (2 * smooth**2)) + 1e-9 * np.eye(len(q))
            values = size * np.linalg.cholesky(kernel) @ rng.standard_normal(len(q))
            effects.append(ComponentTable(f"E{kind}{axis}", (axis,), (q,), values))
    effects += [Squareness(p, 10e-6 * rng.standard_normal()) for p in ("C0Y", "B0Z", "A0Z")]
    return bare(structure).with_effect(*effects)


def truth(machine: Machine, component: str, nodes: np.ndarray) -> np.ndarray:
    """The drawn curve at the nodes, without its mean over the travel (straightness: without its least-squares line)."""
    straight = component[1] in "XYZ" and component[1] != component[2]
    away = np.polyval(np.polyfit(*everywhere(machine, component, nodes), 1 if straight else 0), nodes)
    effect = next(e for e in machine.effects if e.where == component)
    return np.interp(nodes, effect.grids[0], effect.values) - away


def everywhere(machine: Machine, component: str, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The drawn curve at 2000 places between the first and the last node."""
    effect = next(e for e in machine.effects if e.where == component)
    q = nodes[0] + (np.arange(2000) + 0.5) / 2000 * (nodes[-1] - nodes[0])
    return q, np.interp(q, effect.grids[0], effect.values)


def slope(machine: Machine, component: str, nodes: np.ndarray) -> float:
    return float(np.polyfit(*everywhere(machine, component, nodes), 1)[0])


def mean(machine: Machine, component: str, nodes: np.ndarray) -> float:
    return float(everywhere(machine, component, nodes)[1].mean())


def laser_and_plates(machine: Machine) -> list[Recording]:
    """Six errors of every axis along one line, and a ball plate in three planes: complete."""
    middle = {a: (low + high) / 2 for a, (low, high) in TRAVEL.items()}
    out: list[Recording] = []
    for axis, (low, high) in TRAVEL.items():
        out += six_d(machine, axis, np.linspace(low, high, 13), middle, np.array([0.0, 0.0, -100.0]), U)
    tip = np.array([0.0, 0.0, -100.0])
    planes = (
        ((100, 50, -200), (400, 0, 0), (0, 400, 0)),
        ((100, 250, -450), (400, 0, 0), (0, 0, 300)),
        ((300, 50, -450), (0, 400, 0), (0, 0, 300)),
    )
    for i, (corner, along, across) in enumerate(planes):
        out.append(plate(machine, grid_of_balls(corner, along, across, (5, 4)), f"{i + 1}", tip, 0.4e-3))
    return out


def tracers(machine: Machine, u: float = 0.3e-3, step: int = 7) -> list[Recording]:
    """Lengths from six stations to a grid of the volume, with different tips: complete, stations and dead paths unknown."""
    grid = [np.linspace(*TRAVEL[a], step) for a in "XYZ"]
    points = np.stack([m.ravel() for m in np.meshgrid(*grid, indexing="ij")], axis=1)
    stations = (
        (-200, -150, -500),
        (800, -150, -450),
        (300, 700, -550),
        (-150, 650, 100),
        (750, 600, 150),
        (300, -300, -100),
    )
    tips = ((0, 0, -100), (0, 0, -250), (120, 0, -100), (0, 120, -100), (-120, 0, -150), (0, -120, -200))
    free = {"station": "setup", "zero": "setup"}
    return [
        lengths_to(machine, f"station {i + 1}", points + np.array(t), s, t, free, u, f"{i + 1}")
        for i, (s, t) in enumerate(zip(stations, tips))
    ]


@lru_cache
def found_by(design: str, seed: int) -> tuple[Machine, list[Recording], Calibration]:
    """A drawn machine, its recordings by a complete design ("laser", "tracer") and what they say; made once per process."""
    rng = np.random.default_rng(seed)
    machine = draw(rng)
    meant = laser_and_plates(bare()) if design == "laser" else tracers(bare(), step=5)
    read = recorded(machine, meant, rng)
    return machine, read, calibrate(read, bare())


def recorded(machine: Machine, design: Sequence[Recording], rng: np.random.Generator) -> list[Recording]:
    return [simulate_reading(r, machine, rng) for r in design]
