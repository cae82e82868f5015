"""The machine tool when it cuts each point: its states there, and the rows in which it was set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.run import OFFSET_LABEL, TOOL_AXIS_COLUMNS, Array, Run
from vcmm.cutting.contactmap import Contacts, Ints
from vcmm.cutting.envelope import CutSurface, tips
from vcmm.machining.batch import later_in_batch
from vcmm.machining.forces_at import forces_at
from vcmm.machining.neighbours import Candidates, candidates
from vcmm.machining.preparation import Shop, zeros
from vcmm.machining.rotary import angle_of, commands_to_work, point_of_part
from vcmm.machining.rows import (
    Words,
    contact_points,
    contacts_of,
    cut_run,
    joined,
    setting_rows,
    settings_of,
)
from vcmm.machining.states import states_at, turning_states
from vcmm.machining.tool_errors import ToolSide
from vcmm.machining.turned import TurnedSurface
from vcmm.machining.turned_side import turned_side


def tool_side(
    shop: Shop, surface: CutSurface, touch: Words, feature: Words, inputs: tuple[Input, ...] = ()
) -> tuple[ToolSide, Contacts]:
    """States of the machine tool when it cuts each point, and how its errors there move the surface."""
    if isinstance(surface, TurnedSurface):
        return turned_side(shop, surface, touch, feature, inputs)

    def off(row: Ints, share: Array, at: Array) -> Array:
        if shop.motion is None:
            return states_at(shop.path, shop.sweep.move[row], share, at)[1]
        return turning_states(shop.path, shop.motion, row, share, at)[1]

    found = candidates(surface, shop.sweep, _tips(shop, surface), off, shop.motion)
    contacts, point, candidate = contacts_of(surface, found, shop.sweep, shop.motion)
    row = found.row[point, candidate]
    contact = contact_points(surface, found, point, candidate)
    states, known = _states(shop, found, contact, point, candidate)
    states = later_in_batch(states, shop.path, shop.scenario.batch_part, _fed_in_part(shop))
    if shop.blank is not None and shop.blank.forces is not None:
        force = forces_at(shop.blank.forces, shop.sweep, row, found.share[point, candidate])
        states = states.with_columns({f"force_{c}_N": force[:, i] for i, c in enumerate("xyz")})
    run = cut_run(states, surface, contact, point, touch, feature, shop.pose, shop.scenario.constants)
    full, setting = _with_setting(shop, run.with_columns({"across_tool": _across_tool(run)}))
    known = np.concatenate([known, np.zeros((full.n - run.n, 3))])
    full = _prepared(shop, full)
    turn = None
    if shop.motion is not None:
        ways = commands_to_work(shop.machine, full)
        turn = ways @ np.linalg.inv(ways[np.maximum(setting, 0)])
    return ToolSide(shop.machine, full, setting, known, inputs, turn), contacts


def _fed_in_part(shop: Shop) -> dict[str, float] | None:
    """mm that each tool is fed in one part, along its tip in the part, where rotary axes leave zero; None: as the toolpath says."""
    if shop.motion is None:
        return None
    before, length = shop.motion.fed
    tools = np.array([shop.program.moves[i].tool for i in shop.sweep.move.tolist()])
    return {str(t): float((before + length)[tools == t].max()) for t in np.unique(tools)}


def _across_tool(run: Run) -> Array:
    """Share (n,) of the surface normal that lies across the axis of the tool: 1 on walls, 0 on floors."""
    known = TOOL_AXIS_COLUMNS[0] in run.columns
    axis = run.vector(*TOOL_AXIS_COLUMNS) if known else np.array([0.0, 0.0, 1.0])
    return np.asarray(np.linalg.norm(np.cross(run.normal, axis), axis=1))


def _tips(shop: Shop, surface: CutSurface) -> Array:
    """Tips (P, K, 3) of the contacts; nan where there is none."""
    if shop.motion is None:
        return tips(surface, shop.sweep)
    out = np.full((*surface.row.shape, 3), np.nan)
    known = surface.row >= 0
    out[known] = shop.motion.standing(surface.row[known].astype(np.intp), surface.t[known])[0]
    return out


def _states(shop: Shop, found: Candidates, contact: Array, point: Ints, candidate: Ints) -> tuple[Run, Array]:
    """States of the machine with their tip at the cutting points (rows, 3), and what is known to lead elsewhere (rows, 3)."""
    row, share = found.row[point, candidate], found.share[point, candidate]
    if shop.motion is None:
        at = found.tip[point, candidate]
        states, known = states_at(shop.path, shop.sweep.move[row], share, at)
        return replace(states, offset=states.offset + (contact - at)), known
    states, known = turning_states(shop.path, shop.motion, row, share, contact)
    axis = shop.motion.standing(row, share)[1][:, 2]
    return states.with_columns({name: axis[:, i] for i, name in enumerate(TOOL_AXIS_COLUMNS)}), known


def _with_setting(shop: Shop, run: Run) -> tuple[Run, Ints]:
    """The rows of the cut, then one per tool and work offset in which it was set; -1: nothing is taken off."""
    run = run.with_columns({"setting": np.zeros(run.n)})
    if not shop.scenario.set_here:
        return run, np.full(run.n, -1, dtype=np.intp)
    first, number = settings_of(run)
    tools = [shop.scenario.setup.tools[int(name)] for name in run.labels["tool"][first]]
    offset = -np.array([tool.offset for tool in tools])
    names = run.labels[OFFSET_LABEL][first]
    rows = setting_rows(run, first, offset, zeros(shop, names), shop.pose)
    if shop.scenario.set_as_cut and shop.motion is not None:
        rows = _turned(rows, shop, [angle_of(shop.program, shop.motion, str(name)) for name in names])
    setting = np.concatenate([run.n + number, np.full(rows.n, -1, dtype=np.intp)])
    return joined(run, rows), setting


def _turned(rows: Run, shop: Shop, angles: Sequence[Array]) -> Run:
    """The rows of setting with A, B, C at angles (3,) each, rad, and what of the part then lies at the zero."""
    angle = np.array(angles).reshape(-1, 3)
    position = {a: angle[:, "ABC".index(a)] if a in "ABC" else q for a, q in rows.position.items()}
    zero = zeros(shop, rows.labels[OFFSET_LABEL])
    at = np.array([point_of_part(shop.machine, z, a) for z, a in zip(zero, angle)]).reshape(-1, 3)
    part = {f"part_{c}_mm": (at - shop.pose.shift)[:, i] for i, c in enumerate("xyz")}
    return replace(rows, position=position, columns={**rows.columns, **part})


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
