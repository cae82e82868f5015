"""Folds of a recording: rows where the conditions go beyond those of the others, for every job that holds rows out.

Another recording of the machine, another pose, the later time, the warmer rows, a higher speed, the far end of an axis.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array, Run
from vcmm.task.response.recording import SOURCE_LABEL, Ints

Mask = npt.NDArray[np.bool_]
SHARE = 0.3  # of the rows held out
FAR_ZONE = "far zone "  # before the letter of an axis
MOST_POSES = 4


def fold_masks(run: Run, row: Ints) -> list[tuple[str, Mask]]:
    """Yield (name, rows held out (m,)) of every fold that the columns allow; row (m,): run row of each observation."""
    out: list[tuple[str, Mask]] = []
    if SOURCE_LABEL in run.labels:
        of = run.labels[SOURCE_LABEL][row]
        out += [(f"recording {name}", of == name) for name in np.unique(of)]
    if "pose" in run.labels:
        label = run.labels["pose"][row]
        poses = np.unique(label)
        out += [(f"pose {p}", label == p) for p in poses[-MOST_POSES:]] if len(poses) > 1 else []
    if "time_s" in run.columns:
        out.append(("later time", _upper(run.column("time_s")[row])))
    warm = [c for c in run.columns if c.startswith("temp_") and np.ptp(run.columns[c]) > 0.2]
    if warm:
        widest = max(warm, key=lambda c: float(np.ptp(run.columns[c])))
        out.append(("temperature", _upper(run.column(widest)[row])))
    speeds = [c for c in run.columns if c.startswith("speed_")]
    if speeds:
        speed = np.linalg.norm(run.vector(*speeds), axis=1)[row]
        out.append(("speed", _upper(np.round(speed, 6))))
    axes = [a for a in run.position if np.ptp(run.position[a]) > 0]
    out += [(f"{FAR_ZONE}{a}", _upper(run.position[a][row])) for a in axes]
    return out


def _upper(x: Array) -> Mask:
    return np.asarray(x > np.quantile(x, 1 - SHARE))
