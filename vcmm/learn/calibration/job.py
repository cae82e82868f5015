"""Calibrate: from recordings to the errors of the machine with their joint covariance."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.axes import is_rotary, whole_turn
from vcmm.core.blocks import Progress
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.checks import check_agreement, check_instruments, check_recordings, remarks_on
from vcmm.learn.calibration.evidence import smoothness
from vcmm.learn.calibration.growth import growth_factor, growth_remarks
from vcmm.learn.calibration.identifiability import Identifiability, identify
from vcmm.learn.calibration.interpolation import (
    NETS,
    as_kind,
    expected_between,
    interpolation_of,
    left_between,
    net_posterior,
    swings,
)
from vcmm.learn.calibration.model import LINEAR, ErrorModel, error_model
from vcmm.learn.calibration.prior_knowledge import (
    PriorKnowledge,
    as_before,
    assumption_remarks,
    known_errors_of,
    known_nodes,
    known_ranges,
    known_turns,
    name_of,
)
from vcmm.learn.calibration.readings import Readings, read_both_ways, readings
from vcmm.learn.calibration.result import Calibration
from vcmm.learn.calibration.reversal_readings import read_jointly
from vcmm.learn.calibration.rotary import average_line
from vcmm.learn.calibration.solve import Before, ErrorPosterior, columns_of, normal_equations, project, solve
from vcmm.learn.calibration.touching import as_line, is_touched, touched_errors
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.response.recording import Recording

UNLIMITED_TRAVEL_MM, UNLIMITED_TRAVEL_RAD = (
    1e6,
    1e3,
)  # mm, rad: assumed travel of an axis without a stated one
FINE, FINEST = 17, 33  # nodes per axis; every second and every fourth are tried too
LEAST_RECALIBRATION_NODES = 9  # nodes of a recalibration
SPLINE, POLYNOMIAL = "spline", "polynomial"
BETTER = 1.0  # nats that more nodes must win
BETWEEN = (
    0.3  # of the u of a curve: what fewer nodes may leave of it between them; a 95 % band then holds 94 %
)
REST, STILL = (
    1e-6,
    1.0,
)  # mm: an axis that moves less counts as not moved; its assumed travel then, to either side

NEARLY = np.radians(300.0)  # a rotary axis that turned so far went round


def bare_machine(structure: str) -> Machine:
    """Return a machine of that structure without errors, travels without end. Raises UsageError for a wrong structure."""
    chain = parse_structure(structure)
    axes = {
        a: Axis(
            a,
            (-UNLIMITED_TRAVEL_RAD, UNLIMITED_TRAVEL_RAD)
            if is_rotary(a)
            else (-UNLIMITED_TRAVEL_MM, UNLIMITED_TRAVEL_MM),
        )
        for a in chain.letters
    }
    return Machine("calibrated machine", "cmm", chain, axes)


def spans_of(recordings: Sequence[Recording]) -> dict[str, tuple[float, float]]:
    """Return the axis -> (lowest, highest) position in all recordings, mm or rad."""
    out: dict[str, tuple[float, float]] = {}
    for recording in recordings:
        for axis, q in recording.run.position.items():
            low, high = out.get(axis, (np.inf, -np.inf))
            out[axis] = (min(low, float(q.min())), max(high, float(q.max())))
    return out


def ranges_of(spans: Mapping[str, tuple[float, float]], machine: Machine) -> dict[str, tuple[float, float]]:
    """Return the ranges (low, high) of the axes that moved, that of a rotary axis that went round rounded to one turn."""
    out = {}
    for axis, (low, high) in spans.items():
        if high - low <= REST:
            continue
        round_ = is_rotary(axis) and high - low > NEARLY and float(np.ptp(machine.axes[axis].travel)) > NEARLY
        out[axis] = (low, low + 2 * np.pi) if round_ else (low, high)
    return out


def calibrate(
    recordings: Sequence[Recording],
    machine: Machine,
    certificates: Mapping[str, InstrumentCertificate] | None = None,
    only: Sequence[str] = (),
    progress: Progress = lambda text, share: None,
    growth: float = 0.0,
    interpolation: str = SPLINE,
    correlated: Mapping[str, Array] | None = None,
) -> Calibration:
    """Estimate the errors of a machine from any mixture of recordings.

    machine: structure and axes, and what is known besides (its effects are the baseline). certificates: recording name ->
    its instrument. only: names of the errors to look for; the others are taken as zero, or stay as the machine
    file has them. growth: u in mm by which every error of the machine file may have changed since it was found (rotations and
    squareness: that over 1 m); zero leaves it to the readings. interpolation: one of vcmm.learn.calibration.interpolation.
    correlated: recording name -> covariance of its readings (m, m) mm^2, where their noise is not independent. Raises UsageError where nothing is
    identified, naming the combinations, and for recordings that contradict themselves.
    """
    kind = interpolation_of(interpolation)
    check_recordings(recordings)
    check_instruments(certificates or {})
    spans = spans_of(recordings)
    ranges = _looked_at(spans, machine, kind, growth)
    alone = not only and is_touched(recordings, certificates or {})
    only = touched_errors(ranges_of(spans, machine)) if alone else only
    given = (recordings, machine, certificates or {}, ranges, tuple(only), correlated or {})
    job = _Job(*given, progress=progress, growth=growth, lines=alone)
    progress("reading", 0.1)
    parts, post, prior = job.best() if kind == SPLINE else job.refit_as(kind)
    swinging = swings(post, job.posterior_of(job.model(FINEST))[1]) if kind == POLYNOMIAL else []
    check_agreement(parts, post.model)
    progress("what is identified", 0.9)
    identifiability = beforehand(parts, post.model) if growth else identify(post.information, post.covariance)
    if not prior.names:
        _refuse_if_nothing(identifiability)
    kept, theta, covariance = _selected_errors(post, prior, (*identifiability.names, *prior.names), machine)
    remarks = (
        *remarks_on(recordings),
        *assumption_remarks(parts, post, only, bool(prior.names)),
        *swinging,
        *(growth_remarks(growth, parts, post.model, prior) if growth else as_before(identifiability, prior)),
    )
    return Calibration(
        machine=_with_travels(machine, spans | ranges),
        kept_model=kept,
        theta=theta,
        covariance=covariance,
        posterior=post,
        identified=identifiability,
        readings=tuple(parts),
        warnings=remarks,
        interpolation=kind,
    )


def _looked_at(
    spans: Mapping[str, tuple[float, float]], machine: Machine, kind: str, growth: float
) -> dict[str, tuple[float, float]]:
    """Return the ranges of the axes over which errors are looked for: those of readings, and those of tables in the machine file.

    Raises UsageError and ModelLimit where nothing moved, and where the statements of the machine file cannot be the start.
    """
    ranges = ranges_of(spans, machine)
    if not ranges:
        raise UsageError("no axis moves in the recordings; a calibration needs readings at several positions")
    turned = known_turns(machine)
    _check_frame(machine, turned)
    before = known_ranges(machine) | {a: (float(q[0]), float(q[-1])) for a, q in turned.items()}
    _check_reach(before, ranges)
    _check_anew(kind, before)
    if growth and not any(e.about.is_calibrated for e in machine.effects):
        raise UsageError(
            "--growth says by how much known errors may have changed, but the machine file states none; leave --growth out"
        )
    return ranges | before


def _check_anew(kind: str, before: Mapping[str, tuple[float, float]]) -> None:
    """Raises UsageError where a file of splines would be recalibrated by another interpolation."""
    if kind != SPLINE and before:
        raise UsageError(
            f'--interpolation "{kind}" with a machine file that has error tables: a recalibration changes what the file has, at its '
            "own nodes; leave --interpolation out, or calibrate anew with --structure"
        )


def _check_frame(machine: Machine, turned: Collection[str]) -> None:
    """Raises ModelLimit where the machine file tabulates errors of a rotary axis in a frame that does not turn with it."""
    fixed = sorted(a for a in turned if machine.axes[a].error_frame == "fixed")
    if fixed:
        raise ModelLimit(
            f'the machine file tabulates errors of the rotary axis {" ".join(fixed)} with error_frame = "fixed", which a recalibration cannot take '
            "over: state them in the frame that turns with the axis, or calibrate anew with --structure"
        )


def _check_reach(
    before: Mapping[str, tuple[float, float]], ranges: Mapping[str, tuple[float, float]]
) -> None:
    """Raises ModelLimit where readings lie beyond the tables that are to be recalibrated; a table over a whole turn has no end."""
    for axis, span in before.items():
        if axis not in ranges or whole_turn(axis, np.array(span)):
            continue
        unit, scale = ("deg", 180 / np.pi) if is_rotary(axis) else ("mm", 1.0)
        (low, high), (first, last) = ranges[axis], span
        if low < first - REST or high > last + REST:
            raise ModelLimit(
                f"the readings go from {axis} = {low * scale:g} to {high * scale:g} {unit}, the tables of the machine file from "
                f"{first * scale:g} to {last * scale:g} {unit}: leave out the readings beyond, or calibrate anew with --structure"
            )


@dataclass(frozen=True, eq=False)
class _Job:
    """Arguments of `calibrate`."""

    recordings: Sequence[Recording]
    machine: Machine
    certificates: Mapping[str, InstrumentCertificate]
    ranges: Mapping[str, tuple[float, float]]
    only: tuple[str, ...]
    noise_covariances: Mapping[str, Array]
    progress: Progress
    growth: float
    lines: bool = False  # errors of linear axes are straight lines over the travel

    def best(self) -> tuple[list[Readings], ErrorPosterior, PriorKnowledge]:
        """Return the fit with splines; more nodes where a curve is so rough that it runs otherwise between them."""
        parts, post, prior = self.fit_nodes(FINE if known_nodes(self.machine) <= FINE else FINEST)
        fine = post.model.curves and len(post.model.curves[0].nodes) == FINE and not prior.names
        if fine and expected_between(post) > BETWEEN:
            del parts, post  # of 10^5 readings a quarter of a gigabyte
            return self.fit_nodes(FINEST)
        return parts, post, prior

    def refit_as(self, kind: str) -> tuple[list[Readings], ErrorPosterior, PriorKnowledge]:
        """Fit with another interpolation; nets are learnt from the table and use the nodes of a spline."""
        model = self.model(FINEST)
        prior = known_errors_of(self.machine, model)
        if kind in NETS:
            table = self.posterior_of(as_kind(model, LINEAR, self.recordings))[1]
            parts, carrier = self.posterior_of(model)
            return parts, net_posterior(table, carrier, parts, self.machine, kind), prior
        parts, post = self.posterior_of(as_kind(model, kind, self.recordings))
        return parts, post, known_errors_of(self.machine, post.model)

    def posterior_of(self, model: ErrorModel) -> tuple[list[Readings], ErrorPosterior]:
        """Return the fit with exactly these nodes."""
        parts = self.read(model)
        self.progress("errors and smoothness", 0.4)
        return parts, solve_posterior(parts, model, Before.nothing(model))

    def model(self, nodes: int) -> ErrorModel:
        """Return all errors that may be looked for, with so many nodes."""
        both = sorted({a for r in self.recordings for a in read_both_ways(r)})
        turns = known_turns(self.machine)
        stated = bool(known_ranges(self.machine) or turns)
        names = [name_of(e) for e in self.machine.effects if e.about.is_calibrated]
        model = error_model(self.ranges, nodes, () if stated else self.only, both, names if stated else ())
        if stated and self.only:
            known_too = [n for n in model.names if n in names]
            model = error_model(self.ranges, nodes, (*self.only, *known_too), both, names)
        moved = ranges_of(spans_of(self.recordings), self.machine)
        kept = {a: q for a, q in turns.items() if a not in moved or len(q) > 2 * nodes - 1}
        curves = [
            replace(c, nodes=kept[c.axis], has_file_nodes=True) if c.axis in kept else c for c in model.curves
        ]
        curves = [as_line(c) if self.lines and not stated else c for c in curves]
        return ErrorModel(tuple(curves), model.pairs)

    def read(self, model: ErrorModel) -> list[Readings]:
        """Return the recordings read by a model."""
        parts = [readings(r, self.machine, model, self.certificates.get(r.name)) for r in self.recordings]
        return read_jointly(parts, self.noise_covariances)

    def fit_nodes(self, nodes: int) -> tuple[list[Readings], ErrorPosterior, PriorKnowledge]:
        """Return the fit with the fewest nodes that the evidence allows: all, every second, every fourth."""
        model = self.model(nodes)
        parts = self.read(model)
        self.progress("errors and smoothness", 0.4)
        prior = known_errors_of(self.machine, model)
        identifiability = (
            beforehand(parts, model) if prior.names and any(c.rotary for c in model.curves) else None
        )
        best = solve_posterior(parts, model, self.since(prior, model, identifiability))
        for step in (4, 2):
            coarse, lift = model.coarser(step)
            if self.may_be(coarse, lift, prior, best):
                model, parts = coarse, [replace(p, errors=p.errors @ lift) for p in parts]
                prior = known_errors_of(self.machine, model)
                best = solve_posterior(parts, model, self.since(prior, model, identifiability))
                break
        if prior.names and not self.growth:
            best = solve_posterior(parts, model, self.since(prior, model, identify(best.information)))
        return parts, best, prior

    def may_be(self, coarse: ErrorModel, lift: Array, prior: PriorKnowledge, best: ErrorPosterior) -> bool:
        """Return whether fewer nodes are as good: by their misfit between them and by the evidence, or, where a file is known, no
        fewer than it has (9 at least).
        """
        if prior.names:
            due = max(known_nodes(self.machine), LEAST_RECALIBRATION_NODES)
            turns = {axis: len(nodes) for axis, nodes in known_turns(self.machine).items()}
            return all(
                len(c.nodes) >= (turns.get(c.axis, LEAST_RECALIBRATION_NODES) if c.rotary else due)
                for c in coarse.curves
            )
        if coarse.size == best.model.size or left_between(best, coarse) > BETWEEN:
            return False
        fewer = smoothness(best.information.project_onto(coarse, lift))
        return fewer.log_evidence > best.smooth.log_evidence - BETTER

    def since(
        self, prior: PriorKnowledge, model: ErrorModel, identifiability: Identifiability | None
    ) -> Before:
        """Return the errors that may have changed since the file: those that the readings determine, and those that `only` names; with a
        stated growth
        they have changed by that, whether or not a reading shows it.
        """
        changed = np.ones(model.size)
        if self.growth:
            for name in prior.names:
                changed[model.slices[name]] = 0.0
            return Before(
                np.concatenate([prior.factor, growth_factor(model, prior.names, self.growth)], axis=1),
                changed,
            )
        for name in model.names if prior.names else ():
            is_identified = (
                identifiability is None or name in identifiability.names or name not in prior.names
            )
            if not is_identified or (self.only and name not in self.only):
                changed[model.slices[name]] = 0.0
        return Before(prior.factor, changed)


def solve_posterior(parts: Sequence[Readings], model: ErrorModel, before: Before) -> ErrorPosterior:
    """Return the posterior. Raises ModelLimit with the combinations that no reading separates, where these leave no digit of the rest."""
    try:
        return solve(parts, model, before)
    except ModelLimit as error:
        texts = beforehand(parts, model).briefly()
        raise ModelLimit(
            "\n  ".join([f"{error}. Not identified are:", *texts]) if texts else str(error)
        ) from None


def beforehand(parts: Sequence[Readings], model: ErrorModel) -> Identifiability:
    """Return what readings with their stated noise identify of all errors, without any earlier knowledge.

    Of linear and rotary axes that moved together nearly nothing: there what the file states stays as it is from the start.
    """
    columns, _ = columns_of(parts, Before.nothing(model))
    return identify(normal_equations([project(p, c, 1.0 / p.u**2) for p, c in zip(parts, columns)], model))


def _refuse_if_nothing(identifiability: Identifiability) -> None:
    if not identifiability.names:
        raise UsageError(
            "the recordings identify no error of the machine by itself:\n  "
            + "\n  ".join(identifiability.briefly())
            + "\nAdd such recordings, or name the errors to look for with --errors; the others are then taken as zero"
        )


def _selected_errors(
    post: ErrorPosterior, prior: PriorKnowledge, names: Sequence[str], machine: Machine
) -> tuple[ErrorModel, np.ndarray, np.ndarray]:
    """Return the errors with the given names: model, numbers, covariance (unidentified errors stay in it as uncertainty).

    Location errors of rotary axes are those of the axis average line.
    """
    model = post.model
    kept = ErrorModel(
        tuple(c for c in model.curves if c.component in names), tuple(p for p in model.pairs if p in names)
    )
    rows = np.concatenate([np.arange(model.size)[model.slices[n]] for n in kept.names])
    about = average_line(kept, machine)
    covariance = about @ post.covariance[np.ix_(rows, rows)] @ about.T
    return kept, about @ (prior.theta + post.theta)[rows], covariance


def _with_travels(machine: Machine, spans: Mapping[str, tuple[float, float]]) -> Machine:
    """Return the machine with the measured travels, where none are stated; an axis that did not move has 1 mm about it."""
    axes = dict(machine.axes)
    for letter, axis in machine.axes.items():
        if axis.travel in (
            (-UNLIMITED_TRAVEL_MM, UNLIMITED_TRAVEL_MM),
            (-UNLIMITED_TRAVEL_RAD, UNLIMITED_TRAVEL_RAD),
        ):
            low, high = spans.get(letter, (0.0, 0.0))
            still = STILL if high - low <= REST else 0.0
            axes[letter] = replace(axis, travel=(low - still, high + still))
    return replace(machine, axes=axes)
