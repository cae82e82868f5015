"""Remarks on a scenario: statements without effect, and missing ones that count as perfectly known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.effect import required
from vcmm.core.expansions import unusual_expansion
from vcmm.core.inputs import EVERY, Input
from vcmm.core.laws import Law
from vcmm.core.run import T0_DEG_C, Array
from vcmm.part.characteristic import Characteristic
from vcmm.part.extent import EDGE, beyond_extent
from vcmm.part.gps.contradictions import always_kept, free_words, left_free, redundant_zones
from vcmm.part.part import ends, frame
from vcmm.physics.structure.qualification import StylusQualification
from vcmm.physics.structure.residual import ResidualField
from vcmm.physics.structure.tip import TipOffset, TipRadius
from vcmm.task.measuring.scenario import Scenario

OF_QUALIFICATION = (
    TipRadius.name,
    TipOffset.name,
    StylusQualification.name,
)  # what the qualification of a stylus may err by


def remarks(scenario: Scenario) -> tuple[str, ...]:
    """Return sentences for `check`, the result and the report; empty when there are no remarks."""
    return (
        *_unused_temperatures(scenario), *_exact_temperatures(scenario), *_unqualified_warnings(scenario),
        *_short_styli(scenario), *_inward_normals(scenario), *_drawing_warnings(scenario), *_short_arcs(scenario), *_beside(scenario),
        *_unusual_warmth(scenario), *_unusual_spheres(scenario), *independent_draws((*scenario.machine.inputs, *scenario.inputs)), *scenario.machine.remarks,
    )  # fmt: skip


def independent_draws(inputs: Sequence[Input]) -> list[str]:
    """Return the remarks on fields whose nodes are sampled independently and interpolated afterwards; empty where there are none."""
    independent = any(
        i.effect == ResidualField.name and i.parameter == "values" and isinstance(i.law, Law) for i in inputs
    )
    return [ResidualField.independent_draws] if independent else []


INTO = (
    -0.2
)  # cosine between a normal and the way from tip to head, below which the stylus comes out of the material


def _short_styli(scenario: Scenario) -> list[str]:
    """Return remarks on touches deeper in a bore than the stylus is long."""
    out = []
    for step in scenario.plan.steps:
        feature, stylus = scenario.part.features[step.feature], scenario.plan.styli[step.stylus]
        if not feature.inside or feature.kind not in ("cylinder", "cone"):
            continue
        reach = stylus.length or float(np.linalg.norm(stylus.offset))
        up = scenario.pose.inverse().turn(-stylus.direction)  # from tip to head, drawing frame
        along = up @ feature.axis
        if abs(along) < 0.7 or reach == 0.0:
            continue
        mouth = ends(feature) @ feature.axis
        depth = np.max(
            mouth.max() - step.points @ feature.axis
            if along > 0
            else step.points @ feature.axis - mouth.min()
        )
        if depth > reach:
            out.append(
                f"{step.feature}: touches {depth:.4g} mm deep with stylus {step.stylus}, which is {reach:.4g} mm long: its head would "
                "stand in the part; correct offset or length, or touch nearer to the mouth"
            )
    return out


def _inward_normals(scenario: Scenario) -> list[str]:
    """Return remarks on planes that would be touched from inside the material: the way from tip to head leads through the surface."""
    out = []
    for step in scenario.plan.steps:
        feature, stylus = scenario.part.features[step.feature], scenario.plan.styli[step.stylus]
        if feature.kind not in ("plane", "line", "point") or not len(step.normals):
            continue
        up = scenario.pose.inverse().turn(-stylus.direction)
        if float(np.max(step.normals @ up)) < INTO:
            out.append(
                f"{step.feature}: its normal points away from the head of stylus {step.stylus}, which would reach it through the "
                "material: normals point out of the material; turn the normal, or use a stylus from that side"
            )
    return out


def _drawing_warnings(scenario: Scenario) -> list[str]:
    """Return remarks on zones without effect, and on positions that their datums do not fix."""
    part = scenario.part
    out = redundant_zones(part.characteristics, part.features)
    follows = "the alignment of the plan" if scenario.plan.alignment else "[pose], which nothing measures"
    for c in part.characteristics:
        free = left_free(c, part.features)
        if len(free):
            out.append(_what_is_free(c, free, always_kept(c, part.features), follows))
    return out


def _what_is_free(c: Characteristic, free: Array, kept: bool, follows: str) -> str:
    of, words = c.of[0], free_words(free)
    if not c.datums:
        return f'"{c.name}": without datums {of} is free to move ({words}); there it follows {follows}: add a datum that holds it'
    what = "so that no part breaks it: its value is 0" if kept else "and its value is the smallest so"
    return (
        f'"{c.name}": its datums ({", ".join(c.datums)}) leave {of} free to move ({words}); its zone moves with it there (ISO 5459), '
        f"{what}: add a datum if the drawing holds it"
    )


SHORT_ARC_DEG = 90.0  # deg: over less of a circle, size and place are poorly separated


def _short_arcs(scenario: Scenario) -> list[str]:
    """Round features that the plan touches over a small part of their circle only."""
    out = []
    for name, feature in scenario.part.features.items():
        steps = [s.points for s in scenario.plan.steps if s.feature == name and len(s.points)]
        if feature.kind not in ("circle", "cylinder", "cone") or not steps:
            continue
        u, v, _ = frame(feature)
        arm = np.concatenate(steps) - feature.point
        turn = np.sort(np.degrees(np.arctan2(arm @ v, arm @ u)))
        gaps = np.diff(np.append(turn, turn[0] + 360.0))
        covered = 360.0 - float(gaps.max())
        if covered < SHORT_ARC_DEG:
            out.append(
                f"{name}: touched over {covered:.0f} deg of its circle only; so short an arc separates size and place poorly, and U "
                "says how badly: touch more of it"
            )
    return out


def _beside(scenario: Scenario) -> list[str]:
    """Return remarks on planned points that lie beyond the ends or edges of their feature."""
    out = []
    for step in scenario.plan.steps:
        feature = scenario.part.features[step.feature]
        beyond = beyond_extent(feature, step.points) if len(step.points) else np.zeros(1)
        if float(beyond.max()) > EDGE:
            out.append(
                f"{step.feature}: {int((beyond > EDGE).sum())} planned point(s) lie up to {float(beyond.max()):.4g} mm beyond the feature, where "
                "the tip meets air: correct the points, or the size of the feature"
            )
    return out


COLD, HOT = 5.0, 40.0  # degC: rooms in which parts are measured
EXPANDS = 2e-4  # 1/K: more than any solid that is measured


MOST_OF_SPHERE = 0.01  # mm: certificates of reference spheres state 0.02 to 2 um


def _unusual_spheres(scenario: Scenario) -> list[str]:
    """Reference spheres whose certificate may have a slip of the unit."""
    return [
        f'stylus {name}: qualification {key} = "{value:g} mm"; certificates of reference spheres state 0.02 to 2 um: check the unit'
        for name, how in scenario.qualifications.items()
        for key, value in (("u_diameter", how.u_diameter), ("form", how.form))
        if value > MOST_OF_SPHERE
    ]


def _unusual_warmth(scenario: Scenario) -> list[str]:
    """Return remarks on temperatures and expansions that may be a slip of the unit."""
    out = [
        f"the temperature {c[5:-2].replace('_', ' ')} = {t:g} degC is not that of a measuring room; expansion is taken as linear up to there"
        for c, t in scenario.constants.items()
        if c.startswith("temp_") and c != "temp_gradient_C" and not COLD <= t <= HOT
    ]
    if abs(scenario.part.expansion) > EXPANDS:
        out.append(
            f"the part expands by {scenario.part.expansion * 1e6:g} um/(m K); steel has 11.5, aluminium 23, plastics up to 200: check the unit"
        )
    elif remark := unusual_expansion("[part] expansion", scenario.part.expansion):
        out.append(remark)
    return out


def _unused_temperatures(scenario: Scenario) -> list[str]:
    """Return remarks on temperatures that no effect of the machine or part reads."""
    read = {column for effect in scenario.machine.effects for column in required(effect)}
    cures = {"temp_part_C": "[part] expansion", "temp_gradient_C": "an effect that bends with it"}
    out = []
    matter = {
        value for column, value in scenario.constants.items() if column in read
    }  # a room that counts for others
    for column, value in scenario.constants.items():
        neutral = 0.0 if column == "temp_gradient_C" else T0_DEG_C
        if column.startswith("temp_") and value not in (neutral, *matter) and column not in read:
            name = column.removeprefix("temp_").removesuffix("_C")
            cure = cures.get(
                column,
                "[machine.environment] scales" if name.startswith("scale_") else "an effect with that sensor",
            )
            out.append(
                f"the temperature {name} = {value:g} has no effect: nothing in the machine or part depends on it; add {cure}"
            )
    return out


def _exact_temperatures(scenario: Scenario) -> list[str]:
    """Return remarks on temperatures that matter and have no uncertainty."""
    inputs = (*scenario.machine.inputs, *scenario.inputs)
    channels = {single.parameter for i in inputs for single, _ in i.scalars if single.is_channel}
    out = []
    for effect in scenario.machine.effects:
        for column in required(effect):
            readings = {column, column.replace("temp_", "reading_", 1)}
            if column.startswith("temp_") and not readings & channels and bool(getattr(effect, "alpha", 0.0)):
                name = column.removeprefix("temp_").removesuffix("_C")
                out.append(
                    f'the temperature {name} is taken as exactly known; add [environment] u_temperature = {{ {name} = "0.1 K" }}'
                )
    return list(dict.fromkeys(out))


def _unqualified_warnings(scenario: Scenario) -> list[str]:
    used = dict.fromkeys(step.stylus for step in scenario.plan.steps)
    bare = [name for name in used if name not in scenario.qualifications]
    stated = {i.where for i in scenario.machine.inputs if i.effect in OF_QUALIFICATION}
    bare = [name for name in bare if not {name, "", EVERY} & stated]
    if not bare:
        return []
    word = "stylus" if len(bare) == 1 else "styli"
    return [
        f"{word} {', '.join(bare)}: tip radius and offset are taken as exactly known; add qualification = {{ sphere_diameter = ... }}"
    ]
