"""Places of an effect on a machine and recording: every place, as an effect at its typical numbers."""

from __future__ import annotations

import itertools
from dataclasses import Field
from typing import Any

import numpy as np

from vcmm.core.axes import LETTERS, in_order, is_rotary
from vcmm.core.declaration import Site
from vcmm.core.effect import FREE_LINKS, Effect, place_fields, required
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Run
from vcmm.learn.diagnosis.problem import Problem

PAIRS = ("C0Y", "B0Z", "A0Z")
NO_TEMPERATURE = ("pressure_hPa", "humidity_pct", "spindle_rpm", "spindle_load_W", "load_kg")  # other logs


def where_of(effect: Effect) -> dict[str, str]:
    """Place fields of an effect that say something; "other" of contract section 6 is the second axis."""
    places = [(f, getattr(effect, f.name)) for f in place_fields(effect)]
    return {f.name: str(v) for f, v in places if v not in ("", ()) and not f.metadata.get("quiet", False)}


def missing_columns(effect: Effect, run: Run) -> tuple[str, ...]:
    """Return the required columns that neither the run nor its logs have."""
    logged = {f"temp_{sensor}_C" for sensor in run.series}
    have = logged | set(run.series) | set(run.columns) | set(run.labels)
    label = ("event",) if effect.per == "event" else ()  # random per event: without events it is a constant
    return tuple(c for c in (*required(effect), *label) if c not in have)


def instances(kind: type[Effect], problem: Problem) -> list[Effect]:
    """Return the effect at every place it can have on this machine and recording; the machine's own version where it has one."""
    present = {effect.id: effect for effect in problem.machine.effects if isinstance(effect, kind)}
    names = [f.name for f in place_fields(kind)]
    site = _site(problem)
    out: list[Effect] = []
    for values in itertools.product(*(place_values(f, problem) for f in place_fields(kind))):
        place = dict(zip(names, values))
        if "other" in place and place["other"] == place["axis"]:
            continue
        try:
            effect: Effect = kind.diagnosis.make_at(kind, place, site)
        except (UsageError, ModelLimit):
            continue
        if effect.link in (*FREE_LINKS, *problem.machine.chain.letters):
            out.append(present.get(effect.id, effect))
    return out


def _site(problem: Problem) -> Site:
    machine = problem.machine
    return Site(machine.effects, tuple(machine.chain.work), tuple(machine.chain.tool), problem.run)


def place_values(spec: Field[Any], problem: Problem) -> list[Any]:
    """Return the values that a place field can take here."""
    letters, run = problem.machine.chain.letters, problem.run
    linear = [a for a in letters if not is_rotary(a)]
    if spec.name in ("axis", "other"):
        return in_order(letters)
    if spec.name == "pair":
        return [p for p in PAIRS if p[2] in linear and "XYZ"["ABC".index(p[0])] in linear]
    if spec.name == "component":
        kinds = [f"E{d}{a}" for a in letters for d in LETTERS]
        return kinds + [f"{d}0{a}" for a in letters if is_rotary(a) for d in LETTERS]
    if spec.name == "direction":
        return ["x", "y", "z"]
    if spec.name == "sensor":
        return sensors(run)
    if spec.metadata["forms"]:  # another form of the same physics: all are options of one family
        return list(spec.metadata["forms"])
    if spec.name in run.labels:
        values = [str(v) for v in np.unique(run.labels[spec.name])]
        return ["", *values] if len(values) > 1 else [""]
    return [spec.default]


def sensors(run: Run) -> list[str]:
    """Return the names of the temperatures that vary or differ from 20 degC: columns temp_<name>_C and logs."""
    named = {c.removeprefix("temp_").removesuffix("_C") for c in run.columns if c.startswith("temp_")}
    return sorted(
        n for n in named | set(run.series) if n not in NO_TEMPERATURE and not n.startswith("accel_")
    )
