"""Machines that pass the test of a certificate: errors sampled from a broad family, each machine scaled until its test finds the limit.

A machine has the 18 component errors of three axes, smooth over their travels, three squareness errors, a tip that is not
round and not of the size it was qualified with, and scatter. How the kinds of errors share the limit differs from machine to
machine (lognormal factors). The acceptance test itself is simulated on every machine (105 lengths, 25 points on a sphere, with
scatter), and the geometric errors are multiplied by the one number at which the largest error, each length against its own
limit, uses the share of the limit that the prior states. Machines whose scatter and tip alone exceed it are left out.

These machines pass a test with all errors together. The knowledge of a machine file about a machine of which only the limits are
known is wider: see `knowledge`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect, basis
from vcmm.core.errors import UsageError
from vcmm.core.inputs import EVERY, Input
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.physics.structure.component import CalibrationModes
from vcmm.physics.structure.tip_form import TipForm
from vcmm.task.certification.certificate import MachineCertificate, smallest_limit
from vcmm.task.certification.lines import RAM, REPEATS, length_run, ram_lines, seven_lines
from vcmm.task.certification.positioning import axis_run, fit_to_limits
from vcmm.task.response.influence import influences

DRAWN, NODES = 6000, 5  # machines; nodes of every table over the travel
KIND_SPREAD = 0.7  # lognormal spread of the share of each kind of error in a machine
SMOOTH = 0.5  # correlation length of the tables over the travel
SEED = 10360


def drawn_machines(machine: Machine, certificate: MachineCertificate) -> CertifiedMachines:
    """Return the machines, each with its own geometry, tip and scatter, that pass the test with all of them together."""
    effects, loadings = error_tables(machine)
    bare = replace(machine, effects=(*machine.effects, *effects), inputs=())
    rng = np.random.default_rng(SEED)
    modes = drawn_modes(rng, loadings)
    if certificate.E0:
        return _by_lengths(bare, certificate, modes, rng)
    return _by_positioning(bare, certificate, modes, rng)


def error_tables(machine: Machine) -> tuple[list[Effect], Sequence[str]]:
    """Return one effect per component and squareness, all moved by one vector of modes; and the kind of each mode."""
    letters = [a for a in "XYZ" if a in machine.axes]
    names = [f"E{d}{a}" for a in letters for d in "XYZABC"]
    pairs = [
        p
        for p in ("C0Y", "B0Z", "A0Z")
        if {"C": "XY", "B": "XZ", "A": "YZ"}[p[0]]
        and set({"C": "XY", "B": "XZ", "A": "YZ"}[p[0]]) <= set(letters)
    ]
    total = NODES * len(names) + len(pairs)
    reach = max(float(np.ptp(machine.axes[a].travel)) for a in letters)
    effects: list[Effect] = []
    kinds: list[str] = []
    for name in names:
        rows = np.zeros((NODES, total))
        turn = 2.0 / reach if name[1] in "ABC" else 1.0
        rows[:, len(kinds) : len(kinds) + NODES] = 1e-3 * turn * _smooth()
        nodes = np.linspace(*machine.axes[name[2]].travel, NODES)
        effects.append(CalibrationModes(name, nodes, rows, "linear"))
        kinds += [_kind(name)] * NODES
    for pair in pairs:
        row = np.zeros((1, total))
        row[0, len(kinds)] = 2e-3 / reach
        effects.append(CalibrationModes(pair, np.zeros(0), row, "linear"))
        kinds.append("angle")
    return effects, kinds


def _kind(name: str) -> str:
    if name[1] in "ABC":
        return "rotation"
    return "position" if name[1] == name[2] else "straightness"


def _smooth() -> Array:
    """Factor of a smooth curve of variance 1 over the nodes."""
    gap = np.subtract.outer(np.linspace(0, 1, NODES), np.linspace(0, 1, NODES)) / SMOOTH
    return np.asarray(np.linalg.cholesky(np.exp(-0.5 * gap**2) + 1e-9 * np.eye(NODES)))


def drawn_modes(rng: np.random.Generator, kinds: Sequence[str]) -> Array:
    """Sample modes (machines, modes): standard normal, each kind of error with a share of its own."""
    out = rng.normal(size=(DRAWN, len(kinds)))
    for kind in dict.fromkeys(kinds):
        out[:, [k == kind for k in kinds]] *= np.exp(KIND_SPREAD * rng.normal(size=(DRAWN, 1)))
    return out


@dataclass(frozen=True, eq=False)
class CertifiedMachines:
    """Machines that pass: modes (m, k), tip form (m, 12) mm, radius (m,) mm too large, standard deviation of a touch (m,) mm."""

    modes: Array
    form: Array
    radius: Array
    scatter: Array

    @property
    def mirror(self) -> CertifiedMachines:
        """Every machine, followed by its mirror image, as the Inputs have them."""
        return CertifiedMachines(
            mirrored_rows(self.modes),
            mirrored_rows(self.form),
            mirrored_rows(self.radius),
            np.tile(self.scatter, 2),
        )


def geometry_at_limit(machine: Machine, c: MachineCertificate, drawn: CertifiedMachines) -> CertifiedMachines:
    """Return the same machines with geometry that uses all of E0 by itself."""
    if c.E0 is None:
        raise UsageError("geometry has a limit of its own only where E0_MPE is stated")
    effects, _ = error_tables(machine)
    bare = replace(machine, effects=(*machine.effects, *effects), inputs=())
    run, lengths = length_run(bare, seven_lines(bare))
    used = (np.abs(drawn.modes @ per_mode(bare, run).T) / c.E0.at(lengths)).max(axis=1)
    return replace(drawn, modes=drawn.modes / used[:, None])


def shares_of(rng: np.random.Generator, prior: str, least: float) -> Array:
    """Return the share of its limit that each machine uses (machines,); with the prior "limit" at least `least` of it."""
    if prior == "limit":
        return rng.uniform(least, 1.0, DRAWN)
    return rng.uniform(0.0, 1.0, DRAWN) if prior == "uniform" else rng.triangular(0.0, 0.5, 1.0, DRAWN)


def _by_lengths(
    machine: Machine, c: MachineCertificate, modes: Array, rng: np.random.Generator
) -> CertifiedMachines:
    assert c.E0 is not None
    run, lengths = length_run(machine, seven_lines(machine))
    repeat = c.R0 if c.R0 is not None else smallest_limit(c.E0, c.form)
    scatter = shares_of(rng, c.prior, 0.8) * repeat / expected_range(rng, len(lengths))
    if c.form is not None:  # scatter alone shows as form of the test sphere
        scatter = np.minimum(scatter, c.form / expected_form())
    form = tip_forms(
        rng, c.form if c.form is not None else c.E0.constant, scatter, shares_of(rng, c.prior, 0.8)
    )
    size = c.size if c.size is not None else 0.5 * c.E0.constant
    radius = 0.5 * size * rng.choice([-1.0, 1.0], DRAWN) * shares_of(rng, c.prior, 0.0)
    allowed, shows, rest = [c.E0.at(lengths)], [per_mode(machine, run)], [tip_reading(run, form, radius)]
    if c.E150 is not None:
        for side in (-RAM, RAM):
            ram, far = length_run(machine, ram_lines(machine), np.array([0.0, side, 0.0]))
            allowed.append(c.E150.at(far))
            shows.append(per_mode(machine, ram))
            rest.append(tip_reading(ram, form, radius))
    limit, shown, other = np.concatenate(allowed), np.concatenate(shows), np.concatenate(rest).T
    noise = np.sqrt(2.0) * scatter[:, None, None] * rng.normal(size=(DRAWN, len(limit), REPEATS))
    added, share = other[..., None] + noise, shares_of(rng, c.prior, 1.0)
    scale = _largest_scale(modes @ shown.T, added, limit, share)
    modes = modes * np.maximum(scale, 0.0)[:, None]
    if c.positioning:
        kept = _kept_by_positioning(machine, c, modes, rng)
        free = np.where(kept == 0.0, modes, 0.0)
        scale = _largest_scale(free @ shown.T, added + (kept @ shown.T)[..., None], limit, share)
        modes = kept + free * np.maximum(scale, 0.0)[:, None]
    passes = scale > 0.0
    if passes.mean() < 0.02:
        raise UsageError(
            "no machine keeps these limits together: scatter (R0_MPL), tip form and size alone exceed E0_MPE; check the units of the "
            "certificate"
        )
    return CertifiedMachines(modes[passes], form[passes], radius[passes], scatter[passes])


def _kept_by_positioning(
    machine: Machine, c: MachineCertificate, modes: Array, rng: np.random.Generator
) -> Array:
    """Return the modes (machines, modes) that show in the position of an axis, made smaller where its limit of ISO 230-2 requires it; else 0."""
    kept = np.zeros_like(modes)
    for axis in (a for a in "XYZ" if a in machine.axes and c.limits_accuracy(a)):
        run, i = axis_run(machine, axis), "XYZ".index(axis)
        along = along_axis(machine, run, i)
        is_of_axis = np.abs(along).max(axis=0) > 0
        shape = modes[:, is_of_axis] @ along[:, is_of_axis].T
        _, most = fit_to_limits(
            c, axis, shape, rng, (shares_of(rng, c.prior, 1.0), shares_of(rng, c.prior, 0.8))
        )
        kept[:, is_of_axis] = modes[:, is_of_axis] * np.minimum(most, 1.0)[:, None]
    return kept


def _largest_scale(geometry: Array, rest: Array, limit: Array, share: Array) -> Array:
    """Return the factors (m,) of the geometric errors (m, n) at which the largest |error| / limit is the share (m,).

    rest (m, n, repeats): errors of scatter and tip. Not above 0 where these alone exceed the share.
    """
    room = share[:, None] * limit - (np.sign(geometry)[..., None] * rest).max(axis=2)
    back = share[:, None] * limit - np.abs(rest).max(axis=2)
    scale = (room / np.maximum(np.abs(geometry), 1e-15)).min(axis=1)
    return np.where(back.min(axis=1) > 0.0, scale, -1.0)


def per_mode(machine: Machine, run: Run) -> Array:
    """Return the error of every length, indicated - true, per mode, as (m, k) mm."""
    prepared = machine.prepare(run)
    quantity = Input(CalibrationModes.name, EVERY, "modes", Normal(1.0))
    response = influences(machine, prepared, [quantity])[0].response
    both = np.einsum("nik,ni->nk", response, prepared.normal)
    half = len(both) // 2
    return np.asarray(both[:half] + both[half:])


def tip_reading(run: Run, form: Array, radius: Array) -> Array:
    """Return the reading that the tip adds to both ends, (lengths, machines) mm."""
    heights = tip_harmonics(run.normal) @ form.T
    half = len(heights) // 2
    return np.asarray(heights[:half] + heights[half:] + 2.0 * radius)


def tip_harmonics(normals: Array) -> Array:
    """Return the height of the tip along each normal per coefficient of its form, as (n, 12)."""
    effect = TipForm(coefficients=np.zeros(12))
    run = Run({}, np.zeros((len(normals), 3)), {f"n{c}": normals[:, i] for i, c in enumerate("xyz")})
    return np.asarray(np.einsum("nik,ni->nk", basis(effect, "coefficients", run)[:, :3], normals))


def expected_range(rng: np.random.Generator, lengths: int) -> float:
    """Return the expected largest range of the repeats over all lengths, per standard deviation of one touch (two touches a length)."""
    drawn = np.sqrt(2.0) * rng.normal(size=(2000, lengths, REPEATS))
    return float(np.ptp(drawn, axis=2).max(axis=1).mean())


def expected_form() -> float:
    """Return the expected form of 25 points on a perfect sphere, per standard deviation of one touch."""
    columns = np.column_stack([np.ones(25), half_sphere()])
    left = np.eye(25) - columns @ np.linalg.pinv(columns)
    return float(np.ptp(np.random.default_rng(25).normal(size=(4000, 25)) @ left, axis=1).mean())


def tip_forms(rng: np.random.Generator, limit: float, scatter: Array, share: Array) -> Array:
    """Return forms of the tip (machines, 12) mm with which 25 points of a sphere show the share of the limit, scatter included."""
    normals = half_sphere()
    columns = np.column_stack([np.ones(25), normals])  # size and place of the sphere are fitted
    left = np.eye(25) - columns @ np.linalg.pinv(columns)
    coefficients = rng.normal(size=(DRAWN, 12)) / np.repeat([1.0, 2.0], [5, 7])
    shape, noise = (
        coefficients @ tip_harmonics(normals).T @ left,
        (scatter[:, None] * rng.normal(size=(DRAWN, 25))) @ left,
    )
    low, high = np.zeros(DRAWN), np.full(DRAWN, 10.0 * max(limit, 1e-6))
    for _ in range(30):
        middle = (low + high) / 2
        over = np.ptp(middle[:, None] * shape + noise, axis=1) > share * limit
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    return coefficients * low[:, None]


def half_sphere() -> Array:
    """Return the 25 points of ISO 10360-5:2020, 6.2 as unit normals (25, 3): pole, 4 at 22.5 deg, 8 at 45, 4 at 67.5, 8 on the equator."""
    out = [np.array([[0.0, 0.0, 1.0]])]
    for polar, count, start in ((22.5, 4, 0.0), (45.0, 8, 22.5), (67.5, 4, 0.0), (90.0, 8, 22.5)):
        turn = np.radians(start + np.arange(count) * 360.0 / count)
        down = np.radians(polar)
        out.append(
            np.column_stack(
                [np.sin(down) * np.cos(turn), np.sin(down) * np.sin(turn), np.full(count, np.cos(down))]
            )
        )
    return np.concatenate(out)


def _by_positioning(
    machine: Machine, c: MachineCertificate, modes: Array, rng: np.random.Generator
) -> CertifiedMachines:
    """Scale the errors of every axis until its test of ISO 230-2 finds A (or E, M); scatter from R. Squareness by the mean."""
    letters = [a for a in "XYZ" if a in machine.axes]
    scatter, scaled = np.zeros(DRAWN), modes.copy()
    for i, axis in enumerate(letters):
        block = slice(i * 6 * NODES, (i + 1) * 6 * NODES)
        run = axis_run(machine, axis)
        shape = modes[:, block] @ along_axis(machine, run, "XYZ".index(axis))[:, block].T
        s, scale = fit_to_limits(
            c, axis, shape, rng, (shares_of(rng, c.prior, 1.0), shares_of(rng, c.prior, 0.8))
        )
        scaled[:, block] *= scale[:, None]
        scatter = np.maximum(scatter, s)
    last = 6 * NODES * len(letters)
    typical = np.exp(
        np.log(np.abs(scaled[:, :last]) + 1e-12).mean(axis=1)
        - np.log(np.abs(modes[:, :last]) + 1e-12).mean(axis=1)
    )
    scaled[:, last:] *= typical[:, None]
    return CertifiedMachines(scaled, np.zeros((DRAWN, 12)), np.zeros(DRAWN), scatter)


def along_axis(machine: Machine, run: Run, i: int) -> Array:
    """Return the error of the position along axis number i, per mode, as (n, k) mm."""
    prepared = machine.prepare(run)
    quantity = Input(CalibrationModes.name, EVERY, "modes", Normal(1.0))
    return np.asarray(influences(machine, prepared, [quantity])[0].response[:, i])


def mirrored_rows(samples: Array) -> Array:
    return np.concatenate([samples, -samples])
