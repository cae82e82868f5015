"""Check the facets of a mesh as nominal shape: report their share in a profile where it is not small."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.answer.evaluation.result import CharacteristicResult
from vcmm.part.gps.pointwise import PROFILE
from vcmm.part.sag import sag_at
from vcmm.task.measuring.task import Task

FACET_SHARE_OF_LIMIT = 0.1
"""Share of U or the tolerance, the smaller: an unseen bias of a tenth of U makes an interval for 95 % miss in 5.5 % (docs/uncertainty.md)."""


def coarse_mesh(task: Task, results: Sequence[CharacteristicResult]) -> tuple[str, ...]:
    """Return one sentence for each profile to which the facets at its points may add more than `FACET_SHARE_OF_LIMIT`. task: with the measured places.

    A profile is twice the largest distance, so a sag adds up to twice itself.
    """
    out = []
    for c, result in zip(task.part.characteristics, results):
        names = [n for n in c.of if task.part.features[n].kind == "mesh"] if c.type in PROFILE else []
        limits = [result.expanded, *(result.tolerance[1:] if result.tolerance else ())]
        least = FACET_SHARE_OF_LIMIT * min((x for x in limits if np.isfinite(x) and x > 0.0), default=0.0)
        for name in names:
            assert task.part.mesh is not None  # Part has seen to it
            sag = float(sag_at(task.part.mesh, task.touches.points[task.touches.rows[name]]).max())
            if 2.0 * sag > least:
                out.append(_mesh_remark(result, name, sag, least))
    return tuple(out)


def _mesh_remark(c: CharacteristicResult, name: str, sag: float, least: float) -> str:
    against = f"U = {c.expanded * 1e3:.3g} um"
    if c.tolerance:
        against += f", the tolerance {c.tolerance[1] * 1e3:.3g} um"
    finer = f"with a chord tolerance of {least / 2 * 1e3:.2g} um" if least else "with a finer chord tolerance"
    return (
        f'{c.name}: the mesh is coarse where "{name}" was touched: a smooth surface would stand up to {sag * 1e3:.3g} um off its facets '
        f"(chord times turn / 8), which alone adds up to {2 * sag * 1e3:.3g} um to the {c.type} and is not in U ({against}); "
        f"export the mesh {finer}"
    )
