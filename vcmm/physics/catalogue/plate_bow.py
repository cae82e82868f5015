"""Plate bow: holes drilled into a plate that was held convex lie further out when it is released."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import About, ForDiagnosis, Opposite, Prior, Typical, Words
from vcmm.core.effect import Effect, at, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


def _plate_bow_shows_in(effect: PlateBow, run: Run) -> bool:
    """Return whether neighbouring points are nearer together across the plate than along it."""
    spread = np.ptp(run.part_point, axis=0)
    return bool(spread["xyz".index(effect.normal)] == spread.min())


@dataclass(frozen=True, eq=False)
class PlateBow(Effect):
    """c r^2 (x, y): a hole at the distance r from the middle lies c r^3 further out, in the plane of the plate.

    A plate bent to a sphere of radius R holds an arc of r + r^3 / (6 R^2) below a circle of radius r: c = 1 / (6 R^2). What a
    programme that corrects for the bow leaves is a share of it; negative where it corrected for too much, or the plate was
    held hollow. r is counted from the part's origin.
    """

    name = "plate_bow"
    per = "part"
    about = About(
        cites="arc over a chord: s = R arcsin(r / R) = r + r^3 / (6 R^2); Siegmund et al., SDSS technical notes 19941206, 19950130",
        words=Words(
            seen="holes lie further out with the third power of their distance from the middle ({c})",
            causes="the plate was held convex while it was drilled, and lies flat now",
            confirm="measure the height of the plate on its fixture; drill one flat",
            signed=("c",),
            opposite=Opposite(
                "c", "holes lie further in with the third power of their distance from the middle ({c})"
            ),
        ),
        belongs_to="part",
        needs_cut=True,
        on_cut_part="stated",
    )
    diagnosis = ForDiagnosis(
        # few plates are held bent
        prior=Prior(share=0.1),
        shows_in=_plate_bow_shows_in,
    )
    normal: str = at(
        "z", "direction across the plate: x, y or z of the part", quiet=True, forms=("z", "x", "y")
    )
    c: float = param(
        0.0,
        "um/m^3",
        "distance per third power of the radius",
        typical=Typical(
            2e-10, "5 um at 300 mm: remainder of a bow of 10 mm, 200 um at its edge, corrected to 3 %"
        ),
    )

    def __post_init__(self) -> None:
        if self.normal not in ("x", "y", "z"):
            raise UsageError(f'plate_bow: normal = "{self.normal}" must be "x", "y" or "z"')

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        plane = run.part_point * (np.arange(3) != "xyz".index(self.normal))
        out = np.zeros((run.n, 6))
        out[:, :3] = self.c * (plane**2).sum(axis=1)[:, None] * plane
        return out
