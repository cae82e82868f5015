"""Calibrate an arm from poses: its geometry, elastic joints and eccentric gears, by least squares with multiplied transforms.

    measured = B (machine with theta)(joints, offset o) Q + noise

theta: numbers of `arm_terms`; B, o, Q: tracker and target (see vcmm.task.response.poses). Gauss-Newton with the columns of the nominal machine and residuals of
the exact one. Poses separate only part of theta from B, o and Q and from one another: numbers are taken in order (placing, joint offsets,
twists, shifts),
each only where those before it do not already have the same effect, and omitted numbers are named with those of the same effect. Numbers
that are kept have a normal law of zero
mean and the largest believable size as prior (Term.most), which matters only where poses carry next to no information.
Source: Mooring, Roth & Driels, Fundamentals of Manipulator Calibration (1991): complete and minimal models, 4 R + 6 numbers of R joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.learn.calibration.arm_redundancy import SAME_COLUMN_SHARE, Redundant, beside, orthonormal, same_as
from vcmm.learn.calibration.arm_terms import SHIFT, TURN, Term, further_terms, geometry_terms
from vcmm.task.response.poses import (
    PoseReadings,
    TrackerPlacement,
    departures,
    nuisance_columns,
    settle_placement,
    stack_rows,
    tool_frames,
    weights,
)

STEPS, STILL = 40, 1e-9  # of Gauss-Newton; step, mm and rad, at which it rests
STRONG = 3.0  # nats by which a further term must win: "strong", Kass & Raftery (1995)


@dataclass(frozen=True, eq=False)
class ArmFit:
    """terms: those that were kept, with theta and covariance (placing projected out). placement and covariance are of the recordings in
    order. residual per recording: positions (n, 3) mm, orientations (n, 3) rad or None. u: of one coordinate, from the scatter.
    """

    machine: Machine
    nominal: Machine
    recordings: tuple[PoseReadings, ...]
    terms: tuple[Term, ...]
    theta: Array
    covariance: Array
    placements: tuple[TrackerPlacement, ...]
    residual: tuple[tuple[Array, Array | None], ...]
    u: tuple[float, float]
    redundant: tuple[Redundant, ...]
    press: float
    log_evidence: float

    def values(self, term: Term) -> tuple[Array, Array]:
        """Return numbers of a term and their standard uncertainties."""
        start = sum(t.size for t in self.terms[: self.terms.index(term)])
        part = slice(start, start + term.size)
        return self.theta[part], np.sqrt(np.diag(self.covariance)[part])

    @property
    def rms(self) -> tuple[float, float]:
        """Rms of all coordinates: mm, rad (0 without orientations)."""
        turned = [o for _, o in self.residual if o is not None]
        return _rms(np.concatenate([p for p, _ in self.residual])), _rms(
            np.concatenate(turned)
        ) if turned else 0.0


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def machine_with(nominal: Machine, terms: Sequence[Term], theta: Array) -> Machine:
    """Return the nominal machine with the numbers theta of the terms."""
    effects, k = [], 0
    for term in terms:
        effects.append(term.with_values(theta[k : k + term.size]))
        k += term.size
    return replace(nominal, effects=(*nominal.effects, *effects), large_errors=True)


def fit_arm(recordings: Sequence[PoseReadings], nominal: Machine) -> ArmFit:
    """Fit the geometry, then further terms one after the other while they pay: by evidence (Schwarz, STRONG nats) and by poses left out.

    Raises ModelLimit where the poses are fewer than what is to be found.
    """
    for poses in recordings:
        check_nominal(poses, nominal)
    best = fit_terms(recordings, nominal, geometry_terms(nominal))
    left = further_terms(nominal)
    while left:
        gains, same = _screen(best, left)
        best = replace(best, redundant=(*best.redundant, *same))
        gone = {r.name for r in same}
        left = [t for t in left if t.name not in gone]
        worth = [t for t in sorted(left, key=lambda t: -gains[t.name]) if gains[t.name] > STRONG]
        if not worth:
            break
        redundant = best.redundant
        trial = fit_terms(recordings, nominal, [*_all_terms(best), worth[0]], best)
        left.remove(worth[0])
        if trial.log_evidence > best.log_evidence + STRONG and trial.press < best.press:
            best = replace(
                trial, redundant=tuple({r.name: r for r in (*redundant, *trial.redundant)}.values())
            )
    return best


def check_nominal(poses: PoseReadings, nominal: Machine) -> None:
    """Raises UsageError where the nominal arm misses the poses by more than links and zero positions are believed to be off: every joint by TURN at the
    reach of the arm and by SHIFT, added up as independent.
    """
    frames = tool_frames(nominal, poses.run)
    alone = replace(poses, orientation=None)
    miss = _rms(departures(alone, frames, settle_placement(alone, frames))[0])
    reach = float(np.linalg.norm(frames.shift - frames.shift.mean(axis=0), axis=1).max())
    most = len(nominal.chain.tool) ** 0.5 * (SHIFT + TURN * max(reach, 1.0))
    if miss > most:
        raise UsageError(
            f"{poses.name}: the nominal arm misses the positions by {miss:.3g} mm (rms), and joints that are off by {TURN * 1e3:.0f} mrad and links by {SHIFT:g} mm would "
            f"explain {most:.3g} mm; check the order and the unit of the joint columns, the direction and centre of every joint, and that the files hold the same poses"
        )
    turned = poses.orientation is not None
    off = departures(poses, frames, settle_placement(poses, frames))[1] if turned else None
    if off is not None and _rms(off) > len(nominal.chain.tool) ** 0.5 * TURN:
        raise UsageError(
            f"{poses.name}: positions fit the nominal arm to {miss:.3g} mm, but orientations miss by {_rms(off) * 1e3:.3g} mrad (rms); check what their columns "
            "are with [poses] orientation_as (the order of Euler angles, wxyz or xyzw), or leave them out"
        )


def _screen(fit: ArmFit, terms: Sequence[Term]) -> tuple[dict[str, float], list[Redundant]]:
    """Return the nats by which each further term would win beside a fit, all else of first order (likelihood of the best amount, less
    Schwarz' price); and those
    with the same effect as a term of the fit.
    """
    problem = _Problem(fit.recordings, fit.nominal, [*fit.terms, *terms])
    free, of_terms = problem.columns(fit.placements, fit.u)
    size = len(fit.theta)
    fitted_columns = np.column_stack([free, of_terms[:, :size]])
    labels = ["tracker or target"] * free.shape[1] + [t.name for t in fit.terms for _ in range(t.size)]
    q = orthonormal(fitted_columns)
    rest = np.concatenate([stack_rows(p, o, fit.u) for p, o in fit.residual])
    gains, same, k = {}, [], size
    for term in terms:
        block = of_terms[:, k : k + term.size]
        k += term.size
        left = block - q @ (q.T @ block)
        if np.linalg.norm(left) < SAME_COLUMN_SHARE * np.linalg.norm(block):
            same.append(Redundant(term.name, same_as(block[:, 0], fitted_columns, labels)))
        part = orthonormal(left) if np.any(left) else left
        won = min(float(np.sum((part.T @ rest) ** 2)) / float(rest @ rest), 1.0 - 1e-12)
        gains[term.name] = -0.5 * len(rest) * np.log1p(-won) - 0.5 * term.size * np.log(len(rest))
    return gains, same


def _all_terms(fit: ArmFit) -> list[Term]:
    """Return all geometry, and the further terms that a fit has."""
    geometry = geometry_terms(fit.nominal)
    names = {t.name for t in geometry}
    return [*geometry, *(t for t in fit.terms if t.name not in names)]


def fit_terms(
    recordings: Sequence[PoseReadings], nominal: Machine, terms: Sequence[Term], start: ArmFit | None = None
) -> ArmFit:
    """Fit these terms. start: initial values."""
    placing = (
        [settle_placement(r, tool_frames(nominal, r.run)) for r in recordings]
        if start is None
        else list(start.placements)
    )
    kept, redundant = choose_terms(recordings, nominal, terms, placing)
    size = sum(t.size for t in kept)
    observations = sum(r.n * (3 if r.orientation is None else 6) for r in recordings)
    if observations <= size + _free(recordings):
        raise ModelLimit(
            f"{observations} coordinates of poses do not tell {size + _free(recordings)} numbers apart; measure more poses (40 or more, "
            "all joints over most of their travel)"
        )
    problem = _Problem(recordings, nominal, kept)
    theta = np.zeros(size) if start is None else _known(start, kept)
    u = weights(recordings[0]) if start is None else start.u
    for _ in range(3):  # weights of position and orientation follow from their scatter
        theta, placing = problem.solve(theta, placing, u)
        u = problem.scatter(theta, placing, u)
    return problem.result(theta, placing, u, redundant)


def _known(start: ArmFit, kept: Sequence[Term]) -> Array:
    have = {t.name: start.values(t)[0] for t in start.terms}
    return np.concatenate([have.get(t.name, np.zeros(t.size)) for t in kept])


def _free(recordings: Sequence[PoseReadings]) -> int:
    return sum(9 if r.orientation is None else 12 for r in recordings)


def choose_terms(
    recordings: Sequence[PoseReadings],
    nominal: Machine,
    terms: Sequence[Term],
    placing: Sequence[TrackerPlacement],
) -> tuple[list[Term], list[Redundant]]:
    """Return terms that poses separate from placing and from those before them; the others with those of the same effect. A term of two
    numbers is kept whole
    or not at all.
    """
    problem = _Problem(recordings, nominal, terms)
    nuisance, columns = problem.columns(placing, weights(recordings[0]))
    basis: list[Array] = []
    names = []
    for k in range(nuisance.shape[1]):
        left = beside(nuisance[:, k], basis)
        if left is not None:
            basis.append(left)
            names.append(k)
    kept: list[Term] = []
    taken = [nuisance[:, names]]
    labels = ["tracker or target"] * len(names)
    redundant, k = [], 0
    for term in terms:
        new: list[Array] = []
        mine = columns[:, k : k + term.size]
        k += term.size
        for j in range(term.size):
            left = beside(mine[:, j], [*basis, *new])
            if left is None:
                redundant.append(Redundant(term.name, same_as(mine[:, j], np.column_stack(taken), labels)))
                break
            new.append(left)
        else:
            kept.append(term)
            basis += new
            taken.append(mine)
            labels += [term.name] * term.size
    return kept, redundant


@dataclass(frozen=True, eq=False)
class _Problem:
    recordings: Sequence[PoseReadings]
    nominal: Machine
    terms: Sequence[Term]

    @property
    def prior(self) -> Array:
        """Prior precision 1 / most^2 of every number."""
        return np.array([1.0 / t.most**2 for t in self.terms for _ in range(t.size)])

    def columns(self, placing: Sequence[TrackerPlacement], u: tuple[float, float]) -> tuple[Array, Array]:
        """Return columns of placing (m, 9 or 12 per recording) and of the terms (m, k), over the uncertainties."""
        nuisances, of_terms = [], []
        for poses, place in zip(self.recordings, placing):
            run = self.nominal.prepare(_with_offset(poses.run, place.offset))
            frames = tool_frames(self.nominal, run)
            nuisances.append(stack_rows(*nuisance_columns(poses, frames, place), u))
            of_terms.append(self._term_columns(poses, run, place, u))
        m = sum(len(n) for n in nuisances)
        free = np.zeros((m, sum(n.shape[1] for n in nuisances)))
        row = column = 0
        for block in nuisances:
            free[row : row + len(block), column : column + block.shape[1]] = block
            row, column = row + len(block), column + block.shape[1]
        return free, np.concatenate(of_terms)

    def _term_columns(
        self, poses: PoseReadings, run: Run, place: TrackerPlacement, u: tuple[float, float]
    ) -> Array:
        moved = [t.motion(run, k, self.nominal) for t in self.terms for k in range(t.size)]
        if not moved:
            return np.zeros((poses.n * (3 if poses.orientation is None else 6), 0))
        both = np.stack(moved, axis=2)
        shift = np.einsum("ij,njk->nik", place.turn, both[:, :3])
        turn = np.einsum("ij,njk->nik", place.turn, both[:, 3:])
        return stack_rows(shift, None if poses.orientation is None else turn, u)

    def rest(self, theta: Array, placing: Sequence[TrackerPlacement]) -> list[tuple[Array, Array | None]]:
        machine = machine_with(self.nominal, self.terms, theta)
        return [departures(r, tool_frames(machine, r.run), p) for r, p in zip(self.recordings, placing)]

    def solve(
        self, theta: Array, placing: list[TrackerPlacement], u: tuple[float, float]
    ) -> tuple[Array, list[TrackerPlacement]]:
        """Solve by Gauss-Newton until convergence."""
        free, of_terms = self.columns(placing, u)
        for step in range(STEPS):
            if step in (1, 3):  # the target sits elsewhere than at first
                free, of_terms = self.columns(placing, u)
            rest = np.concatenate([stack_rows(p, o, u) for p, o in self.rest(theta, placing)])
            change, moves = self._step(free, of_terms, rest, theta)
            theta = theta + change
            placing = self._step_placements(placing, moves)
            if max(np.abs(change).max(initial=0.0), np.abs(moves).max(initial=0.0)) < STILL:
                break
        return theta, placing

    def _step(self, free: Array, of_terms: Array, rest: Array, theta: Array) -> tuple[Array, Array]:
        root = np.sqrt(self.prior)
        top = np.concatenate([free, of_terms], axis=1)
        below = np.concatenate([np.zeros((len(theta), free.shape[1])), np.diag(root)], axis=1)
        a, b = np.concatenate([top, below]), np.concatenate([rest, -root * theta])
        size = np.linalg.norm(a, axis=0)
        size[size == 0] = 1.0
        step = np.linalg.lstsq(a / size, b, rcond=1e-10)[0] / size
        return step[free.shape[1] :], step[: free.shape[1]]

    def _step_placements(self, placing: Sequence[TrackerPlacement], moves: Array) -> list[TrackerPlacement]:
        out, k = [], 0
        for poses, place in zip(self.recordings, placing):
            size = 9 if poses.orientation is None else 12
            out.append(place.after_step(moves[k : k + size]))
            k += size
        return out

    def scatter(
        self, theta: Array, placing: Sequence[TrackerPlacement], u: tuple[float, float]
    ) -> tuple[float, float]:
        """Return the standard deviation of a coordinate of position and of orientation, for the fitted numbers; a stated u is kept where it is
        larger. The numbers are counted off both kinds by their share of the coordinates.
        """
        rest = self.rest(theta, placing)
        position = np.concatenate([p for p, _ in rest])
        turned = [o for _, o in rest if o is not None]
        m = position.size + sum(o.size for o in turned)
        share = m / max(m - self.rank, 1)
        stated = self.recordings[0].u
        rms = _rms(position) * share**0.5
        angle = _rms(np.concatenate(turned)) * share**0.5 if turned else u[1]
        return max(rms, stated[0], 1e-9), max(angle, stated[1], 1e-12)

    @property
    def rank(self) -> int:
        return sum(t.size for t in self.terms) + _free(self.recordings)

    def result(
        self,
        theta: Array,
        placing: Sequence[TrackerPlacement],
        u: tuple[float, float],
        redundant: Sequence[Redundant],
    ) -> ArmFit:
        free, of_terms = self.columns(placing, u)
        rest = self.rest(theta, placing)
        flat = np.concatenate([stack_rows(p, o, u) for p, o in rest])
        basis = orthonormal(free)
        visible = of_terms - basis @ (basis.T @ of_terms)
        covariance = np.asarray(np.linalg.inv(visible.T @ visible + np.diag(self.prior)), dtype=float)
        left_out = self._left_out(basis, visible, flat, covariance)
        m = len(flat)
        cost = float(flat @ flat)
        return ArmFit(
            machine=machine_with(self.nominal, self.terms, theta),
            nominal=self.nominal,
            recordings=tuple(self.recordings),
            terms=tuple(self.terms),
            theta=theta,
            covariance=covariance,
            placements=tuple(placing),
            residual=tuple(rest),
            u=u,
            redundant=tuple(redundant),
            press=float(np.sqrt(left_out @ left_out / m)) * u[0],
            log_evidence=-0.5 * cost - m_log(rest, u) - 0.5 * len(theta) * np.log(m),
        )

    def _left_out(self, basis: Array, visible: Array, flat: Array, covariance: Array) -> Array:
        """Return the residuals of every pose predicted from the others (Allen, Technometrics 16 (1974) 125): (1 - H)^-1 r by pose."""
        root = visible @ np.linalg.cholesky(covariance)
        half = np.concatenate([basis, root], axis=1)
        out, start = np.empty_like(flat), 0
        for poses in self.recordings:
            kinds = 1 if poses.orientation is None else 2
            for i in range(poses.n):
                rows = np.concatenate([start + 3 * poses.n * k + 3 * i + np.arange(3) for k in range(kinds)])
                block = np.eye(len(rows)) - half[rows] @ half[rows].T
                out[rows] = np.linalg.solve(block, flat[rows])
            start += 3 * poses.n * kinds
        return out


def m_log(rest: Sequence[tuple[Array, Array | None]], u: tuple[float, float]) -> float:
    """Sum of ln u over all coordinates."""
    return sum(p.size * np.log(u[0]) + (0 if o is None else o.size * np.log(u[1])) for p, o in rest)


def _with_offset(run: Run, offset: Array) -> Run:
    columns = {k: v for k, v in run.columns.items() if not k.startswith("tip_")}
    return Run(run.position, np.tile(offset, (run.n, 1)), columns, run.labels, run.series)
