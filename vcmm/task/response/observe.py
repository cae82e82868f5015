"""Convert motions of the tip into the observations of a recording. All its signs are defined here.

    probe, displacement, path     value = s n . t + r n . g      t translation of the tip, g reading, n direction
    length                        the same at the first end less the same at the second
    angle                         value = s n . w                w rotation of the tip

    s = -1 for indicated - true, +1 for actual - commanded
    r = +1, but -1 for actual - commanded of a displacement or length: there the instrument is the reference, and a
        reading that lets it indicate less makes the machine appear to go too far

Readings (indicated - true) are those of vcmm.core.effect, mm. On a part that was cut and is measured later those that turn
(`on_cut_part`: clamping, expansion) leave the surface on the other side, as in `vcmm cut`: r = -1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vcmm.core.effect import Effect, basis
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.knowledge import targets
from vcmm.core.laws import MultivariateNormal, MultivariateSamples, row_factor
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.physics.structure.scatter import Scatter
from vcmm.task.response.carrier import Carrier, Sight, missing_columns, responses
from vcmm.task.response.logs import with_logs
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.recording import Recording

__all__ = [
    "Observer", "baseline", "calibration_columns", "known_here", "left_out", "missing_columns", "noise_u", "nuisance_columns", "observe",
]  # fmt: skip
INSTRUMENT_KINDS = ("displacement", "length")  # an instrument is the reference


def observe(recording: Recording, motion: Array, reading: Array) -> Array:
    """Change (m, k) of the observations, mm or rad, by tip motions (n, 6, k) and readings (n, 3, k) of all run rows.

    motion: actual - nominal, workpiece axes, mm and rad (tip sense); reading: indicated - true, mm. Signs: see the
    head of this file.
    """
    return _less_second([sight.of(motion, reading) for sight in sights(recording)])


def sights(recording: Recording) -> tuple[Sight, ...]:
    """Return the sights of the first end of every observation, and of the second where some have one: with s, r and n of the docstring of
    this module."""
    angle = recording.kind == "angle"
    # readings are lengths, so an angle has none
    r = 0.0 if angle else -recording.sign if recording.kind in INSTRUMENT_KINDS else 1.0
    turned = -1.0 if recording.of_cut_part else 1.0
    first = Sight(recording.direction, recording.row, recording.sign, r, angle, turned)
    has = recording.other >= 0
    if not has.any():
        return (first,)
    return first, replace(first, direction=recording.direction * has[:, None], rows=recording.other)


class Observer:
    """A recording seen through a machine's kinematics, which converts any effect to its observations.

    run: the recording's run, prepared by the machine.   ends: a carrier for the first end of the observations, and for the
    second where there is one.   Raises ModelLimit for rows outside the travels.
    """

    def __init__(self, recording: Recording, machine: Machine) -> None:
        recording = replace(recording, run=with_logs(recording.run))
        self.recording, self.machine = recording, machine
        self.run = _count_from_first(recording, machine.prepare(recording.run))
        self.ends = tuple(Carrier(machine, self.run, sight) for sight in sights(recording))

    def of_parameter(self, effect: Effect, name: str) -> Array:
        """Return the derivative (m, k) of the observations with respect to each element of a parameter of an effect."""
        self.machine.check_columns(effect, self.run)
        return self.through(effect, basis(effect, name, self.run))

    def through(self, effect: Effect, six: Array) -> Array:
        """Change (m,) or (m, k) of the observations by error motions (n, 6) or (n, 6, k) of the effect's link."""
        return _less_second([end.through(effect, six) for end in self.ends])

    @cached_property
    def usable(self) -> Machine:
        """The machine with those of its effects whose columns the recording has."""
        kept = tuple(e for e in self.machine.effects if not missing_columns(e, self.run))
        return replace(self.machine, effects=kept)

    def baseline(self) -> Array:
        """Return the observations (m,) predicted from the machine's own effects, by the engine that their size requires."""
        return self.predict[0]

    @cached_property
    def predict(self) -> tuple[Array, bool]:
        """The result of `baseline`, and whether the transforms were multiplied: rotations above 1 mrad, translations above 1 mm."""
        return self._prediction(self.usable)

    def of_effects(self, effects: tuple[Effect, ...]) -> Array:
        """Return the observations (m,) that the machine would have with other effects in place of its own."""
        return self._prediction(replace(self.machine, effects=effects, inputs=()))[0]

    def _prediction(self, machine: Machine) -> tuple[Array, bool]:
        motion, exact = machine.chosen_motion(self.run)
        reading = self.readings(machine)
        return observe(self.recording, motion[:, :, None], reading[:, :, None])[:, 0], exact

    def readings(self, machine: Machine) -> Array:
        """Return the readings of the rows (n, 3) mm; those that a cut part shows the other way have their sign turned."""
        whole = machine.reading(self.run)
        if not self.recording.of_cut_part:
            return whole
        turned = tuple(e for e in machine.effects if e.link == "reading" and e.about.on_cut_part == "turned")
        return whole - 2.0 * replace(machine, effects=turned).reading(self.run)

    def calibration(self) -> list[tuple[str, Array]]:
        """See `calibration_columns`."""
        out = list(self.recording.known)
        for quantity in self.machine.inputs:
            stated = quantity.effect == Scatter.name or quantity.id in dict(out)
            effects = () if stated else self._acted_on(quantity)
            if effects:
                columns = self._code(quantity, responses(self.ends, quantity, effects))
                used = np.abs(columns).max(axis=0, initial=0.0) > 0
                if used.any():
                    out.append((quantity.id, columns[:, used]))
        return out

    def of_input(self, quantity: Input) -> tuple[tuple[Effect, ...], Array]:
        """Return the effects through which an Input shows, and its columns (m, r) per draw of unit variance, sampled once for all rows."""
        effects = self._acted_on(quantity)
        if not effects:
            return (), np.zeros((self.recording.m, 0))
        ends = responses(self.ends, quantity, effects)
        factor = _unit_factor(quantity, ends[0].shape[1])
        return effects, _less_second([end @ factor for end in ends])

    def _acted_on(self, quantity: Input) -> tuple[Effect, ...]:
        """Return the effects through which an Input shows; none where the recording lacks its columns."""
        if quantity.members:
            members = [self._acted_on(m) for m in quantity.members]
            some = all(members) or bool(
                quantity.widths
            )  # what was followed together is seen as far as its effects are
            return tuple(e for effects in members for e in effects) if some else ()
        if quantity.is_channel:
            return self.usable.effects if quantity.parameter in self.run.columns else ()
        return tuple(e for e in targets(self.machine, quantity) if not missing_columns(e, self.run))

    def _code(self, quantity: Input, ends: Sequence[Array]) -> Array:
        """Return columns (m, r): the response (m, k) of each end times the factor of the law, one block per independent copy."""
        factor = _unit_factor(quantity, ends[0].shape[1])
        labels, codes = self._copies(quantity.redraw)
        ends = [end @ factor for end in ends]
        if len(labels) == 1:
            return _less_second(ends)
        rows = (self.recording.row, self.recording.other)  # a second end that is none has a response of zero
        blocks = []
        for copy in range(len(labels)):
            block = _less_second([end * (codes[row] == copy)[:, None] for end, row in zip(ends, rows)])
            blocks.append(_shorten(block))
        return np.concatenate(blocks, axis=1)

    def _copies(self, label: str) -> tuple[list[str], npt.NDArray[np.intp]]:
        """Return the values of a redraw label and the code (n,) of each run row; one value where the recording lacks the label."""
        if label in ("machine", "setup", "run", "touch") or label in self.run.labels:
            return self.run.copies(label)
        return [""], np.zeros(self.run.n, dtype=np.intp)


def _less_second(ends: Sequence[Array]) -> Array:
    """Return the first end of every observation, less the second where there is one."""
    return ends[0] if len(ends) == 1 else ends[0] - ends[1]


def _count_from_first(recording: Recording, run: Run) -> Run:
    """Return the run of displacements: the tip from the first row of its set-up, where the counter was zeroed: first by the clock, where one
    is recorded.
    """
    if recording.kind != "displacement" or "counted_x_mm" in run.columns:
        return run
    _, codes = run.copies("setup")
    by_time = np.argsort(run.columns.get("time_s", np.zeros(run.n)), kind="stable")
    first = by_time[np.unique(codes[by_time], return_index=True)[1]]
    way = run.tip - run.tip[first[codes]]
    return run.with_columns({f"counted_{c}_mm": way[:, i] for i, c in enumerate("xyz")})


def _shorten(block: Array) -> Array:
    """Return the same covariance block @ block.T with no more columns than there are rows in use."""
    rows = np.flatnonzero(np.abs(block).max(axis=1, initial=0.0) > 0)
    if len(rows) >= block.shape[1]:
        return block
    short = row_factor(block[rows])
    out = np.zeros((len(block), short.shape[1]))
    out[rows] = short
    return out


def _unit_factor(quantity: Input, k: int) -> Array:
    """Return the departure (k, r) of the k elements per draw of unit variance. Raises ModelLimit for a law without variance."""
    law, factor = quantity.spread(k)
    if isinstance(law, MultivariateSamples):
        return MultivariateNormal(law.covariance).factor
    if not np.isfinite(law.u):
        raise ModelLimit(
            f"{quantity.id}: the law {law.name} has no standard uncertainty; use dof above 2 or another law"
        )
    return factor * law.u


def left_out(recording: Recording, machine: Machine) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Return (effect id, missing columns) of the machine's own effects that the recording cannot show; `baseline` is without them."""
    run = machine.prepare(recording.run)
    needs = ((e.id, missing_columns(e, run)) for e in machine.effects if not e.about.is_random)
    return tuple((name, columns) for name, columns in needs if columns)


def baseline(recording: Recording, machine: Machine) -> Array:
    """Return the observations (m,) predicted from the machine's own effects, mm or rad.

    Effects whose columns the recording lacks are left out; `left_out` names them. Raises ModelLimit for rows outside
    the travels or the tables.
    """
    return Observer(recording, machine).baseline()


def calibration_columns(recording: Recording, machine: Machine) -> list[tuple[str, Array]]:
    """Return (Input id, columns (m, r)) for every Input of the machine but the scatter, which is the noise.

    Columns are scaled so that the prior of their coefficients is unit normal: covariance = columns @ columns.T (laws
    enter by their standard uncertainty). Every copy of a redrawn Input has columns of its own, shortened to the rows
    it acts on. Inputs that do not act on this recording are left out. What the recording itself states to be known comes first.
    """
    return Observer(recording, machine).calibration()


def known_here(recording: Recording, machine: Machine) -> Array:
    """Return columns (m, r), mm or rad per unit variance, of uncertainties that the recording states and that belong to no number of the machine:
    setting, scatter of a pass. They are independent for each recording, like noise.
    """
    ids = {i.id for i in machine.inputs if i.effect != Scatter.name}
    columns = [c for name, c in recording.known if name not in ids]
    return np.concatenate([np.zeros((recording.m, 0)), *columns], axis=1)


def noise_u(recording: Recording, machine: Machine) -> Array:
    """Return the standard uncertainty (m,) of the noise, mm or rad: [noise], else the column u, else the machine's repeatability.

    Raises ModelLimit when none of them is known.
    """
    if recording.noise is not None:
        return np.full(recording.m, _finite_u(recording.noise.u, "[noise]"))
    if recording.u is not None:
        return recording.u
    scatter = [i for i in machine.inputs if i.effect == Scatter.name]
    if recording.kind == "angle" or not scatter:
        why = "an angle has no repeatability in mm" if scatter else "the machine file has no [repeatability]"
        raise ModelLimit(
            f'the noise of recording "{recording.name}" is not known: {why}; add [noise] with law and u, or a column u_um'
            + (" (u_d_urad)" if recording.kind == "angle" else "")
        )
    parts = [_finite_u(float(np.linalg.norm(_unit_factor(i, 1))), i.id) for i in scatter]
    return np.full(recording.m, float(np.linalg.norm(parts)))


def _finite_u(u: float, what: str) -> float:
    if not (np.isfinite(u) and u > 0):
        raise ModelLimit(
            f"{what} has no finite standard uncertainty above zero ({u:g}); a t law needs dof above 2"
        )
    return float(u)
