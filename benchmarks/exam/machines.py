"""Machines of the exam: smooth random error tables, their stated uncertainty, and the files that say so."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.exam.kinema import Array, Chain

SIX = ("EX", "EY", "EZ", "EA", "EB", "EC")
Smooth = Callable[[Array], Array]


def smooth(rng: np.random.Generator, u: float, length: float) -> Smooth:
    """One draw of a Gaussian process u^2 exp(-d^2 / (2 l^2)): 300 random waves (Rahimi and Recht 2007)."""
    k, phase = rng.normal(0.0, 1.0 / length, 300), rng.uniform(0, 2 * np.pi, 300)
    size = u * np.sqrt(2 / 300)
    return lambda q: size * np.cos(np.asarray(q)[:, None] * k + phase).sum(axis=1)


@dataclass(frozen=True, eq=False)
class Kind:
    """A type of machine. travel in mm (rad for rotary); u: translation mm, rotation rad, squareness rad."""

    name: str
    kind: str
    structure: str
    travel: Mapping[str, tuple[float, float]]
    size: tuple[float, float, float] = (2.0e-3, 8e-6, 6e-6)
    u: tuple[float, float, float] = (0.4e-3, 0.8e-6, 1e-6)
    length: float = 150.0
    scale: float = 0.7e-3
    dof: float = 6.0
    centre: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    measured_at: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    dynamics: str = ""

    @property
    def chain(self) -> Chain:
        return Chain(self.structure, self.centre, self.measured_at)

    @property
    def linear(self) -> list[str]:
        return [a for a in "XYZ" if a in self.travel]


BRIDGE = Kind(
    "bridge CMM", "cmm", "w b Y X Z t", {"X": (0.0, 800.0), "Y": (0.0, 700.0), "Z": (-500.0, 0.0)},
    measured_at={"X": (0.0, 0.0, -150.0), "Y": (30.0, 0.0, -260.0), "Z": (40.0, 25.0, 0.0)},
)  # fmt: skip
MILL = Kind(
    "three-axis mill", "machine-tool", "w X' Y' b Z t",
    {"X": (-300.0, 300.0), "Y": (-250.0, 250.0), "Z": (-350.0, 0.0)},
    (4e-3, 15e-6, 15e-6), (0.8e-3, 1.5e-6, 2e-6), 150.0, 0.9e-3,
    dynamics='{ speed = "500 mm/s", acceleration = "3 m/s^2", jerk = "50 m/s^3", gain = "40 1/s" }',
)  # fmt: skip
TURNTABLE = Kind(
    "mill with turntable", "machine-tool", "w C' X' Y' b Z t",
    {"X": (-300.0, 300.0), "Y": (-300.0, 300.0), "Z": (-350.0, 0.0), "C": (-2 * np.pi, 2 * np.pi)},
    (4e-3, 15e-6, 15e-6), (0.8e-3, 1.5e-6, 2e-6), 150.0, 0.9e-3, centre={"C": (12.0, -8.0, 0.0)},
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Machine:
    """A machine: nodes and table (nodes, 6) per linear axis, squareness. `real` is what the calibration missed."""

    kind: Kind
    nodes: Mapping[str, Array]
    table: Mapping[str, Array]
    square: Mapping[str, float]
    missed: Mapping[str, list[Smooth]]
    missed_square: Mapping[str, float]

    def stored(self, letter: str, q: Array) -> Array:
        """(n, 6) by linear interpolation of the stored table."""
        table = self.table[letter]
        return np.stack([np.interp(q, self.nodes[letter], table[:, i]) for i in range(6)], axis=1)

    def real(self, letter: str, q: Array, stale: float = 1.0) -> Array:
        """Stored table plus what the calibration missed, `stale` times its stated uncertainty."""
        missed = np.stack([f(q) for f in self.missed[letter]], axis=1)
        return self.stored(letter, q) + stale * missed


def draw(kind: Kind, rng: np.random.Generator, step: float = 50.0) -> Machine:
    nodes, table, missed = {}, {}, {}
    for letter in kind.linear:
        low, high = kind.travel[letter]
        nodes[letter] = np.linspace(low, high, round((high - low) / step) + 1)
        sizes = [kind.size[0]] * 3 + [kind.size[1]] * 3
        table[letter] = np.stack([smooth(rng, s, 180.0)(nodes[letter]) for s in sizes], axis=1)
        missed[letter] = [smooth(rng, u, kind.length) for u in [kind.u[0]] * 3 + [kind.u[1]] * 3]
    pairs = ("A0Z", "B0Z", "C0Y")
    square = {p: float(rng.normal(0, kind.size[2])) for p in pairs}
    missed_square = {p: float(rng.normal(0, kind.u[2])) for p in pairs}
    return Machine(kind, nodes, table, square, missed, missed_square)


def write(machine: Machine, folder: Path) -> Path:
    """machine.toml and errors.csv."""
    kind = machine.kind
    lines = [
        'vcmm = "machine/1"',
        f'name = "{kind.name}"',
        f'kind = "{kind.kind}"',
        f'structure = "{kind.structure}"',
    ]
    for letter, (low, high) in kind.travel.items():
        unit = "rad" if letter in "ABC" else "mm"
        lines += [f"[axes.{letter}]", f'travel = ["{low:.9g} {unit}", "{high:.9g} {unit}"]']
        for word, points in (("centre", kind.centre), ("measured_at", kind.measured_at)):
            if letter in points:
                lines.append(f"{word} = [" + ", ".join(f'"{v} mm"' for v in points[letter]) + "]")
        if kind.dynamics and letter in "XYZ":
            lines.append(f"dynamics = {kind.dynamics}")
    u = (
        f'{{ translation = "{kind.u[0] * 1e3:g} um", rotation = "{kind.u[1] * 1e6:g} urad", '
        f'squareness = "{kind.u[2] * 1e6:g} urad", correlation_length = "{kind.length:g} mm" }}'
    )
    lines += ["[errors]", 'table = "errors.csv"', 'state = "residual"', f"uncertainty = {u}"]
    lines += ["[repeatability]", 'law = "t"', f'scale = "{kind.scale * 1e3:g} um"', f"dof = {kind.dof:g}"]
    (folder / "machine.toml").write_text("\n".join(lines) + "\n")
    (folder / "errors.csv").write_text(_table(machine))
    return folder / "machine.toml"


def _table(machine: Machine) -> str:
    blocks = []
    for letter, nodes in machine.nodes.items():
        rows = [" ".join([letter] + [w + letter for w in SIX])]
        for q, six in zip(nodes, machine.table[letter]):
            rows.append(" ".join([f"{q:.9g}"] + [f"{v:.9e}" for v in six]))
        blocks.append("\n".join(rows))
    words = list(machine.square)
    blocks.append(" ".join(words) + "\n" + " ".join(f"{machine.square[w]:.9e}" for w in words))
    return "// component errors in mm and rad\n" + "\n#\n".join(blocks) + "\n"
