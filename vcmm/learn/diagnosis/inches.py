"""Positions in inches, and times in minutes: units that no header contradicts, seen from what belongs together.

A small artefact on a large machine also covers a small part of the travels. So positions are suspected only where a
second thing disagrees by 25.4: the points of the part, or digits that are round in mm and not as they stand.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.task.response.recording import Recording

INCH = 25.4
NEAR = 0.05  # of the factor that the points of the part give; the tip stands off them by its radius
DIGITS = 5  # after the point, mm: what coordinate lists hold
FASTEST = 1000.0  # mm/s, 60 m/min in every second row: beyond what feed axes do on a measured path


def inches(recording: Recording, machine: Machine) -> list[str]:
    """One sentence where positions look like inches, one where the times look like minutes."""
    return [*_positions(recording, machine), *_times(recording)]


def _positions(recording: Recording, machine: Machine) -> list[str]:
    run = recording.run
    lines = {a: run.position[a] for a in "XYZ" if a in run.position and np.ptp(run.position[a]) > 0}
    if not lines or any(INCH * np.ptp(q) > np.ptp(machine.axes[a].travel) for a, q in lines.items()):
        return []
    because = _of_part(recording) or _of_digits(lines)
    if not because:
        return []
    shown = ", ".join(
        f"{a} {float(np.ptp(q)):.3g} of {float(np.ptp(machine.axes[a].travel)):.4g} mm"
        for a, q in lines.items()
    )
    return [
        f"the positions cover only {shown}, and {because}: they look like inches; mm are due (1 inch is {INCH} mm)"
    ]


def _of_part(recording: Recording) -> str:
    """Distances between the points of the part against those between the positions, per placement and stylus."""
    run = recording.run
    names = [f"part_{c}_mm" for c in "xyz"]
    if not set(names) <= set(run.columns) or not set("XYZ") <= set(run.position):
        return ""
    part, tip = run.vector(*names), np.stack([run.q(a) for a in "XYZ"], axis=1)
    none = np.zeros(run.n, dtype=np.str_)
    both = np.stack([run.labels.get(label, none) for label in ("pose", "stylus")], axis=1)
    own, seen = 0.0, 0.0
    for value in np.unique(both, axis=0):
        rows = (both == value).all(axis=1)
        own += float(((part[rows] - part[rows].mean(axis=0)) ** 2).sum())
        seen += float(((tip[rows] - tip[rows].mean(axis=0)) ** 2).sum())
    if seen <= 0 or abs(np.sqrt(own / seen) / INCH - 1.0) > NEAR:
        return ""
    return f"the points of the part (part_x_mm ...) lie {np.sqrt(own / seen):.4g} times as far apart"


def _of_digits(lines: dict[str, Array]) -> str:
    """Numbers with a few digits in mm, which were divided by 25.4."""

    def round_share(values: Array) -> float:
        return float(np.mean(np.abs(values - np.round(values, DIGITS)) < 1e-8))

    values = np.concatenate(list(lines.values()))
    if round_share(values) > 0.2 or round_share(INCH * values) < 0.95:
        return ""
    return "times 25.4 they become numbers of a few digits"


def _times(recording: Recording) -> list[str]:
    """A path that is faster than any axis."""
    names = [f"speed_{a}_mm_s" for a in "XYZ" if f"speed_{a}_mm_s" in recording.run.columns]
    if recording.kind not in ("path", "displacement") or not names:
        return []
    each = np.stack([recording.run.columns[c] for c in names], axis=1)
    usual = float(np.median(np.linalg.norm(each, axis=1)))
    if usual <= FASTEST:
        return []
    return [
        f"the motion runs at {usual:.4g} mm/s ({usual * 0.06:.3g} m/min), faster than feed axes do: is time_s in seconds? "
        f"Were it in minutes, it would run at {usual / 60:.3g} mm/s"
    ]
