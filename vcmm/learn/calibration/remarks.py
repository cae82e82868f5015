"""What a calibration says beside its figures: what was assumed, what was found to be otherwise, what stays as it was."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.learn.calibration.identifiability import Identifiability
from vcmm.learn.calibration.prior_knowledge import PriorKnowledge
from vcmm.learn.calibration.readings import Readings
from vcmm.learn.calibration.solve import ErrorPosterior

WRONG_UNIT = {"angle": "arcsec taken for urad are 4.848 times too small"}  # of lengths: mm taken for um


def as_before(found: Identifiability, known: PriorKnowledge) -> list[str]:
    """What is taken over from the machine file unchanged."""
    kept = [n for n in known.names if n not in found.names]
    if not kept:
        return []
    return [
        f"{', '.join(kept)}: no reading of these recordings tells whether they changed; they stay as the machine file has them"
    ]


def assumption_remarks(
    parts: Sequence[Readings], post: ErrorPosterior, only: Sequence[str], stated: bool
) -> list[str]:
    """Sentences about what was assumed and what was found to be otherwise."""
    out = [a for p in parts for a in p.assumed]
    if only:
        rest = "stays as the machine file has it" if stated else "was taken as zero"
        out.append(f"only {', '.join(only)} were looked for; every other error {rest}")
    for part, noise in zip(parts, post.noise):
        name = part.recording.name
        if not part.stated:
            unit, scale = ("urad", 1e6) if part.recording.kind == "angle" else ("um", 1e3)
            out.append(
                f"{name}: the noise is not stated; the residuals say {noise.u * part.u[0] * scale:.2g} {unit}"
            )
        elif noise.scale > 1.0 and np.isinf(noise.dof):
            out.append(
                f"{name}: the residuals are {noise.scale:.2f} times the stated noise, which was raised by that"
            )
        if noise.quiet < 1.0:
            unit = WRONG_UNIT.get(part.recording.kind, "mm taken for um are 1000 times too small")
            out.append(
                f"{name}: the residuals are only {noise.quiet:.2g} times the stated noise: check the unit of its values ({unit}), or state "
                "the noise that it has"
            )
        if noise.outliers.any():
            out.append(
                f"{name}: {int(noise.outliers.sum())} outliers carry little weight: {part.recording.places(noise.outliers)}"
            )
    for name, value in zip(post.own_names, post.own):
        if abs(value) > 3:
            out.append(
                f"{name}: the readings pull it by {value:+.1f} times its stated u; check its certificate"
            )
    return out
