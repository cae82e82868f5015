"""Where an effect can sit on this machine and recording: every place of it, as an effect at its typical numbers."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import Field
from typing import Any, cast

import numpy as np

from vcmm.core.effect import FREE_LINKS, Effect, place_fields
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import ROTARY
from vcmm.core.run import Array, Run
from vcmm.diagnosis.problem import Problem

PAIRS = ("C0Y", "B0Z", "A0Z")
NO_TEMPERATURE = ("pressure_hPa", "humidity_pct", "spindle_rpm", "load_kg")  # other logs
SHAPES = ("follows", "zero")
FULL_TURN = np.radians(345.0)


def where_of(effect: Effect) -> dict[str, str]:
    """Place fields of an effect that say something; "other" of contract section 6 is the second axis."""
    said = [(f, getattr(effect, f.name)) for f in place_fields(effect)]
    return {f.name: str(v) for f, v in said if v not in ("", ()) and not f.metadata.get("quiet", False)}


def lacking_columns(effect: Effect, run: Run) -> tuple[str, ...]:
    """Required columns that neither the run nor its logs have."""
    logged = {f"temp_{sensor}_C" for sensor in run.series}
    have = logged | set(run.series) | set(run.columns) | set(run.labels)
    label = ("event",) if effect.per == "event" else ()  # random per event: without events it is a constant
    return tuple(c for c in (*effect.required(), *label) if c not in have)


def instances(kind: type[Effect], problem: Problem) -> list[Effect]:
    """The effect at every place it can have on this machine and recording; the machine's own version where it has one."""
    present = {effect.id: effect for effect in problem.machine.effects if isinstance(effect, kind)}
    names = [f.name for f in place_fields(kind)]
    out: list[Effect] = []
    for values in itertools.product(*(domain(f, problem) for f in place_fields(kind))):
        place = dict(zip(names, values))
        if "other" in place and place["other"] == place["axis"]:
            continue
        try:
            effect = _made(kind, place, problem)
        except (UsageError, ModelLimit):
            continue
        if effect.link in (*FREE_LINKS, *problem.machine.chain.letters):
            out.append(present.get(effect.id, effect))
    return out


def _made(kind: type[Effect], place: Mapping[str, Any], problem: Problem) -> Effect:
    """One instance, with what it takes from the stored tables, the travel, the chain or the part's size."""
    machine, made = problem.machine, cast(Any, kind)
    if kind.name == "abbe_offset":
        return cast(Effect, made.from_tables(place["axis"], machine.effects))
    if kind.name == "map_interpolation":
        return cast(Effect, made.from_table(_table(place["component"], problem)))
    if kind.name == "geometric_change":
        q = problem.run.q(place["component"][2])
        if place["component"][2] in ROTARY and float(np.ptp(q)) > FULL_TURN:
            raise UsageError(
                "after a full turn an axis is where it was: its geometry repeats, see rotary_cyclic"
            )
        return cast(Effect, made(place["component"], np.array([q.min(), q.max()])))
    changes: dict[str, Any] = dict(place)
    if kind.name == "gradient_bending":
        changes["carries"] = "workpiece" if place["axis"] in machine.chain.work else "tool"
    if kind.name == "lost_motion_curve":
        changes["nodes"] = _ends(problem.run.q(place["axis"]))
    if kind.name == "clamping":
        changes["length"] = max(float(np.abs(problem.run.part_point).max()), 1.0)
    return kind(**changes)


def _ends(q: Array) -> Array:
    """The places between which a curve is fitted: four at least, else a straight line says as much."""
    if len(np.unique(np.round(q, 6))) < 4:
        raise UsageError("a curve over the travel needs four places")
    return np.array([q.min(), q.max()])


def _table(component: str, problem: Problem) -> Effect:
    for effect in problem.machine.effects:
        if effect.name == "component_table" and getattr(effect, "component", "") == component:
            return effect
    raise UsageError(f"the machine has no table of {component}")


def domain(spec: Field[Any], problem: Problem) -> list[Any]:
    """Values that a place field can take here."""
    letters, run = problem.machine.chain.letters, problem.run
    linear = [a for a in letters if a not in ROTARY]
    if spec.name in ("axis", "other"):
        return [a for a in "XYZABC" if a in letters]
    if spec.name == "pair":
        return [p for p in PAIRS if p[2] in linear and "XYZ"["ABC".index(p[0])] in linear]
    if spec.name == "component":
        kinds = [f"E{d}{a}" for a in letters for d in "XYZABC"]
        return kinds + [f"{d}0{a}" for a in letters if a in ROTARY for d in "XYZABC"]
    if spec.name == "direction":
        return ["x", "y", "z"]
    if spec.name == "sensor":
        return sensors(run)
    if spec.name in SHAPES:  # another form of the same physics: both are options of one family
        return [0, 1]
    if spec.name in run.labels:
        values = [str(v) for v in np.unique(run.labels[spec.name])]
        return ["", *values] if len(values) > 1 else [""]
    return [spec.default]


def sensors(run: Run) -> list[str]:
    """Names of the temperatures that vary or differ from 20 degC: columns temp_<name>_C and logs."""
    named = {c.removeprefix("temp_").removesuffix("_C") for c in run.columns if c.startswith("temp_")}
    return sorted(
        n for n in named | set(run.series) if n not in NO_TEMPERATURE and not n.startswith("accel_")
    )
