"""The scenario xcz_lathe: readings of the paper's three reversals on one drawn lathe, thinned, as files that a user would write."""

from __future__ import annotations

import numpy as np

from vcmm import Array, reversals

from .lathe import NM, drawn_lathe
from .surveys import FACE, half_turn_scans, straightness_scans

SEED, THIN = 3, 10  # every tenth mean of a scan: 1 mm
SAMPLING = reversals.Sampling(turns=5, per_turn=48, u=0.3 * NM, mounting=2e-6)
FORM = 20 * NM  # two waves of the flat under the outer probe


def texts() -> dict[str, str]:
    """File name -> text of the data tables."""
    rng = np.random.default_rng(SEED)
    lathe = drawn_lathe(rng)
    return {
        "straight.csv": _lines(straightness_scans(lathe.machine, rng)),
        "half.csv": _lines(half_turn_scans(lathe, rng)),
        "face.csv": _face(rng),
    }


def _lines(scans: list[reversals.LineScan]) -> str:
    rows, count = ["X_mm,setup,run,d_um"], {"normal": 0, "reversed": 0}
    for scan in scans:
        count[scan.setup] += 1
        for x, d in zip(scan.place[::THIN], scan.value[::THIN] - scan.value.mean()):
            rows.append(f"{x:.1f},{scan.setup},{count[scan.setup]},{d * 1e3:.5f}")
    return "\n".join(rows) + "\n"


def _face(rng: np.random.Generator) -> str:
    lathe = drawn_lathe(np.random.default_rng(SEED))

    def form(angle: Array) -> Array:
        return np.asarray(FORM * np.cos(2 * angle + 1.0))

    rows = ["C_deg,setup,instrument,d_um"]
    for one in reversals.simulated_values(
        FACE, lathe.machine, form, ("normal", "reversed"), SAMPLING, rng=rng
    ):
        setup, probe, angle, value = one
        rows += [f"{a:.1f},{setup},{probe},{d * 1e3:.5f}" for a, d in zip(np.degrees(angle), value)]
    return "\n".join(rows) + "\n"
