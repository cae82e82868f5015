"""Result of a calibration: errors with their joint covariance, unidentified combinations, residuals.

How much larger a touch probe reads all round than stated: ball of the stylus, less its mean pre-travel, with half of a sphere's diameter.

The nuisance `radius` of a touch is one number per label along the outward normal. It is found beside the errors that were identified, the own
errors of the probe and all other nuisance by generalised least squares, so that its u counts what they are not known to:

    [S B, C, N]' W [S B, C, N] + diag(0, 1, 0)      S errors (their free shapes B), C own errors in units of their u, N nuisance

It is + where surfaces were indicated further out of the material than they are. The probe goes on by its pre-travel p after it has met a surface, so
it reads -p; a ball that is larger by d in diameter than stated stops earlier and reads +d/2.
Source: JCGM 102:2011 (generalised least squares).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.readable import Readable, Reading
from vcmm.core.run import Array
from vcmm.core.views import draw
from vcmm.learn.calibration.identifiability import Identifiability, is_angle
from vcmm.learn.calibration.model import ErrorModel
from vcmm.learn.calibration.readings import Readings
from vcmm.learn.calibration.rotary import harmonics
from vcmm.learn.calibration.solve import Before, ErrorPosterior, columns_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FINE = 121  # positions of a picture


@dataclass(frozen=True, eq=False)
class Calibration(Readable):
    """machine: earlier knowledge (structure, axes, prior errors). kept_model: the errors that are identified, as a model.

    theta (kept_model.size,), covariance: of the kept errors, mm and rad. assumed, warnings: sentences. interpolation: its name.
    """

    machine: Machine
    kept_model: ErrorModel
    theta: Array
    covariance: Array
    posterior: ErrorPosterior
    identified: Identifiability
    readings: tuple[Readings, ...]
    warnings: tuple[str, ...]
    interpolation: str = "spline"
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        names, left = list(self.kept_model.names), 1e3 * rms(self.residual)
        shown = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
        return (
            f"<Calibration: {shown}; residuals {left:.3g} µm rms, condition {self.identified.condition:.3g}>"
        )

    @property
    def residual(self) -> Array:
        """All residuals of lengths (not of angles), mm."""
        residuals = [e for r, e in zip(self.readings, self.posterior.residual) if r.recording.kind != "angle"]
        return np.concatenate(residuals) if residuals else np.zeros(0)

    def band(self, name: str) -> tuple[Array, Array, Array]:
        """Return (nodes, value, u) of one identified error, mm or rad; a squareness has one node, nan."""
        part = self.kept_model.slices[name]
        nodes = self.kept_model.labels[1][part]
        return nodes, self.theta[part], np.sqrt(np.diag(self.covariance)[part])

    def along(self, name: str) -> tuple[Array, Array, Array]:
        """Return (positions, value, u) of one identified curve between its nodes too, as the machine file interpolates; mm or rad."""
        part, curve = (
            self.kept_model.slices[name],
            next(c for c in self.kept_model.curves if c.component == name),
        )
        q = np.unique(np.concatenate([np.linspace(curve.nodes[0], curve.nodes[-1], FINE), curve.nodes]))
        weights = curve.weights(q)
        u = np.sqrt(np.einsum("ij,jk,ik->i", weights, self.covariance[part, part], weights))
        return q, weights @ self.theta[part], u

    def plot(self, name: str, ax: Any = None) -> Axes:
        """Plot one identified error curve with its band. Raises KeyError for a name that is not in `identified.names`."""
        drawn: Axes = draw(self, name, ax)
        return drawn

    def probe_radii(self) -> list[dict[str, Any]]:
        """Return, for touches, how much further out than stated surfaces read all round, um; see `probe_radii`."""

        return probe_radii(self.readings, self.posterior, self.identified.names)

    def figures(self) -> list[Mapping[str, object]]:
        """Return one row per identified error: size and uncertainty, um or urad."""
        out: list[Mapping[str, object]] = []
        for name in self.kept_model.names:
            _, value, u = self.band(name)
            turns = is_angle(name)
            scale = 1e6 if turns else 1e3
            row: dict[str, object] = {"error": name, "unit": "urad" if turns else "um"}
            if len(value) > 1:
                row |= {"low": float(value.min() * scale), "high": float(value.max() * scale)}
            else:
                row |= {"value": float(value[0] * scale)}
            row["u"] = float(np.sqrt((u**2).mean()) * scale)
            curve = next((c for c in self.kept_model.curves if c.component == name), None)
            if curve is not None and curve.periodic:
                part = self.kept_model.slices[name]
                waves = harmonics(curve, value, self.covariance[part, part])
                row["harmonics"] = [
                    {"order": int(h["order"]), "amplitude": h["amplitude"] * scale, "u": h["u"] * scale}
                    for h in waves
                ]
            out.append(row)
        return out


def rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean())) if len(values) else 0.0


NOTHING_FOUND_SHARE = 1e-9  # of the largest eigenvalue: what is below is not found


def probe_radii(
    parts: Sequence[Readings], post: ErrorPosterior, identified: Sequence[str]
) -> list[dict[str, object]]:
    """Return, per recording of touches and copy of its nuisance `radius`, input, value and u in um. Those that nothing separates from the
    errors are left out."""
    named = [
        (i, k, n) for i, p in enumerate(parts) for k, n in enumerate(p.names) if n.split("[")[0] == "radius"
    ]
    named = [row for row in named if parts[row[0]].recording.kind == "probe"]
    if not named:
        return []
    columns, names = columns_of(parts, Before.nothing(post.model))
    shapes = _shapes(post.model, identified)
    before = shapes.shape[1] + len(names)
    starts = before + np.cumsum([0, *(p.nuisance.shape[1] for p in parts)])
    gram, right = np.zeros((starts[-1], starts[-1])), np.zeros(starts[-1])
    for part, block, noise, start in zip(parts, columns, post.noise, starts):
        x = np.zeros((part.m, starts[-1]))
        x[:, : shapes.shape[1]] = block[:, : post.model.size] @ shapes
        x[:, shapes.shape[1] : before] = block[:, post.model.size :]
        x[:, start : start + part.nuisance.shape[1]] = part.nuisance
        x = x / (noise.u * part.u)[:, None]
        gram += x.T @ x
        right += x.T @ (part.value / (noise.u * part.u))
    gram[shapes.shape[1] : before, shapes.shape[1] : before] += np.eye(len(names))
    solution, covariance, shares = _solve(gram, right)
    out: list[dict[str, object]] = []
    for i, k, name in named:
        at = starts[i] + k
        if shares[at] > 1 - 1e-6:
            u = float(np.sqrt(covariance[at, at]))
            out.append(
                {
                    "input": f"{parts[i].recording.name}: {name}",
                    "value_um": float(solution[at]) * 1e3,
                    "u_um": u * 1e3,
                }
            )
    return out


def _shapes(model: ErrorModel, names: Sequence[str]) -> Array:
    """Return free shapes of the curves of the named errors, and unit columns of their pairs, (size, k)."""
    blocks = []
    for curve in (c for c in model.curves if c.component in names):
        full = np.zeros((model.size, curve.free.shape[1]))
        full[model.slices[curve.component]] = curve.free
        blocks.append(full)
    for pair in (p for p in model.pairs if p in names):
        full = np.zeros((model.size, 1))
        full[model.slices[pair]] = 1.0
        blocks.append(full)
    return np.concatenate(blocks, axis=1) if blocks else np.zeros((model.size, 0))


def _solve(gram: Array, right: Array) -> tuple[Array, Array, Array]:
    """Solve least squares with columns scaled to unit length: return values, covariance, and of each number the share that is determined."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    values, ways = np.linalg.eigh(gram / np.outer(size, size))
    kept = values > NOTHING_FOUND_SHARE * values[-1]
    half = ways[:, kept] / np.sqrt(values[kept])
    covariance = (half @ half.T) / np.outer(size, size)
    share = (ways[:, kept] ** 2).sum(axis=1)
    return covariance @ right, covariance, share
