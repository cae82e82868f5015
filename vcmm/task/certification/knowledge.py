"""Convert a certificate into the effects of a machine file, and Inputs with samples of their joint law.

Machines whose geometry, tip and scatter each use all of their own limit: the largest errors that a certificate allows.

A certificate is an upper bound: the machine lies anywhere between perfect and the limit, in every kind of error by itself. So
no error may be made smaller here because another limit is wide (a wide R0 would otherwise leave little of E0 to the
geometry, and a worse certificate would give a smaller U). Every kind of error is scaled until it alone meets each limit that
it shows in, and every one of them grows with every limit or stays:

    geometry    the largest of |error| / limit over 35 lengths (E0, E150), each sampled machine by itself, is 1; then errors of
                position are made smaller where a limit of ISO 230-2 requires it, and nothing takes their place
    tip form    the form of 25 points on a sphere is P_Form; pairs of touches keep E0
    tip size    a diameter errs by P_Size, up or down; at most by E0 of the shortest length
    scatter     the expected range of three repeats over 35 lengths is R0; the form of the sphere keeps P_Form, lengths keep E0

The results of the test (`[certificate.measured]`) are observations: they replace the limit, and where one determines
the size of an error by itself (scatter from R0; with it the tip form from P_Form), this error has that size and is no longer only bounded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.inputs import EVERY, Input
from vcmm.core.laws import MultivariateSamples, Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.physics.structure.scatter import Scatter
from vcmm.physics.structure.tip import TipRadius
from vcmm.physics.structure.tip_form import TipForm
from vcmm.task.certification.certificate import LengthLimit, MachineCertificate, smallest_limit
from vcmm.task.certification.findings import Finding, LimitShare
from vcmm.task.certification.lines import RAM, REPEATS, SHARES, length_run, ram_lines, seven_lines
from vcmm.task.certification.machines import (
    NODES,
    SEED,
    CertifiedMachines,
    along_axis,
    drawn_machines,
    drawn_modes,
    error_tables,
    expected_form,
    expected_range,
    mirrored_rows,
    per_mode,
    shares_of,
    tip_forms,
    tip_reading,
)
from vcmm.task.certification.positioning import axis_run, fit_to_limits

GEOMETRY, TIP, SIZE, SCATTER, AXES, FINDING = range(
    6
)  # streams: what one limit draws does not depend on another
LEAST_KEPT = 0.02  # of the machines must keep E0 with their scatter
TRIALS_TRIED = 500


def machines_at_each_limit(machine: Machine, c: MachineCertificate) -> CertifiedMachines:
    """Return the machines that reach each limit. UsageError: scatter alone exceeds E0."""
    effects, kinds = error_tables(machine)
    bare = replace(machine, effects=(*machine.effects, *effects), inputs=())
    modes = drawn_modes(np.random.default_rng([SEED, GEOMETRY]), kinds)
    if c.E0 is None:
        return _by_positioning(bare, c, modes, SEED)
    scatter = _scatter(bare, c, c.E0, _shares(c, SEED, SCATTER, len(modes)), SEED)
    modes = _kept_by_axes(bare, c, modes * _by_lengths(bare, c, c.E0, modes, SEED)[:, None], SEED)
    return CertifiedMachines(
        modes, _tip(bare, c, c.E0, scatter, SEED), _radius(bare, c, c.E0, len(modes), SEED), scatter
    )


def _shares(c: MachineCertificate, seed: int, stream: int, count: int) -> Array:
    """Return the share of a limit that each machine uses (count,)."""
    return shares_of(np.random.default_rng([seed, stream, 1]), c.prior, 1.0)[:count]


def _draw_finding(finding: Finding, seed: int, stream: int, count: int) -> Array:
    """Sample a finding with its uncertainty (count,) mm, never below 0."""
    rng = np.random.default_rng([seed, FINDING, stream])
    return np.maximum(finding.error + finding.u * rng.normal(size=count), 0.0)


def _by_lengths(machine: Machine, c: MachineCertificate, e0: LengthLimit, modes: Array, seed: int) -> Array:
    """Return the factors (m,) of the geometric errors from the limits of lengths."""
    run, lengths = length_run(machine, seven_lines(machine))
    limits, shown = [e0.at(lengths)], [per_mode(machine, run)]
    if c.E150 is not None:
        for side in (-RAM, RAM):
            ram, far = length_run(machine, ram_lines(machine), np.array([0.0, side, 0.0]))
            limits.append(c.E150.at(far))
            shown.append(per_mode(machine, ram))
    limit = np.concatenate(limits)
    used = (np.abs(modes @ np.concatenate(shown).T) / limit).max(axis=1)
    scale = _shares(c, seed, GEOMETRY, len(modes)) / np.maximum(used, 1e-15)
    if c.findings.largest is not None:
        _check_largest(c.findings.largest, float(e0.at(lengths).max()))
        most = np.abs(modes @ shown[0].T).max(axis=1)
        scale = np.minimum(
            scale, _draw_finding(c.findings.largest, seed, GEOMETRY, len(modes)) / np.maximum(most, 1e-15)
        )
    if c.findings.worst is not None:
        scale = np.minimum(scale, _by_found_share(c.findings.worst, modes @ shown[0].T, e0.at(lengths), seed))
    if c.findings.lengths:
        scale = np.minimum(scale, _by_found_lengths(c, e0, modes @ shown[0].T, lengths, seed))
    return np.asarray(scale)


def _check_largest(largest: Finding, most: float) -> None:
    """Raise UsageError where the largest error exceeds the limit of the longest length of the machine."""
    if abs(largest.error) > most:
        raise UsageError(
            f"measured E0_largest: {abs(largest.error) * 1e3:g} um is more than E0_MPE allows on the longest length of this machine "
            f"({most * 1e3:.3g} um): such a machine did not pass; correct the value, or state the limit that it was held to"
        )


def _by_found_share(worst: LimitShare, errors: Array, limits: Array, seed: int) -> Array:
    """Return the factors (m,) at which the largest share of the limit equals the measured one. errors (m, 35) mm of the unscaled
    machines, limits (35,) mm."""
    rng = np.random.default_rng([seed, FINDING, GEOMETRY])
    shares = np.abs(errors) / limits
    most = limits[shares.argmax(axis=1)]
    drawn = worst.share + worst.u_at(most) * rng.normal(size=len(errors))
    return np.asarray(np.maximum(drawn, 0.0) / np.maximum(shares.max(axis=1), 1e-15))


def _by_found_lengths(
    c: MachineCertificate, e0: LengthLimit, errors: Array, lengths: Array, seed: int
) -> Array:
    """Return the factors (m,) at which each machine shows, on lengths like the measured ones, the same share of E0 as the test.

    errors (m, 35) mm of the unscaled machines. The place of each length is unknown: any of the seven lines that is long
    enough. Few lengths may therefore have missed larger errors of the machine, and the factors allow for that.
    """
    rng = np.random.default_rng([seed, FINDING, GEOMETRY])
    steps = len(SHARES)
    ends = lengths[steps - 1 :: steps]
    along = np.concatenate(
        [np.zeros((len(errors), len(ends), 1)), errors.reshape(len(errors), -1, steps)], axis=2
    )
    rows, indicated, at_findings = np.arange(len(errors)), np.zeros(len(errors)), np.zeros(len(errors))
    for length, finding in c.findings.lengths:
        fit = np.flatnonzero(ends >= length)
        line = rng.choice(fit if len(fit) else [int(np.argmax(ends))], len(errors))
        place = np.minimum(length / ends[line], 1.0) * steps
        below = np.minimum(place.astype(int), steps - 1)
        step = place - below
        error = along[rows, line, below] * (1 - step) + along[rows, line, below + 1] * step
        limit = e0(length)
        indicated = np.maximum(indicated, np.abs(error) / limit)
        at_findings = np.maximum(
            at_findings, (abs(finding.error) + finding.u * rng.normal(size=len(errors))) / limit
        )
    return np.asarray(at_findings / np.maximum(indicated, 1e-15))


def _kept_by_axes(machine: Machine, c: MachineCertificate, modes: Array, seed: int) -> Array:
    """Return the errors of the position of an axis, made smaller where its limit of ISO 230-2 requires it."""
    out = modes.copy()
    for i, axis in enumerate("XYZ"):
        if axis not in machine.axes or not c.limits_accuracy(axis):
            continue
        along = along_axis(machine, axis_run(machine, axis), i)
        is_of_axis = np.abs(along).max(axis=0) > 0
        rng, share = np.random.default_rng([seed, AXES, i]), _shares(c, seed, AXES, len(modes))
        _, most = fit_to_limits(
            c, axis, modes[:, is_of_axis] @ along[:, is_of_axis].T, rng, (share, share), alone=True
        )
        out[:, is_of_axis] *= np.minimum(most, 1.0)[:, None]
    return out


def _scatter(machine: Machine, c: MachineCertificate, e0: LengthLimit, share: Array, seed: int) -> Array:
    """Return the standard deviation of a touch (m,) mm."""
    _, lengths = length_run(machine, seven_lines(machine))
    rng = np.random.default_rng([seed, SCATTER])
    if c.findings.R0 is not None:
        return _scatter_as_found(c.findings.R0, len(share), len(lengths), seed)
    repeat = c.R0 if c.R0 is not None else smallest_limit(e0, c.form)
    scatter = share * repeat / expected_range(rng, len(lengths))
    for sphere in (c.form, c.findings.form.highest if c.findings.form else None):
        if sphere is not None:  # scatter alone shows as form of the test sphere
            scatter = np.minimum(scatter, sphere / expected_form())
    noise = np.sqrt(2.0) * np.abs(rng.normal(size=(TRIALS_TRIED, len(lengths), REPEATS))).max(axis=2)
    kept = (scatter[:TRIALS_TRIED, None] * noise[: len(scatter)] <= e0.at(lengths)).all(axis=1)
    if kept.mean() < LEAST_KEPT:
        raise UsageError(
            "no machine keeps these limits together: scatter (R0_MPL) alone exceeds E0_MPE; check the units of the certificate"
        )
    limit = e0.at(lengths)
    if c.findings.largest is not None:
        limit = np.minimum(limit, c.findings.largest.highest)
    if c.findings.worst is not None:
        limit = np.minimum(limit, c.findings.worst.highest(e0.at(lengths)))
    return np.minimum(scatter, 1.0 / (noise / limit).max(axis=1).mean())


def _scatter_as_found(finding: Finding, count: int, lengths: int, seed: int) -> Array:
    """Return the scatter (count,) mm from the measured range: that range over the range of as many repeats of unit scatter, sampled for
    every machine, since the range over the scatter is a pivot.
    """
    rng = np.random.default_rng([seed, SCATTER, 2])
    unit = np.array(
        [np.ptp(np.sqrt(2.0) * rng.normal(size=(lengths, REPEATS)), axis=1).max() for _ in range(count)]
    )
    return _draw_finding(finding, seed, SCATTER, count) / unit


def _tip(machine: Machine, c: MachineCertificate, e0: LengthLimit, scatter: Array, seed: int) -> Array:
    """Return the form of the tip alone (m, 12) mm; with a measured scatter, the part of the measured form that scatter does not explain."""
    rng, count = np.random.default_rng([seed, TIP]), len(scatter)
    limit = c.form if c.form is not None else e0.constant
    if c.findings.form is None:
        form = tip_forms(rng, limit, np.zeros(count), _shares(c, seed, TIP, count))
    else:
        beside = scatter if c.findings.R0 is not None else np.zeros(count)
        size = max(c.findings.form.error, 1e-9)
        form = tip_forms(rng, size, beside, _draw_finding(c.findings.form, seed, TIP, count) / size)
    run, lengths = length_run(machine, seven_lines(machine))
    shown = (np.abs(tip_reading(run, form, np.zeros(count))) / e0.at(lengths)[:, None]).max(axis=0)
    return form / np.maximum(shown, 1.0)[:, None]


def _radius(machine: Machine, c: MachineCertificate, e0: LengthLimit, count: int, seed: int) -> Array:
    """Return how much too large the radius of the tip is (m,) mm."""
    _, lengths = length_run(machine, seven_lines(machine))
    sign = np.random.default_rng([seed, SIZE]).choice([-1.0, 1.0], count)
    if c.findings.size is not None:
        return 0.5 * sign * _draw_finding(c.findings.size, seed, SIZE, count)
    size = min(c.size if c.size is not None else 0.5 * e0.constant, e0(float(lengths.min())))
    return 0.5 * size * sign * _shares(c, seed, SIZE, count)


def _by_positioning(machine: Machine, c: MachineCertificate, modes: Array, seed: int) -> CertifiedMachines:
    """Scale every axis until its test of ISO 230-2 finds A (or E, M) without scatter; scatter from R. Squareness by the mean."""
    letters = [a for a in "XYZ" if a in machine.axes]
    scatter, scaled = np.zeros(len(modes)), modes.copy()
    each = 6 * NODES
    for i, axis in enumerate(letters):
        block = slice(i * each, (i + 1) * each)
        number = "XYZ".index(axis)
        shape = modes[:, block] @ along_axis(machine, axis_run(machine, axis), number)[:, block].T
        rng, share = np.random.default_rng([seed, AXES, number]), _shares(c, seed, AXES, len(modes))
        s, scale = fit_to_limits(c, axis, shape, rng, (share, share), alone=True)
        scaled[:, block] *= scale[:, None]
        scatter = np.maximum(scatter, s)
    last = each * len(letters)
    usual = [np.log(np.abs(a[:, :last]) + 1e-12).mean(axis=1) for a in (scaled, modes)]
    scaled[:, last:] *= np.exp(usual[0] - usual[1])[:, None]
    return CertifiedMachines(scaled, np.zeros((len(modes), 12)), np.zeros(len(modes)), scatter)


@dataclass(frozen=True, eq=False)
class CertifiedKnowledge:
    """Effects and Inputs of a machine that is known by its certificate only."""

    effects: tuple[Effect, ...]
    inputs: tuple[Input, ...]


def certified_knowledge(machine: Machine, certificate: MachineCertificate) -> CertifiedKnowledge:
    """Return the effects and Inputs for a machine with its axes. UsageError: limits that no machine of the family can keep.

    Inputs are `bound` where only a limit is known: they are the largest errors that the machine may have.
    """
    effects, _ = error_tables(machine)
    return _knowledge(effects, certificate, machines_at_each_limit(machine, certificate))


def passing_machines(machine: Machine, certificate: MachineCertificate) -> CertifiedKnowledge:
    """Return effects and Inputs of machines that pass the test with all their errors together, to predict the test of such a machine."""
    effects, _ = error_tables(machine)
    return _knowledge(effects, certificate, drawn_machines(machine, certificate))


def _knowledge(
    effects: Sequence[Effect], c: MachineCertificate, drawn: CertifiedMachines
) -> CertifiedKnowledge:
    """Return samples as Inputs, about their mean of zero: every machine and its mirror image."""
    evidence = c.words()
    tables = effects[0].name
    inputs = [
        Input(
            tables,
            EVERY,
            "modes",
            MultivariateSamples(mirrored_rows(drawn.modes)),
            "machine",
            evidence,
            bound=True,
        ),
        Input(
            Scatter.name,
            "",
            "value",
            Normal(float(np.sqrt((drawn.scatter**2).mean()))),
            "touch",
            evidence,
            bound=c.findings.R0 is None,
        ),
    ]
    further: list[Effect] = [Scatter()]
    if drawn.form.any():
        further.append(TipForm(coefficients=np.zeros(12)))
        inputs.append(
            Input(
                TipForm.name,
                "",
                "coefficients",
                MultivariateSamples(mirrored_rows(drawn.form)),
                "machine",
                evidence,
                bound=c.findings.R0 is None or c.findings.form is None,
            )
        )
    if drawn.radius.any():
        further.append(TipRadius())
        inputs.append(
            Input(
                TipRadius.name,
                "",
                "dr",
                MultivariateSamples(mirrored_rows(drawn.radius[:, None])),
                "machine",
                evidence,
                bound=True,
            )
        )
    return CertifiedKnowledge((*effects, *further), tuple(inputs))
