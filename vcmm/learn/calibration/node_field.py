"""Nodes that were found, as a residual field in a machine file: mean deviations as values, scatter as a t-law per touch."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.files.toml_edits import editable, move_names
from vcmm.learn.calibration.nodes import NodeScatter
from vcmm.learn.diagnosis.machine_file import effect_toml
from vcmm.physics.structure.residual import ResidualField

TOLD = 2.0  # times its u: a mean deviation below that is not written
REDRAW = "touch"  # d is a scatter of approaches


def node_effect(found: NodeScatter, machine: Machine) -> Effect:
    """The residual field of these nodes, of mean deviations that are told from zero: on columns where they stand in columns, else trilinear on a full grid.

    Raises UsageError where they do neither, or where the machine states such a field already.
    """
    if any(e.name == ResidualField.name for e in machine.effects):
        raise UsageError(
            f"the machine file states {ResidualField.name} already; take it out of the file, so that no error is counted twice"
        )
    grids = [len(np.unique(found.place[:, i])) for i in range(3)]
    columns, heights = np.unique(found.place[:, :2], axis=0, return_counts=True)
    if int(np.prod(grids)) == len(found.place):
        way = "trilinear"
    elif len(columns) >= 3 and heights.min() >= 2:
        way = "columns-linear"
    else:
        raise UsageError(
            f"{len(found.place)} nodes stand neither in vertical columns of two or more nor on a full grid; measure each column at several heights"
        )
    told = np.abs(found.deviation) > TOLD * found.deviation_u
    return ResidualField(nodes=found.place, interpolation=way, values=np.where(told, found.deviation, 0.0))


def predictive_scale(found: NodeScatter) -> Array:
    """(K, 3) mm: scale of the t-law of one new approach after n of them, `single` times sqrt(1 + 1/n).

    Where `single` is below what the lengths alone make, that stands for it: less cannot be seen.
    """
    seen = np.maximum(found.single, found.instrument)
    return np.asarray(seen * np.sqrt(1 + 1 / (found.dof + 1))[:, None])


def node_text(
    found: NodeScatter, machine: Machine, original: Path | None, target: Path, sources: Sequence[str]
) -> str:
    """Text of the machine file with the field at its end. original: the file that it is added to; None: one of structure and travels."""
    from vcmm.learn.calibration.machine_file import bare_text

    effect = node_effect(found, machine)
    if original is None:
        start = bare_text(machine)
    else:
        document = editable(original)
        move_names(document, original.parent, target.parent)
        start = str(document.as_string())
    said = f"LaserTracer, {', '.join(sources)}"
    dof = sorted({int(v) for v in found.dof})
    head = ["[[inputs]]", f'effect = "{effect.name}"', 'parameter = "values"', 'law = "t"', f"dof = {dof[0]}"]
    head += [f'redraw = "{REDRAW}"', f'evidence = "{said}: scatter of {dof[0] + 1} approaches of each node"']
    rows = [f'  "{" ".join(f"{v * 1e3:.3f}" for v in row)} um",' for row in predictive_scale(found)]
    block = "\n".join([*head, "scale = [", *rows, "]"])
    return f"{start.rstrip()}\n\n{effect_toml(effect, said)}\n{block}\n"
