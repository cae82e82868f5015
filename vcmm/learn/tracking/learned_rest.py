"""Learn missing effects without a name from recordings in the order of their dates, and only where they predict the later ones.

    residual = A v + N (nuisance) + e,   v ~ N(0, s^2 K),   cov e = the covariance by the machine file for these rows, and their noise

A: response of a learned residual of one component to its values (vcmm.physics.catalogue.learned_residual). Whitened and without nuisance, L = sum A'A and b =
sum A'y give the evidence against "nothing is missing" in closed form (Rasmussen & Williams, Gaussian Processes (2006), 2.3):

    gain(s) = b' (L + (s^2 K)^-1)^-1 b / 2 - ln det(I + s^2 K L) / 2

Component, column and s are those of the highest gain on the earlier half. The gate: the gain of all recordings less that of the earlier half is the logarithm of how much more
probable the later ones are with the term than without; below ln GATE nothing is written.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import Effect, typical
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.result import rms
from vcmm.learn.calibration.solve import nuisance_basis
from vcmm.learn.diagnosis.problem import Problem, make_problem
from vcmm.physics import ALL
from vcmm.task.response.recording import Recording

GATE = 20.0  # times more probable: the usual bound of strong evidence (H. Jeffreys, Theory of Probability (1961), app. B: 10 to 30)
NODES, LEVELS = 9, 5
SIZES = tuple(2.0**k for k in range(-4, 5))  # of s, usual sizes
FEWEST = 4  # recordings
VARIES = 0.5  # of a column, in its unit, over all recordings: below it nothing can be learned over it


@dataclass(frozen=True, eq=False)
class LearnedRest:
    """effect: with its values; covariance (k, k) of them; gains in nats on the earlier and, predicted, on the later recordings.

    before, after: rms over the noise of the residuals of the later recordings, without the term and predicted by the earlier ones. rows
    (k,): information on each value, rows of
    one standard noise. has_passed: whether it may be written.
    """

    effect: Effect
    covariance: Array
    gain: float
    later_gain: float
    before: float
    after: float
    size: float
    earlier: tuple[str, ...]
    later: tuple[str, ...]
    REFERENCE = (
        "all recordings were held against the machine file as it was given, not against the state of the day: a wear, season or jump that track names is "
        "not taken out before, and the file that is written is that machine file with the term"
    )

    @property
    def has_passed(self) -> bool:
        return self.later_gain > float(np.log(GATE)) and self.after < self.before

    @property
    def sentence(self) -> str:
        """The result in words, with the figures of the gate."""
        odds = f"e^{self.later_gain:.0f} times as probable with it"
        text = f"{len(self.later)} later recordings are {odds}; rms over their noise {self.before:.2f} without it, {self.after:.2f} predicted from the earlier {len(self.earlier)}"
        if self.has_passed:
            return f"{self.effect.id}: {text}"
        return f"nothing that predicts later recordings was found (best: {self.effect.id}: {text}; expected at least {GATE:g} times as probable), so nothing is written"

    def to_dict(self) -> dict[str, Any]:
        """Return the document as in vcmm.track/1: canonical units (mm or rad)."""
        effect = vars(self.effect)
        return {
            "passed": self.has_passed, "said": self.sentence, "input": f"{self.effect.id}.values", "component": effect["component"],
            "column": effect["column"] or None, "kernel": effect["kernel"], "gain": self.gain, "foretold": self.later_gain,
            "rms_before": self.before, "rms_after": self.after, "earlier": list(self.earlier), "later": list(self.later),
            "nodes": np.asarray(effect["nodes"]).tolist(), "levels": effect["levels"] or None,
            "values": np.asarray(effect["values"]).tolist(), "u": np.sqrt(np.diag(self.covariance)).tolist(),
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Rows:
    """One recording: problem, root of its covariance, basis of its nuisance, whitened residual without it."""

    problem: Problem
    root: Array
    basis: Array
    y: Array

    def columns(self, effect: Effect) -> Array:
        x = _divide(self.root, self.problem.observer.of_parameter(effect, "values"))
        return np.asarray(x - self.basis @ (self.basis.T @ x))


def learn_rest(machine: Machine, recordings: Sequence[tuple[str, Recording]]) -> LearnedRest:
    """Return the learned residual of the highest gain. recordings: (name, recording) by date. Raises UsageError for fewer than FEWEST, or
    where none can be placed."""
    if len(recordings) < FEWEST:
        raise UsageError(
            f"a learned residual is tested on later recordings: expected {FEWEST} or more recordings, found {len(recordings)}"
        )
    rows = [_rows(r, machine) for _, r in recordings]
    half = (len(rows) + 1) // 2
    best: tuple[float, float, Effect] | None = None
    for effect in _candidates(machine, rows):
        information, b = _sums(effect, rows[:half])
        if not information.any():
            continue
        for size in SIZES:
            gain = _gain(effect, size, information, b)
            if best is None or gain > best[0]:
                best = gain, size, effect
    if best is None:
        raise UsageError(
            "no component error of a linear axis shows in these recordings, so that nothing can be learned"
        )
    return _judge(best, rows, half, [name for name, _ in recordings])


def _judge(best: tuple[float, float, Effect], rows: list[_Rows], half: int, names: list[str]) -> LearnedRest:
    gain, size, effect = best
    first, whole = _sums(effect, rows[:half]), _sums(effect, rows)
    foretold = _gain(effect, size, *whole) - gain
    early, _ = _posterior(effect, size, *first)
    value, covariance = _posterior(effect, size, *whole)
    without = np.concatenate([r.y for r in rows[half:]])
    left = np.concatenate([r.y - r.columns(effect) @ early for r in rows[half:]])
    noise = max(1.0, rms(np.concatenate([r.y - r.columns(effect) @ value for r in rows])))
    nodes = np.asarray(vars(effect)["nodes"])
    length = 2.0 * np.ptp(nodes) / (len(nodes) - 1)
    words = f"squared exponential over {length:.4g} mm of {effect.link}, size {size * typical(effect, 'values') * 1e3:.3g} um or mrad"
    made: Any = effect
    changed: Effect = replace(
        made,
        values=value,
        kernel=words,
        learned=f"from {len(names)} recordings until {names[-1]}; no physics",
    )
    return LearnedRest(
        changed,
        noise**2 * covariance,
        gain,
        foretold,
        rms(without),
        rms(left),
        size,
        tuple(names[:half]),
        tuple(names[half:]),
    )


def _rows(recording: Recording, machine: Machine) -> _Rows:
    problem = make_problem(recording, machine)
    calibration = problem.calibration
    root: Array = problem.u
    if calibration.shape[1]:
        root = np.asarray(np.linalg.cholesky(np.diag(problem.u**2) + calibration @ calibration.T))
    basis = nuisance_basis(_divide(root, problem.nuisance))
    y = _divide(root, problem.residual[:, None])[:, 0]
    return _Rows(problem, root, basis, y - basis @ (basis.T @ y))


def _divide(root: Array, columns: Array) -> Array:
    if root.ndim == 1:
        return np.asarray(columns / root[:, None])
    return np.asarray(np.linalg.solve(root, columns))


def _candidates(machine: Machine, rows: list[_Rows]) -> list[Effect]:
    """Return every component error of every linear axis that moves, alone and over every column that all recordings have and that varies."""
    kind: Any = _kind()
    out: list[Effect] = []
    runs = [r.problem.run for r in rows]
    shared = set.intersection(*(set(r.columns) for r in runs))
    over = [
        c
        for c in sorted(shared)
        if c.startswith("temp_") and np.ptp(np.concatenate([r.columns[c] for r in runs])) > VARIES
    ]
    for axis in machine.axes:
        if is_rotary(axis) or not all(axis in r.position for r in runs):
            continue
        q = np.concatenate([r.position[axis] for r in runs])
        if np.ptp(q) < 1e-3:
            continue
        nodes = np.linspace(float(q.min()), float(q.max()), NODES)
        for letter in "XYZABC":
            place = {"component": f"E{letter}{axis}", "nodes": nodes}
            out.append(kind(**place, values=np.zeros(NODES)))
            for column in over:
                t = np.concatenate([r.columns[column] for r in runs])
                levels = " ".join(
                    f"{v:.6g}" for v in np.linspace(np.floor(t.min()), np.ceil(t.max()), LEVELS)
                )
                out.append(kind(**place, column=column, levels=levels, values=np.zeros(NODES * LEVELS)))
    return out


def _kind() -> type[Effect]:
    """Return the effect whose values have a prior of their own. Raises UsageError where its file was taken away."""
    kind = next((k for k in ALL if hasattr(k, "prior_shape")), None)
    if kind is None:
        raise UsageError("no effect of this installation can be learned")
    return kind


def _sums(effect: Effect, rows: Sequence[_Rows]) -> tuple[Array, Array]:
    """Return L and b of the docstring of this module."""
    k = np.size(vars(effect)["values"])
    information, b = np.zeros((k, k)), np.zeros(k)
    for block in rows:
        a = block.columns(effect)
        information += a.T @ a
        b += a.T @ block.y
    return information, b


def _prior_root(effect: Effect, size: float) -> Array:
    """Return a root of s^2 K without the part that a convention removes at each level: the mean, and of a straightness the line, which is
    squareness."""
    shape = effect.prior_shape()  # type: ignore[attr-defined]
    nodes, where = np.asarray(vars(effect)["nodes"], dtype=float), effect.where
    gone = [np.ones(len(nodes))] + ([nodes] if where[1] in "XYZ" and where[1] != where[2] else [])
    basis = np.linalg.qr(np.stack(gone, axis=1))[0]
    free = np.kron(np.eye(len(shape) // len(nodes)), np.eye(len(nodes)) - basis @ basis.T)
    scale = size * typical(effect, "values")
    return np.asarray(scale * free @ np.linalg.cholesky(shape + 1e-10 * np.eye(len(shape))))


def _gain(effect: Effect, size: float, information: Array, b: Array) -> float:
    """Return ln of the evidence over that of no term: with v = R z, z standard normal, I + R' L R."""
    root = _prior_root(effect, size)
    inner = np.eye(len(b)) + root.T @ information @ root
    lower = np.linalg.cholesky(inner)
    half = np.linalg.solve(lower, root.T @ b)
    return float(0.5 * half @ half - np.log(np.diag(lower)).sum())


def _posterior(effect: Effect, size: float, information: Array, b: Array) -> tuple[Array, Array]:
    """Return the mean (k,) and covariance (k, k) of the values."""
    root = _prior_root(effect, size)
    inner = np.eye(len(b)) + root.T @ information @ root
    mean = root @ np.linalg.solve(inner, root.T @ b)
    return mean, np.asarray(root @ np.linalg.solve(inner, root.T))
