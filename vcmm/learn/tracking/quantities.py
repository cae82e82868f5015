"""Tracked quantities: every linear parameter of the machine's effects, its knowledge in the file, and its possible changes.

    theta(t) = theta of the file + F z + G (b(t) + w(t))

F F' is the covariance that the machine file states, z standard normal and constant. G holds the shapes in which a number may
change, each of the usual size of its parameter (`typical` of the effect): a number by itself, a table by a straight line
(scale: what a warmer scale, a new encoder and a worn screw do first) and the smooth modes of a Gaussian process over its axis beside it (explicit basis
functions: Rasmussen & Williams, Gaussian Processes (2006), 2.7; correlation length: half the travel, 4.2), without
what a convention takes away: the mean of a curve, and the line of a straightness, which is squareness. b is a random walk and holds
jumps, w goes back to its mean (see vcmm.learn.tracking.rates).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import Effect, own_nodes, parameter_fields, typical
from vcmm.core.errors import UsageError
from vcmm.core.inputs import EVERY, Input
from vcmm.core.laws import MultivariateNormal, MultivariateSamples
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.model import number_of
from vcmm.physics.structure.component import CalibrationModes
from vcmm.physics.structure.scatter import Scatter

LENGTH = 0.5  # of the travel: correlation length of a change
HELD = 0.99  # share of the variance of a smooth change that its modes hold
ROUNDING_VARIANCE_SHARE = 1e-8  # of the largest variance of an Input: what is below is rounding


@dataclass(frozen=True, eq=False)
class TrackedQuantity:
    """A parameter of an effect: k numbers that are followed.

    shape (k, g): how they change, canonical units, of the usual size. shape_groups (g): names of what shares a rate, one of each shape.
    """

    effect: Effect
    parameter: str
    shape: Array
    shape_groups: tuple[str, ...]

    @cached_property
    def id(self) -> str:
        return f"{self.effect.id}.{self.parameter}"

    @property
    def value(self) -> Array:
        """Values of the machine file (k,)."""
        return np.ravel(np.asarray(getattr(self.effect, self.parameter), dtype=float))

    @property
    def size(self) -> int:
        return len(self.value)

    @property
    def axis(self) -> str:
        """The axis that it belongs to; "" for one of the tool, the probe or the whole machine."""
        return self.effect.link if len(self.effect.link) == 1 else ""


@dataclass(frozen=True, eq=False)
class TrackedMachine:
    """The machine, its quantities, and factor (K, r) of the covariance that the file states of all their numbers.

    input_ids: Inputs of the file that state these quantities. apart: ids of Inputs that no reading of this kind changes (temperatures,
    Inputs that are sampled anew, laws for all effects of a name).
    """

    machine: Machine
    quantities: tuple[TrackedQuantity, ...]
    factor: Array
    input_ids: tuple[str, ...]
    apart: tuple[str, ...]

    @cached_property
    def rows(self) -> dict[str, slice]:
        """Slice of the numbers of each quantity among all K."""
        ends = np.cumsum([0, *(q.size for q in self.quantities)])
        return {q.id: slice(int(a), int(b)) for q, a, b in zip(self.quantities, ends, ends[1:])}

    @cached_property
    def modes(self) -> dict[str, slice]:
        """Slice of the shapes of each quantity among all g."""
        ends = np.cumsum([0, *(q.shape.shape[1] for q in self.quantities)])
        return {q.id: slice(int(a), int(b)) for q, a, b in zip(self.quantities, ends, ends[1:])}

    @cached_property
    def growth(self) -> Array:
        """Matrix G of the docstring of this module (K, g)."""
        rows, modes = self.rows, self.modes
        out = np.zeros((self.factor.shape[0], sum(q.shape.shape[1] for q in self.quantities)))
        for q in self.quantities:
            out[rows[q.id], modes[q.id]] = q.shape
        return out

    @cached_property
    def stated(self) -> int:
        """Number of coefficients z."""
        return int(self.factor.shape[1])

    @cached_property
    def groups(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(g for q in self.quantities for g in q.shape_groups))

    @cached_property
    def group_of_mode(self) -> Array:
        """Number of the group of each shape (g,)."""
        numbers = {name: i for i, name in enumerate(self.groups)}
        return np.array([numbers[g] for q in self.quantities for g in q.shape_groups], dtype=np.intp)


def tracked_machine(machine: Machine) -> TrackedMachine:
    """Return the tracked quantities of a machine. Raises UsageError where it has no error that can be."""
    for_all = {i.parameter + i.effect for i in machine.inputs if i.where == EVERY and not i.is_channel}
    quantities = []
    for effect in machine.effects:
        if effect.about.is_random or isinstance(effect, CalibrationModes | Scatter):
            continue
        alone = sum(e.id == effect.id for e in machine.effects) == 1
        for name in _numbers_of(effect) if alone else ():
            if name + effect.name not in for_all:
                quantities.append(_quantity(effect, name))
    if not quantities:
        raise UsageError(
            f'the machine "{machine.name}" states no error that could be followed: calibrate or diagnose it first, and give the file '
            "that this writes"
        )
    bare = TrackedMachine(machine, tuple(quantities), np.zeros((sum(q.size for q in quantities), 0)), (), ())
    blocks, used, apart = [bare.factor], [], []
    for item in machine.inputs:
        block = _block(bare, item)
        if block is None:
            apart += [item.id] if item.effect != Scatter.name else []
        else:
            used.append(item.id)
            blocks.append(_shorten(block))
    return TrackedMachine(machine, bare.quantities, np.concatenate(blocks, axis=1), tuple(used), tuple(apart))


def _numbers_of(effect: Effect) -> list[str]:
    """Return the parameters in which the effect is linear, which it uses at its place and which were not chosen by hand."""
    first = effect.where[:1]
    return [
        f.name
        for f in parameter_fields(effect)
        if not f.metadata["scan"]
        and not f.metadata["chosen"]
        and (not f.metadata["only"] or first in f.metadata["only"])
        and np.size(getattr(effect, f.name))
    ]


def _quantity(effect: Effect, name: str) -> TrackedQuantity:
    size, count = typical(effect, name), int(np.size(getattr(effect, name)))
    letters = str(getattr(effect, "component", ""))
    if effect.about.table_parameter == name and letters[:1] == "E":
        kind = "rotations" if letters[1] in "ABC" else "translations"
        shape = size * _smooth(effect, letters)
        words = (f"{kind} over a travel", f"bends of {kind} over a travel")
        return TrackedQuantity(effect, name, shape, tuple(words[min(i, 1)] for i in range(shape.shape[1])))
    return TrackedQuantity(effect, name, size * np.eye(count), (f"{effect.id}.{name}",) * count)


def _smooth(effect: Effect, letters: str) -> Array:
    """Return (k, modes) of unit root mean square over the nodes of a table or spline."""
    grids = getattr(effect, "grids", None) or (np.asarray(own_nodes(effect), dtype=float),)
    arguments = getattr(effect, "arguments", None) or (letters[2],)
    mesh = np.stack([m.ravel() for m in np.meshgrid(*grids, indexing="ij")], axis=1)
    square = np.zeros((len(mesh), len(mesh)))
    for i, letter in enumerate(arguments):
        gap = mesh[:, None, i] - mesh[None, :, i]
        length = LENGTH * max(float(np.ptp(mesh[:, i])), 1e-9)
        square += (
            (2.0 * np.sin(gap / 2.0) / min(length, 1.0)) ** 2 if is_rotary(letter) else (gap / length) ** 2
        )
    at = arguments.index(letters[2]) if letters[2] in arguments else 0
    gone = [np.ones(len(mesh))]
    if not is_rotary(letters[2]):
        gone.append(mesh[:, at])
    basis = np.linalg.qr(np.stack(gone, axis=1))[0]
    line = basis[:, 1:] * np.sqrt(len(mesh)) * np.sign(basis[-1, 1:])  # unit root mean square, rising
    if letters[1] in "XYZ" and letters[1] != letters[2]:
        line = line[:, :0]
    free = np.eye(len(mesh)) - basis @ basis.T
    size, ways = np.linalg.eigh(free @ np.exp(-square / 2.0) @ free)
    size, ways = size[::-1], ways[:, ::-1]
    if not size[0] > 1e-12:  # two nodes of a straightness: a line, which is squareness
        return line
    kept = int(np.searchsorted(np.cumsum(size) / size[size > 0].sum(), HELD)) + 1
    modes = ways[:, :kept] * np.sqrt(size[:kept])
    sign = np.where(modes[np.abs(modes).argmax(axis=0), np.arange(kept)] < 0, -1.0, 1.0)
    bends = modes * sign / np.sqrt((modes**2).sum() / len(mesh))
    return np.concatenate([line, bends], axis=1)


def _block(tracked: TrackedMachine, item: Input) -> Array | None:
    """Return the departure of all numbers per draw of unit variance of an Input, as (K, r); None where it moves none of them alone."""
    if item.is_channel or item.redraw != "machine" or item.effect == Scatter.name:
        return None
    if item.effect == CalibrationModes.name:
        return _of_modes(tracked)
    members = item.members or (item,)
    places = [_place_of(tracked, m) for m in members]
    if any(p is None for p in places) or (item.members and not isinstance(item.law, MultivariateNormal)):
        return None
    rows = np.concatenate([np.arange(p.start, p.stop) for p in places if p is not None])
    law, factor = item.spread(len(rows))
    columns = (
        MultivariateNormal(law.covariance).factor if isinstance(law, MultivariateSamples) else factor * law.u
    )
    if not np.isfinite(columns).all() or len(columns) != len(rows):
        return None
    out = np.zeros((tracked.factor.shape[0], columns.shape[1]))
    out[rows] = columns
    return out


def _place_of(tracked: TrackedMachine, item: Input) -> slice | None:
    where = f"[{item.where}]" if item.where else ""
    effect = next((q.effect for q in tracked.quantities if q.effect.id == f"{item.effect}{where}"), None)
    if effect is None:
        return None
    return tracked.rows.get(f"{effect.id}.{effect.about.aliases.get(item.parameter, item.parameter)}")


def _of_modes(tracked: TrackedMachine) -> Array | None:
    """Return the joint covariance of an error table: every error by its loadings."""
    out = None
    for effect in tracked.machine.effects:
        if not isinstance(effect, CalibrationModes):
            continue
        target = next(
            (
                q
                for q in tracked.quantities
                if q.effect.about.is_calibrated and q.effect.where == effect.component
            ),
            None,
        )
        if target is None or target.parameter != number_of(target.effect):
            return None
        loadings = np.asarray(effect.loadings, dtype=float)
        out = np.zeros((tracked.factor.shape[0], loadings.shape[1])) if out is None else out
        out[tracked.rows[target.id]] += loadings
    return out


def _shorten(block: Array) -> Array:
    """Return the same covariance by the columns that hold more than rounding."""
    scale = np.maximum(np.sqrt((block**2).sum(axis=1)), 1e-300)
    ways, size, _ = np.linalg.svd(block / scale[:, None], full_matrices=False)
    kept = size**2 > ROUNDING_VARIANCE_SHARE * size[0] ** 2
    return np.asarray(scale[:, None] * (ways[:, kept] * size[kept]))


def group_numbers(tracked: TrackedMachine, names: Sequence[str]) -> Array:
    """Return whether each shape belongs to a quantity with a given id (g,) bool."""
    out = np.zeros(tracked.growth.shape[1], dtype=bool)
    for name in names:
        out[tracked.modes[name]] = True
    return out
