"""Cut: from a cutting scenario to the finished part with its uncertainty.

program -> moves -> time law -> swept tools -> contacts at the inspection points -> states of the machine there
        -> departures of the surface -> inspection -> features, characteristics, decisions, budget
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.cutting.envelope import BEYOND, UNCUT, CutSurface, surface_left, tips
from vcmm.cutting.index import Index, build
from vcmm.cutting.stylus import rolled
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
from vcmm.machining.neighbours import candidates
from vcmm.machining.probing import ProbedHere
from vcmm.machining.recut import Recut, recut
from vcmm.machining.result import CutResult, Patch, batch, extremes, grouped
from vcmm.machining.rows import Words, contacts_of, cut_run, joined, setting_rows, settings_of
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
from vcmm.result import CharacteristicResult, UncertaintyResult
from vcmm.run import Array, Run
from vcmm.sampling import Progress
from vcmm.task import Task
from vcmm.world import Measuring

DEPTH, HEIGHT = 0.5, 2.0  # mm, how far below and above nominal the surface is looked for
DEEPEST = 20.0  # mm, for points that are gouged deeper
MOST_ACROSS, MOST_FACES = 41, 28_000  # points across one feature, triangles of all features in one picture
CONTACTS = 6  # of one point: repeated passes tie
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
    engine: str | None = None,
    progress: Progress | None = None,
) -> CutResult:
    """Machine a part virtually. Raises DataError for a program that cannot be read, UsageError and ModelLimit."""
    report = progress or (lambda text, share: None)
    changes = {"seed": seed, "trials": trials, "engine": engine}
    settings = replace(scenario.settings, **{k: v for k, v in changes.items() if v is not None})  # type: ignore[arg-type]
    report("reading the program", 0.0)
    shop = set_up(scenario)
    report("cutting (compiles on first use)", 0.0)
    task, world, notes = finished_part(shop)
    again = recut(shop.path, shop.sweep, shop.machine, _inspected(shop, task), dict(scenario.constants))
    found = evaluate(task, settings, report, world)
    report("mapping the surface", 0.0)
    patches = surface_map(shop)
    warnings = (*remarks(shop), *notes, *_beyond_contacts(again), *found.warnings)
    found = replace(found, warnings=warnings, characteristics=_with_uncut(found, task, shop))
    halves = {c.name: batch(c) for c in found.characteristics}
    return CutResult(
        found, extremes(patches, GOUGE), patches, shop.seconds, {c.name: grouped(c) for c in found.characteristics},
        {n: h[0] for n, h in halves.items()}, {n: h[1] for n, h in halves.items()}, warnings, shop.blank, again,
    )  # fmt: skip


def _with_uncut(found: UncertaintyResult, task: Task, shop: Shop) -> tuple[CharacteristicResult, ...]:
    """A feature of which points were left uncut does not conform, whatever the points that were cut say."""
    scenario = shop.scenario
    plan = gauge_plan(scenario.part, scenario.plan) if scenario.inspection.kind == IDEAL else scenario.plan
    planned = {step.feature: len(step.points) for step in plan.steps} if plan else {}
    left = {name for name, rows in task.touches.rows.items() if len(rows) < planned.get(name, 0)}
    out = []
    for c, spec in zip(found.characteristics, scenario.part.characteristics):
        if c.decision is not None and left & {*spec.of, *spec.between, *spec.datums}:
            c = replace(
                c, decision=replace(c.decision, text="does not conform", p_conform=0.0), coverage_shown=False
            )
        out.append(c)
    return tuple(out)


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
    _check_travels(scenario, path)
    sweep = swept(program.moves, scenario.setup.tools)
    zero = _work_zero(scenario, program)
    blank = machined_blank(scenario.setup, program, sweep, zero)
    pose = scenario.pose or Pose(
        np.eye(3), zero
    )  # the drawing frame is the work coordinate system of the first cut
    return Shop(scenario, program, path, sweep, build(sweep), pose, scenario.machine, blank)


def _check_travels(scenario: CutScenario, path: Toolpath) -> None:
    """The whole program stays within the travels, but for the way from where the machine happens to stand."""
    later = np.flatnonzero(path.move != path.timing.moving[0])
    for letter, axis in scenario.machine.axes.items():
        q, (low, high) = path.axes[letter][later], axis.travel
        bad = np.flatnonzero((q < low - 1e-6) | (q > high + 1e-6))
        if len(bad):
            line = path.columns["line"][later[bad[0]]]
            scale, unit = (180 / np.pi, "deg") if axis.rotary else (1.0, "mm")
            raise ModelLimit(
                f"line {line:.0f} of the program leaves the machine: axis {letter} = {q[bad[0]] * scale:.6g} {unit}, its travel is "
                f"{low * scale:.6g} to {high * scale:.6g} {unit}; check work offset and tool length"
            )


def _work_zero(scenario: CutScenario, program: Program) -> Array:
    """Work offset of the first cut (3,), workpiece axes."""
    return np.array(scenario.setup.offsets.get(_first_offset(program), (0.0, 0.0, 0.0)))


def _first_offset(program: Program) -> str:
    """The work offset of the first cut."""
    return next((m.offset for m in program.moves if m.kind != "rapid"), program.moves[0].offset)


def _inspected(shop: Shop, task: Task) -> CutSurface:
    return look(shop, task.touches.points, task.touches.normals)


def finished_part(shop: Shop) -> tuple[Task, Cutting, tuple[str, ...]]:
    """The task of inspecting the part, the world it was cut in, and what is to be said about points left out."""
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
    form = world.level + _lifted(shop, surface, measuring.task.touches.tip_radius)
    task = replace(measuring.task, inputs=(*inputs, *measuring.task.inputs), form=form)
    measuring = replace(measuring, task=replace(measuring.task, form=form))
    return task, replace(world, measuring=measuring), notes


def _lifted(shop: Shop, surface: CutSurface, radius: Array) -> Array:
    """How much higher a stylus tip of radius (P,) mm rests on the cusps beside each point than the surface in it, (P,) mm."""
    out = np.zeros(len(surface.points))
    for r in np.unique(radius[radius > 0]):
        mine = np.flatnonzero(radius == r)
        found = rolled(surface.points[mine], surface.normals[mine], float(r), shop.index)
        out[mine] = np.where(np.isfinite(found.s), np.maximum(found.s - surface.contact_s[mine, 0], 0.0), 0.0)
    return out


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
                f"{step.feature}: at {len(step.points) - len(kept)} of {len(step.points)} points more than {HEIGHT:g} mm is left or nothing was "
                "cut; the figures are of the other points, and what depends on it does not conform"
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
    found = surface_left(at, out, shop.index, DEPTH, HEIGHT, candidates=CONTACTS)
    deep = np.flatnonzero(found.status == BEYOND)
    if not len(deep):
        return found
    again = surface_left(at[deep], out[deep], shop.index, DEEPEST, HEIGHT, candidates=CONTACTS)
    names = ("status", "contact_s", "row", "t", "normal", "tests")
    merged = {name: getattr(found, name).copy() for name in names}
    for name in names:
        merged[name][deep] = getattr(again, name)
    return replace(found, **merged)


def _inspection(shop: Shop, plan: Plan) -> Measuring | ProbedHere:
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
    placed = touches(plan, pose, machine, scenario.constants if same else how.constants)
    empty = np.zeros(placed.run.n)
    if not same:
        own = [replace(i, owner=machine.name) for i in (*machine.inputs, *qualified)]
        return Measuring(Task(machine, scenario.part, plan, placed, tuple(own), empty))
    given = [i for i in (*machine.inputs, *scenario.inputs) if i.effect not in ("tool_length", "tool_radius")]
    shared = [
        i if i.redraw == "machine" or i.effect == "work_offset" else replace(i, owner="probing")
        for i in given
    ]
    own = [*shared, *(replace(i, owner="probing") for i in qualified)]
    task = Task(machine, scenario.part, plan, placed, tuple(own), empty)
    if not scenario.set_here:
        return Measuring(task)
    name = _first_offset(shop.program)
    zero = _zeros(shop, np.array([name]))[0]
    return ProbedHere(task, zero, name)


def tool_side(
    shop: Shop, surface: CutSurface, touch: Words, feature: Words, inputs: tuple[Input, ...] = ()
) -> tuple[ToolSide, Contacts]:
    """States of the machine tool when it cuts each point, and how its errors there move the surface."""
    found = candidates(surface, shop.sweep, tips(surface, shop.sweep))
    contacts, point, candidate = contacts_of(surface, found, shop.sweep)
    row, at = found.row[point, candidate], found.tip[point, candidate]
    states, known = states_at(shop.path, shop.sweep.move[row], found.share[point, candidate], at)
    if shop.blank is not None and shop.blank.forces is not None:
        force = shop.blank.forces[row]
        states = states.with_columns({f"force_{c}_N": force[:, i] for i, c in enumerate("xyz")})
    run = cut_run(
        states, surface, found, point, candidate, touch, feature, shop.pose, shop.scenario.constants
    )
    full, setting = _with_setting(shop, run)
    known = np.concatenate([known, np.zeros((full.n - run.n, 3))])
    return ToolSide(shop.machine, _prepared(shop, full), setting, known, inputs), contacts


def _with_setting(shop: Shop, run: Run) -> tuple[Run, Ints]:
    """The rows of the cut, then one per tool and work offset in which it was set; -1: nothing is taken off."""
    run = run.with_columns({"setting": np.zeros(run.n)})
    if not shop.scenario.set_here:
        return run, np.full(run.n, -1, dtype=np.intp)
    first, number = settings_of(run)
    tools = [shop.scenario.setup.tools[int(name)] for name in run.labels["tool"][first]]
    offset = -np.array([tool.offset for tool in tools])
    rows = setting_rows(run, first, offset, _zeros(shop, run.labels["setup"][first]), shop.pose)
    setting = np.concatenate([run.n + number, np.full(rows.n, -1, dtype=np.intp)])
    return joined(run, rows), setting


def _zeros(shop: Shop, names: Words) -> Array:
    """Where each work offset was set (k, 3): at the stated place, else at the work zero itself; workpiece axes."""
    scenario = shop.scenario
    if scenario.set_at is not None:
        return np.tile(np.array(scenario.set_at), (len(names), 1))
    return np.array([scenario.setup.offsets.get(str(name), (0.0, 0.0, 0.0)) for name in names], dtype=float)


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


def _unready(shop: Shop) -> list[str]:
    """Cuts without the tool length in force, or with a spindle that stands still."""
    tools, out = shop.scenario.setup.tools, []
    for move in shop.program.moves:
        if move.kind not in ("line", "arc") or move.tool not in tools:
            continue
        if tools[move.tool].length and not any(move.tool_offset):
            out.append(
                f"line {move.source.line} cuts with tool {move.tool} while no tool length is in force (G43)"
            )
        elif not move.spindle:
            out.append(f"line {move.source.line} cuts while the spindle stands still")
    return out[:1]


def remarks(shop: Shop) -> tuple[str, ...]:
    """What the program, the time law and the machine leave to be said."""
    program = [f"{shop.scenario.program.name}:{w.line}: {w.text}" for w in shop.program.warnings]
    idle = cutting_effects(shop.machine)[2]
    said = [f"{', '.join(idle)} act on measuring, not on cutting"] if idle else []
    assumed = (
        (f"assumed, as nothing is stated: {'; '.join(shop.path.assumptions)}",)
        if shop.path.assumptions
        else ()
    )
    return (*program, *_unready(shop), *blank_notes(shop.blank), *said, *assumed)
