"""vcmm calibrate design of a touch probe: rotary positions, and the uncertainties expected from them."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from pathlib import Path
from typing import Any, NamedTuple

from vcmm.core.machine import Machine
from vcmm.face.job import Job, Progress, Record
from vcmm.learn.calibration.design import PlannedSetup
from vcmm.learn.calibration.pose_design import PoseCandidate, PosePlan, best_poses, pose_plan, unit_of
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import show_table
from vcmm.show.tables.table import listing


class ChosenPoses(NamedTuple):
    """Rotary positions of a plan, by their number in it: chosen, and all."""

    plan: PosePlan
    numbers: list[int]

    @property
    def everything(self) -> list[int]:
        return list(range(len(self.plan.candidates)))


@dataclass(frozen=True)
class PosesJob(Job[list[PlannedSetup], ChosenPoses]):
    """The rotary positions to touch at, with the standard uncertainty expected of every error. Exit code 1 where even all leave one open."""

    path: Path
    setups: list[PlannedSetup]
    machine: Machine
    budget: float | None
    schema = "vcmm.design/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.path, "setups"

    def load(self) -> list[PlannedSetup]:
        return self.setups

    def run(self, loaded: list[PlannedSetup], report: Progress) -> ChosenPoses:
        plan = pose_plan(loaded, self.machine)
        return ChosenPoses(plan, best_poses(plan, self.budget))

    def body(self, result: ChosenPoses) -> dict[str, Any]:
        (plan, chosen), everything, budget = result, result.everything, self.budget
        return {
            "setups": len(self.setups),
            "all": _record(plan, everything),
            "budget_minutes": budget,
            "best_within_budget": None if budget is None else _record(plan, chosen),
            "cheapest_complete": _record(plan, chosen) if budget is None else None,
            "poses": [_pose(plan.candidates[i]) for i in in_order_of_angles(plan, chosen)],
            "expected": _expected_uncertainties(plan, chosen, everything),
            "correlated": [{"errors": [a, b], "correlation": r} for a, b, r in plan.correlated_pairs(chosen)],
        }

    def record(self, loaded: list[PlannedSetup], result: ChosenPoses) -> Record:
        return Record(self.body(result), sources(self.path), 0)

    def texts(
        self, loaded: list[PlannedSetup], result: ChosenPoses, content: str, folder: Path
    ) -> dict[str, str]:
        return {"design.json": content}

    def exit_code(self, loaded: list[PlannedSetup], result: ChosenPoses) -> int:
        return int(bool(result.plan.identifiability(result.everything).combinations))

    def show(self, loaded: list[PlannedSetup], result: ChosenPoses) -> None:
        _show(result.plan, result.numbers, result.everything, self.body(result))


def in_order_of_angles(plan: PosePlan, chosen: list[int]) -> list[int]:
    """Sort the poses by their angles, the first rotary axis of the chain first, so that it moves least."""
    return sorted(chosen, key=lambda i: (plan.candidates[i].setup, tuple(plan.candidates[i].angles.values())))


def _record(plan: PosePlan, chosen: list[int]) -> dict[str, Any]:
    identified = plan.identifiability(chosen)
    return {
        "setups": list(dict.fromkeys(plan.candidates[i].setup for i in chosen)),
        "poses": len(chosen),
        "touches": sum(plan.candidates[i].touches for i in chosen),
        "minutes": plan.minutes(chosen),
        "volume_um": plan.volume(chosen) * 1e3,
        "identified": list(identified.names),
        "not_identified": identified.document(),
        "condition": identified.condition,
    }


def _pose(candidate: PoseCandidate) -> dict[str, object]:
    angles = {f"{a}_deg": round(degrees(q), 6) for a, q in candidate.angles.items()}
    return {"setup": candidate.setup, **angles, "touches": candidate.touches, "minutes": candidate.minutes}


def _expected_uncertainties(
    plan: PosePlan, chosen: list[int], everything: list[int]
) -> list[dict[str, object]]:
    """Return the u of every error before any touch, after the chosen poses, and after all."""
    before, here, best = plan.before(), plan.uncertainties(chosen), plan.uncertainties(everything)
    out = []
    for name, u in here.items():
        unit, scale = unit_of(name)
        after = {"u": u * scale, "u_all_poses": best[name] * scale}
        out.append({"error": name, "unit": unit, "u_before": before[name] * scale, **after})
    return out


def _two_digits(u: float) -> str:
    """Return a number with two digits, never as a power of ten: 0.078, 1.1, 1000."""
    return f"{u:.2g}" if u < 100 else f"{u:.0f}"


def _show(plan: PosePlan, chosen: list[int], everything: list[int], body: dict[str, Any]) -> None:
    rows = [
        (
            what,
            str(len(some)),
            str(sum(plan.candidates[i].touches for i in some)),
            f"{plan.minutes(some):.3g}",
            f"{plan.volume(some) * 1e3:.3g}",
        )
        for what, some in (("chosen", chosen), ("all of the plan", everything))
    ]
    show_table(listing("poses", ("", "poses", "touches", "minutes", "left over the volume / um"), rows))
    angles = [k for k in body["poses"][0] if k.endswith("_deg")]
    steps = [(str(k + 1), *(f"{pose[a]:g}" for a in angles)) for k, pose in enumerate(body["poses"])]
    show_table(
        listing(
            "rotary positions, in this order", ("", *(a.replace("_deg", " / deg") for a in angles)), steps
        )
    )
    lines = [
        (e["error"], *(f"{_two_digits(e[k])} {e['unit']}" for k in ("u_before", "u", "u_all_poses")))
        for e in body["expected"]
    ]
    columns = ("error", "u before", "u expected after the chosen", "u expected after all of the plan")
    show_table(
        listing(
            "standard uncertainty of every error: by its usual size before any touch, and after",
            columns,
            lines,
        )
    )
    for c in plan.identifiability(everything).combinations:
        print(f"not identified, even by all: {c.text}")
    for pair in body["correlated"]:
        print(f"{' and '.join(pair['errors'])} depend on one another: correlation {pair['correlation']:.2f}")
