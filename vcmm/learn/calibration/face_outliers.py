"""Readings of a turned face that lie far from all others: a chip, dust, a jump of the probe. They are reported and not left out."""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array
from vcmm.task.instruments.face_scan import FaceScan

OUTLIER_SIGMAS = 12.0  # times the usual scatter: a reading of a normal law never lies so far
LEAST_SCATTER_MM = 1e-6  # mm: usual scatter below which a scan is taken as computed
SHARE = 0.005  # of the readings: more of them are a feature of the face
NORMAL = 1.4826  # standard deviation over median of absolute values, normal law


def outlier_remarks(scan: FaceScan, a: Array, height: Array, rest: Array) -> tuple[str, ...]:
    """Return remarks on outliers, in words; nothing where there are none, or too many. rest (n,) mm: heights less the fit of the columns a (n, p).

    Least squares give a part of an outlier to many readings, so that the farthest is taken out and the fit made anew, one after another.
    """
    kept = np.ones(len(rest), dtype=bool)
    first = rest
    for _ in range(int(max(SHARE * len(rest), 1.0)) + 1):
        usual = max(NORMAL * float(np.median(np.abs(rest[kept]))), LEAST_SCATTER_MM)
        far = kept & (np.abs(rest) > OUTLIER_SIGMAS * usual)
        if not far.any():
            break
        kept[int(np.where(kept, np.abs(rest), 0.0).argmax())] = False
        some = a[kept]
        fit = np.linalg.pinv(some.T @ some, rcond=1e-12, hermitian=True) @ (some.T @ height[kept])
        rest = height - a @ fit
    else:
        return ()
    if kept.all():
        return ()
    worst = int(np.where(kept, 0.0, np.abs(first)).argmax())
    count = "1 reading stands" if (~kept).sum() == 1 else f"{(~kept).sum()} readings stand"
    return (
        f"{count} out of the {usual * 1e3:.2g} um by which the others scatter, farthest the one at X {scan.x[worst]:.6g} mm, "
        f"C {np.degrees(scan.across[worst]):.6g} deg ({scan.reading[worst] * 1e3:.4g} um): a chip, dust or a jump of the probe; map and figures hold it, "
        "remove its row where it is not of the face",
    )
