"""Remarks on what a machine file states: numbers out of the usual range, scatter that stands twice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vcmm.files.own.machine_tables import MachineFile
from vcmm.physics.structure.residual import ResidualField

MOST_SCATTER = (
    0.05  # mm: hand-held arms have 20 to 50 um; probes of machines, on CMMs and machine tools, 0.1 to 10 um
)


def repeatability_remarks(model: MachineFile, inputs: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """inputs: the tables [[inputs]] of the file. Empty where nothing is to be said."""
    if model.repeatability is None:
        return ()
    stated = model.repeatability
    key, spread = ("u", stated.u) if stated.u is not None else ("scale", stated.scale)
    out = []
    if spread is not None and spread > MOST_SCATTER:
        out.append(
            f'[repeatability] {key} = "{spread:g} mm": usual are 0.1 to 10 um, of arms up to 50 um: check the unit and the decimal point'
        )
    if any(i.get("effect") == ResidualField.name and i.get("parameter") == "random" for i in inputs):
        out.append(ResidualField.counted_twice)
    return tuple(out)
