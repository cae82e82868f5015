"""Write estimated nodes as a residual field in a machine file: a process of a repeatable share and of one that each approach adds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.residual_process import FieldProcess
from vcmm.core.run import Array
from vcmm.files.toml_edits import editable, move_names
from vcmm.learn.calibration.field_process import ProcessFit, field_process, fit_process
from vcmm.learn.calibration.nodes import NodeScatter
from vcmm.physics.structure.residual import ResidualField

SHARES = (
    ("systematic", "machine"),
    ("random", "touch"),
)  # d is a scatter of approaches, the mean deviation stays


def check_nodes(nodes: NodeScatter, machine: Machine) -> str:
    """Return the name of the effect that these nodes become.

    Raises UsageError where they span no volume, or where the machine states such a field already.
    """
    if any(e.name == ResidualField.name for e in machine.effects):
        raise UsageError(
            f"the machine file states {ResidualField.name} already; take it out of the file, so that no error is counted twice"
        )
    if np.linalg.matrix_rank(nodes.place - nodes.place[0], tol=1e-6 * float(np.ptp(nodes.place))) < 3:
        raise UsageError(
            f"{len(nodes.place)} nodes lie in one plane; measure nodes at several heights, so that they span a volume"
        )
    return ResidualField.name


def approach_scale(nodes: NodeScatter) -> Array:
    """Return the scale of the t-law of one approach about the mean of its node, as (K, 3) mm; that mean has its own u in the systematic share.
    Where `single` is below the scatter by the lengths alone, the latter replaces it: less cannot be seen.
    """
    return np.maximum(nodes.single, nodes.instrument)


def node_text(
    nodes: NodeScatter,
    machine: Machine,
    original: Path | None,
    target: Path,
    sources: Sequence[str],
    fit: ProcessFit | None = None,
) -> str:
    """Return the text of the machine file with the field at its end. original: the file that it is added to; None: one of structure and travels."""
    from vcmm.files.learned.calibrated_machine import bare_text

    name = check_nodes(nodes, machine)
    fit = fit_process(nodes) if fit is None else fit
    if original is None:
        start = bare_text(machine)
    else:
        document = editable(original)
        move_names(document, original.parent, target.parent)
        start = str(document.as_string())
    source_text, dof = f"LaserTracer, {', '.join(sources)}", int(nodes.dof.min())
    process = field_process(nodes, fit, approach_scale(nodes))
    parts = [start.rstrip(), "", *_effect_lines(name, process, nodes, dof, source_text)]
    evidence = {
        "systematic": f"{source_text}: mean of {dof + 1} approaches of each node, {len(nodes.place)} nodes",
        "random": f"{source_text}: scatter of {dof + 1} approaches of each node",
    }
    for share, redraw in SHARES:
        parts += ["", "[[inputs]]", f'effect = "{name}"', f'parameter = "{share}"', f'redraw = "{redraw}"']
        parts += [f'evidence = "{evidence[share]}"']
    return "\n".join(parts) + "\n"


def _effect_lines(
    name: str, process: FieldProcess, scatter: NodeScatter, dof: int, evidence: str
) -> list[str]:
    """Return the [[effects]] table; nodes that are filled in follow those that were read."""
    mean, _ = process.posterior(scatter.deviation)
    rows = ", ".join(f"[{', '.join(f'{v:.4f}' for v in row)}]" for row in process.correlation)
    words = [
        'margins = "t"', f"dof = {dof}", f"length_scales_mm = [{_three(process.lengths)}]",
        f"amplitude_um = [{_three(process.amplitude * 1e3)}]", f"correlation = [{rows}]",
    ]  # fmt: skip
    return [
        f"[[effects]]                                # {evidence}",
        f'effect = "{name}"',
        f"process = {{ {', '.join(words)} }}",
        f"# the first {process.readings} nodes were read, the others are filled in",
        *_rows("nodes", process.nodes, "mm", 1.0, ".10g"),
        *_rows("systematic", mean, "um", 1e3, ".4f"),
        *_rows("scatter", process.scatter, "um", 1e3, ".4f"),
        *_rows("reading_u", process.reading_u, "um", 1e3, ".4f"),
    ]


def _three(values: Array) -> str:
    return ", ".join(f"{v:.5g}" for v in values)


def _rows(key: str, values: Array, unit: str, scale: float, digits: str) -> list[str]:
    body = [f'  "{" ".join(format(v * scale, digits) for v in row)} {unit}",' for row in values]
    return [f"{key} = [", *body, "]"]
