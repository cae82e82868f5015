"""Prove a program: cut it virtually and inspect the part, before and after the program was rewritten.

Largest and mean of the absolute departure along the normals, at the usual points of every feature that a characteristic names (or of the
plan), errors at their estimates, the path deviations of the control included. `met`: no point departs by more than is allowed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.shop.cutting.envelope import UNCUT
from vcmm.shop.machining.contact_path import surface_at, tool_side
from vcmm.shop.machining.gauge import gauge_plan
from vcmm.shop.machining.inspection import cut_points
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import Words
from vcmm.task.measuring.cut_scenario import CutScenario


@dataclass(frozen=True, eq=False)
class InspectedCut:
    """off (n,): departures along the normals, mm, plus is material left; feature (n,) of each; uncut: points that no cutter reached."""

    off: Array
    feature: Words
    uncut: int

    @property
    def largest(self) -> float:
        return float(np.abs(self.off).max())

    @property
    def mean(self) -> float:
        return float(np.abs(self.off).mean())

    @property
    def worst(self) -> str:
        """The feature with the largest departure."""
        return str(self.feature[int(np.abs(self.off).argmax())])


@dataclass(frozen=True, eq=False)
class CutProof:
    """The part of the original program and of the new one; allowed: mm. reason: why nothing was inspected, instead."""

    before: InspectedCut | None
    after: InspectedCut | None
    limit: float
    reason: str = ""

    @property
    def is_met(self) -> bool:
        return self.after is not None and self.after.largest <= self.limit and not self.after.uncut

    @property
    def worse(self) -> str:
        """Reason why the new part is worse than the old one, beyond the allowed departure; else ""."""
        if self.before is None or self.after is None:
            return ""
        worse = [
            f"{name} departure {new * 1e3:.2f} um ({self.after.worst}), before {old * 1e3:.2f} um ({self.before.worst})"
            for name, new, old in (
                ("largest", self.after.largest, self.before.largest),
                ("mean", self.after.mean, self.before.mean),
            )
            if new > max(old, self.limit)
        ]
        if self.after.uncut > self.before.uncut:
            worse.append(f"{self.after.uncut} points are left uncut, before {self.before.uncut}")
        return "; ".join(worse)


def inspected_cut(scenario: CutScenario) -> InspectedCut:
    """Cut the part of a scenario and inspect it. Raises DataError, UsageError and ModelLimit."""
    planned = gauge_plan(scenario.part, scenario.plan)
    job = set_up(scenario)
    plan, surface, _ = cut_points(job, planned)
    feature = np.concatenate([np.full(len(s.points), s.feature) for s in plan.steps])
    touch = np.array([str(i) for i in range(len(feature))])
    tool, contacts = tool_side(job, surface, touch, feature)
    uncut = sum(
        int(np.count_nonzero(surface_at(job, s.points, s.normals).status == UNCUT)) for s in planned.steps
    )
    return InspectedCut(contacts.surface(tool.errors()), feature, uncut)


def proof_by_cut(scenario: CutScenario, program: Path, allowed: float) -> CutProof:
    """Cut and inspect the scenario's own program and another one. allowed: mm at any point."""
    try:
        gauge_plan(scenario.part, scenario.plan)
    except UsageError as error:
        return CutProof(None, None, allowed, str(error))
    before = inspected_cut(scenario)
    return CutProof(before, inspected_cut(replace(scenario, program=program)), allowed)


def proof_without_inspection(reason: str) -> CutProof:
    return CutProof(None, None, 0.0, reason)
