"""Machine: structure, axes, and the effects that make it imperfect. Numbers are crisp; knowledge is in Inputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from vcmm.core.effect import FREE_LINKS, Effect, required
from vcmm.core.errors import BeyondFirstOrder, ModelLimit, UsageError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.kinematics import (
    CHUNK,
    Axis,
    Chain,
    Motion,
    exact_tip_error,
    exact_tip_motion,
    nominal_tip,
    tip_motion,
)
from vcmm.core.run import Array, Run

LARGEST_TRANSLATION = 1.0  # mm of one effect; more is a table in micrometres, unless it is stated
FIRST_ORDER_LIMIT_RAD = 1e-3  # second-order terms: 1e-3^2 / 2 x 1 m = 0.5 um
MOVE_IT = "; move the part or the pose"  # the way out of a travel, where nothing was recorded yet


@dataclass(frozen=True, eq=False)
class Machine:
    """A machine as data. `effects` hold what is known of its errors, `inputs` how well that is known."""

    name: str
    kind: str
    chain: Chain
    axes: Mapping[str, Axis]
    effects: tuple[Effect, ...] = ()
    inputs: tuple[Input, ...] = ()
    state: str = "residual"
    compensation: tuple[str, ...] = ()
    load_limit: float | None = None  # kg
    large_errors: bool = (
        False  # translations above 1 mm and rotations above 1 mrad are meant: transforms are multiplied
    )
    remarks: tuple[str, ...] = ()  # what its file states and a reader should check
    record: Mapping[str, str] = field(default_factory=dict)  # serial number, certificate: words for reports

    def __post_init__(self) -> None:
        for letter in self.chain.letters:
            if letter not in self.axes:
                raise UsageError(
                    f"structure names axis {letter}, but there is no [axes.{letter}]; add it with its travel"
                )
        for letter in self.axes:
            if letter not in self.chain.letters:
                raise UsageError(
                    f'[axes.{letter}] is not in structure = "{self.chain.structure}"; add it there or remove it'
                )
        for effect in self.effects:
            if effect.link not in (*FREE_LINKS, *self.chain.letters):
                raise UsageError(
                    f"{effect.id} acts on axis {effect.link}, which is not in structure {self.chain.structure}"
                )

    def with_effect(self, *effects: Effect) -> Machine:
        """Return a copy with further effects."""
        return replace(self, effects=self.effects + effects)

    def without(self, name: str, where: str | None = None) -> Machine:
        """Return a copy without the effects of that name (and place)."""
        gone = [e for e in self.effects if e.name == name and where in (None, e.where)]
        if not gone:
            raise UsageError(
                f"the machine has no effect {name}.{choose_from(name, sorted({e.name for e in self.effects}))}"
            )
        return replace(self, effects=tuple(e for e in self.effects if e not in gone))

    def check_travels(self, run: Run) -> None:
        """Raises ModelLimit naming the row, the axis and the travel for the first position outside."""
        for letter, axis in self.axes.items():
            check_travel(axis, run.q(letter))

    def prepare(self, run: Run) -> Run:
        """Return the run with the nominal tip position as columns, after checking its positions against the travels.

        Raises ModelLimit naming the row, the axis and the travel.
        """
        self.check_travels(run)
        if "tip_x_mm" in run.columns:
            return run
        tip = nominal_tip(self.chain, self.axes, run)
        return run.with_columns({f"tip_{c}_mm": tip[:, i] for i, c in enumerate("xyz")})

    def motions(self, run: Run, effects: Iterable[Effect] | None = None) -> list[Motion]:
        """Return the error motions of all effects that move a link, in tip sense. `run` is prepared."""
        chosen = [e for e in (self.effects if effects is None else effects) if e.link != "reading"]
        return [Motion(e.link, e.place, self.sign(e) * self.checked_motion(e, run)) for e in chosen]

    def sign(self, effect: Effect) -> float:
        """Return -1 for an axis's own motion on the workpiece side, else +1 (error motions are in tip sense)."""
        return -1.0 if effect.own and effect.link in self.chain.work else 1.0

    def checked_motion(self, effect: Effect, run: Run) -> Array:
        """Return the error motion, after checking that the run has the columns the effect needs."""
        self.check_columns(effect, run)
        return effect.error_motion(run)

    def check_columns(self, effect: Effect, run: Run) -> None:
        """Raises ModelLimit naming a column that an effect needs and the run has neither as a column nor as a log."""
        for column in required(effect):
            if (
                column not in run.columns
                and column.removeprefix("temp_").removesuffix("_C") not in run.series
            ):
                raise ModelLimit(
                    f"{effect.id} needs the column {column}, which this run lacks; add it or remove the effect"
                )

    def tip_motion(self, run: Run, exact: bool = False) -> Array:
        """Return the motion of the tip (n, 6), actual - nominal, workpiece axes: mm and rad; of first order unless exact.

        Raises ModelLimit where a rotation exceeds 1 mrad, where first order is no longer good enough, or a
        translation 1 mm, unless the machine says large_errors: then the transforms are multiplied.
        """
        run = self.prepare(run)
        if exact or self.large_errors:
            return exact_tip_motion(self.chain, self.axes, run, self.motions(run))
        if 0 < run.n <= CHUNK:
            return self._first_order(run, 0)
        parts = [self._first_order(run.take(slice(i, i + CHUNK)), i) for i in range(0, run.n, CHUNK)]
        return np.concatenate(parts) if parts else np.zeros((0, 6))

    def chosen_motion(self, run: Run) -> tuple[Array, bool]:
        """Return the motion of the tip (n, 6) as `tip_motion`, by the engine that the size of the machine's own errors requires,
        and whether the transforms were multiplied.
        """
        if self.large_errors:
            return self.tip_motion(run, exact=True), True
        try:
            return self.tip_motion(run), False
        except BeyondFirstOrder:
            return self.tip_motion(run, exact=True), True

    def _first_order(self, run: Run, first: int) -> Array:
        """Return the motion (n, 6) of the rows of a run from row `first` on."""
        motions = self.motions(run)
        for motion in motions:
            largest = float(np.abs(motion.six[:, 3:]).max(initial=0.0))
            if largest > FIRST_ORDER_LIMIT_RAD:
                raise BeyondFirstOrder(
                    f"a rotation of {largest * 1e3:.3g} mrad of link {motion.link} exceeds 1 mrad, the limit of the "
                    "first-order engine; use exact=True (--exact) or check the unit of the error table"
                )
            moved = np.abs(motion.six[:, :3]).max(axis=1, initial=0.0)
            if moved.max(initial=0.0) > LARGEST_TRANSLATION:
                row = first + int(moved.argmax())
                raise BeyondFirstOrder(
                    f"row {row + 1}: a translation of {moved.max():.4g} mm of link {motion.link} exceeds 1 mm; error tables are in mm and rad: check "
                    "the unit, use exact=True (--exact), or state large_errors = true in the machine file",
                    row=row,
                )
        return tip_motion(self.chain, self.axes, run, motions)

    def tip_error(self, run: Run, exact: bool = False) -> Array:
        """Return the tip error (n, 3) mm, actual - nominal, workpiece axes. exact=True multiplies the transforms."""
        if not exact and not self.large_errors:
            return self.tip_motion(run)[:, :3]
        run = self.prepare(run)
        return exact_tip_error(self.chain, self.axes, run, self.motions(run))

    def reading(self, run: Run) -> Array:
        """Return what probe, stylus, part and instrument add to the indication (n, 3) mm, indicated - true."""
        run = self.prepare(run)
        total = np.zeros((run.n, 3))
        for effect in self.effects:
            if effect.link == "reading":
                total += self.checked_motion(effect, run)[:, :3]
        return total

    def indication_error(self, run: Run, exact: bool = False) -> Array:
        """Return the error of indication of a measuring machine, indicated - true = -tip error + reading, (n, 3) mm. This sign is defined
        here only."""
        run = self.prepare(run)
        return self.reading(run) - self.tip_error(run, exact)


def check_travel(axis: Axis, q: Array) -> None:
    """Raises ModelLimit, with its row, for the first row outside the travel (1 nm or 1 nrad of rounding is allowed)."""
    low, high = axis.limits
    outside = np.flatnonzero((q < low - 1e-6) | (q > high + 1e-6))
    if len(outside):
        row = int(outside[0])
        scale, unit = (180 / np.pi, "deg") if axis.rotary else (1.0, "mm")
        raise BeyondFirstOrder(
            f"row {row + 1}: axis {axis.letter} = {q[row] * scale:.6g} {unit} is outside its travel "
            f"{low * scale:.6g} to {high * scale:.6g} {unit} ({len(outside)} of {len(q)} rows are){MOVE_IT}",
            row=row,
        )
