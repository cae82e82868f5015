"""The picture of deviations: where the surface of a part lies beside its nominal one, at every point that was touched."""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array
from vcmm.show import report as r
from vcmm.show.pages.view import Item, part_items, rounded_down, touch_names
from vcmm.show.report import Lines, Points
from vcmm.task.measuring.task import Task

SHARE = 12.0  # the longest needle is at most so small a part of the size of the part
KINDS = (("bad", "material left over", 1.0), ("accent", "material missing", -1.0))


def deviations_block(task: Task) -> list[str]:
    """The scene, or nothing where no touch has a deviation (n,) mm along its outward normal (`task.form`)."""
    if not task.form.any():
        return []
    factor = magnification(task.touches.points, task.form)
    return [
        r.scene(
            deviation_items(task, factor),
            title="Deviations of the points",
            caption=f"From the nominal surface along its normal, less the known error of the machine, drawn {factor:,.0f} times too long; "
            f"from {1e3 * task.form.min():+.2f} to {1e3 * task.form.max():+.2f} µm. Point at a dot to read it.",
        )
    ]


def magnification(points: Array, deviations: Array) -> float:
    """A round factor by which the longest needle is about a twelfth of the part, or less."""
    return rounded_down(float(np.ptp(points, axis=0).max()) / SHARE / float(np.abs(deviations).max()))


def deviation_items(task: Task, factor: float) -> list[Item]:
    """The part, and a needle from every touched place to where the surface lies, `factor` times too far; by sign in two colours."""
    t, form = task.touches, task.form
    names = touch_names(t)
    items: list[Item] = [*part_items(list(task.part.features.values()), t.pose, task.part.mesh)]
    for colour, name, sign in KINDS:
        rows = np.flatnonzero(sign * form > 0)
        if len(rows):
            said = [f"{names[i]}\ndeviation {1e3 * form[i]:+.2f} µm" for i in rows]
            feet = t.pose.apply(t.points[rows])
            tips = feet + factor * form[rows, None] * t.pose.turn(t.normals[rows])
            items += [
                Lines(np.stack([feet, tips], axis=1), colour, 2.0, name=name),
                Points(tips, colour, 1.8, hover=said),
            ]
    return items
