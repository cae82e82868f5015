"""Placement problems: the plate with a field of errors over the machine, and drawn ones of up to six freedoms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.plate import PLATE
from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal
from vcmm.files.own.scenario import load_scenario
from vcmm.physics.structure.residual import CorrelatedField
from vcmm.task.measuring.scenario import Scenario


def written(folder: Path, more: str = "", *edits: tuple[str, str]) -> Path:
    """The plate as a file, edited, with further lines at its end."""
    text = PLATE
    for old, new in edits:
        assert text.count(old) == 1, (old, text.count(old))
        text = text.replace(old, new)
    path = folder / "plate.toml"
    path.write_text(text + more, encoding="utf-8")
    return path


def plate(folder: Path, more: str = "", *edits: tuple[str, str]) -> Scenario:
    return load_scenario(written(folder, more, *edits))


def nodes(step: int = 3) -> np.ndarray:
    """A grid of step^3 nodes over the reach of the plate's machine."""
    ends = [np.linspace(0, 600, step), np.linspace(0, 500, step), np.linspace(-520, -120, step)]
    return np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, 3)


def with_field(scenario: Scenario, seed: int, redraw: str = "run", step: int = 3) -> Scenario:
    """The scenario with a correlated field whose standard deviations are drawn between 0.2 and 2 um."""
    rng = np.random.default_rng([seed, 5])
    at = nodes(step)
    field = CorrelatedField(
        nodes=at, deviation=rng.uniform(0.2e-3, 2e-3, at.shape), length=float(rng.uniform(120, 250))
    )
    known = Input("correlated_field", "", "values", MultivariateNormal(field.covariance()), redraw)
    machine = scenario.machine
    machine = replace(machine, effects=(*machine.effects, field), inputs=(*machine.inputs, known))
    return replace(scenario, machine=machine)
