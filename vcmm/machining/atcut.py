"""The machine tool when it cuts each point: its states there, and the rows in which it was set."""

from __future__ import annotations

import numpy as np

from vcmm.cutting.envelope import CutSurface, tips
from vcmm.errors import ModelLimit
from vcmm.inputs import Input
from vcmm.machining.batch import later_in_batch
from vcmm.machining.contacts import Contacts, Ints
from vcmm.machining.forces_at import forces_at
from vcmm.machining.neighbours import candidates
from vcmm.machining.rows import Words, contacts_of, cut_run, joined, setting_rows, settings_of
from vcmm.machining.shop import Shop, zeros
from vcmm.machining.states import states_at
from vcmm.machining.toolside import ToolSide
from vcmm.machining.turned import TurnedSurface
from vcmm.machining.turned_side import turned_side
from vcmm.run import Array, Run


def tool_side(
    shop: Shop, surface: CutSurface, touch: Words, feature: Words, inputs: tuple[Input, ...] = ()
) -> tuple[ToolSide, Contacts]:
    """States of the machine tool when it cuts each point, and how its errors there move the surface."""
    if isinstance(surface, TurnedSurface):
        return turned_side(shop, surface, touch, feature, inputs)

    def off(row: Ints, share: Array, at: Array) -> Array:
        return states_at(shop.path, shop.sweep.move[row], share, at)[1]

    found = candidates(surface, shop.sweep, tips(surface, shop.sweep), off)
    contacts, point, candidate = contacts_of(surface, found, shop.sweep)
    row, at = found.row[point, candidate], found.tip[point, candidate]
    states, known = states_at(shop.path, shop.sweep.move[row], found.share[point, candidate], at)
    states = later_in_batch(states, shop.path, shop.scenario.batch_part)
    if shop.blank is not None and shop.blank.forces is not None:
        force = forces_at(shop.blank.forces, shop.sweep, row, found.share[point, candidate])
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
    rows = setting_rows(run, first, offset, zeros(shop, run.labels["setup"][first]), shop.pose)
    setting = np.concatenate([run.n + number, np.full(rows.n, -1, dtype=np.intp)])
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
