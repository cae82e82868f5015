"""Compute, for any process, the errors with which a machine tool cuts the points of a part.

    surface_at   which cuts make the surface at the points, and what may cut deeper beside them
    tool_side    one row of a run per candidate: state of the machine, columns of the surface, forces, wear;
                 then the rows in which the zeros were set; then the errors of all rows

Each step is a step of the process (vcmm.shop.machining.process); the rest is the same for milling and turning.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.run import OFFSET_LABEL, POWER_COLUMN, PROBE_LABEL, Array, Run
from vcmm.program.setup import first_tool
from vcmm.shop.cutting.contactmap import Contacts, Ints, upright
from vcmm.shop.cutting.envelope import CutSurface
from vcmm.shop.machining.own_logs import with_own_logs
from vcmm.shop.machining.passes import MOVE, PASS, move_and_pass, pass_weights
from vcmm.shop.machining.process import ContactRows, PreparedCut, Words, by_axis, zeros
from vcmm.shop.machining.spindle_load import measured_share, power_log
from vcmm.shop.machining.states import later_in_batch, states_at
from vcmm.shop.machining.tool_errors import ToolSide
from vcmm.shop.machining.warming import add_temperatures, warmed_when_set
from vcmm.shop.machining.zero_setting import ProbedRows, join_runs, setting_rows, ways_of_setting


def surface_at(job: PreparedCut, points: Array, normals: Array, exact: bool = True) -> CutSurface:
    """Return the surface that the program leaves at points (n, 3) of the drawing, workpiece axes.

    exact=False: as the search sees it, tools that turn with a rotary axis in short rows of constant direction.
    """
    return job.process.surface(job, job.pose.apply(points), job.pose.turn(normals), exact)


def tool_side(
    job: PreparedCut, surface: CutSurface, touch: Words, feature: Words, inputs: tuple[Input, ...] = ()
) -> tuple[ToolSide, Contacts]:
    """Return the states of the machine tool when it cuts each point, and how its errors there move the surface.

    touch, feature (n,): labels of the points, all of which are cut. Raises ModelLimit where the cut leaves the machine.
    """
    rows = contact_rows(job, surface)
    run, known_error = _cut_run(job, rows)
    run = Run(
        run.position, run.offset, run.columns,
        {**run.labels, "touch": touch[rows.point], "feature": feature[rows.point]}, run.series,
    )  # fmt: skip
    whole, setting = _with_setting(job, run)
    whole, setting, touches = _with_touches(job, whole, setting, rows)
    side = _tool_errors(job, run, whole, setting, known_error=known_error, inputs=inputs)
    deepest = np.flatnonzero(rows.candidate == 0)[
        rows.point
    ]  # all candidates of a point scatter as its deepest cut
    passes = pass_weights(job.program, job.sweep, rows.row[deepest], rows.share[deepest])
    passes = np.concatenate([passes, np.zeros((whole.n - run.n, passes.shape[1]))])
    return replace(side, passes=passes, touches=touches), rows.contacts


def of_one_pass(job: PreparedCut, run: Run, known_error: Array, inputs: tuple[Input, ...]) -> ToolSide:
    """Return the rows of a run that one pass cuts, with their labels, and those of setting behind them; known_error (n, 3) as of `states_at`."""
    whole, setting = _with_setting(job, run)
    passes = np.concatenate([np.ones((run.n, 1)), np.zeros((whole.n - run.n, 1))])
    return replace(
        _tool_errors(job, run, whole, setting, known_error=known_error, inputs=inputs), passes=passes
    )


def _tool_errors(
    job: PreparedCut, run: Run, whole: Run, setting: Ints, *, known_error: Array, inputs: tuple[Input, ...]
) -> ToolSide:
    """Return the errors of all rows; known deviations of the cut are zero in the rows of setting behind it."""
    known_error = np.concatenate([known_error, np.zeros((whole.n - run.n, 3))])
    return job.process.tool_side(job, _prepare_run(job, whole), setting, known_error, inputs)


def contact_rows(job: PreparedCut, surface: CutSurface) -> ContactRows:
    """Return the contacts of points that are all cut, and the row of the run that belongs to each candidate."""
    process = job.process
    candidates = process.candidates(job, surface)
    points, normals = process.contacts_seen(surface)
    is_cut = candidates.row >= 0
    point, candidate = np.nonzero(is_cut)
    number = np.full(is_cut.shape, -1, dtype=np.intp)
    number[is_cut] = np.arange(len(point))
    # where the ray ends in the side of a gouge the tool moves that end as it moves itself
    cutter = upright(candidates.cutter, normals, is_cut)
    contacts = Contacts(candidates.height, cutter, normals, number, process.cutters(surface, candidates))
    at = points[point] + candidates.height[is_cut][:, None] * normals[point]
    row, share = candidates.row[is_cut], candidates.share[is_cut]
    return ContactRows(
        surface, contacts, point, candidate, row=row, share=share, tip=candidates.tip[is_cut], at=at
    )


def _cut_run(job: PreparedCut, rows: ContactRows) -> tuple[Run, Array]:
    """Return the run of all contacts, without labels of the points, and the known deviations of the path (rows, 3) mm.

    The offset of each row leads to the point where the cutter meets the surface, so that the lever arms of all error
    motions, and with them the tilt of the tool, count to there.
    """
    process, scenario = job.process, job.scenario
    states, known_error = process.states(job, rows)
    logged = {
        n: np.interp(states.column("time_s"), log.time, log.value) for n, log in scenario.force_log.items()
    }
    share = measured_share(job, states.column("time_s"), rows.row, rows.share)
    states = later_in_batch(states, job.path, scenario.batch_part, process.fed_in_part(job))
    columns = process.columns(job, rows)
    if logged:
        columns |= logged
    elif job.blank is not None and job.blank.forces is not None:
        force = process.force(job, rows, job.blank.forces)
        columns |= by_axis("force_{}_N", force * share[:, None])
    columns |= {name: np.full(states.n, value) for name, value in scenario.constants.items()}
    columns |= dict(zip((MOVE, PASS), move_and_pass(job.program, job.sweep, rows.row)))
    return logged_states(job, states.with_columns(columns)), known_error


def logged_states(job: PreparedCut, states: Run) -> Run:
    """Add to the run the logs of the machine while it cuts: load and speed of the spindle, temperatures."""
    load = power_log(job)
    states = with_own_logs(states, job.path, job.machine.effects, job.scenario.batch_part)
    series = states.series if load is None else {**states.series, POWER_COLUMN: load}
    return add_temperatures(replace(states, series=series), job.scenario.setup.log)


def _with_setting(job: PreparedCut, run: Run) -> tuple[Run, Ints]:
    """Return the rows of the cut, then those in which each tool and work offset was set.

    The second result (n, 3): first of the rows in which the zero of each row was set, in X, Y and Z; -1: nothing is subtracted.
    """
    run = run.with_columns({"setting": np.zeros(run.n)})
    if not job.scenario.set_here:
        return run, np.full((run.n, 3), -1, dtype=np.intp)
    first, number = ways_of_setting(run)
    tools = run.labels["tool"][first]
    setter = np.array([setting_tool(job, str(name)) for name in tools])
    other = np.flatnonzero(setter != tools)  # their X and Y were set with another tool
    each = job.process.rows_per_zero
    rows = _set_with(
        job,
        run,
        np.repeat(np.concatenate([first, first[other]]), each),
        np.repeat([*tools, *setter[other]], each),
    )
    across = np.arange(len(first))
    across[other] = len(first) + np.arange(len(other))
    back = run.n + each * np.stack([across, across, np.arange(len(first))], axis=1)[number]
    return join_runs(run, rows), np.concatenate([back, np.full((rows.n, 3), -1)]).astype(np.intp)


def _with_touches(
    job: PreparedCut, run: Run, setting: Ints, rows: ContactRows
) -> tuple[Run, Ints, ProbedRows | None]:
    """Return the rows of touches of the program behind those of setting, which no longer count along axes that the program sets itself."""
    touched = job.touched_zero
    if touched is None:
        return run, setting, None
    move = job.sweep.move[rows.row]
    cut, count = len(move), len(touched.touches)
    tips = np.array([t.tip for t in touched.touches])
    states, _ = states_at(job.path, np.array(touched.moves, dtype=np.intp), np.ones(count), tips)
    states = later_in_batch(states, job.path, job.scenario.batch_part, job.process.fed_in_part(job))
    offset = states.offset + touched.centre - tips
    some = setting_rows(run, np.zeros(count, dtype=np.intp), offset, touched.centre, job.pose)
    normals = np.array([t.normal for t in touched.touches])
    then = {name: values for name, values in states.columns.items() if name in some.columns}
    then |= by_axis("n{}", normals) | {"setting": np.zeros(count), "across_tool": np.hypot(*normals.T[:2])}
    some = add_temperatures(some.with_columns(then), job.scenario.setup.log)
    labels = {"tool": np.array([str(t.tool) for t in touched.touches])}
    labels[PROBE_LABEL] = np.arange(1, count + 1).astype(str)
    some = replace(
        some, labels={**some.labels, **labels, OFFSET_LABEL: np.array([t.offset for t in touched.touches])}
    )
    is_held = np.zeros((run.n, 3))
    is_held[:cut] = touched.is_held[move]
    run = replace(run, labels={**run.labels, PROBE_LABEL: np.full(run.n, "")}).with_columns(
        by_axis("held_{}", is_held)
    )
    some = some.with_columns(by_axis("held_{}", np.zeros((count, 3))))
    weight = np.zeros((run.n + count, 3, count))
    weight[:cut] = touched.at(move, rows.share)
    setting = np.concatenate([setting, np.full((count, 3), -1, dtype=np.intp)])
    setting[:cut] = np.where(touched.is_held[move], setting[:cut], -1)
    return join_runs(run, some), setting, ProbedRows(run.n, weight, touched.reads)


def _set_with(job: PreparedCut, run: Run, chosen: Ints, tool: Words) -> Run:
    """Return the rows `chosen` (k,) of a run again, as when their zero was set with tools (k,)."""
    offset = -np.array([job.scenario.setup.tools[int(name)].offset for name in tool])
    rows = setting_rows(run, chosen, offset, zeros(job, run.labels[OFFSET_LABEL][chosen]), job.pose)
    rows = warmed_when_set(rows, job.scenario.setup.log)
    return job.process.set_at(job, replace(rows, labels={**rows.labels, "tool": tool}))


def setting_tool(job: PreparedCut, tool: str) -> str:
    """Return the tool that carried X and Y of the zeros under which `tool` cuts: on a mill the one that set the work offsets."""
    return tool if job.process.each_tool_set else str(first_tool(job.program.moves, job.scenario.setup))


def _prepare_run(job: PreparedCut, run: Run) -> Run:
    try:
        return job.machine.prepare(run)
    except ModelLimit as error:
        line = "" if error.row is None else f", line {run.columns['line'][error.row]:.0f} of the program"
        raise ModelLimit(
            f"some point of the cut is out of travel{line}: {error}; check work offset and tool length",
            row=error.row,
        ) from None
