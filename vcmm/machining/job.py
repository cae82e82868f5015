"""Cut: from a cutting scenario to the finished part with its uncertainty.

program -> moves -> time law -> swept tools -> contacts at the inspection points -> states of the machine there
        -> departures of the surface -> inspection -> features, characteristics, decisions, budget
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.cutting.envelope import BEYOND, UNCUT, CutSurface, surface_left, tips
from vcmm.cutting.index import Index, build
from vcmm.cutting.sweeps import Sweep
from vcmm.errors import ModelLimit, UsageError
from vcmm.evaluation import evaluate
from vcmm.fit.elements import MINIMUM_POINTS
from vcmm.inputs import Input
from vcmm.machine import Machine
from vcmm.machining.blank import Blank, machined_blank
from vcmm.machining.blank import notes as blank_notes
from vcmm.machining.contacts import Contacts, Ints
from vcmm.machining.gauge import gauge_plan, ideal_gauge
from vcmm.machining.maps import Net, net
from vcmm.machining.recut import Recut, recut
from vcmm.machining.result import CutResult, Patch, batch, extremes, grouped
from vcmm.machining.rows import Words, contacts_of, cut_run, joined, setting_of, setting_rows
from vcmm.machining.scenario import IDEAL, SAME, CutScenario
from vcmm.machining.states import states_at
from vcmm.machining.sweeps import swept
from vcmm.machining.toolside import ToolSide, cutting_effects
from vcmm.machining.world import Cutting
from vcmm.nc.interpret import read_program
from vcmm.nc.moves import Program
from vcmm.nc.toolpath import Toolpath, toolpath
from vcmm.plan import Plan, touches
from vcmm.pose import Pose
from vcmm.qualification import qualified_machine
from vcmm.run import Array, Run
from vcmm.sampling import Progress
from vcmm.task import Task
from vcmm.world import Measuring

DEPTH, HEIGHT = 0.5, 2.0  # mm, how far below and above nominal the surface is looked for
DEEPEST = 20.0  # mm, for points that are gouged deeper
MOST_ACROSS, MOST_FACES = 41, 28_000  # points across one feature, triangles of all features in one picture
RECUT_LIMIT = 1e-4  # mm
GOUGE = 0.01  # mm below nominal by the program alone


@dataclass(frozen=True, eq=False)
class Shop:
    """A scenario made ready: the program read, its motion in time, the tools swept, the part placed."""

    scenario: CutScenario
    program: Program
    path: Toolpath
    sweep: Sweep
    index: Index
    pose: Pose
    machine: Machine
    blank: Blank | None

    @property
    def seconds(self) -> float:
        return self.path.seconds


def cut(
    scenario: CutScenario,
    *,
    seed: int | None = None,
    trials: int | None = None,
    progress: Progress | None = None,
) -> CutResult:
    """Machine a part virtually. Raises DataError for a program that cannot be read, UsageError and ModelLimit."""
    report = progress or (lambda text, share: None)
    changes = {"seed": seed, "trials": trials}
    settings = replace(scenario.settings, **{k: v for k, v in changes.items() if v is not None})  # type: ignore[arg-type]
    report("reading the program", 0.0)
    shop = set_up(scenario)
    report("cutting (compiles on first use)", 0.0)
    task, world, notes, again = finished_part(shop)
    found = evaluate(task, settings, report, world)
    report("mapping the surface", 0.0)
    patches = surface_map(shop)
    warnings = (*remarks(shop), *notes, *_beyond_contacts(again), *found.warnings)
    found = replace(found, warnings=warnings)
    halves = {c.name: batch(c) for c in found.characteristics}
    return CutResult(
        found, extremes(patches, GOUGE), patches, shop.seconds, {c.name: grouped(c) for c in found.characteristics},
        {n: h[0] for n, h in halves.items()}, {n: h[1] for n, h in halves.items()}, warnings, shop.blank, again,
    )  # fmt: skip


def _beyond_contacts(again: Recut | None) -> list[str]:
    if again is None:
        return [
            "the errors change too fast along the path to cut some points again as a check of the contacts"
        ]
    if again.largest <= RECUT_LIMIT:
        return []
    return [
        f"cut again with the tools really displaced, {again.points} points differ by up to {again.largest * 1e3:.2f} um from the "
        "contacts used here: the errors change faster along the path than the contacts follow"
    ]


def set_up(scenario: CutScenario) -> Shop:
    """Read, time and sweep the program; place the part."""
    program = read_program(scenario.program, scenario.dialect, scenario.setup)
    if not program.moves:
        raise UsageError(f"{scenario.program}: the program has no motion; nothing is cut")
    path = toolpath(program, scenario.machine, scenario.setup, step=scenario.step)
    sweep = swept(program.moves, scenario.setup.tools)
    zero = _work_zero(scenario, program)
    blank = machined_blank(scenario.setup, program, sweep, zero)
    pose = scenario.pose or Pose(
        np.eye(3), zero
    )  # the drawing frame is the work coordinate system of the first cut
    return Shop(scenario, program, path, sweep, build(sweep), pose, scenario.machine, blank)


def _work_zero(scenario: CutScenario, program: Program) -> Array:
    """Work offset of the first cut (3,), workpiece axes."""
    first = next((m.offset for m in program.moves if m.kind != "rapid"), program.moves[0].offset)
    return np.array(scenario.setup.offsets.get(first, (0.0, 0.0, 0.0)))


def finished_part(shop: Shop) -> tuple[Task, Cutting, tuple[str, ...], Recut | None]:
    """The task of inspecting the part, the world it was cut in, what is to be said about points left out, and the check."""
    scenario = shop.scenario
    planned = gauge_plan(scenario.part, scenario.plan) if scenario.inspection.kind == IDEAL else scenario.plan
    if planned is None:
        raise UsageError(
            "inspection on a machine needs a plan with styli; add [plan], or leave [inspection] out"
        )
    plan, surface, notes = cut_points(shop, planned)
    inputs = (*shop.machine.inputs, *scenario.inputs)
    measuring = _inspection(shop, plan)
    touch, feature = (measuring.task.touches.run.labels[name] for name in ("touch", "feature"))
    tool, contacts = tool_side(shop, surface, touch, feature, inputs)
    world = Cutting(measuring, tool, contacts)
    task = replace(measuring.task, inputs=(*inputs, *measuring.task.inputs), form=world.level)
    measuring = replace(measuring, task=replace(measuring.task, form=world.level))
    again = recut(shop.path, shop.sweep, shop.machine, surface, dict(scenario.constants))
    return task, replace(world, measuring=measuring), notes, again


def cut_points(shop: Shop, plan: Plan) -> tuple[Plan, CutSurface, tuple[str, ...]]:
    """The plan without the points that no cutter touched, and the surface at those that remain."""
    steps, notes = [], []
    for step in plan.steps:
        found = look(shop, step.points, step.normals)
        kept = np.flatnonzero(found.status != UNCUT)
        kind = shop.scenario.part.features[step.feature].kind
        if len(kept) < MINIMUM_POINTS.get(kind, 1):
            raise ModelLimit(
                f"feature {step.feature}: the program cuts {len(kept)} of its {len(step.points)} inspection points within "
                f"{HEIGHT:g} mm; check the work offset, the pose of the part and the tool, or leave the feature out"
            )
        if len(kept) < len(step.points):
            notes.append(
                f"{step.feature}: {len(step.points) - len(kept)} of {len(step.points)} points are not cut and left out"
            )
        notes += _gouges(shop, step.feature, found)
        approach = None if step.approach is None else step.approach[kept]
        steps.append(replace(step, points=step.points[kept], normals=step.normals[kept], approach=approach))
    plan = replace(plan, steps=tuple(steps))
    points, normals = (
        np.concatenate([getattr(s, name) for s in plan.steps]) for name in ("points", "normals")
    )
    return plan, look(shop, points, normals), tuple(notes)


def _gouges(shop: Shop, feature: str, found: CutSurface) -> list[str]:
    """What the program itself takes away too much. Raises ModelLimit where the depth is beyond all search."""
    if not (found.status == BEYOND).any() and not (found.contact_s[:, 0] < -GOUGE).any():
        return []
    worst = int(np.where(found.status == BEYOND, -np.inf, np.nan_to_num(found.contact_s[:, 0])).argmin())
    row = int(found.row[worst, 0])
    line = shop.program.moves[int(shop.sweep.move[row])].source.line if row >= 0 else 0
    if (found.status == BEYOND).any():
        raise ModelLimit(
            f"feature {feature}: line {line} of the program cuts more than {DEEPEST:g} mm below it; check the work offset, the "
            "pose of the part and the tool"
        )
    count, depth = int((found.contact_s[:, 0] < -GOUGE).sum()), -float(found.contact_s[worst, 0])
    return [f"{feature}: the program itself gouges {count} points, by {depth:.3f} mm at most (line {line})"]


def look(shop: Shop, points: Array, normals: Array) -> CutSurface:
    """The surface that the program leaves at points (n, 3) of the drawing, workpiece axes."""
    at, out = shop.pose.apply(points), shop.pose.turn(normals)
    found = surface_left(at, out, shop.index, DEPTH, HEIGHT)
    deep = np.flatnonzero(found.status == BEYOND)
    if not len(deep):
        return found
    again = surface_left(at[deep], out[deep], shop.index, DEEPEST, HEIGHT)
    names = ("status", "contact_s", "row", "t", "normal", "tests")
    merged = {name: getattr(found, name).copy() for name in names}
    for name in names:
        merged[name][deep] = getattr(again, name)
    return replace(found, **merged)


def _inspection(shop: Shop, plan: Plan) -> Measuring:
    """The world of the measuring machine: none, the machine tool again, or another machine."""
    scenario, how = shop.scenario, shop.scenario.inspection
    if how.kind == IDEAL:
        gauge = ideal_gauge()
        placed = touches(plan, shop.pose, gauge)
        return Measuring(Task(gauge, scenario.part, plan, placed, (), np.zeros(placed.run.n)))
    same = how.kind == SAME
    base = shop.machine if same else how.machine
    assert base is not None
    machine, qualified = qualified_machine(base, plan, scenario.qualifications)
    pose = how.pose or shop.pose
    placed = touches(plan, pose, machine, how.constants or scenario.constants)
    owner = "probing" if same else machine.name
    given = (*machine.inputs, *(scenario.inputs if same else ()))
    own = [i if same and i.redraw == "machine" else replace(i, owner=owner) for i in (*given, *qualified)]
    return Measuring(Task(machine, scenario.part, plan, placed, tuple(own), np.zeros(placed.run.n)))


def tool_side(
    shop: Shop, surface: CutSurface, touch: Words, feature: Words, inputs: tuple[Input, ...] = ()
) -> tuple[ToolSide, Contacts]:
    """States of the machine tool when it cuts each point, and how its errors there move the surface."""
    contacts, point, candidate = contacts_of(surface)
    row = surface.row[point, candidate]
    at = tips(surface, shop.sweep)
    states, known = states_at(
        shop.path, shop.sweep.move[row], surface.t[point, candidate], at[point, candidate]
    )
    if shop.blank is not None and shop.blank.forces is not None:
        force = shop.blank.forces[row]
        states = states.with_columns({f"force_{c}_N": force[:, i] for i, c in enumerate("xyz")})
    run = cut_run(states, surface, point, candidate, touch, feature, shop.pose, at, shop.scenario.constants)
    full, setting = _with_setting(shop, run)
    known = np.concatenate([known, np.zeros((full.n - run.n, 3))])
    return ToolSide(shop.machine, _prepared(shop, full), setting, known, inputs), contacts


def _with_setting(shop: Shop, run: Run) -> tuple[Run, Ints]:
    """The rows of the cut, then one per tool in which the work offset was set; -1: nothing is taken off."""
    tools = run.labels["tool"]
    if not shop.scenario.set_here:
        return run, np.full(run.n, -1, dtype=np.intp)
    at = shop.pose.shift if shop.scenario.set_at is None else np.array(shop.scenario.set_at)
    offsets = {
        name: -np.array(shop.scenario.setup.tools[int(name)].offset) for name in dict.fromkeys(tools.tolist())
    }
    rows = setting_rows(run, tools, offsets, at)
    setting = np.concatenate([setting_of(tools, run.n), np.full(rows.n, -1, dtype=np.intp)])
    return joined(run, rows), setting


def _prepared(shop: Shop, run: Run) -> Run:
    try:
        return shop.machine.prepare(run)
    except ModelLimit as error:
        text = str(error)
        row = int(text.split(":")[0].removeprefix("row ")) - 1 if text.startswith("row ") else -1
        line = f", line {run.columns['line'][row]:.0f} of the program" if 0 <= row < run.n else ""
        raise ModelLimit(
            f"the cut leaves the machine{line}: {text}; check work offset and tool length"
        ) from None


def surface_map(shop: Shop) -> tuple[Patch, ...]:
    """All features of the part that have an extent, as densely as a picture of all of them can show."""
    features = shop.scenario.part.features.values()
    across = int(min(MOST_ACROSS, np.sqrt(MOST_FACES / 2 / max(len(features), 1))))
    return tuple(patch(shop, n) for f in features if (n := net(f, across)) is not None)


def patch(shop: Shop, over: Net) -> Patch:
    """The surface over one net at the estimates of all errors, and without errors."""
    surface = look(shop, over.points, over.normals)
    height, nominal = np.full(len(over.points), np.nan), np.full(len(over.points), np.nan)
    there = np.flatnonzero(surface.status != UNCUT)
    if len(there):
        some = look(shop, over.points[there], over.normals[there])
        names = np.array([f"{over.feature} {i}" for i in range(len(there))])
        tool, contacts = tool_side(shop, some, names, np.full(len(there), over.feature))
        height[there], nominal[there] = contacts.surface(tool.errors()), contacts.surface(tool.known)
    return Patch(over, height, nominal)


def remarks(shop: Shop) -> tuple[str, ...]:
    """What the program, the time law and the machine leave to be said."""
    program = [f"{shop.scenario.program.name}:{w.line}: {w.text}" for w in shop.program.warnings]
    idle = cutting_effects(shop.machine)[2]
    said = [f"{', '.join(idle)} act on measuring, not on cutting"] if idle else []
    return (*program, *shop.path.assumptions, *blank_notes(shop.blank), *said)
