"""Calibrate: recordings in, the errors of the machine with their joint covariance out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.calibrating.checks import check_agreement, check_recordings
from vcmm.calibrating.evidence import smoothness
from vcmm.calibrating.identified import Identified, identified
from vcmm.calibrating.known import Known, known_errors_of, known_ranges
from vcmm.calibrating.model import ErrorModel, error_model
from vcmm.calibrating.readings import Readings, read_both_ways, readings
from vcmm.calibrating.result import Calibration
from vcmm.calibrating.solve import Before, Posterior, solve
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.instruments.instrument import Certificate
from vcmm.response.recording import Recording

FAR, TURNS = 1e6, 1e3  # mm, rad: travel of an axis that nobody stated
FINE, FINEST = 17, 33  # nodes per axis; every second and every fourth are tried too
BETTER = 1.0  # nats that more nodes must win
REST = 1e-6  # mm: an axis that moves less stands still

Progress = Callable[[str, float], None]


def bare_machine(structure: str, kind: str = "cmm") -> Machine:
    """A machine of that structure without errors, travels without end. Raises UsageError for a wrong structure."""
    chain = parse_structure(structure)
    axes = {a: Axis(a, (-TURNS, TURNS) if a in "ABC" else (-FAR, FAR)) for a in chain.letters}
    return Machine("calibrated machine", kind, chain, axes)


def ranges_of(recordings: Sequence[Recording]) -> dict[str, tuple[float, float]]:
    """Axis -> (lowest, highest) position in all recordings, of linear axes that moved. Raises ModelLimit for rotary ones."""
    out: dict[str, tuple[float, float]] = {}
    for recording in recordings:
        for axis, q in recording.run.position.items():
            low, high = out.get(axis, (np.inf, -np.inf))
            out[axis] = (min(low, float(q.min())), max(high, float(q.max())))
    for axis, (low, high) in out.items():
        if axis in "ABC" and high - low > 1e-9:
            raise ModelLimit(
                f"axis {axis} turns in the recordings; calibrate finds the errors of linear axes: keep {axis} still, "
                "and give what is known of its own errors in a machine file with --machine"
            )
    return {a: r for a, r in out.items() if a in "XYZ" and r[1] - r[0] > REST}


def calibrate(
    recordings: Sequence[Recording],
    machine: Machine,
    certificates: Mapping[str, Certificate] | None = None,
    only: Sequence[str] = (),
    progress: Progress = lambda text, share: None,
) -> Calibration:
    """The errors of a machine from any mixture of recordings.

    machine: structure and axes, and what is known besides (its effects are the baseline). certificates: recording name ->
    its instrument. only: names of the errors to look for, the others are taken as zero. Raises UsageError where nothing is
    identified, naming the combinations, and for recordings that contradict themselves.
    """
    check_recordings(recordings)
    ranges = ranges_of(recordings)
    if not ranges:
        raise UsageError("no axis moves in the recordings; a calibration needs readings at several positions")
    before = known_ranges(machine)
    _check_reach(before, ranges)
    ranges = ranges | before
    job = _Job(recordings, machine, certificates or {}, ranges, tuple(only), progress)
    progress("reading", 0.1)
    parts, post, known = job.fitted(FINE)
    if post.model.curves and len(post.model.curves[0].nodes) == FINE and _rough(post):
        more, finer, better = job.fitted(FINEST)
        if finer.log_evidence > post.log_evidence + BETTER:
            parts, post, known = more, finer, better
    check_agreement(parts, post.model)
    progress("what is identified", 0.9)
    found = identified(post.information)
    if not known.names:
        _refuse_if_nothing(found)
    kept, theta, covariance = _kept(post, known, (*found.names, *known.names))
    remarks = (*_remarks(parts, post, only), *_as_before(found, known))
    return Calibration(
        _travelled(machine, ranges), kept, theta, covariance, post, found, tuple(parts), remarks
    )


def _check_reach(
    before: Mapping[str, tuple[float, float]], ranges: Mapping[str, tuple[float, float]]
) -> None:
    """Raises ModelLimit where readings lie beyond the tables that are to be recalibrated."""
    for axis, (low, high) in ranges.items():
        if axis in before and (low < before[axis][0] - REST or high > before[axis][1] + REST):
            raise ModelLimit(
                f"the readings go from {axis} = {low:g} to {high:g} mm, the tables of the machine file from {before[axis][0]:g} to "
                f"{before[axis][1]:g} mm: leave out the readings beyond, or calibrate anew with --structure"
            )


@dataclass(frozen=True, eq=False)
class _Job:
    """What `calibrate` was asked."""

    recordings: Sequence[Recording]
    machine: Machine
    certificates: Mapping[str, Certificate]
    ranges: Mapping[str, tuple[float, float]]
    only: tuple[str, ...]
    progress: Progress

    def fitted(self, nodes: int) -> tuple[list[Readings], Posterior, Known]:
        """The fit with the fewest nodes that the evidence allows: all, every second, every fourth."""
        both = sorted({a for r in self.recordings for a in read_both_ways(r)})
        model = error_model(self.ranges, nodes, self.only, both)
        parts = [readings(r, self.machine, model, self.certificates.get(r.name)) for r in self.recordings]
        self.progress("errors and smoothness", 0.4)
        known = known_errors_of(self.machine, model)
        best = solve(parts, model, _since(known, model, None))
        for step in (4, 2):
            coarse, lift = model.coarser(step)
            if (
                known.names
                or smoothness(best.information.lifted(coarse, lift)).log_evidence
                > best.smooth.log_evidence - BETTER
            ):
                if known.names and step == 4:
                    continue
                model, parts = coarse, [replace(p, errors=p.errors @ lift) for p in parts]
                known = known_errors_of(self.machine, model)
                best = solve(parts, model, _since(known, model, None))
                break
        if known.names:
            best = solve(parts, model, _since(known, model, identified(best.information)))
        return parts, best, known


def _since(known: Known, model: ErrorModel, found: Identified | None) -> Before:
    """Errors that the file states may have changed only where the readings can tell."""
    changed = np.ones(model.size)
    for name in known.names:
        if found is not None and name not in found.names:
            changed[model.slices[name]] = 0.0
    return Before(known.factor, changed)


def _as_before(found: Identified, known: Known) -> list[str]:
    """What is taken over from the machine file unchanged."""
    kept = [n for n in known.names if n not in found.names]
    if not kept:
        return []
    return [
        f"{', '.join(kept)}: no reading of these recordings tells whether they changed; they stay as the machine file has them"
    ]


def _rough(post: Posterior) -> bool:
    """Is a curve so rough that more nodes may be needed: its correlation length near the shortest that was tried?"""
    spans = {c.axis: float(c.nodes[-1] - c.nodes[0]) for c in post.model.curves}
    return any(length < 0.15 * spans[name[-1]] for name, length in post.smooth.lengths.items())


def _refuse_if_nothing(found: Identified) -> None:
    if not found.names:
        raise UsageError(
            "the recordings identify no error of the machine by itself:\n  "
            + "\n  ".join(c.text for c in found.combinations)
            + "\nAdd such recordings, or name the errors to look for with --errors; the others are then taken as zero"
        )


def _kept(post: Posterior, known: Known, names: Sequence[str]) -> tuple[ErrorModel, np.ndarray, np.ndarray]:
    """The errors of these names: model, numbers, covariance (what is not identified stays in it as uncertainty)."""
    model = post.model
    kept = ErrorModel(
        tuple(c for c in model.curves if c.component in names), tuple(p for p in model.pairs if p in names)
    )
    rows = np.concatenate([np.arange(model.size)[model.slices[n]] for n in kept.names])
    return kept, (known.theta + post.theta)[rows], post.covariance[np.ix_(rows, rows)]


def _travelled(machine: Machine, ranges: Mapping[str, tuple[float, float]]) -> Machine:
    """The machine with the travels that were measured, where nobody stated them."""
    axes = {
        a: replace(axis, travel=ranges.get(a, (-1.0, 1.0)))
        if axis.travel in ((-FAR, FAR), (-TURNS, TURNS))
        else axis
        for a, axis in machine.axes.items()
    }
    return replace(machine, axes=axes)


def _remarks(parts: Sequence[Readings], post: Posterior, only: Sequence[str]) -> list[str]:
    """Sentences about what was assumed and what was found to be otherwise."""
    out = [a for p in parts for a in p.assumed]
    if only:
        out.append(f"only {', '.join(only)} were looked for; every other error was taken as zero")
    for part, noise in zip(parts, post.noise):
        name = part.recording.name
        if not part.stated:
            unit, scale = ("urad", 1e6) if part.recording.kind == "angle" else ("um", 1e3)
            out.append(
                f"{name}: the noise is not stated; the residuals say {noise.u * part.u[0] * scale:.2g} {unit}"
            )
        elif noise.scale > 1.0 and np.isinf(noise.dof):
            out.append(
                f"{name}: the residuals are {noise.scale:.2f} times the stated noise, which was raised by that"
            )
        if noise.outliers.any():
            out.append(
                f"{name}: {int(noise.outliers.sum())} outliers carry little weight: {part.recording.places(noise.outliers)}"
            )
    for name, value in zip(post.own_names, post.own):
        if abs(value) > 3:
            out.append(
                f"{name}: the readings pull it by {value:+.1f} times its stated u; check its certificate"
            )
    return out
