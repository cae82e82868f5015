"""A calibrated arm as files: machine.toml, the location errors of its joints, and their joint covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vcmm.core.inputs import Input, JointCovariance
from vcmm.core.laws import MultivariateNormal
from vcmm.files.foreign.isg import ErrorFile, isg_text
from vcmm.files.learned.effect_text import effect_toml, input_toml
from vcmm.files.own.joint_covariance import covariance_text
from vcmm.files.toml_edits import editable, move_names
from vcmm.learn.calibration.arm import ArmFit
from vcmm.physics.structure.squareness import RotaryLocation


def arm_texts(fit: ArmFit, prior: Path, target: Path, sources: Sequence[str]) -> dict[str, str]:
    """Return file name -> text: STEM.toml as `target` says, STEM_errors.csv, STEM_covariance.csv. prior: the machine file with the nominal arm.

    The joint covariance holds the geometry; further terms have an Input each, and what they share with the geometry is not written.
    """
    table, covariance = f"{target.stem}_errors.csv", f"{target.stem}_covariance.csv"
    evidence = f"calibrated from {', '.join(sources)}"
    geometry = [i for i, t in enumerate(fit.terms) if isinstance(t.effect, RotaryLocation)]
    starts = np.cumsum([0, *(t.size for t in fit.terms)])
    rows = starts[geometry]
    names = [fit.terms[i].name for i in geometry]
    joint = JointCovariance(tuple(names), np.full(len(names), np.nan), fit.covariance[np.ix_(rows, rows)])
    document = editable(prior)
    move_names(document, prior.parent, target.parent)
    document.pop("large_errors", None)
    head = (
        str(document.as_string())
        .rstrip()
        .replace('vcmm = "machine/1"\n', 'vcmm = "machine/1"\nlarge_errors = true\n', 1)
    )
    remarks = "".join(f"# {r.text}\n" for r in fit.redundant)
    errors = f'[errors]\ntable = "{table}"\nstate = "residual"\ncovariance = "{covariance}"\nevidence = "{evidence}"\n'
    further = [_term(fit, i, evidence) for i in range(len(fit.terms)) if i not in geometry]
    return {
        f"{target.stem}.toml": "\n".join([head, "", remarks + errors, *further]),
        table: isg_text(ErrorFile((), dict(zip(names, fit.theta[rows].tolist()))), evidence),
        covariance: covariance_text(joint),
    }


def _term(fit: ArmFit, i: int, evidence: str) -> str:
    """Return an effect of two numbers with its Input."""
    term = fit.terms[i]
    start = sum(t.size for t in fit.terms[:i])
    part = slice(start, start + term.size)
    effect = term.with_values(fit.theta[part])
    law = MultivariateNormal(fit.covariance[part, part])
    calibrated = Input(effect.name, effect.where, term.parameter, law, "machine", "")
    text = input_toml(effect, replace(calibrated), evidence).replace(
        "diagnosed from calibrated", "calibrated"
    )
    return effect_toml(effect) + text
