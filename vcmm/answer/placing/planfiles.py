"""A plan as files: plan/1 TOML and one CSV of points per step, which read back to the same plan; the curve as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vcmm.answer.placing.planning import PlanPoint, PlanResult
from vcmm.core.text import csv_of, quote
from vcmm.part.gps import characteristics as gps
from vcmm.task.measuring.plan import Plan, Step
from vcmm.task.measuring.qualification import Qualification
from vcmm.task.measuring.scenario import Scenario


def plan_files(plan: Plan, qualifications: Mapping[str, Qualification] | None = None) -> dict[str, str]:
    """Return file name -> text: plan.toml and plan-01-<feature>.csv, ..."""
    lines, texts = ['vcmm = "plan/1"'], {}
    if plan.alignment is not None:
        scheme = plan.alignment
        roles = (("plane", scheme.plane), ("line", scheme.line), ("origin", scheme.origin))
        keys = [f"{role} = {_names(value)}" for role, value in roles if value]
        lines.append(f"alignment = {{ {', '.join(keys)} }}")
    t = plan.touch
    lines.append(
        f'touch = {{ speed = "{t.speed!r} mm/s", approach = "{t.approach!r} mm", clearance = "{t.clearance!r} mm", '
        f'positioning = "{t.positioning!r} mm/s" }}'
    )
    for name in dict.fromkeys(s.stylus for s in plan.steps):
        lines += ["", *_stylus(plan, name, (qualifications or {}).get(name))]
    for i, step in enumerate(plan.steps, 1):
        file = f"plan-{i:02d}-{''.join(c if c.isalnum() else '_' for c in step.feature)}.csv"
        texts[file] = _points(step)
        lines += ["", "[[steps]]", f"feature = {quote(step.feature)}", f"stylus = {quote(step.stylus)}"]
        lines.append(f"points = {quote(file)}")
        if step.approach is not None:
            lines.append(f"approach = [{', '.join(repr(float(v)) for v in step.approach[0])}]")
    return {"plan.toml": "\n".join(lines) + "\n", **texts}


def _stylus(plan: Plan, name: str, qualification: Qualification | None) -> list[str]:
    s = plan.styli[name]
    offset = " ".join(repr(float(v)) for v in s.offset)
    out = [
        f"[styli.{quote(name)}]",
        f'offset = "{offset} mm"',
        f'tip_diameter = "{2.0 * s.tip_radius!r} mm"',
    ]
    out += [f'length = "{float(s.length)!r} mm"'] if s.length > 0.0 else []
    out += [f"event = {quote(s.event)}"] if s.event else []
    if qualification is not None:
        sizes = (qualification.diameter, qualification.u_diameter, qualification.form)
        named = zip(("sphere_diameter", "u_diameter", "form"), sizes)
        out.append("qualification = { " + ", ".join(f'{k} = "{float(v)!r} mm"' for k, v in named) + " }")
    return out


def _points(step: Step) -> str:
    rows = [[*(f"{v:.9f}" for v in p), *(f"{v:.12f}" for v in n)] for p, n in zip(step.points, step.normals)]
    return csv_of([["x_mm", "y_mm", "z_mm", "nx", "ny", "nz"], *rows])


def _names(value: str | tuple[str, ...]) -> str:
    return quote(value) if isinstance(value, str) else "[" + ", ".join(quote(v) for v in value) + "]"


def plan_json(scenario: Scenario, result: PlanResult) -> dict[str, Any]:
    """Return the body of vcmm.plan/1: budget, styli, forms, curve, chosen and present plan."""
    units = {c.name: gps.unit(c) for c in scenario.part.characteristics}
    return {
        "budget_minutes": result.budget_s / 60.0,
        "styli": dict(result.styli),
        "form_um": {name: 1e3 * value for name, value in result.forms.items()},
        "pareto": [_entry(p, units) for p in result.pareto],
        "chosen": _entry(result.choice, units),
        "present": _entry(result.present, units),
        "steps": [
            {"feature": s.feature, "stylus": s.stylus, "points": len(s.points)} for s in result.plan.steps
        ],
    }


def _entry(point: PlanPoint, units: Mapping[str, str]) -> dict[str, Any]:
    characteristics = [
        {"name": n, f"u_{units[n]}": point.u[n], f"U_{units[n]}": point.expanded[n]} for n in point.u
    ]
    return {
        "minutes": point.minutes,
        "touches": point.touches,
        "points": dict(point.per_feature),
        "objective": point.objective,
        "characteristics": characteristics,
    }
