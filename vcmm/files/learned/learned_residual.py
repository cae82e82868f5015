"""Write a learned residual as files: the machine file with the term and the joint covariance of its values, and its rows beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vcmm.files.learned.effect_text import effect_toml
from vcmm.files.toml_edits import editable, move_names
from vcmm.learn.tracking.learned_rest import LearnedRest

ROWS = "learned_residual.csv"
MACHINE = "machine_learned.toml"


def learned_files(rest: LearnedRest, original: Path, folder: Path) -> dict[str, str]:
    """Return file name -> text of MACHINE and ROWS; none where the gate was not passed."""
    if not rest.has_passed:
        return {}
    document = editable(original)
    move_names(document, original.parent, folder)
    text = str(document.as_string()).rstrip() + "\n\n"
    text += f"# LEARNED, no physics. {rest.sentence}\n# Its rows for people: {ROWS}\n"
    text += effect_toml(rest.effect) + _input(rest)
    return {MACHINE: text, ROWS: _rows(rest)}


def _input(rest: LearnedRest) -> str:
    rows = ",\n  ".join(f"[{', '.join(f'{v:.12g}' for v in row)}]" for row in rest.covariance)
    place = "".join(
        f'{name} = "{getattr(rest.effect, name)}"\n'
        for name in ("component", "column")
        if getattr(rest.effect, name)
    )
    return (
        f'\n[[inputs]]\neffect = "{rest.effect.name}"\n{place}parameter = "values"\nlaw = "multivariate"\n'
        f"covariance = [\n  {rows}\n]\n"
    )


def _rows(rest: LearnedRest) -> str:
    """Return position, level, value and standard uncertainty of every node."""
    effect = vars(rest.effect)
    nodes, column = np.asarray(effect["nodes"]), str(effect["column"])
    levels = np.array([float(v) for v in str(effect["levels"]).split()] or [0.0])
    turns = rest.effect.where[1] in "ABC"
    unit = "urad" if turns else "um"
    values = np.asarray(effect["values"]) * (1e6 if turns else 1e3)
    us = np.sqrt(np.diag(rest.covariance)) * (1e6 if turns else 1e3)
    lines = [f"{rest.effect.link}_mm,{column + ',' if column else ''}value_{unit},u_{unit}"]
    for i, level in enumerate(levels):
        for j, q in enumerate(nodes):
            k = i * len(nodes) + j
            over = f"{level:.6g}," if column else ""
            lines.append(f"{q:.6g},{over}{values[k]:.6g},{us[k]:.6g}")
    return "\n".join(lines) + "\n"
