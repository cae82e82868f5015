"""Reasons why a pose cannot be used, in words: which touch, pair or feature, by how much, and what to do.

`Hindrance` is one such thing, whichever constraint names it; `Constraint` is the interface of all constraints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from vcmm.answer.placing.tool import NAMES
from vcmm.core.pose import Array, Pose
from vcmm.task.measuring.fixture import off_fixture, six_of


@dataclass(frozen=True)
class Hindrance:
    """One thing that keeps a pose from being used. amount > 0 in `unit` (mm, rad or kg): by how much it is missed.

    name: the kind of constraint. constraint: which one of its kind. point: the touch, pair, feature or axis it is about.
    """

    name: str
    constraint: str
    point: str
    amount: float
    text: str
    unit: str = "mm"


class Constraint(Protocol):
    """A constraint on poses: which of (m, 6) can be used, and what is wrong with one."""

    def problems(self, pose: Pose) -> Sequence[Hindrance]: ...

    def feasible(self, poses: Array) -> npt.NDArray[np.bool_]: ...


def _of(constraint: str, text: str, point: str, amount: float, unit: str = "mm") -> Hindrance:
    """Return the hindrance of a constraint that is the only one of its kind."""
    return Hindrance(constraint, constraint, point, float(amount), text, unit)


REMEDIES = {
    "shaft": "use a thinner or longer stylus, or another direction of the stylus",
    "extension": "use a longer stylus",
    "head": "use a longer stylus or an extension, or turn the part",
    "quill": "use a longer stylus or an extension, or turn the part",
}


def problems(check: Any, pose: Pose) -> list[Hindrance]:
    """Return everything that is in the way at one pose; check is a `vcmm.answer.placing.reach.Feasibility`, which is above this module in
    the imports."""
    single = pose.alone()
    every = [*_static(check, single), *_travel(check, single), *_of_tool(check, pose)]
    return [p for p in every if p.amount > 0.0]


def _static(check: Any, single: Pose) -> list[Hindrance]:
    out, machine, part = [], check.scenario.machine, check.scenario.part
    if check.overload():
        text = f"the part weighs {part.mass:g} kg, the machine carries {machine.load_limit:g} kg"
        out.append(_of("load", text, "part", check.overload(), "kg"))
    if check.fixture is not None:
        shift, turn = off_fixture(check.fixture, six_of(single))
        out.append(
            _of(
                "fixture",
                f"the fixture does not allow this place: {shift[0]:.4g} mm off",
                "part",
                float(shift[0]),
            )
        )
        text = f"the fixture does not allow this turn: {np.degrees(turn[0]):.4g} deg off"
        out.append(_of("fixture", text, "part", float(turn[0]), "rad"))
    if check.scenario.surroundings.table is not None:
        sunk = float(check._depth_in_table(single)[0])
        out.append(_of("table", f"the part reaches {sunk:.4g} mm below the table; raise it", "part", sunk))
    return out


def _travel(check: Any, single: Pose) -> list[Hindrance]:
    out = []
    size, over = (a[0] for a in check._travel(single))
    low, high = check.limits()
    for i, letter in enumerate("XYZ"):
        if size[i] > 0.0:
            text = (
                f"the points span {high[i] - low[i] + size[i]:.5g} mm along {letter}, its travel is {high[i] - low[i]:.5g} mm: "
                "the part is larger than the machine in this orientation"
            )
            out.append(_of("size", text, letter, float(size[i])))
    n = check.rows.n
    kinds = ["touch"] * n + ["start of the approach"] * n + ["retract"] * n + ["clearance above the start"]
    worst = over.max(axis=1).reshape(-1)
    for touch in range(n):
        rows = [
            r for r in (touch, n + touch, 2 * n + touch, *([3 * n] if touch == 0 else [])) if worst[r] > 0.0
        ]
        if rows:
            row = max(rows, key=lambda r: float(worst[r]))
            letter = "XYZ"[int(over[row].argmax())]
            name, stylus = check.rows.names[touch], check.rows.styli[check.rows.stylus[touch]]
            text = f'{name} with stylus "{stylus}": {kinds[row]} is {worst[row]:.4g} mm beyond the travel of {letter}'
            out.append(_of("travel", text, name, float(worst[row])))
    return sorted(out, key=lambda p: -p.amount)


def _of_tool(check: Any, pose: Pose) -> list[Hindrance]:
    names, out = check.rows.names, []
    steep = check.steep(pose.rotation)
    for i in np.flatnonzero(steep):
        limit = np.degrees(check.scenario.surroundings.steepest)
        text = f"{names[i]}: the stylus leans {np.degrees(steep[i]) + limit:.4g} deg from the normal, allowed are {limit:.4g}"
        out.append(_of("direction", text, names[i], float(steep[i]), "rad"))
    of_part, table = check.room(pose.rotation), check.table_room(pose)
    met = _bodies_in_the_way(check, pose, of_part)
    for body in NAMES:
        what = [f"the {body} meets {name}" for name in met[body]]
        out += _lacking(names, body, of_part.bodies[body], what, REMEDIES[body])
    fix = "reduce approach, use a smaller tip, or correct the part's features"
    what = [f"the tip meets {name} on its approach" for name in met["approach"]]
    out += _lacking(names, "approach", of_part.tip, what, fix)
    if table is not None:
        worst = np.max([*table.room.bodies.values(), table.room.tip], axis=0)
        out += _lacking(names, "clamps", worst, "the tool meets a clamp or the table", "move clamp or part")
        clamps = [c.name for c in check.scenario.surroundings.clamps if c.on == "table"]
        for name, amount in zip(clamps, table.overlap):
            out.append(
                _of("clamps", f'the part overlaps the clamp "{name}" by {amount:.4g} mm', name, float(amount))
            )
    every, ends = check.blocked_moves(pose.alone(), of_part, table)
    moves = every[0]
    for k in np.flatnonzero(moves):
        a, b = (names[i] for i in of_part.pairs[k])
        text = f"from {a} to {b}: neither straight nor by drawing back along the shaft is the way free ({moves[k]:.4g} mm)"
        out.append(_of("moves", text, f"{a} - {b}", float(moves[k])))
    out += _lacking(names, "moves", ends, "the tool cannot be drawn back along its shaft", REMEDIES["head"])
    return out


def _bodies_in_the_way(check: Any, pose: Pose, of_part: Any) -> dict[str, list[str]]:
    """Return, for each body of the tool and for the tip, the obstacle at each touch: the part or a clamp that the part carries."""
    amounts = {**of_part.bodies, "approach": of_part.tip}
    carried = any(c.on == "part" for c in check.scenario.surroundings.clamps)
    if not carried or not any(a.any() for a in amounts.values()):
        return {body: ["the part"] * len(a) for body, a in amounts.items()}
    alone = {
        name: {**r.bodies, "approach": r.tip} for name, r in check.rooms_by_obstacle(pose.rotation).items()
    }
    return {
        body: [" and ".join(n for n, a in alone.items() if a[body][i] > 0.0) or "the part" for i in range(len(lack))]
        for body, lack in amounts.items()
    }  # fmt: skip


def _lacking(
    names: tuple[str, ...], constraint: str, amount: Array, what: str | list[str], fix: str
) -> list[Hindrance]:
    texts = [what] * len(amount) if isinstance(what, str) else what
    rows = np.flatnonzero(amount)
    rows = rows[np.argsort(-amount[rows], kind="stable")]
    return [
        _of(
            constraint,
            f"{names[i]}: {texts[i]} ({amount[i]:.4g} mm too near); {fix}",
            names[i],
            float(amount[i]),
        )
        for i in rows
    ]
