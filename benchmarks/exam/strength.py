"""delta = ||W e||: the concealed effect after whitening with noise and calibration covariance, nuisance projected out.

Sigma = s^2 nu/(nu-2) I  +  sum over components u^2 (c c^T) o exp(-(q_i - q_j)^2 / (2 l^2))  +  u_sq^2 c c^T
c: what one unit of that error changes in the observations, by finite differences of the exact chain.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array, Errors
from benchmarks.exam.observe import Hidden, nuisance_columns, observed, tip_motion

STEP = 1e-5  # mm or rad
FAR = 100.0


@dataclass(frozen=True, eq=False)
class Whitener:
    lower: Array  # Cholesky factor of Sigma
    basis: Array  # orthonormal basis of the whitened nuisance

    def apply(self, values: Array) -> Array:
        from scipy.linalg import solve_triangular

        white = solve_triangular(self.lower, values, lower=True)
        return np.asarray(white - self.basis @ (self.basis.T @ white))

    def delta(self, effect: Array) -> float:
        return float(np.linalg.norm(self.apply(effect)))


def calibration_columns(design: Design) -> list[tuple[str, str, Array]]:
    """(component, axis, c (m,)) of the 18 + 3 errors of the linear axes."""
    out = []
    n = design.rows
    none = Hidden()
    for axis in design.machine.linear:
        for i, word in enumerate(("EX", "EY", "EZ", "EA", "EB", "EC")):
            six = np.zeros((n, 6))
            six[:, i] = STEP
            out.append(
                (word + axis, axis, observed(design, tip_motion(design, Errors({axis: six})), none) / STEP)
            )
    for pair in ("A0Z", "B0Z", "C0Y"):
        c = observed(design, tip_motion(design, Errors(square={pair: STEP})), none) / STEP
        out.append((pair, "", c))
    return out


def covariance(design: Design, calibration: bool = True) -> Array:
    kind = design.machine
    per = 1 if design.normal is not None else 3
    m = design.rows * per
    total = np.eye(m) * kind.scale**2 * kind.dof / (kind.dof - 2)
    for word, axis, c in calibration_columns(design) if calibration else ():
        if axis:
            q = np.repeat(design.q[axis], per)
            near = np.exp(-((q[:, None] - q[None, :]) ** 2) / (2 * kind.length**2))
            total += kind.u[0 if word[1] in "XYZ" else 1] ** 2 * np.outer(c, c) * near
        else:
            total += kind.u[2] ** 2 * np.outer(c, c)
    return total


def whitener(design: Design, calibration: bool = True) -> Whitener:
    from scipy.linalg import cholesky, solve_triangular

    lower = cholesky(covariance(design, calibration), lower=True)
    white = solve_triangular(lower, nuisance_columns(design), lower=True)
    u, s, _ = np.linalg.svd(white, full_matrices=False)
    return Whitener(lower, u[:, s > 1e-9 * s.max(initial=1.0)])


def amplitude_for(delta: float, strength: Callable[[float], float], start: float = 1.0) -> float:
    """The amplitude at which `strength` is delta: secant steps on a nearly proportional curve.

    Raises ValueError when the design cannot see the effect, however large it may reasonably be (100 times `start`).
    """
    a = start
    for _ in range(8):
        seen = strength(a)
        if a == start and seen * FAR < delta:
            raise ValueError("this design cannot see the effect")
        if abs(seen / delta - 1) < 1e-3:
            break
        a *= delta / seen
    else:
        raise ValueError("this design sees the effect only where it is no longer small")
    return a
