"""What of a curve is a simple name: a change of geometry whose slope is a scale or a squareness says so, with its number.

A curve with a small bend wins over its straight part by evidence; a person still wants to read "square by -60 urad".
"""

from __future__ import annotations

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.core.effect import parameter, unit_at
from vcmm.core.units import in_unit
from vcmm.learn.diagnosis.candidates import Family, Option, rebuild_option
from vcmm.learn.diagnosis.constants import MOSTLY, NOTHING
from vcmm.learn.diagnosis.evidence import visible
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.select import Selection
from vcmm.learn.diagnosis.special_cases import generalises
from vcmm.physics import BY_NAME


def simple_part(
    selection: Selection, i: int, families: tuple[Family, ...], problem: Problem, white: Whitener
) -> str:
    """'95 % of it is squareness C0Y, -61.2 urad'; '' where term i is no curve or holds no simple name to that extent."""
    term = selection.terms[i]
    if term.option.columns.shape[1] < 2:
        return ""
    signal = selection.signal(i)
    best: tuple[float, Family, Option, float] | None = None
    for family in families:
        simple = family.name in BY_NAME and BY_NAME[family.name].diagnosis.is_uniform
        if not simple or not generalises(term.family.name, family.name):
            continue
        for known in (o for o in family.options if o.columns.shape[1] == 1 and o.effect is not None):
            option = known if len(known.columns) == problem.m else rebuild_option(known, problem)
            x = None if option is None else visible(option.columns, white)
            if option is None or x is None:
                continue
            size = float(x[:, 0] @ signal / (x[:, 0] @ x[:, 0]))
            share = size**2 * float(x[:, 0] @ x[:, 0]) / max(float(signal @ signal), NOTHING)
            if share > (best[0] if best else MOSTLY):
                best = share, family, option, size
    return _text(*best) if best else ""


def _text(share: float, family: Family, option: Option, size: float) -> str:
    assert option.effect is not None
    show = parameter(option.effect, option.labels[0]).metadata["show"]
    unit = unit_at(option.effect, show, axis=str(getattr(option.effect, "axis", "")))
    value = in_unit(size * float(option.unit[0]), unit)
    where = " ".join(family.where.values())
    return f"{100 * share:.0f} % of it is {family.name} {where}".rstrip() + f", {value:.3g} {unit}"
