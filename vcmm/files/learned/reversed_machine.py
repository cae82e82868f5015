"""Write the machine file of reversals: straightness as a table with its covariance, spindle errors as orders, squareness as a number."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input, JointCovariance
from vcmm.core.kinematics import Chain
from vcmm.core.laws import Law, MultivariateNormal, Normal
from vcmm.core.run import Array
from vcmm.files.foreign.isg import ErrorFile, ErrorTable, isg_text
from vcmm.files.learned.effect_text import effect_toml, input_toml
from vcmm.files.own.joint_covariance import covariance_text
from vcmm.learn.calibration.reversal import (
    ReversalResult,
    spans,
    student_variance,
    turning_axes,
    turning_input,
)
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.physics.structure.squareness import RotaryLocation

TURNS = 36000  # deg, to either side: a spindle's travel


def reversed_texts(
    results: Sequence[ReversalResult], chain: Chain, target: Path, sources: Sequence[str]
) -> dict[str, str]:
    """Return file name -> text: STEM.toml as `target` says; STEM_errors.csv and STEM_covariance.csv where it holds a straightness.

    Raises UsageError for an axis that the structure lacks.
    """
    for result in results:
        if result.file.axis not in chain.letters:
            raise UsageError(
                f'{result.file.name} is about axis {result.file.axis}, which structure = "{chain.structure}" lacks'
            )
    straight = [result for result in results if result.straight is not None]
    out: dict[str, str] = {}
    text = _head(results, chain)
    if straight:
        table, covariance = f"{target.stem}_errors.csv", f"{target.stem}_covariance.csv"
        evidence = f"reversal {', '.join(sources)}"
        text += f'[errors]\ntable = "{table}"\ncovariance = "{covariance}"\nevidence = "{evidence}"\n'
        out[table] = isg_text(_tables(straight), evidence)
        out[covariance] = covariance_text(_joint(straight))
    for result in results:
        text += "".join(f"\n# not identified: {c.text}" for c in result.combinations) + "\n"
        text += _effects(result)
    return {f"{target.stem}.toml": text, **out}


def _head(results: Sequence[ReversalResult], chain: Chain) -> str:
    """Return axes with the travel that was scanned; those that did not move get a millimetre to either side."""
    lines = ['vcmm = "machine/1"', 'name = "machine of reversals"', f'structure = "{chain.structure}"']
    ranges, fixed = spans(results), turning_axes(results)
    for letter in chain.letters:
        low, high = (-TURNS, TURNS) if is_rotary(letter) else ranges.get(letter, (-1.0, 1.0))
        unit = "deg" if is_rotary(letter) else "mm"
        lines += [f"[axes.{letter}]", f'travel = ["{low:.10g} {unit}", "{high:.10g} {unit}"]']
        if letter in fixed:
            lines.append('error_frame = "fixed"')
    return "\n".join(lines) + "\n"


def _tables(straight: Sequence[ReversalResult]) -> ErrorFile:
    tables = []
    for result in straight:
        assert result.straight is not None
        values: dict[str, Array] = {result.file.error: result.straight.machine}
        tables.append(ErrorTable((result.file.axis,), (result.straight.nodes,), values, 0))
    return ErrorFile(tuple(tables), {})


def _joint(straight: Sequence[ReversalResult]) -> JointCovariance:
    """Return the joint covariance; straightnesses of different files are independent."""
    from scipy.linalg import block_diag

    parts = [result.straight for result in straight if result.straight is not None]
    names = tuple(result.file.error for result in straight if result.straight for _ in result.straight.nodes)
    matrix = block_diag(*(p.covariance * student_variance(p.dof) for p in parts))
    return JointCovariance(names, np.concatenate([p.nodes for p in parts]), matrix)


def _effects(result: ReversalResult) -> str:
    """Return [[effects]] and [[inputs]] of a squareness or a turning axis."""
    out = ""
    if result.square is not None:
        located = RotaryLocation(result.file.error, tilt=result.square.angle)
        u = result.square.u * float(np.sqrt(student_variance(result.square.dof)))
        out += _toml_of(located, "tilt", Normal(u), result.file.name)
    for name in result.errors if result.turning is not None else ():
        assert result.turning is not None
        value, covariance = turning_input(result.turning, name)
        turning = RotaryCyclic(name, value)
        out += _toml_of(
            turning,
            "coefficients",
            MultivariateNormal(covariance * student_variance(result.turning.dof)),
            result.file.name,
        )
    return out


def _toml_of(effect: Effect, parameter: str, law: Law | MultivariateNormal, source: str) -> str:
    located = Input(effect.name, str(effect.where), parameter, law, "machine", "")
    text = input_toml(effect, located, source).replace("diagnosed from", "reversal")
    return effect_toml(effect) + text
