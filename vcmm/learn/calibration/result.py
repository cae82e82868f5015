"""What a calibration found: errors with their joint covariance, what is not identified, residuals."""

from __future__ import annotations

from collections.abc import Mapping
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
from vcmm.learn.calibration.solve import ErrorPosterior

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FINE = 121  # positions of a picture


@dataclass(frozen=True, eq=False)
class Calibration(Readable):
    """machine: what was known before (structure, axes, prior errors). kept: the errors that are identified, as a model.

    theta (kept.size,), covariance: of these errors, mm and rad. assumed, warnings: sentences. interpolation: its name.
    """

    machine: Machine
    kept: ErrorModel
    theta: Array
    covariance: Array
    posterior: ErrorPosterior
    identified: Identifiability
    readings: tuple[Readings, ...]
    warnings: tuple[str, ...]
    interpolation: str = "spline"
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        names, left = list(self.kept.names), 1e3 * rms(self.residual)
        shown = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
        return (
            f"<Calibration: {shown}; residuals {left:.3g} µm rms, condition {self.identified.condition:.3g}>"
        )

    @property
    def residual(self) -> Array:
        """All residuals of lengths (not of angles), mm."""
        found = [e for r, e in zip(self.readings, self.posterior.residual) if r.recording.kind != "angle"]
        return np.concatenate(found) if found else np.zeros(0)

    def band(self, name: str) -> tuple[Array, Array, Array]:
        """(nodes, value, u) of one identified error, mm or rad; a squareness has one node, nan."""
        part = self.kept.slices[name]
        nodes = self.kept.labels[1][part]
        return nodes, self.theta[part], np.sqrt(np.diag(self.covariance)[part])

    def along(self, name: str) -> tuple[Array, Array, Array]:
        """(positions, value, u) of one identified curve between its nodes too, as the machine file interpolates; mm or rad."""
        part, curve = self.kept.slices[name], next(c for c in self.kept.curves if c.component == name)
        q = np.unique(np.concatenate([np.linspace(curve.nodes[0], curve.nodes[-1], FINE), curve.nodes]))
        weights = curve.weights(q)
        u = np.sqrt(np.einsum("ij,jk,ik->i", weights, self.covariance[part, part], weights))
        return q, weights @ self.theta[part], u

    def plot(self, name: str, ax: Any = None) -> Axes:
        """One identified error curve with its band. Raises KeyError for a name that is not in `identified.names`."""
        drawn: Axes = draw(self, name, ax)
        return drawn

    def probe_radii(self) -> list[dict[str, Any]]:
        """Of touches: how much further out than stated surfaces read all round, um; see `vcmm.learn.calibration.probe_radius`."""
        from vcmm.learn.calibration.probe_radius import probe_radii

        return probe_radii(self.readings, self.posterior, self.identified.names)

    def figures(self) -> list[Mapping[str, object]]:
        """One row per identified error: size and uncertainty, um or urad."""
        out: list[Mapping[str, object]] = []
        for name in self.kept.names:
            _, value, u = self.band(name)
            turns = is_angle(name)
            scale = 1e6 if turns else 1e3
            row: dict[str, object] = {"error": name, "unit": "urad" if turns else "um"}
            if len(value) > 1:
                row |= {"low": float(value.min() * scale), "high": float(value.max() * scale)}
            else:
                row |= {"value": float(value[0] * scale)}
            row["u"] = float(np.sqrt((u**2).mean()) * scale)
            curve = next((c for c in self.kept.curves if c.component == name), None)
            if curve is not None and curve.periodic:
                part = self.kept.slices[name]
                found = harmonics(curve, value, self.covariance[part, part])
                row["harmonics"] = [
                    {"order": int(h["order"]), "amplitude": h["amplitude"] * scale, "u": h["u"] * scale}
                    for h in found
                ]
            out.append(row)
        return out


def rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean())) if len(values) else 0.0
