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
from vcmm.files.foreign.isg import ErrorFile, ErrorTable
from vcmm.files.foreign.isg_writer import isg_text
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
    found: Sequence[ReversalResult], chain: Chain, target: Path, sources: Sequence[str]
) -> dict[str, str]:
    """Return file name -> text: STEM.toml as `target` says; STEM_errors.csv and STEM_covariance.csv where it holds a straightness.

    Raises UsageError for an axis that the structure lacks.
    """
    for one in found:
        if one.file.axis not in chain.letters:
            raise UsageError(
                f'{one.file.name} is about axis {one.file.axis}, which structure = "{chain.structure}" lacks'
            )
    straight = [one for one in found if one.straight is not None]
    out: dict[str, str] = {}
    text = _head(found, chain)
    if straight:
        table, covariance = f"{target.stem}_errors.csv", f"{target.stem}_covariance.csv"
        said = f"reversal {', '.join(sources)}"
        text += f'[errors]\ntable = "{table}"\ncovariance = "{covariance}"\nevidence = "{said}"\n'
        out[table] = isg_text(_tables(straight), said)
        out[covariance] = covariance_text(_joint(straight))
    for one in found:
        text += "".join(f"\n# not identified: {c.text}" for c in one.combinations) + "\n"
        text += _effects(one)
    return {f"{target.stem}.toml": text, **out}


def _head(found: Sequence[ReversalResult], chain: Chain) -> str:
    """Return axes with the travel that was scanned; those that did not move get a millimetre to either side."""
    lines = ['vcmm = "machine/1"', 'name = "machine of reversals"', f'structure = "{chain.structure}"']
    seen, fixed = spans(found), turning_axes(found)
    for letter in chain.letters:
        low, high = (-TURNS, TURNS) if is_rotary(letter) else seen.get(letter, (-1.0, 1.0))
        unit = "deg" if is_rotary(letter) else "mm"
        lines += [f"[axes.{letter}]", f'travel = ["{low:.10g} {unit}", "{high:.10g} {unit}"]']
        if letter in fixed:
            lines.append('error_frame = "fixed"')
    return "\n".join(lines) + "\n"


def _tables(straight: Sequence[ReversalResult]) -> ErrorFile:
    tables = []
    for one in straight:
        assert one.straight is not None
        values: dict[str, Array] = {one.file.error: one.straight.machine}
        tables.append(ErrorTable((one.file.axis,), (one.straight.nodes,), values, 0))
    return ErrorFile(tuple(tables), {})


def _joint(straight: Sequence[ReversalResult]) -> JointCovariance:
    """Return the joint covariance; straightnesses of different files are independent."""
    from scipy.linalg import block_diag

    parts = [one.straight for one in straight if one.straight is not None]
    names = tuple(one.file.error for one in straight if one.straight for _ in one.straight.nodes)
    matrix = block_diag(*(p.covariance * student_variance(p.dof) for p in parts))
    return JointCovariance(names, np.concatenate([p.nodes for p in parts]), matrix)


def _effects(one: ReversalResult) -> str:
    """Return [[effects]] and [[inputs]] of a squareness or a turning axis."""
    out = ""
    if one.square is not None:
        located = RotaryLocation(one.file.error, tilt=one.square.angle)
        u = one.square.u * float(np.sqrt(student_variance(one.square.dof)))
        out += _toml_of(located, "tilt", Normal(u), one.file.name)
    for name in one.errors if one.turning is not None else ():
        assert one.turning is not None
        value, covariance = turning_input(one.turning, name)
        turning = RotaryCyclic(name, value)
        out += _toml_of(
            turning,
            "coefficients",
            MultivariateNormal(covariance * student_variance(one.turning.dof)),
            one.file.name,
        )
    return out


def _toml_of(effect: Effect, parameter: str, law: Law | MultivariateNormal, source: str) -> str:
    known = Input(effect.name, str(effect.where), parameter, law, "machine", "")
    said = input_toml(effect, known, source).replace("diagnosed from", "reversal")
    return effect_toml(effect) + said
