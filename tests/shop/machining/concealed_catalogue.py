"""One effect of the catalogue after another is concealed in the block, with scatter per point, per move or per pass."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import vcmm
from vcmm.core.effect import Effect, parameter_fields, place_fields, with_parameter
from vcmm.core.errors import VcmmError
from vcmm.physics import ALL
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import set_up
from vcmm.task.measuring.cut_scenario import CutScenario

LARGEST, NOISE, SCATTER = 12e-3, 0.3e-3, 0.6e-3  # mm: of what is concealed, of a point, of a move or a pass
SEEN = 2e-3  # mm: an effect that shows less in this part, made as large as it may be, is left out
PLACES = {
    "axis": "X",
    "direction": "z",
    "tool": "",
    "other": "Z",
    "pair": "C0Y",
    "component": "EBX",
    "clamp": "1",
    "part": "",
}
OTHER_PLACES = {"spindle_growth": {"axis": "Z"}, "spindle_load_growth": {"axis": "Z"}}
PER = ("point", "move", "pass")


def concealed() -> Iterator[Effect]:
    """One effect of every class of which a diagnosis may speak, its linear numbers of their usual size."""
    for kind in ALL:
        if not kind.diagnosis.is_named or kind.about.is_random:
            continue
        try:
            place = {
                f.name: PLACES[f.name] for f in place_fields(kind) if f.name in PLACES
            } | OTHER_PLACES.get(kind.name, {})
            effect = kind(**place)
            for spec in parameter_fields(kind):
                usual, value = (
                    spec.metadata.get("typical"),
                    np.asarray(getattr(effect, spec.name), dtype=float),
                )
                if usual is not None and not spec.metadata["scan"]:
                    effect = with_parameter(
                        effect,
                        spec.name,
                        np.full(value.shape, usual.amount)[()] if value.ndim else usual.amount,
                    )
        except (VcmmError, TypeError, ValueError):
            continue  # it wants a table, a map or a place that the block has not
        yield effect


def in_part(
    scenario: CutScenario, effect: Effect
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
    """(points, normals, departures by the effect, move and pass that made each point); None where it does not show."""
    try:
        task, world, _ = finished_part(
            set_up(
                replace(
                    scenario, machine=replace(scenario.machine, effects=(*scenario.machine.effects, effect))
                )
            )
        )
        shows = world.contacts.surface(world.tool_errors) - world.contacts.surface(world.tool.known_error)
    except VcmmError:
        return None  # a column that a cut has not, a rotary axis, a number that is none for this part
    if not np.isfinite(shows).all() or np.abs(shows).max() < 1e-6:
        return None
    row, _ = world.contacts.deepest(world.tool_errors)
    line = world.tool.run.columns["line"][row]
    rapid = np.floor(line / 8.0)  # stretches between retracts, coarsely
    return shows, task.touches.run.labels["feature"], line, rapid


def points_file(folder: Path, scenario: CutScenario, effect: Effect, per: str, seed: int) -> Path | None:
    """points.csv of a part cut with the effect, every third point; None where the effect does not show in it."""
    seen = in_part(scenario, effect)
    if seen is None:
        return None
    shows, feature, line, stretch = seen
    shows = shows * min(1.0, LARGEST / np.abs(shows).max())
    if np.abs(shows).max() < SEEN:
        shows = shows * SEEN * 3.0 / np.abs(shows).max()
    rng = np.random.default_rng([seed, len(per)])
    shows = shows + rng.normal(0.0, NOISE, len(shows))
    if per != "point":
        group = line if per == "move" else stretch
        names, which = np.unique(group, return_inverse=True)
        shows = shows + rng.normal(0.0, SCATTER, len(names))[which]
    task, _, _ = finished_part(set_up(scenario))
    at = task.touches.points + shows[:, None] * task.touches.normals
    rows = [f"{f},{p[0]:.6f},{p[1]:.6f},{p[2]:.6f}" for f, p in zip(feature, at)][::3]
    file = folder / "points.csv"
    file.write_text("\n".join(["feature,x_mm,y_mm,z_mm", *rows]) + "\n")
    return file


__all__ = ["PER", "concealed", "points_file", "vcmm"]
