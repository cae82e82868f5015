"""Energy of the concealed effect that the improved machine file leaves on a recording that was never made.

A second design of the same kind (other poses, points, times, temperatures) of the same real machine; the effect on it is known
here without noise, the product's prediction is that of the improved file less that of the stated one. This is the only
module of the exam that imports the product, to predict with its own machine files.

    left = ||W (e - prediction)||^2 / ||W e||^2
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.exam import blocks, files
from benchmarks.exam.blocks import Case, Setting
from benchmarks.exam.kinema import Array
from benchmarks.exam.observe import join
from benchmarks.exam.strength import whitener

OWN_EACH_TIME = {
    "reindexing",
    "clamping",
    "step_change",
    "map_mistake",
    "abbe_counted_twice",
}  # do not come again
SHAPED_BY_ROWS = {"geometric_change", "tip_form"}  # bump and worn flat are drawn from the rows of a recording


def energy_left(case: Case, improved: Path, folder: Path) -> float | None:
    """None where the effect does not come again in another recording, or where its shape was drawn from the rows."""
    truth = case.truth
    if not truth.items or any(i.effect in OWN_EACH_TIME | SHAPED_BY_ROWS for i in truth.items):
        return None
    key = (truth.seed, ord(truth.block), truth.number)
    name, concealed, _ = blocks.plan(truth.block, truth.number)
    design = blocks.DESIGNS[name](np.random.default_rng((*key, 99)))
    s = Setting(design, case.machine, whitener(design))
    items = [
        blocks.FAMILIES[c](design, case.machine, np.random.default_rng((*key, i)))
        for i, c in enumerate(concealed)
    ]
    if any(dict(a.where) != dict(b.where) for a, b in zip(items, truth.items)):
        return None
    effect = blocks.effect_of(s, join([item.build(a) for item, a in zip(items, truth.amplitudes)]))
    recording = files.write(folder, design, case.machine, np.zeros(len(effect)))
    rest = s.white.apply(effect - _predicted(recording, improved))
    whole = s.white.apply(effect)
    return float(rest @ rest / (whole @ whole))


def _predicted(recording: Path, improved: Path) -> Array:
    """What the improved file predicts more than the stated one, mm (rows, x y z in turn where there is no direction)."""
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.recording import load_recording
    from vcmm.task.response.observe import baseline

    first, stated = load_recording(recording, None)
    second, better = load_recording(recording, load_machine(improved))
    return np.asarray(baseline(replace(second), better) - baseline(first, stated))
