"""Observe: from motions of the tip to what a recording holds. The one home of its signs.

    probe, displacement, path     value = s n . t + r n . g      t translation of the tip, g reading, n direction
    length                        the same at the first end less the same at the second
    angle                         value = s n . w                w rotation of the tip

    s = -1 for indicated - true, +1 for actual - commanded
    r = +1, but -1 for actual - commanded of a displacement or length: there the instrument is the reference, and a
        reading that lets it indicate less makes the machine appear to go too far

Readings (indicated - true) are those of vcmm.core.effect, mm. `Observer` keeps how each link of the machine shows in the
observations, so that thousands of candidate effects cost one small product each.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vcmm.core.effect import Effect, basis
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.kinematics import Motion, tip_motion
from vcmm.core.laws import MultivariateNormal, MultivariateSamples, row_factor
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.effects import has_role
from vcmm.response.influence import STEP, shifted, targets
from vcmm.response.logs import with_logs
from vcmm.response.nuisance import nuisance_columns
from vcmm.response.recording import Recording

__all__ = [
    "Observer", "baseline", "calibration_columns", "lacking", "left_out", "noise_u", "nuisance_columns", "observe",
]  # fmt: skip
INSTRUMENT_KINDS = ("displacement", "length")  # an instrument is the reference


def observe(recording: Recording, motion: Array, reading: Array) -> Array:
    """Change (m, k) of the observations, mm or rad, by tip motions (n, 6, k) and readings (n, 3, k) of all run rows.

    motion: actual - nominal, workpiece axes, mm and rad (tip sense); reading: indicated - true, mm. Signs: see the
    head of this file.
    """
    first, second = _ends(recording, motion, reading)
    return first if second is None else first - second


def _ends(recording: Recording, motion: Array, reading: Array) -> tuple[Array, Array | None]:
    """The two ends (m, k) of every observation; None where no observation has a second end."""
    moved = motion[:, 3:] if recording.kind == "angle" else motion[:, :3]
    seen = recording.sign * moved + _reading_sign(recording) * reading
    first = np.einsum("mi,mik->mk", recording.direction, seen[recording.row])
    has = recording.other >= 0
    if not has.any():
        return first, None
    second = np.zeros_like(first)
    second[has] = np.einsum("mi,mik->mk", recording.direction[has], seen[recording.other[has]])
    return first, second


def _reading_sign(recording: Recording) -> float:
    """r of the head of this file; readings are lengths, so an angle has none."""
    if recording.kind == "angle":
        return 0.0
    return -recording.sign if recording.kind in INSTRUMENT_KINDS else 1.0


class Observer:
    """A recording seen through a machine's kinematics: any effect to its observations.

    run: the recording's run, prepared by the machine.   Raises ModelLimit for rows outside the travels.
    """

    def __init__(self, recording: Recording, machine: Machine) -> None:
        recording = replace(recording, run=with_logs(recording.run))
        self.recording, self.machine = recording, machine
        self.run = _counted(recording, machine.prepare(recording.run))
        self._seen: dict[tuple[str, str], tuple[Array, Array | None]] = {}

    def of_effect(self, effect: Effect) -> Array:
        """What an effect with its present numbers adds to the observations (m,), mm or rad."""
        return self.through(effect, self.machine.asked(effect, self.run)[:, :, None])[:, 0]

    def of_parameter(self, effect: Effect, name: str) -> Array:
        """Derivative (m, k) of the observations with respect to each element of a parameter of an effect."""
        self.machine.asked(effect, self.run)
        return self.through(effect, basis(effect, name, self.run))

    def ends_of(self, effect: Effect, six: Array) -> tuple[Array, Array | None]:
        """Both ends (m, k) of the observations by error motions (n, 6, k) of the effect's link."""
        maps, sign = self._maps(effect), self.machine.sign(effect)
        row, other = self.recording.row, self.recording.other
        first = sign * np.einsum("mj,mjk->mk", maps[0], six[row])
        if maps[1] is None:
            return first, None
        return first, sign * np.einsum(
            "mj,mjk->mk", maps[1], six[other]
        )  # rows of maps without that end are 0

    def through(self, effect: Effect, six: Array) -> Array:
        """Change of the observations (m, k) by error motions (n, 6, k) of the effect's link: one end less the other."""
        first, second = self.ends_of(effect, six)
        return first if second is None else first - second

    def _maps(self, effect: Effect) -> tuple[Array, Array | None]:
        """(m, 6) of each end: the observation by a unit motion of the link; made once per link and place."""
        key = (effect.link, effect.place if effect.link != "reading" else "")
        if key not in self._seen:
            motion, reading = np.zeros((self.run.n, 6, 6)), np.zeros((self.run.n, 3, 6))
            if effect.link == "reading":
                reading[:, :, :3] = np.eye(3)
            else:
                unit = [Motion(*key, np.broadcast_to(np.eye(6)[j], (self.run.n, 6))) for j in range(6)]
                chain, axes = self.machine.chain, self.machine.axes
                motion = np.stack([tip_motion(chain, axes, self.run, [m]) for m in unit], axis=2)
            self._seen[key] = _ends(self.recording, motion, reading)
        return self._seen[key]

    @cached_property
    def usable(self) -> Machine:
        """The machine with those of its effects whose columns the recording has."""
        kept = tuple(e for e in self.machine.effects if not lacking(e, self.run))
        return replace(self.machine, effects=kept)

    def baseline(self, run: Run | None = None) -> Array:
        """Observations (m,) predicted from the machine's own effects; run: another run of the same rows."""
        first, second = self.baseline_ends(run)
        return first[:, 0] if second is None else (first - second)[:, 0]

    def baseline_ends(self, run: Run | None = None) -> tuple[Array, Array | None]:
        """The two ends (m, 1) of `baseline`."""
        run = self.run if run is None else run
        motion, reading = self.usable.tip_motion(run), self.usable.reading(run)
        return _ends(self.recording, motion[:, :, None], reading[:, :, None])

    def calibration(self) -> list[tuple[str, Array]]:
        """See `calibration_columns`."""
        out = []
        for one in self.machine.inputs:
            ends = None if has_role(one.effect, "repeatability") else self._input_ends(one)
            if ends is not None:
                columns = self._coded(one, *ends)
                used = np.abs(columns).max(axis=0, initial=0.0) > 0
                if used.any():
                    out.append((one.id, columns[:, used]))
        return out

    def _input_ends(self, one: Input) -> tuple[Array, Array | None] | None:
        """Response (m, k) of both ends per unit of the Input; None where the recording lacks its columns."""
        if one.is_channel:
            return self._channel_ends(one.parameter)
        found = [e for e in targets(self.machine, one) if not lacking(e, self.run)]
        if not found:
            return None
        ends = [self.ends_of(e, basis(e, one.parameter, self.run)) for e in found]
        first = np.sum([f for f, _ in ends], axis=0)
        second = [s for _, s in ends if s is not None]
        return first, np.sum(second, axis=0) if second else None

    def _channel_ends(self, channel: str) -> tuple[Array, Array | None] | None:
        """Central difference of the baseline in a column; None where the recording has no such column."""
        if channel not in self.run.columns:
            return None
        step = next((s for ending, s in STEP.items() if channel.endswith(ending)), 1e-3)
        high, low = (
            self.baseline_ends(shifted(self.run, channel, np.full(self.run.n, h))) for h in (step, -step)
        )
        first = (high[0] - low[0]) / (2 * step)
        second = None if high[1] is None or low[1] is None else (high[1] - low[1]) / (2 * step)
        return first, second

    def _coded(self, one: Input, first: Array, second: Array | None) -> Array:
        """Columns (m, r): the response times the factor of the law, one block per independent copy."""
        factor = _unit_factor(one, first.shape[1])
        labels, codes = self._copies(one.redraw)
        first, rec = first @ factor, self.recording
        if len(labels) == 1:
            return first if second is None else first - second @ factor
        blocks = []
        for copy in range(len(labels)):
            block = first * (codes[rec.row] == copy)[:, None]
            if second is not None:
                block -= (second @ factor) * ((codes[rec.other] == copy) & (rec.other >= 0))[:, None]
            blocks.append(_shortened(block))
        return np.concatenate(blocks, axis=1)

    def _copies(self, label: str) -> tuple[list[str], npt.NDArray[np.intp]]:
        """Values of a redraw label and the code (n,) of each run row; one value where the recording lacks the label."""
        if label in ("machine", "setup", "run", "touch") or label in self.run.labels:
            return self.run.copies(label)
        return [""], np.zeros(self.run.n, dtype=np.intp)


def _counted(recording: Recording, run: Run) -> Run:
    """Of displacements: the tip from the first row of its set-up, where the counter was zeroed."""
    if recording.kind != "displacement" or "counted_x_mm" in run.columns:
        return run
    _, codes = run.copies("setup")
    _, first = np.unique(codes, return_index=True)
    way = run.tip - run.tip[first[codes]]
    return run.with_columns({f"counted_{c}_mm": way[:, i] for i, c in enumerate("xyz")})


def _shortened(block: Array) -> Array:
    """The same covariance block @ block.T with no more columns than there are rows in use."""
    rows = np.flatnonzero(np.abs(block).max(axis=1, initial=0.0) > 0)
    if len(rows) >= block.shape[1]:
        return block
    short = row_factor(block[rows])
    out = np.zeros((len(block), short.shape[1]))
    out[rows] = short
    return out


def _unit_factor(one: Input, k: int) -> Array:
    """(k, r): departure of the k elements per draw of unit variance. Raises ModelLimit for a law without variance."""
    law, factor = one.spread(k)
    if isinstance(law, MultivariateSamples):
        return MultivariateNormal(law.covariance).factor
    if not np.isfinite(law.u):
        raise ModelLimit(
            f"{one.id}: the law {law.name} has no standard uncertainty; use dof above 2 or another law"
        )
    return factor * law.u


def lacking(effect: Effect, run: Run) -> tuple[str, ...]:
    """Columns that an effect needs and the run has neither as a column nor as a log."""
    return tuple(
        c
        for c in effect.required()
        if c not in run.columns and c.removeprefix("temp_").removesuffix("_C") not in run.series
    )


def left_out(recording: Recording, machine: Machine) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """(effect id, missing columns) of the machine's own effects that the recording cannot show; `baseline` is without them."""
    run = machine.prepare(recording.run)
    found = ((e.id, lacking(e, run)) for e in machine.effects if not e.random)
    return tuple((name, columns) for name, columns in found if columns)


def baseline(recording: Recording, machine: Machine) -> Array:
    """Observations (m,) predicted from the machine's own effects, mm or rad.

    Effects whose columns the recording lacks are left out; `left_out` names them. Raises ModelLimit for rows outside
    the travels or the tables.
    """
    return Observer(recording, machine).baseline()


def calibration_columns(recording: Recording, machine: Machine) -> list[tuple[str, Array]]:
    """(Input id, columns (m, r)) for every Input of the machine but the scatter, which is the noise.

    Columns are scaled so that the prior of their coefficients is unit normal: covariance = columns @ columns.T (laws
    enter by their standard uncertainty). Every copy of a redrawn Input has columns of its own, shortened to the rows
    it acts on. Inputs that do not act on this recording are left out.
    """
    return Observer(recording, machine).calibration()


def noise_u(recording: Recording, machine: Machine) -> Array:
    """Standard uncertainty (m,) of the noise, mm or rad: [noise], else the column u, else the machine's repeatability.

    Raises ModelLimit when none of them is known.
    """
    if recording.noise is not None:
        return np.full(recording.m, _finite_u(recording.noise.u, "[noise]"))
    if recording.u is not None:
        return recording.u
    scatter = [i for i in machine.inputs if has_role(i.effect, "repeatability")]
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
