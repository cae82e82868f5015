"""Scenario files: scenario/1 TOML to a Scenario. Each of machine, part, plan, environment, job may name a file."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from vcmm.core.effect import Effect, required
from vcmm.core.errors import DataError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.knowledge import add_knowledge
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.files.own.environment import (
    EnvironmentTable,
    Temperatures,
    columns_of,
    sensor_columns,
    temperature_inputs,
    temperatures_of,
)
from vcmm.files.own.knowledge import further_effects, further_inputs, note_second, tables_in
from vcmm.files.own.machine import machine_from
from vcmm.files.own.machine_tables import RecordTable, found_machine
from vcmm.files.own.obstacles import SurroundingsTable, surroundings_of
from vcmm.files.own.part import PartData, part_from
from vcmm.files.own.placement import PlacementTable, ProcessTable, placement_from, process_of
from vcmm.files.own.plan import plan_from
from vcmm.files.own.room import room_changes
from vcmm.files.problems import Problems
from vcmm.files.schema import Gradient, Point, Table, Turn, checked_model, read_model
from vcmm.files.toml import Document, Location, check_version, read_toml
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.decision import RULES
from vcmm.task.measuring.knobs import with_knobs
from vcmm.task.measuring.plan import Plan
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.settings import Settings


class PoseTable(Table):
    shift: Point = (0.0, 0.0, 0.0)
    turn: Turn = (0.0, 0.0, 0.0)


class JobTable(Table):
    trials: int = Field(default=1_000_000, examples=["1_000_000"])
    seed: int = Field(default=0, ge=0, examples=["0"])
    p: float = Field(default=0.95, examples=["0.95"])
    interval: Literal["symmetric", "shortest"] = "symmetric"
    rule: str = Field(default=RULES[0], examples=[f'"{RULES[0]}"'])
    known_bias: Literal["reported", "corrected"] = "reported"
    production: dict[str, ProcessTable] = Field(default_factory=dict)


class KnobsTable(Table):
    """Knobs of the workbench, applied after all other tables: `vcmm.task.measuring.knobs`."""

    room: Gradient = 0.0
    styli: float = Field(default=1.0, examples=["1.5"])
    touches: int = Field(default=1, examples=["2"])
    spread: float = Field(default=1.0, examples=["0.5"])


class ScenarioFile(Table):
    """scenario/1"""

    vcmm: str
    name: str = ""
    machine: str | dict[str, Any] = Field(examples=['"machine.toml"'])
    part: str | dict[str, Any] = Field(examples=['"part.toml"'])
    plan: str | dict[str, Any] = Field(examples=['"plan.toml"'])
    pose: PoseTable = Field(default_factory=PoseTable)
    places: dict[str, PoseTable] = Field(default_factory=dict)
    environment: str | dict[str, Any] = Field(default_factory=dict, examples=['"environment.toml"'])
    job: str | dict[str, Any] = Field(default_factory=dict, examples=['"job.toml"'])
    surroundings: SurroundingsTable = Field(default_factory=SurroundingsTable)
    effects: list[dict[str, Any]] = Field(default_factory=list)
    inputs: list[dict[str, Any]] = Field(default_factory=list)
    placement: PlacementTable = Field(default_factory=PlacementTable)
    record: RecordTable = Field(default_factory=RecordTable)
    knobs: KnobsTable = Field(default_factory=KnobsTable)


def load_scenario(
    path: str | Path,
    machine: str | Path | None = None,
    certificate: dict[str, Any] | None = None,
    knobs: bool = True,
) -> Scenario:
    """Read a scenario (scenario/1) that measures.

    Parameters
    ----------
    path
        The file.
    machine
        A machine file that takes the place of the scenario's own.
    certificate
        A [certificate] table in place of that of its machine.
    knobs
        Whether those of its [knobs] are turned (the workbench turns them itself).

    Returns
    -------
    Scenario
        Machine, part, plan, pose and environment.

    Raises
    ------
    DataError
        Every problem of the file and of the files it names, each with its line.
    """
    document = read_toml(path)
    if certificate is not None:
        tables = {k: v for k, v in found_machine(path)[1].items() if k != "vcmm"}
        stated = {**tables, "certificate": certificate}
        document = replace(document, data={**document.data, "machine": stated})
    if machine is not None:
        document = replace(document, data={**document.data, "machine": str(Path(machine).resolve())})
    check_version(document, "scenario")
    problems = Problems(document)
    scenario = _checked_scenario(document, problems)
    if scenario is not None and knobs and "knobs" in document.data:
        scenario = _with_its_knobs(scenario, document, problems)
    problems.raise_if_any()
    assert scenario is not None
    return scenario


def turned_knobs(path: str | Path) -> dict[str, float]:
    """Return the statements of [knobs] of a scenario file, by the name of the knob; knobs that it does not name are not in it."""
    table = read_toml(path).data.get("knobs", {})
    whole = read_model(KnobsTable, table, read_toml(path), ("knobs",)).model_dump()
    return {name: float(whole[name]) for name in table}


def _checked_scenario(document: Document, problems: Problems) -> Scenario | None:
    data = document.data
    if "cut" in data:
        problems.add(("cut",), "this scenario cuts a part: run it with vcmm cut (in Python vcmm.load_cut)")
        return None
    model = checked_model(ScenarioFile, data, problems)
    machine = section(document, "machine", data.get("machine"), problems, machine_from)
    part = section(document, "part", data.get("part"), problems, lambda d, t, at: noting(part_from, d, t, at))
    planned = section(
        document,
        "plan",
        data.get("plan"),
        problems,
        lambda d, t, at: noting(partial(_plan, part), d, t, at),
    )
    environment = section(
        document,
        "environment",
        data.get("environment", {}),
        problems,
        lambda d, t, at: read_model(EnvironmentTable, t, d, at),
    )
    temperatures = temperatures_of(document, environment, problems) if environment else Temperatures()
    sensors = sensor_columns(document, environment, problems) if environment else {}
    settings = section(document, "job", data.get("job", {}), problems, partial(settings_from, part=part))
    knowledge = with_knowledge(document, machine, part, environment, planned, problems)
    placement = placement_from(document, part.part if part else None, model, problems)
    if problems.found or not (model and planned and part and settings and environment and knowledge):
        return None
    machine, inputs = knowledge
    plan, qualifications = planned
    around = surroundings_of(model.surroundings, part.part, plan, problems)
    if around is None:
        return None
    return Scenario(
        name=model.name or document.path.stem, machine=machine, part=part.part, plan=plan, pose=pose_from(model.pose),
        constants=columns_of(temperatures) | sensors, inputs=inputs, forms=part.forms, qualifications=qualifications,
        settings=settings, places={n: pose_from(t) for n, t in model.places.items()}, placement=placement,
        surroundings=around, record={**machine.record, **model.record.entries},
    )  # fmt: skip


def _with_its_knobs(scenario: Scenario, document: Document, problems: Problems) -> Scenario | None:
    """Return the scenario with [knobs] turned; a knob beyond its range is a problem of its line."""
    table = read_model(KnobsTable, document.data["knobs"], document, ("knobs",)).model_dump()
    for name in document.data["knobs"]:
        problems.attempt(("knobs", name), partial(with_knobs, scenario, {name: table[name]}))
    if problems.found:
        return None
    return with_knobs(scenario, {name: table[name] for name in document.data["knobs"]})


def noting(make: Any, document: Document, data: dict[str, Any], at: Location) -> Any:
    """Run a reader that notes its problems, with a list of its own: its document may be another file."""
    problems = Problems(document)
    made = make(document, data, at, problems)
    problems.raise_if_any()
    return made


def _plan(
    part: PartData | None, document: Document, data: dict[str, Any], at: Location, problems: Problems
) -> Any:
    return plan_from(document, data, at, part.part if part else None, problems)


def pose_from(table: PoseTable) -> Pose:
    return Pose.from_turns(np.array(table.shift), np.array(table.turn))


def section(document: Document, key: str, value: object, problems: Problems, make: Any) -> Any:
    """Read a table of this file, or the file it names (whose version line is checked); None where it cannot be read."""
    if isinstance(value, dict):
        return problems.attempt((key,), lambda: make(document, value, (key,)))
    if not isinstance(value, str):
        return None  # missing or of a wrong type: reported with the scenario itself

    def from_file() -> Any:
        other = read_toml(document.path.parent / value)
        check_version(other, key)
        return make(other, {k: v for k, v in other.data.items() if k != "vcmm"}, ())

    return problems.attempt((key,), from_file)


def settings_from(
    document: Document, data: dict[str, Any], at: Location, part: PartData | None = None
) -> Settings:
    problems = Problems(document)
    job = checked_model(JobTable, data, problems, at)
    if job is not None and job.rule not in RULES:
        problems.add((*at, "rule"), f'unknown rule "{job.rule}".{choose_from(job.rule, RULES)}')
    if job is not None:
        problems.attempt((*at, "trials"), lambda: Settings(trials=job.trials))
        problems.attempt((*at, "p"), lambda: Settings(p=job.p))
    production = {}
    units = {c.name: gps.unit(c) for c in part.part.characteristics} if part else {}
    for name, table in job.production.items() if job is not None else ():
        here = (*at, "production", name)
        if name in units:
            production[name] = problems.attempt(here, lambda n=name, t=table: process_of(n, t, units[n]))  # type: ignore[misc]
        elif part is not None:
            problems.add(here, f'the part has no characteristic "{name}".{choose_from(name, list(units))}')
    problems.raise_if_any()
    assert job is not None
    return Settings(
        job.seed, job.trials, job.p, job.interval, rule=job.rule, known_bias=job.known_bias,
        production={n: value for n, value in production.items() if value},
    )  # fmt: skip


def with_knowledge(
    document: Document,
    machine: Machine | None,
    part: PartData | None,
    environment: EnvironmentTable | None,
    planned: tuple[Plan, Any] | None,
    problems: Problems,
) -> tuple[Machine, tuple[Input, ...]] | None:
    """Return the machine with the effects of part and scenario, and all inputs that are not the machine's own."""
    chain = machine.chain if machine else None
    further = further_effects(tables_in(document.data, "effects"), chain, problems, ())
    temperatures = temperature_inputs(document, environment, problems) if environment else []
    if planned:
        _check_styli(document, planned[0], problems)
    if machine is None or part is None or environment is None:
        return None
    complete = not problems.found
    machine = add_knowledge(machine, [*part.effects(environment.part.compensated), *further])
    changes, rates = room_changes(document, environment, machine.effects, problems)
    machine = add_knowledge(machine, changes)
    inputs = [*part.inputs(), *rates]
    for location, quantity in temperatures:
        note_second(quantity, machine.inputs, problems, location)
        inputs.append(quantity)
    inputs += further_inputs(
        tables_in(document.data, "inputs"),
        machine.effects,
        [*machine.inputs, *inputs],
        problems,
        (),
        complete,
    )
    _check_temperatures(document, machine.effects, environment.sensors, problems)
    return machine, tuple(inputs)


def _check_temperatures(
    document: Document, effects: Sequence[Effect], sensors: Collection[str], problems: Problems
) -> None:
    """Check that a temperature that an effect needs is one of the environment's, or of the machine's own sensors."""
    columns = [*columns_of(Temperatures()), *(f"temp_{name}_C" for name in sensors)]
    for effect in effects:
        for column in required(effect):
            if column.startswith("temp_") and column not in columns:
                sensor = column.removeprefix("temp_").removesuffix("_C")
                names = [*Temperatures.model_fields, *sensors]
                problems.add(
                    _effect_location(document, "sensor", sensor),
                    f'{effect.id} needs the temperature "{sensor}".{choose_from(sensor, names)} For a sensor of the machine write '
                    f'[environment] sensors = {{ {sensor} = "21.5 degC" }}',
                )


def _check_styli(document: Document, plan: Plan, problems: Problems) -> None:
    """Check that a stylus named by an effect or input of this file is one of the plan's: others would have no effect, unnoticed."""
    for above in ((), ("machine",)):
        tables = document.data if not above else document.data.get("machine", {})
        for key in ("effects", "inputs"):
            for i, table in enumerate(tables_in(tables, key) if isinstance(tables, dict) else []):
                name = table.get("stylus", "")
                if isinstance(name, str) and name not in ("", "*", *plan.styli):
                    text = f'stylus = "{name}" is not a stylus of the plan.{choose_from(name, plan.styli)}'
                    problems.add((*above, key, i, "stylus"), text)


def _effect_location(document: Document, key: str, value: str) -> Location:
    """Return where an [[effects]] table of this file states key = value; else the machine."""
    for above in ((), ("machine",)):
        tables: Any = document.data if not above else document.data.get("machine", {})
        for i, table in enumerate(tables_in(tables, "effects") if isinstance(tables, dict) else []):
            if table.get(key) == value:
                return (*above, "effects", i, key)
    return ("machine",)


__all__ = ["DataError", "ScenarioFile", "load_scenario"]
