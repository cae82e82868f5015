"""Cutting scenarios: scenario/1 TOML with a [cut] table, to a CutScenario."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.errors import DataError, VcmmError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.knowledge import add_knowledge
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import FORCE_COLUMNS, OFFSET_LABEL, POWER_COLUMN, Series
from vcmm.core.text import is_file
from vcmm.files.own.cut_tables import CutFile, CutTable, InspectionTable, ToolKnowledge
from vcmm.files.own.environment import (
    EnvironmentTable,
    Temperatures,
    columns_of,
    sensor_columns,
    temperatures_of,
)
from vcmm.files.own.knowledge import found_since, note_second, tables_in
from vcmm.files.own.machine import load_machine, machine_from
from vcmm.files.own.part import PartData, part_from
from vcmm.files.own.placement import placement_from
from vcmm.files.own.plan import plan_from
from vcmm.files.own.room import refuse_room_changes
from vcmm.files.own.scenario import (
    noting,
    pose_from,
    section,
    settings_from,
    with_knowledge,
)
from vcmm.files.own.setup import load_setup
from vcmm.files.problems import Problems
from vcmm.files.schema import checked_model, read_model
from vcmm.files.sheets import SheetColumn, read_csv
from vcmm.files.toml import Document, Location, check_version, read_toml
from vcmm.physics.structure.setting import ToolLength, ToolOffset, ToolRadius, WorkOffset
from vcmm.physics.structure.tool_bending import ToolDeflection, bending
from vcmm.program.setup import Setup, turns_with
from vcmm.task.measuring.cut_scenario import IDEAL, OTHER, SAME_MACHINE, CutScenario, Inspection
from vcmm.task.measuring.settings import CORRECTED

# Stands for the stylus of an inspection without errors.
GAUGE = {"offset": "0 0 0 mm", "tip_diameter": "1 mm"}


def load_cut(path: str | Path) -> CutScenario:
    """Read a scenario (scenario/1) that cuts a part: one with a [cut] table.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    CutScenario
        Program, machine tool, set-up, part and how it is inspected.

    Raises
    ------
    DataError
        Every problem of the file and of the files it names, each with its line.
    """
    document = read_toml(path)
    check_version(document, "scenario")
    problems = Problems(document)
    if "cut" not in document.data:
        problems.add(
            (), 'the scenario has no [cut] table; add program = "part.nc" and setup = "setup.toml" there'
        )
    scenario = None if problems.found else _check_document(document, problems)
    problems.raise_if_any()
    assert scenario is not None
    return scenario


def _check_document(document: Document, problems: Problems) -> CutScenario | None:
    data = document.data
    model = checked_model(CutFile, data, problems)
    setup = None
    if model is not None:
        setup = problems.attempt(("cut", "setup"), lambda: load_setup(document.path.parent / model.cut.setup))
    machine = _machine(document, setup, problems)
    part = section(document, "part", data.get("part"), problems, lambda d, t, at: noting(part_from, d, t, at))
    planned = None
    if "plan" in data:
        ideal = model is None or model.inspection.machine == IDEAL
        planned = section(document, "plan", data["plan"], problems, partial(_plan, part, ideal))
    environment = section(
        document, "environment", data.get("environment", {}), problems,
        lambda d, t, at: read_model(EnvironmentTable, t, d, at),
    )  # fmt: skip
    temperatures = temperatures_of(document, environment, problems) if environment else Temperatures()
    sensors = sensor_columns(document, environment, problems) if environment else {}
    if environment:
        refuse_room_changes(document, environment, problems)
    settings = section(document, "job", data.get("job", {}), problems, partial(settings_from, part=part))
    if settings is not None and settings.known_bias == CORRECTED:
        problems.add(
            ("job", "known_bias"),
            "the known errors of a cut are the part's deviation; there is nothing to correct",
        )
    if model is None or setup is None:
        return None
    setup = setup if machine is None else replace(setup, axes=frozenset(machine.axes))
    log, load = (
        problems.attempt(("cut", key), partial(_log, document, getattr(model.cut, key), names)) or {}
        for key, names in (("force_log", FORCE_COLUMNS), ("load_log", (POWER_COLUMN,)))
    )
    knowledge = _combine_knowledge(
        document, machine, setup, cut=model.cut, part=part, environment=environment, problems=problems
    )
    inspection = _inspection(document, model.inspection, problems)
    placement = placement_from(document, part.part if part else None, model, problems)
    if model.placement.objective not in ("", "deviation"):
        problems.add(("placement", "objective"), 'the objective of a cut part is "deviation"; leave it out')
    program = document.path.parent / model.cut.program
    if not is_file(program):
        problems.add(
            ("cut", "program"), f"there is no file {program}; name the NC program, relative to this file"
        )
    if problems.found or not (part and settings and environment and knowledge and inspection):
        return None
    machine, inputs, causes = knowledge
    offset = model.cut.work_offset
    return CutScenario(
        name=model.name or document.path.stem, machine=machine, program=program, setup=setup, part=part.part,
        plan=planned[0] if planned else None, pose=None if model.pose is None else pose_from(model.pose),
        dialect=model.cut.dialect or setup.dialect, constants=columns_of(temperatures) | sensors, inputs=inputs,
        touch_scatter={int(n): t.u_touch for n, t in model.cut.tools.items() if t.u_touch},
        qualifications=planned[1] if planned else {}, inspection=inspection, settings=settings,
        set_here=offset.set_on == "this machine", set_at=offset.at, set_as_cut=offset.rotary == "as cut", step=model.cut.step,
        u_width={int(n): t.u_width for n, t in model.cut.tools.items() if t.u_width}, work_spindle=model.cut.work_spindle, batch_part=model.cut.batch_part, force_log=log, load_log=load.get(POWER_COLUMN),
        fixture=placement.fixture if placement else None, weights=model.placement.weights,
        found_since=causes, record={**machine.record, **model.record.entries},
    )  # fmt: skip


def _log(document: Document, file: str | None, columns: tuple[str, ...]) -> dict[str, Series]:
    """Read the logs over the time of the program: forces (N, of the part on the tool, workpiece axes), power (W)."""
    if file is None:
        return {}
    sheet = read_csv(document.path.parent / file)
    names = ("time_s", *columns)
    what = "force" if columns == FORCE_COLUMNS else "load"
    problems = sheet.missing(
        SheetColumn(n, advice=f"; a {what} log has {', '.join(names)}{_in_other_unit(n, sheet.header)}")
        for n in names
    )
    if problems:
        raise DataError(problems[0])
    time = sheet.numbers("time_s")
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        raise DataError(f"{sheet.at(int(back[0]) + 1)}: time_s does not increase; sort the rows by time")
    return {name: Series(time, sheet.numbers(name)) for name in columns}


def _in_other_unit(name: str, header: Sequence[str]) -> str:
    """Return what to do with a column that looks like the missing one in another unit or clock."""
    stem = name.rsplit("_", 1)[0]
    other = next((h for h in header if h.lower().startswith(stem)), None)
    if other is None:
        return ""
    if stem == "time":
        return f'. "{other}": write seconds since the start of the program as time_s'
    return (
        f'. "{other}": convert it to {name.rsplit("_", 1)[1]}, and take what idling takes off'
        if stem == "spindle_load"
        else f'. "{other}": convert it to N'
    )


def _machine(document: Document, setup: Setup | None, problems: Problems) -> Machine | None:
    """Return the machine of the scenario, else that of the set-up."""
    if "machine" in document.data:
        machine = section(document, "machine", document.data["machine"], problems, machine_from)
        return machine if isinstance(machine, Machine) else None
    path = setup.machine if setup else None
    if path is None:
        if setup is not None:
            problems.add((), 'no machine: add machine = "mill.toml" here or in the set-up')
        return None
    return problems.attempt(("cut", "setup"), lambda: load_machine(path))


def _plan(part: PartData | None, ideal: bool, document: Document, data: dict[str, Any], at: Location) -> Any:
    """Read [plan]; an inspection without errors needs no styli."""
    if ideal and "styli" not in data and isinstance(data.get("steps"), list):
        steps = [{"stylus": "gauge", **s} if isinstance(s, dict) else s for s in data["steps"]]
        data = {**data, "styli": {"gauge": GAUGE}, "steps": steps}
    problems = Problems(document)
    plan = plan_from(document, data, at, part.part if part else None, problems)
    problems.raise_if_any()
    return plan


def _combine_knowledge(
    document: Document, machine: Machine | None, setup: Setup, cut: CutTable, part: PartData | None,
    environment: Any, problems: Problems,
) -> tuple[Machine, tuple[Input, ...], dict[str, str]] | None:  # fmt: skip
    """Return the machine with the effects of setting up, of the part and of the scenario; its Inputs and theirs; those that a diagnosis
    found since."""
    for name in cut.tools:
        if name not in map(str, setup.tools):
            numbers = [str(n) for n in setup.tools]
            problems.add(
                ("cut", "tools", name), f"tool {name} is not in the set-up.{choose_from(name, numbers)}"
            )
        elif cut.tools[name].u_width and setup.tools[int(name)].width is None:
            text = f'u_width needs the width of tool {name} in the set-up, for example width = "3 mm"'
            problems.add(("cut", "tools", name, "u_width"), text)
        elif setup.tools[int(name)].shape != "turning" and setup.tools[int(name)].driven is None:
            for key in ("u_offset_x", "u_offset_y"):
                if getattr(cut.tools[name], key):
                    text = f"{key} belongs to a turning or driven tool; tool {name} is {setup.tools[int(name)].shape}"
                    problems.add(("cut", "tools", name, key), text)
        if cut.tools[name].compliance is not None and not (has_forces(setup) or cut.force_log):
            text = "compliance needs cutting forces: add [stock] with its size and material to the set-up, or leave compliance out"
            problems.add(("cut", "tools", name, "compliance"), text)
    if problems.found:
        return None
    machine_effects = machine.effects if machine else ()
    effects, inputs = setting_knowledge(
        setup, cut, _is_turned(setup, cut, document.path.parent / cut.program)
    )
    stated = [str(e.get("effect")) for e in tables_in(document.data, "effects")]
    if not any(name == ToolDeflection.name for name in (*stated, *(e.name for e in machine_effects))):
        bends, known_bends = bending_knowledge(setup, cut)
        effects, inputs = [*effects, *bends], [*inputs, *known_bends]
    full = None if machine is None else add_knowledge(machine, effects)
    whole = with_knowledge(document, full, part, environment, None, problems)
    if whole is None:
        return None
    causes = found_since(inputs, machine.inputs if machine else ())
    inputs = [quantity for quantity in inputs if quantity.id not in causes]
    for quantity in inputs:
        note_second(quantity, [*whole[0].inputs, *whole[1]], problems, ("cut",))
    return whole[0], (*whole[1], *inputs), causes


def _is_turned(setup: Setup, cut: CutTable, program: Path) -> bool:
    """Return whether the part is turned. Where the set-up has tools of both kinds, the program shows which it uses.

    One that cannot be read is refused by the job, with its line.
    """
    shapes = {tool.shape == "turning" for tool in setup.tools.values()}
    if len(shapes) < 2:
        return shapes == {True}
    from vcmm.program.interpret import read_program

    try:
        return turns_with(setup, read_program(program, cut.dialect or setup.dialect, setup))
    except (VcmmError, OSError):
        return False


def setting_knowledge(setup: Setup, cut: CutTable, turned: bool) -> tuple[list[Effect], list[Input]]:
    """Return effects of setting up, at zero, and Inputs where an uncertainty is stated.

    turned: on a lathe the zero lies on the axis of the spindle: only z is set, and each tool has an offset in x and a height.
    """
    directions = "z" if turned else "xyz"
    effects: list[Effect] = [WorkOffset(d) for d in directions]
    inputs = []
    if cut.work_offset.u:
        law = Normal(cut.work_offset.u)
        inputs = [
            Input(WorkOffset.name, d, "shift", law, OFFSET_LABEL, "setting of the work offset")
            for d in directions
        ]
    for number in setup.tools:
        name, stated = str(number), cut.tools.get(str(number), ToolKnowledge())
        effects += [ToolLength(name), ToolRadius(name)]
        if stated.u_length:
            inputs.append(_of_setter(ToolLength, name, "dl", stated.u_length))
        if stated.u_radius:
            inputs.append(_of_setter(ToolRadius, name, "dr", stated.u_radius))
        if setup.tools[number].shape == "turning" or setup.tools[number].driven is not None:
            effects += [ToolOffset(name, d) for d in "xy"]
        for d, u in (("x", stated.u_offset_x), ("y", stated.u_offset_y)):
            if u:
                inputs.append(_of_setter(ToolOffset, f"{name},{d}", "shift", u))
    return effects, inputs


def _of_setter(kind: type[Effect], where: str, parameter: str, u: float) -> Input:
    return Input(kind.name, where, parameter, Normal(u), "setup", "tool setter")


def bending_knowledge(setup: Setup, cut: CutTable) -> tuple[list[Effect], list[Input]]:
    """Return the bending of each tool, where forces are known and its compliance or stick-out is stated."""
    effects: list[Effect] = []
    inputs: list[Input] = []
    if not (has_forces(setup) or cut.force_log):
        return effects, inputs
    for number, tool in setup.tools.items():
        stated = cut.tools.get(str(number), ToolKnowledge())
        amount = stated.compliance
        if amount is None and tool.stick_out and tool.diameter and tool.shape in ("flat", "ball", "bull"):
            amount = bending(tool.diameter / 2, tool.stick_out)
        if amount is not None:
            yields = ToolDeflection.of_edge if tool.shape == "turning" else ToolDeflection.of_rod
            effects.append(yields(amount, str(number)))
            if stated.u_compliance:
                law, why = Normal(stated.u_compliance), "stiffness of tool and spindle"
                inputs.append(Input(ToolDeflection.name, str(number), "compliance", law, "setup", why))
    return effects, inputs


def has_forces(setup: Setup) -> bool:
    """Return whether the set-up states the material, so that cutting forces can be computed."""
    return (setup.stock is not None or setup.bar is not None) and setup.material is not None


def _inspection(document: Document, table: InspectionTable, problems: Problems) -> Inspection | None:
    pose: Pose | None = None if table.pose is None else pose_from(table.pose)
    if table.machine in (IDEAL, SAME_MACHINE):
        return Inspection(str(table.machine), None, pose)
    at: Location = ("inspection", "machine")
    if isinstance(table.machine, dict):
        inner = table.machine
        machine = problems.attempt(at, lambda: machine_from(document, inner, at))
    else:
        path = document.path.parent / table.machine
        machine = problems.attempt(at, lambda: load_machine(path))
    if machine is None:
        return None
    if pose is None:
        problems.add(
            ("inspection",),
            'where does the part lie on the measuring machine? Add pose = { shift = "x y z mm" }',
        )
    return Inspection(OTHER, machine, pose, columns_of(table.temperature))


__all__ = ["CutFile", "load_cut"]
