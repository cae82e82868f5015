"""Threads that a lathe cuts: errors of pitch and diameter, and their uncertainty.

The last pass makes the thread. At points along it the machine is evaluated as at any other cut (vcmm.shop.machining.contact_path), over a turn
of the spindle at each of them:

    pitch       +-(e_z(s) - e_z(0)), + along the way of the tool: how much further a flank lies than the first one requires
    diameter    2 e_x, mean over the length
    gauge       |pitch deviation| / tan(flank angle / 2), on the pitch diameter: the effect on a nut or a go gauge; 1.732 for 60 deg
                (ISO 965-1:2013, virtual pitch diameter)

e = error of the tool, z along the axis of the spindle, x from it to the tool. The form of the flanks is that of the insert and is
left out, and so is the force of threading; the spindle is taken to be in step with Z, as far as the program and the errors of the machine define it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.linear import term_of
from vcmm.answer.evaluation.montecarlo import covariance
from vcmm.core.run import FORCE_COLUMNS, Array
from vcmm.program.moves import Move
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.turning import OUTWARD
from vcmm.shop.machining.contact_path import logged_states, of_one_pass
from vcmm.shop.machining.process import PreparedCut, by_axis
from vcmm.shop.machining.states import later_in_batch, states_at
from vcmm.shop.machining.tool_errors import ToolSide
from vcmm.shop.machining.turning import turned_by

# along the thread, and of the spindle at each: errors of the machine change over 10 mm and more
PLACES = 13
ANGLES = 12
FLANKS = math.radians(60.0)
SAME_PLACE_MM = 1e-6  # mm


@dataclass(frozen=True)
class CutThread:
    """One thread. um unless named otherwise; U for k = 2. pitch: the largest cumulative deviation, `after` mm of thread, + is longer."""

    line: int
    tool: int
    lead_mm: float
    length_mm: float
    pitch_um: float
    pitch_U_um: float
    after_mm: float
    diameter_um: float
    diameter_U_um: float

    @property
    def gauge_um(self) -> float:
        """Gauge error on the pitch diameter, flanks of 60 deg."""
        return abs(self.pitch_um) / math.tan(FLANKS / 2.0)


def threads_of(job: PreparedCut) -> tuple[CutThread, ...]:
    """Return every thread of the program, in order; none where it cuts none."""
    last = last_passes(job.program.moves)
    return tuple(
        _cut_thread(job, number)
        for number in last
        if job.program.moves[number].tool in job.scenario.setup.tools
        and job.program.moves[number].work_spindle == job.scenario.work_spindle
    )


def last_passes(moves: tuple[Move, ...]) -> list[int]:
    """Return the numbers of the moves that cut each thread last.

    Passes that follow one another with one tool and one lead are one thread where both ends lie within two leads: infeed along the
    flank shifts where they begin, and the starts of a thread of several lie within one.
    """
    numbers: list[int] = []
    for k, m in enumerate(moves):
        if m.kind == "thread":
            if numbers and _is_same_pass(moves[numbers[-1]], m):
                numbers.pop()
            numbers.append(k)
    return numbers


def _is_same_pass(move: Move, other: Move) -> bool:
    lead = _lead(other)
    near = all(abs(a[2] - b[2]) < 2.0 * lead for a, b in ((move.start, other.start), (move.end, other.end)))
    return near and move.tool == other.tool and abs(_lead(move) - lead) < SAME_PLACE_MM


def _lead(m: Move) -> float:
    return (m.feed or 0.0) / abs(m.spindle) if m.spindle else 0.0


def _cut_thread(job: PreparedCut, number: int) -> CutThread:
    move = job.program.moves[number]
    share = np.repeat(np.linspace(0.0, 1.0, PLACES), ANGLES)
    side = asked_along(job, np.full(len(share), number, dtype=np.intp), share, "thread", OUTWARD)
    n = len(share)
    mean = np.kron(np.eye(PLACES), np.full((1, ANGLES), 1.0 / ANGLES))
    operator = np.zeros((PLACES + 1, side.run.n, 3))
    operator[:PLACES, :n, 2] = mean - mean[:1]
    operator[PLACES, :n, 0] = 2.0 / n
    operator[:PLACES] *= math.copysign(
        1.0, move.end[2] - move.start[2]
    )  # plus: longer, whichever way it is cut
    value = np.einsum("kni,ni->k", operator, side.errors())
    u = uncertainty_of(side, operator)
    worst = int(np.argmax(np.abs(value[:PLACES]) + 2.0 * u[:PLACES]))
    length = math.dist(move.start, move.end)
    return CutThread(
        line=move.source.line, tool=move.tool, lead_mm=_lead(move), length_mm=length,
        pitch_um=1e3 * float(value[worst]), pitch_U_um=2e3 * float(u[worst]), after_mm=length * worst / (PLACES - 1),
        diameter_um=1e3 * float(value[PLACES]), diameter_U_um=2e3 * float(u[PLACES]),
    )  # fmt: skip


def uncertainty_of(side: ToolSide, operator: Array) -> Array:
    """Return the standard uncertainties (K,) of operator (K, n, 3) on the errors; the scatter of a pass is common to the whole of it."""
    flat = operator.reshape(len(operator), -1)
    terms = []
    for influence in side.influences():
        relative = side.relative(influence)
        rows = relative.response.reshape(-1, relative.response.shape[2])
        spread = replace(relative, codes=np.repeat(relative.codes, 3))
        terms.append(term_of(spread, rows, flat))
    return np.sqrt(np.diag(covariance(terms))) if terms else np.zeros(len(operator))


def _forces(job: PreparedCut, time: Array) -> dict[str, Array]:
    """Return logged forces (n,) N at times (n,). None are computed for a thread, so that nothing bends by them."""
    logged = {n: np.interp(time, log.time, log.value) for n, log in job.scenario.force_log.items()}
    return {name: np.zeros(len(time)) for name in FORCE_COLUMNS} | logged


def asked_along(job: PreparedCut, move: Ints, share: Array, feature: str, normal: Array) -> ToolSide:
    """Evaluate the machine at fractions (n,) of moves (n,), the spindle at ANGLES places in turn; then the rows of setting. All one pass.

    normal (3,) or (n, 3): of the surface, meridian frame.
    """
    moves = [job.program.moves[i] for i in move.tolist()]
    start, end = (np.array([getattr(m, side) for m in moves]) for side in ("start", "end"))
    tips = start + share[:, None] * (end - start)
    states, known_error = states_at(job.path, move, share, tips)
    n = len(share)
    turn = (
        np.tile(2.0 * np.pi * np.arange(ANGLES) / ANGLES, n // ANGLES)
        if "C" in states.position
        else np.zeros(n)
    )
    if "C" in states.position:
        states = replace(states, position={**states.position, "C": turn})
    states = later_in_batch(states, job.path, job.scenario.batch_part, job.process.fed_in_part(job))
    out = turned_by(
        np.broadcast_to(normal, (n, 3)), turn
    )  # of the insert only the place counts, not its radius
    columns = by_axis("n{}", out) | by_axis("nose_{}", out)
    columns |= by_axis("part_{}_mm", turned_by(tips, turn) - job.pose.shift)
    columns |= _forces(job, states.column("time_s"))
    columns |= {name: np.full(n, value) for name, value in job.scenario.constants.items()}
    states = logged_states(job, states.with_columns(columns))
    names = {"touch": np.arange(n).astype(str), "feature": np.full(n, feature)}
    run = replace(states, labels={**states.labels, **names})
    inputs = (*job.machine.inputs, *job.scenario.inputs)
    return of_one_pass(job, run, known_error, inputs)
