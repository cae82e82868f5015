"""Write a thermal model to a machine file: its terms as effects, and their joint covariance as one Input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.effect import Effect, parameter
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.units import parse_unit
from vcmm.core.valid_range import trained_range
from vcmm.files.learned.effect_text import effect_toml, input_toml
from vcmm.files.toml_edits import editable, move_names
from vcmm.learn.calibration.thermal import ThermalModel
from vcmm.physics.structure.thermal import ThermalDriftTwoLags

POSITIVE = 4.0  # a lag below so many u of it is taken as it is: a normal law would make it negative


@dataclass(frozen=True, eq=False)
class WrittenTerms:
    """effects; numbers: (effect, parameter, number of the amount or lag in the covariance of the model)."""

    effects: tuple[Effect, ...]
    numbers: tuple[tuple[Effect, str, int], ...]


def written_terms(model: ThermalModel) -> WrittenTerms:
    """Return the terms as effects: two of one direction and sensor become one with two lags, the faster one first."""
    effects: list[Effect] = []
    numbers: list[tuple[Effect, str, int]] = []
    single, count = model.effects(), len(model.terms)
    for i, term in enumerate(model.terms):
        same = sorted(
            (k for k, t in enumerate(model.terms) if t.where == term.where and t.amount == term.amount),
            key=lambda k: float(model.lags[k]),
        )
        if i != min(same):
            continue
        effect = single[i] if len(same) == 1 else _two_lags(model, same)
        effects.append(effect)
        for k, more in zip(same, ("", "_slow")):
            numbers.append((effect, f"{term.amount}{more}", k))
            if term.lag and model.lags[k] > POSITIVE * np.sqrt(model.covariance[count + k, count + k]):
                numbers.append((effect, f"tau{more}", count + k))
    return WrittenTerms(tuple(effects), tuple(numbers))


def _two_lags(model: ThermalModel, pair: Sequence[int]) -> Effect:
    fast, slow = pair
    term = model.terms[fast]
    return ThermalDriftTwoLags(
        direction=term.where[0], sensor=term.sensor,
        k=float(model.amounts[fast]), k_slow=float(model.amounts[slow]),
        tau=float(model.lags[fast]), tau_slow=float(model.lags[slow]),
        trained=trained_range(*model.trained[term.sensor]),
    )  # fmt: skip


def covariance_of(model: ThermalModel, written: WrittenTerms) -> Array:
    """Return the covariance (n, n) of the numbers that are written, canonical units."""
    rows = [k for _, _, k in written.numbers]
    return model.covariance[np.ix_(rows, rows)]


def thermal_text(
    model: ThermalModel, machine: Machine, original: Path, target: Path, sources: Sequence[str]
) -> str:
    """Return the text of the machine file `original`, moved to `target`, with the terms at its end.

    Raises UsageError where the file has an effect of the same name and place already.
    """
    written = written_terms(model)
    for effect in written.effects:
        if any(e.id == effect.id for e in machine.effects):
            raise UsageError(
                f"{original.name} states {effect.id} already; take it out of the file and calibrate again, so that its number is not "
                "counted twice"
            )
    document = editable(original)
    move_names(document, original.parent, target.parent)
    evidence = f"calibrated from {', '.join(sources)}"
    blocks = [effect_toml(e, evidence if k == 0 else "") for k, e in enumerate(written.effects)]
    return f"{str(document.as_string()).rstrip()}\n\n" + "\n".join(
        [*blocks, _input(model, written, evidence)]
    )


def _input(model: ThermalModel, written: WrittenTerms, evidence: str) -> str:
    units = [parse_unit(parameter(e, name).metadata["unit"]).factor for e, name, _ in written.numbers]
    covariance = covariance_of(model, written) / np.outer(units, units)
    covariance = (covariance + covariance.T) / 2
    left = f"# left of the readings: {model.after * 1e3:.3g} um rms\n"
    if len(units) == 1:
        effect, name, number = written.numbers[0]
        law = Normal(float(np.sqrt(model.covariance[number, number])))
        block = input_toml(effect, Input(effect.name, effect.where, name, law), "")
        return left + block.replace("diagnosed from ", evidence)
    names = ", ".join(f'"{e.id}.{name}"' for e, name, _ in written.numbers)
    rows = ",\n  ".join(f"[{', '.join(f'{v:.12g}' for v in row)}]" for row in covariance)
    return f'{left}[[inputs]]\nnames = [{names}]\ncovariance = [\n  {rows},\n]\nevidence = "{evidence}"\n'
