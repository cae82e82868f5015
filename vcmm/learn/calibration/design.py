"""Design: the errors that a plan of set-ups would identify, with their uncertainty, and the best set-ups under a time budget.

Every set-up gives information A = G' W G (nuisance projected out) whatever will be read, so designs are compared before
anything is measured:

    volume_um   root mean variance of the tip error over the volume after the measurement (conventions of `model`), when
                before it every error had its usual size; tip on the axes of the machine and 100 mm to each side

The search adds, drops and swaps set-ups while that pays, from several starts; it is no proof of the best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.learn.calibration.evidence import NormalEquations
from vcmm.learn.calibration.identifiability import Identifiability, identify
from vcmm.learn.calibration.job import ranges_of, spans_of
from vcmm.learn.calibration.model import ErrorModel, error_model
from vcmm.learn.calibration.prior import prior, scale_factor, usual
from vcmm.learn.calibration.readings import error_columns, readings
from vcmm.learn.calibration.solve import Before, columns_of, project
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.laying import layout
from vcmm.task.response.observe import Observer
from vcmm.task.response.recording import Recording

NODES = 5
TIPS = ((0.0, 0.0, -100.0), (100.0, 0.0, -100.0), (0.0, 100.0, -100.0))
GRID = 4
STARTS = 3
GAIN = 1e-9


@dataclass(frozen=True, eq=False)
class PlannedSetup:
    """One set-up: its recordings, not read yet, its instrument, and its duration."""

    name: str
    recordings: tuple[Recording, ...]
    minutes: float
    certificate: InstrumentCertificate | None = None


@dataclass(frozen=True, eq=False)
class SetupPlan:
    """information: per set-up (size, size); field: (3 n, size) tip errors per unit of theta; minutes (k,)."""

    model: ErrorModel
    names: tuple[str, ...]
    information: tuple[Array, ...]
    minutes: Array
    field: Array
    factor: Array

    def normal_equations(self, chosen: Sequence[int]) -> NormalEquations:
        a = np.zeros((self.model.size, self.model.size))
        for i in chosen:
            a = a + self.information[i]
        return NormalEquations(a, np.zeros(self.model.size), self.model)

    @cached_property
    def information_factors(self) -> tuple[Array, ...]:
        """Information of every set-up on the numbers behind the prior, of unit variance."""
        return tuple(self.factor.T @ a @ self.factor for a in self.information)

    @cached_property
    def weight(self) -> Array:
        """Mean square of the tip error over the volume per unit variance of the numbers behind the prior: a quadratic form."""
        visible = self.field @ self.factor
        return np.asarray(visible.T @ visible / (len(visible) / 3))

    def volume(self, chosen: Sequence[int]) -> float:
        """Return the root mean variance of the tip error over the volume, mm."""
        inner = np.eye(len(self.weight))
        for i in chosen:
            inner += self.information_factors[i]
        return float(np.sqrt(np.trace(np.linalg.solve(inner, self.weight))))

    def time(self, chosen: Sequence[int]) -> float:
        return float(self.minutes[list(chosen)].sum())


@dataclass(frozen=True, eq=False)
class Proposal:
    """A choice of set-ups: their names, minutes together, u of the tip over the volume (um), and which errors they identify."""

    names: tuple[str, ...]
    minutes: float
    volume_um: float
    identifiability: Identifiability


def plan_of(setups: Sequence[PlannedSetup], machine: Machine) -> SetupPlan:
    """Return the information of every set-up, by the travels of the machine; of rotary axes that turn in one too. Raises UsageError for a
    plan without set-ups."""
    if not setups:
        raise UsageError("the plan has no set-ups; add [[setups]] with name, instrument and minutes")
    ranges = {a: x.travel for a, x in machine.axes.items() if a in "XYZ"}
    moved = ranges_of(spans_of([r for s in setups for r in s.recordings]), machine)
    ranges |= {a: r for a, r in moved.items() if is_rotary(a)}
    model = error_model(ranges, NODES)
    information = []
    for setup in setups:
        parts = [readings(r, machine, model, setup.certificate) for r in setup.recordings]
        columns, names = columns_of(parts, Before.nothing(model))
        gram = np.sum([project(p, c, 1 / p.u**2).gram for p, c in zip(parts, columns)], axis=0)
        information.append(_marginal_information(gram, len(names)))
    lengths = {c.component: 0.35 * c.travel for c in model.curves}
    factor = scale_factor(prior(model, lengths), usual(model))
    minutes = np.array([s.minutes for s in setups])
    return SetupPlan(
        model,
        tuple(s.name for s in setups),
        tuple(information),
        minutes,
        volume_field(model, machine),
        factor,
    )


def _marginal_information(gram: Array, size: int) -> Array:
    """Return the information on theta when the own errors of the instrument (unit variance, the last ones) are marginalised."""
    if not size:
        return gram
    k = len(gram) - size
    inner = gram[k:, k:] + np.eye(size)
    return np.asarray(gram[:k, :k] - gram[:k, k:] @ np.linalg.solve(inner, gram[k:, :k]))


def volume_field(model: ErrorModel, machine: Machine) -> Array:
    """Return the tip error x y z on a grid of the volume with three tips, per unit of theta, (3 n, size)."""
    letters = [a for a in "XYZ" if a in machine.axes]
    steps = [np.linspace(*machine.axes[a].travel, GRID) for a in letters]
    turning = {c.axis: c for c in model.curves if c.rotary}
    letters += list(turning)
    steps += [np.linspace(c.nodes[0], c.nodes[-1], GRID)[: GRID - int(c.periodic)] for c in turning.values()]
    mesh = np.stack([m.ravel() for m in np.meshgrid(*steps, indexing="ij")], axis=1)
    offset = np.repeat(np.array(TIPS), len(mesh), axis=0)
    mesh = np.tile(mesh, (len(TIPS), 1))
    out = []
    for direction in np.eye(3):
        position = {a: mesh[:, i] for i, a in enumerate(letters)}
        position |= {a: np.zeros(len(mesh)) for a in machine.axes if a not in letters}
        volume = layout("field", "displacement", Run(position, offset), direction, {}, 1.0)
        out.append(error_columns(Observer(volume, machine), model))
    return np.concatenate(out)


def proposal(plan: SetupPlan, chosen: Sequence[int]) -> Proposal:
    identifiability = identify(plan.normal_equations(chosen))
    names = tuple(plan.names[i] for i in sorted(chosen))
    return Proposal(names, plan.time(chosen), plan.volume(chosen) * 1e3, identifiability)


def best_within(plan: SetupPlan, budget: float, seed: int = 0) -> list[int]:
    """Return the numbers of the set-ups that leave the smallest volume_um within the budget (minutes), by exchange from several starts."""
    rng = np.random.default_rng(seed)
    starts = [_greedy(plan, budget, [])]
    for _ in range(STARTS):
        first = [int(i) for i in rng.permutation(len(plan.names))[:2]]
        starts.append(_greedy(plan, budget, first if plan.time(first) <= budget else []))
    plans = [_exchange_setups(plan, budget, s) for s in starts]
    return min(plans, key=plan.volume)


def _greedy(plan: SetupPlan, budget: float, chosen: list[int]) -> list[int]:
    """Add the set-up that gains most per minute while there is time."""
    now = plan.volume(chosen)
    while True:
        left = budget - plan.time(chosen)
        free = [i for i in range(len(plan.names)) if i not in chosen and plan.minutes[i] <= left]
        gains = [(np.log(now / plan.volume([*chosen, i])) / max(plan.minutes[i], 1e-9), i) for i in free]
        if not gains or max(gains)[0] <= GAIN:
            return chosen
        chosen = [*chosen, max(gains)[1]]
        now = plan.volume(chosen)


def _exchange_setups(plan: SetupPlan, budget: float, chosen: list[int]) -> list[int]:
    """Swap one set-up for another, and fill the time that this leaves, while the volume gains."""
    now = plan.volume(chosen)
    while True:
        swaps = []
        for out in chosen:
            rest = [i for i in chosen if i != out]
            left = budget - plan.time(rest)
            free = (i for i in range(len(plan.names)) if i not in chosen and plan.minutes[i] <= left)
            swaps += [(plan.volume([*rest, new]), [*rest, new]) for new in free]
        if not swaps:
            return chosen
        tried = _greedy(plan, budget, min(swaps, key=lambda s: s[0])[1])
        value = plan.volume(tried)
        if value >= now * (1 - 1e-6):
            return chosen
        chosen, now = tried, value


def cheapest_complete(plan: SetupPlan) -> list[int] | None:
    """Return the set-ups that identify what all together do, in little time: drop the dearest ones that are not needed. None without any."""
    everything = list(range(len(plan.names)))
    due = set(identify(plan.normal_equations(everything)).names)
    if not due:
        return None
    chosen = everything
    for i in sorted(everything, key=lambda i: -plan.minutes[i]):
        fewer = [j for j in chosen if j != i]
        if due <= set(identify(plan.normal_equations(fewer)).names):
            chosen = fewer
    return chosen
