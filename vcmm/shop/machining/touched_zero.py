"""Touches of a program: the shift of its path when a touch reads further, and the errors of the machine at each touch.

A probe answers where ball and surface meet. With an error e of the tip there (actual - commanded) the axes then read

    d = -(e . n) / (a . n)

further along the way a of the probing move, n the outward normal of the surface. The result of the program (a work offset, a
tool length, a mean of two touches, a turned frame) is not looked up in its text: the program is read again with each touch reading
STEP further, and once more with the zeros of the set-up shifted, and the moves are compared. So

    error of a cut = e(cut) + sum over touches of  weight x d        weight = d path / d reading

and the zero of the set-up counts only along the axes on which the program still rests on it. Where an arc is cut larger as a touch
reads further, its path moves away from its centre besides. Hand check: e the same everywhere
and one touch of a face in -X, a = +X: d = -e_x, weight 1, nothing is left along X.

What the probe itself errs by is an error of its tip: length and ball (u_length, u_radius of its tool) the same in all touches, its scatter
(u_touch) in each on its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.inputs import Input
from vcmm.core.knowledge import add_knowledge
from vcmm.core.laws import Normal
from vcmm.core.run import Array
from vcmm.physics.structure.setting import ProbeTouch
from vcmm.program.interpret import read_for
from vcmm.program.moves import PLANES, Move, Program
from vcmm.program.offsetting import sweep_of
from vcmm.program.setup import Setup, turns_with
from vcmm.program.touching import ProbeContact
from vcmm.shop.motion.tool_centre import leads
from vcmm.task.measuring.cut_scenario import CutScenario

Bools = np.typing.NDArray[np.bool_]
STEP = 1e-3  # mm by which readings and zeros are varied
ROUNDING = 1e-6  # of a weight: what differences of positions of 1e3 mm leave, 1e-13 relative, over STEP


@dataclass(frozen=True, eq=False)
class GrowingArc:
    """An arc whose radius follows readings: growth (K,) mm per mm. first: angle at its start in its plane, sweep: to its end, rad."""

    axes: tuple[int, int, int]
    first: float
    sweep: float
    growth: Array

    def at(self, share: Array) -> Array:
        """Return how far (n, 3, K) its path moves from its centre at fractions (n,) of it."""
        angle = self.first + share * self.sweep
        out = np.zeros((len(share), 3, len(self.growth)))
        out[:, self.axes[0]] = np.cos(angle)[:, None] * self.growth
        out[:, self.axes[1]] = np.sin(angle)[:, None] * self.growth
        return out


@dataclass(frozen=True, eq=False)
class TouchedZero:
    """K touches of a program of m moves; moves (K,): those that end in them.

    weight (m, 2, 3, K): mm by which start and end of each move lie further per mm that a touch reads further. is_held (m, 3): whether
    the zero of the set-up still counts along X, Y, Z. centre (K, 3): of the ball at each touch, mm. reads (K, 3): what 1 mm of
    error of the tip along X, Y, Z takes off the reading. arcs: of the moves that are cut larger by a touch, which is in no weight.
    """

    touches: tuple[ProbeContact, ...]
    moves: tuple[int, ...]
    weight: Array
    is_held: Bools
    centre: Array
    arcs: Mapping[int, GrowingArc] = field(default_factory=dict)

    @property
    def reads(self) -> Array:
        way, normal = (np.array([getattr(t, name) for t in self.touches]) for name in ("along", "normal"))
        return np.asarray(normal / np.einsum("ki,ki->k", way, normal)[:, None])

    def at(self, move: np.typing.NDArray[np.intp], share: Array) -> Array:
        """Return weights (n, 3, K) at fractions (n,) of the moves (n,)."""
        first, last = self.weight[move, 0], self.weight[move, 1]
        out = np.asarray(first + share[:, None, None] * (last - first))
        for number, arc in self.arcs.items():
            here = np.flatnonzero(move == number)
            out[here] += arc.at(share[here])
        return out


def touched_zero(scenario: CutScenario, text: str, program: Program) -> TouchedZero | None:
    """Return the dependence of the program on its touches; None where it probes nothing. Raises ModelLimit for what is not modelled."""
    if not program.touches:
        return None
    _check(scenario, program)
    count = len(program.touches)
    # what answers where the program expects it lies there, whatever the program makes of the other touches
    setup = replace(scenario.setup, expected_at=tuple(t.tip for t in program.touches))

    def read_again(changed: Setup) -> Program:
        again = read_for("cut", text, scenario.dialect, changed, name=str(scenario.program))
        _same_way(program, again, str(scenario.program))
        return again

    further = [
        read_again(replace(setup, read_out=tuple(STEP * (i == k) for i in range(k + 1))))
        for k in range(count)
    ]
    weight = np.stack([_zero_sensitivity(program, again) for again in further], axis=-1)
    shifts = np.stack(
        [_zero_sensitivity(program, read_again(_shift_zeros(setup, i))) for i in range(3)], axis=-1
    )
    arcs = _growing(program, further)
    follows = np.asarray((np.abs(weight) > ROUNDING).any(axis=(1, 3)))
    by_hand = _follows_hand_zero(program, shifts[:, 1], follows, str(scenario.program))
    radius = [_ball(setup, t) for t in program.touches]
    centre = np.array([t.tip for t in program.touches]) + np.array(radius)[:, None] * np.array(
        [0.0, 0.0, 1.0]
    )
    return TouchedZero(program.touches, _moves_of(program), weight, by_hand, centre, arcs)


def _ball(setup: Setup, touch: ProbeContact) -> float:
    tool = setup.tools.get(touch.tool)
    return 0.0 if tool is None else (tool.diameter or 0.0) / 2.0


def _shift_zeros(setup: Setup, axis: int) -> Setup:
    """Return the set-up with all zeros STEP further along an axis; touched values do not move."""
    by = tuple(STEP * (i == axis) for i in range(3))
    names = {"G54", *setup.offsets}
    old = {name: setup.offsets.get(name, (0.0, 0.0, 0.0)) for name in names}
    return replace(setup, offsets={n: (p[0] + by[0], p[1] + by[1], p[2] + by[2]) for n, p in old.items()})


def _same_way(program: Program, again: Program, name: str) -> None:
    kinds = [[(m.kind, m.source.line) for m in p.moves] for p in (program, again)]
    if kinds[0] != kinds[1] or len(program.touches) != len(again.touches):
        raise ModelLimit(
            f"{name}: line {program.touches[0].line} probes, and the program goes another way when the probe reads {STEP * 1e3:g} um further; only "
            "programs that shift with what they probe are simulated"
        )


def _zero_sensitivity(program: Program, again: Program) -> Array:
    """Return start and end of every move of `again` less those of `program`, per STEP (m, 2, 3); arcs go with their centres."""
    first, second = (np.array([_ends(m) for m in p.moves]) for p in (program, again))
    out = (second - first) / STEP
    out[np.abs(out) < ROUNDING] = 0.0
    return np.asarray(out)


def _growing(program: Program, further: Sequence[Program]) -> dict[int, GrowingArc]:
    """Return the arcs whose radius follows a touch."""
    out = {}
    for k, move in enumerate(program.moves):
        if move.centre is None:
            continue
        growth = np.array([(_radius(p.moves[k]) - _radius(move)) / STEP for p in further])
        growth[np.abs(growth) < ROUNDING] = 0.0
        if growth.any():
            first_axis, second_axis, normal = PLANES[move.plane]
            start, end, centre = (
                (p[first_axis], p[second_axis]) for p in (move.start, move.end, move.centre)
            )
            swept = sweep_of(start, end, centre, bool(move.clockwise), move.turns)
            first = math.atan2(start[1] - centre[1], start[0] - centre[0])
            out[k] = GrowingArc((first_axis, second_axis, normal), first, swept, growth)
    return out


def _radius(move: Move) -> float:
    assert move.centre is not None
    first_axis, second_axis, _ = PLANES[move.plane]
    return math.hypot(
        move.start[first_axis] - move.centre[first_axis], move.start[second_axis] - move.centre[second_axis]
    )


def _ends(move: Move) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    return (move.start, move.end) if move.centre is None else (move.centre, move.centre)


def _follows_hand_zero(program: Program, shift: Array, follows: Bools, name: str) -> Bools:
    """Return whether each axis of each move rests on a zero that was set by hand (m, 3): it goes with the zero of the set-up, shift (m, 3, 3) =
    d end / d zero, or follows (m, 3) nothing that was probed, as where the program types its zero.
    """
    whole = np.abs(shift - np.eye(3)) < ROUNDING
    none = np.abs(shift) < ROUNDING
    by_hand = whole[:, range(3), range(3)] | ~follows
    fine = (whole | none).all(axis=(1, 2)) | ~np.array([m.rewritable for m in program.moves])
    if not fine.all():
        line = program.moves[int(np.argmin(fine))].source.line
        raise ModelLimit(
            f"{name}: line {line} goes with the zero of the set-up and with what was probed as well, as where a typed number is added to a reading that counts from the "
            "old zero (#5061, $AA_MW), or where one axis of a zero is set that has been turned; correct the old zero instead (#5221=#5221+..., $P_UIFR[1,X,TR]=$P_UIFR[1,X,TR]+...), or count from the machine ($AA_MM)"
        )
    return np.asarray(by_hand)


def _moves_of(program: Program) -> tuple[int, ...]:
    """Number of the move that ends in each touch."""
    numbers, at = [], 0
    for t in program.touches:
        at = next(
            k
            for k, m in enumerate(program.moves[at:], at)
            if m.source.line == t.line and np.allclose(m.end, t.tip, rtol=0.0, atol=1e-9)
        )
        numbers.append(at)
        at += 1
    return tuple(numbers)


def with_scatter(scenario: CutScenario, touched: TouchedZero | None) -> CutScenario:
    """Return the scenario with an Input for the scatter of each touch. Raises UsageError where scatter is stated for a tool that does not probe."""
    tools = {} if touched is None else {t.tool for t in touched.touches}
    idle = next((tool for tool in scenario.touch_scatter if tool not in tools), None)
    if idle is not None:
        raise UsageError(
            f"[cut] tools.{idle}.u_touch: {scenario.program} does not probe with tool {idle}; take it out"
        )
    if touched is None or not scenario.touch_scatter:
        return scenario
    effects, inputs = [], []
    for k, t in enumerate(touched.touches, 1):
        if t.tool in scenario.touch_scatter:
            effects.append(ProbeTouch(str(k)))
            law = Normal(scenario.touch_scatter[t.tool])
            inputs.append(
                Input(
                    ProbeTouch.name, str(k), "shift", law, "setup", f"scatter of the touch in line {t.line}"
                )
            )
    return replace(
        scenario, machine=add_knowledge(scenario.machine, effects), inputs=(*scenario.inputs, *inputs)
    )


def _check(scenario: CutScenario, program: Program) -> None:
    """Refuse features of programs that probe which are not simulated."""
    name, line = scenario.program, program.touches[0].line
    turned = next((t for t in program.touches if any(t.rotary)), None)
    if turns_with(scenario.setup, program):
        raise ModelLimit(f"{name}: line {line} probes on a lathe; only mills that probe are simulated")
    if turned is not None or leads(program.moves) or any(any(m.rotary_end) for m in program.moves):
        raise ModelLimit(
            f"{name}: line {line} probes, and the program turns rotary axes; only programs with the rotary axes at zero are simulated then"
        )
