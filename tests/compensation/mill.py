"""Machines with simple errors and a short way to compensate a text."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vcmm.compensation.job import compensate
from vcmm.compensation.result import CompensatedProgram
from vcmm.core.effect import Effect
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness
from vcmm.program.setup import Setup, Tool

SETUP = Setup(
    dialect="fanuc",
    offsets={"G54": (0.0, 0.0, 0.0), "G55": (100.0, 0.0, 0.0)},
    tools={1: Tool(1, 0.0, 10.0), 2: Tool(2, 30.0, 6.0)},
    compensation=(),
)


def mill(*effects: Effect, travel: float = 1e4) -> Machine:
    axes = {a: Axis(a, (-travel, travel)) for a in "XYZ"}
    return Machine("test mill", "machine-tool", parse_structure("w X' Y' b Z t"), axes, effects)


def lathe(structure: str = "w b Z X t") -> Machine:
    """X 100 um/m too long."""
    axes = {a: Axis(a, (-1e4, 1e4)) for a in "XZC" if a in structure}
    return Machine("test lathe", "lathe", parse_structure(structure), axes, (ScaleFactor("X", 100e-6),))


def scale(k_um_m: float, axis: str = "X") -> Machine:
    return mill(ScaleFactor(axis, k_um_m * 1e-6))


def wavy(
    component: str, amplitude: float, length: float, phase: float = 0.0, reach: float = 500.0
) -> ComponentTable:
    """A tabulated component error, um or urad, over its own axis: a sine of the given length, mm."""
    grid = np.linspace(-reach, reach, 2 * round(reach / 10.0) + 1)
    values = amplitude * np.sin(2 * np.pi * grid / length + phase)
    unit = 1e-3 if component.startswith(("EX", "EY", "EZ")) else 1e-6
    return ComponentTable(
        component=component, arguments=(component[-1],), grids=(grid,), values=values * unit
    )


def rough(reach: float = 500.0) -> Machine:
    """Every kind of smooth geometric error at once, about 10 um; tables from -reach to reach, mm."""
    return mill(
        ScaleFactor("X", 60e-6), ScaleFactor("Z", -40e-6), Squareness("C0Y", 30e-6), Squareness("B0Z", 20e-6),
        wavy("EYX", 4.0, 300.0, reach=reach), wavy("EXY", 3.0, 250.0, 1.0, reach), wavy("EZX", 3.0, 400.0, 0.5, reach),
        wavy("ECX", 15.0, 500.0, reach=reach),
    )  # fmt: skip


def run(
    folder: Path, text: str, machine: Machine, setup: Setup = SETUP, **more: object
) -> CompensatedProgram:
    path = folder / "part.nc"
    path.write_bytes(text.encode("utf-8"))
    return compensate(path, setup, machine, **more)  # type: ignore[arg-type]


def body(found: CompensatedProgram) -> list[str]:
    """The new program without the mark, line by line, with line ends."""
    lines = found.text.splitlines(keepends=True)
    return [line for line, source in zip(lines, found.source_lines) if source]
