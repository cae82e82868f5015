"""Tip form: the stylus ball is not round."""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial
from typing import Any

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Trade, Typical, WithResponse, Words
from vcmm.core.effect import Effect, along, at, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run

SIZES = {5: 2, 12: 3, 21: 4}  # number of coefficients -> highest degree


@dataclass(frozen=True, eq=False)
class TipForm(Effect, WithResponse):
    """Sum of c_j Y_j(n) along n: spherical harmonics of the outward normal of degree 2 (5 terms), 3 (12) or 4 (21).

    Degree 0 is the radius and degree 1 the offset of the tip, which have effects of their own. Order within a degree:
    sin(l phi) ... sin(phi), 1, cos(phi) ... cos(l phi). Scaled to mean square 1 over the sphere, so that rms is the
    root of the sum of c_j^2. Where the ball is high, too much material is indicated.
    """

    name = "tip_form"
    diagnosis = ForDiagnosis(
        shared_physics="lobes",
    )
    per = "stylus"
    needs = ("nx", "ny", "nz")
    about = About(
        cites="ISO 10360-5: form error of the probing system on the test sphere; expansion in spherical harmonics",
        trade=Trade(
            "form of the tip {where}", "a rounder tip, or a better form of the probing system (P_Form)"
        ),
        words=Words(
            seen="the tip is not round ({rms})",
            causes="wear, a flat or dirt",
            confirm="turn the stylus by 90 degrees and touch a sphere again",
        ),
    )
    stylus: str = at("", "stylus name; empty = all")
    coefficients: Any = param(
        lambda: np.zeros(5),
        "um",
        "height of each harmonic, degree 2 first",
        shape="(powers,)",
        typical=Typical(0.1 * UM, "ball grade 5: 0.13 um out of round; worn or dirty: more"),
        lengths=(5, 12),
    )

    def __post_init__(self) -> None:
        if len(self.coefficients) not in SIZES:
            raise UsageError(f"{self.id}: {len(self.coefficients)} coefficients; give 5, 12 or 21")

    @property
    def link(self) -> str:
        return "reading"

    @property
    def rms(self) -> float:
        """Root mean square over the whole sphere, mm."""
        return float(np.linalg.norm(np.asarray(self.coefficients, dtype=float)))

    def error_motion(self, run: Run) -> Array:
        c = np.asarray(self.coefficients, dtype=float)
        height = harmonics(run.normal, SIZES[len(c)]) @ c
        return along(run, run.normal, height * run.label_mask("stylus", self.stylus))

    def response(self, name: str, run: Run) -> Array:
        height = (
            harmonics(run.normal, SIZES[len(self.coefficients)])
            * run.label_mask("stylus", self.stylus)[:, None]
        )
        out = np.zeros((run.n, 6, height.shape[1]))
        out[:, :3] = run.normal[:, :, None] * height[:, None, :]
        return out

    def projection(self, name: str, run: Run, weights: Array) -> Array:
        """Project the harmonics directly, without a step for each of them: a search of places evaluates hundreds of poses."""
        share = (weights[:, :3] * run.normal).sum(axis=1) * run.label_mask("stylus", self.stylus)
        return share[:, None] * harmonics(run.normal, SIZES[len(self.coefficients)])


def harmonics(n: Array, degree: int) -> Array:
    """Return the real spherical harmonics of degree 2 to `degree` at unit vectors n (k, 3): (k, terms), mean square 1."""
    from scipy.special import lpmv

    azimuth, height = np.arctan2(n[:, 1], n[:, 0]), np.clip(n[:, 2], -1.0, 1.0)
    out = []
    for l in range(2, degree + 1):  # noqa: E741 - the usual letter
        for m in range(-l, l + 1):
            k = abs(m)
            size = np.sqrt((2 * l + 1) * (2 if m else 1) * factorial(l - k) / factorial(l + k))
            turn = np.cos(k * azimuth) if m >= 0 else np.sin(k * azimuth)
            out.append(
                (-1) ** k * size * lpmv(k, l, height) * turn
            )  # lpmv has the sign of Condon and Shortley
    return np.stack(out, axis=1)
