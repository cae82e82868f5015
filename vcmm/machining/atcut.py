"""The machine tool when it cuts each point: its states there, and the rows in which it was set."""

from __future__ import annotations

import numpy as np

from vcmm.cutting.envelope import CutSurface, tips
from vcmm.errors import ModelLimit
from vcmm.inputs import Input
from vcmm.machining.contacts import Contacts, Ints
from vcmm.machining.neighbours import candidates
from vcmm.machining.rows import Words, contacts_of, cut_run, joined, setting_rows, settings_of
from vcmm.machining.shop import Shop, zeros
from vcmm.machining.states import states_at
from vcmm.machining.toolside import ToolSide
from vcmm.nc.toolpath import Toolpath
from vcmm.run import Run


def tool_side(
    shop: Shop, surface: CutSurface, touch: Words, feature: Words, inputs: tuple[Input, ...] = ()
) -> tuple[ToolSide, Contacts]:
    """States of the machine tool when it cuts each point, and how its errors there move the surface."""
    found = candidates(surface, shop.sweep, tips(surface, shop.sweep))
    contacts, point, candidate = contacts_of(surface, found, shop.sweep)
    row, at = found.row[point, candidate], found.tip[point, candidate]
    states, known = states_at(shop.path, shop.sweep.move[row], found.share[point, candidate], at)
    states = later_in_batch(states, shop.path, shop.scenario.batch_part)
    if shop.blank is not None and shop.blank.forces is not None:
        force = shop.blank.forces[row]
        states = states.with_columns({f"force_{c}_N": force[:, i] for i, c in enumerate("xyz")})
    run = cut_run(
        states, surface, found, point, candidate, touch, feature, shop.pose, shop.scenario.constants
    )
    full, setting = _with_setting(shop, run)
    known = np.concatenate([known, np.zeros((full.n - run.n, 3))])
    return ToolSide(shop.machine, _prepared(shop, full), setting, known, inputs), contacts


def later_in_batch(states: Run, path: Toolpath, number: int) -> Run:
    """The same states while the `number`-th part in a row is cut: time, cut length of each tool and travel have gone on.

    The parts follow one another without a pause, and the spindle does not cool while tools are changed. Tools and work
    offset were set before the first part.
    """
    if number == 1:
        return states
    before = float(number - 1)
    going_on = {"time_s": path.seconds} | {
        name: float(values[-1]) for name, values in path.columns.items() if name.startswith("travel_")
    }
    columns = {name: states.column(name) + before * amount for name, amount in going_on.items()}
    on = states.column("spindle_on_s")
    columns["spindle_on_s"] = np.where(on > 0.0, on + before * path.seconds, on)
    fed = {
        t: float(path.columns["cut_length_mm"][path.labels["tool"] == t].max())
        for t in set(path.labels["tool"])
    }
    tools = states.labels["tool"]
    columns["cut_length_mm"] = states.column("cut_length_mm") + before * np.array(
        [fed.get(t, 0.0) for t in tools]
    )
    return states.with_columns(columns)


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
