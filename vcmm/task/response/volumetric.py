"""The volumetric error field of a machine: tip errors on a grid or at given positions, maxima, body diagonals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.effect import required
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.readable import Readable, Reading
from vcmm.core.run import T0_DEG_C, Array, Run
from vcmm.core.views import draw
from vcmm.task.response.known_volume import known_box, known_rows, tip_uncertainty, without_unknown

if TYPE_CHECKING:
    from matplotlib.axes import Axes


MOST_NODES = 10_000_000  # of a grid: 2 GB with their columns


@dataclass(frozen=True)
class Diagonal:
    """A body diagonal of the travels: ends (axis positions, mm) and how much too long the machine travels it, mm."""

    start: tuple[float, ...]
    end: tuple[float, ...]
    length_error: float


@dataclass(frozen=True, eq=False)
class ErrorField(Readable):
    """tip_error (n, 3) mm at the rows of `run`; the four body diagonals (empty without three linear axes, and where an effect is not known at their ends).

    u (n, 3) mm: standard uncertainty of the tip error at one positioning, None where the machine states no Inputs that move the tip;
    left_out: its Inputs that are not in it. within: ranges of the axes, mm, of the grid where travels are not known to their ends; else empty.
    """

    run: Run
    tip_error: Array
    exact: bool
    diagonals: tuple[Diagonal, ...]
    u: Array | None = None
    left_out: tuple[str, ...] = ()
    within: tuple[tuple[str, float, float], ...] = ()
    reading: Reading | None = None

    def __repr__(self) -> str:
        engine = "exact" if self.exact else "first order"
        return f"<ErrorField: {self.run.n} positions, at most {1e3 * float(self.size.max(initial=0.0)):.4g} µm, {engine}>"

    @property
    def size(self) -> Array:
        return np.linalg.norm(self.tip_error, axis=1)

    def plot(self, ax: Any = None) -> Axes:
        """Plot tip errors (actual - nominal) as arrows in the volume."""
        drawn: Axes = draw(self, ax)
        return drawn


def field(machine: Machine, run: Run | None = None, exact: bool = False, nodes: int = 5) -> ErrorField:
    """Return tip errors at the rows of a run, or on a grid of nodes^3 over the travels (rotary axes at zero), as far as every effect is known."""
    exact = exact or machine.large_errors
    within: tuple[tuple[str, float, float], ...] = ()
    if run is None:
        run = grid(machine, nodes)
        if not known_rows(machine, run).all():
            box = known_box(machine, linear_axes(machine))
            run = without_unknown(machine, grid(machine, nodes, box))
            within = tuple((a, *ends) for a, ends in box.items())
    run = with_defaults(machine, run)
    error = machine.tip_error(run, exact)
    u, left = tip_uncertainty(machine, run) if machine.inputs else (None, ())
    if u is not None and len(left) == len(machine.inputs):
        u = None
    return ErrorField(
        run=run,
        tip_error=error,
        exact=exact,
        diagonals=diagonals(machine, exact),
        u=u,
        left_out=left,
        within=within,
    )


def linear_axes(machine: Machine) -> list[str]:
    return [a for a in "XYZ" if a in machine.axes]


def grid(machine: Machine, nodes: int, box: Mapping[str, tuple[float, float]] | None = None) -> Run:
    """Return a grid over the travels of the linear axes, or over ranges of them, for the tip without a stylus."""
    if nodes < 2:
        raise UsageError(f"a grid of {nodes} nodes per axis has no extent; use at least 2")
    letters = linear_axes(machine)
    if not letters:
        raise UsageError(
            f"the machine has rotary axes alone ({', '.join(machine.axes)}): no grid of X, Y, Z spans its volume; name positions with --at FILE"
        )
    if nodes ** len(letters) > MOST_NODES:
        raise UsageError(
            f"{nodes} nodes per axis are {nodes ** len(letters):,} points, and at most {MOST_NODES:,} are mapped; "
            f"use {int(MOST_NODES ** (1 / len(letters)))} or fewer"
        )
    mesh = np.meshgrid(
        *(np.linspace(*(box or {}).get(a, machine.axes[a].travel), nodes) for a in letters), indexing="ij"
    )
    n = mesh[0].size
    position = {a: m.ravel() for a, m in zip(letters, mesh)}
    position |= {a: np.zeros(n) for a in machine.axes if a not in letters}
    return Run(position, np.zeros((n, 3)))


def with_defaults(machine: Machine, run: Run) -> Run:
    """Fill columns that effects need and a bare grid lacks: no motion sense, 20 degC, unit normal up."""
    missing = {c for e in machine.effects if e.link != "reading" for c in required(e) if c not in run.columns}
    filled = {
        c: np.full(run.n, T0_DEG_C if c.startswith("temp_") and c != "temp_gradient_C" else 0.0)
        for c in missing
    }
    return run.with_columns(filled)


def missing_columns(machine: Machine, run: Run) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Return (effect id, columns) of effects that a map at these positions cannot show, since they need more than a position.

    A backlash needs the sense of the last motion, a drift the time; such columns are zero on a bare grid, and 20 degC.
    """
    out: list[tuple[str, tuple[str, ...]]] = []
    for e in machine.effects:
        if e.about.is_random:
            continue
        if e.link == "reading":
            out.append((e.id, ("a touch",)))
            continue
        lacking = tuple(c for c in required(e) if c not in run.columns)
        if lacking:
            out.append((e.id, lacking))
    return tuple(out)


def diagonals(machine: Machine, exact: bool = False) -> tuple[Diagonal, ...]:
    """Return the length errors of the four body diagonals (ISO 230-6): (e(end) - e(start)) . direction, tip-error sense."""
    letters = linear_axes(machine)
    if len(letters) < 3:
        return ()
    ends = [machine.axes[a].travel for a in letters]
    out = []
    for flips in product((0, 1), repeat=2):
        start = [ends[0][0]] + [ends[i + 1][f] for i, f in enumerate(flips)]
        stop = [ends[0][1]] + [ends[i + 1][1 - f] for i, f in enumerate(flips)]
        both = np.array([start, stop])
        position = {a: both[:, i] for i, a in enumerate(letters)}
        position |= {a: np.zeros(2) for a in machine.axes if a not in letters}
        run = with_defaults(machine, Run(position, np.zeros((2, 3))))
        if not known_rows(machine, run).all():
            return ()
        error = machine.tip_error(run, exact)
        direction = both[1] - both[0]
        length_error = (error[1] - error[0]) @ direction / np.linalg.norm(direction)
        out.append(Diagonal(tuple(start), tuple(stop), float(length_error)))
    return tuple(out)
