"""Scenario files: scenario/1 TOML to a Scenario. Each of machine, part, plan, environment, job may name a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np

from vcmm.effect import Effect
from vcmm.errors import DataError
from vcmm.files.effects import build_effect, build_input
from vcmm.files.machine import load_machine, machine_from
from vcmm.files.part import PartData, part_from
from vcmm.files.plan import plan_from
from vcmm.files.schema import Kelvin, Point, Problems, Table, Temperature, Turn, read_model
from vcmm.files.toml import Document, Location, check_version, read_toml
from vcmm.gps.decision import RULES
from vcmm.inputs import Input
from vcmm.laws import Normal
from vcmm.machine import Machine
from vcmm.pose import Pose
from vcmm.run import T0_DEG_C
from vcmm.scenario import Scenario
from vcmm.settings import Settings


class PoseTable(Table):
    shift: Point = (0.0, 0.0, 0.0)
    turn: Turn = (0.0, 0.0, 0.0)


class Temperatures(Table):
    part: Temperature = T0_DEG_C
    scale_x: Temperature = T0_DEG_C
    scale_y: Temperature = T0_DEG_C
    scale_z: Temperature = T0_DEG_C
    air: Temperature = T0_DEG_C
    spindle: Temperature = T0_DEG_C
    gradient: Kelvin = 0.0


class PartCompensation(Table):
    compensated: bool = False
    u_sensor: Kelvin = 0.0


class EnvironmentTable(Table):
    temperature: Temperatures = Temperatures()
    u_temperature: dict[str, str] = {}
    part: PartCompensation = PartCompensation()


class JobTable(Table):
    trials: int = 1_000_000
    seed: int = 0
    p: float = 0.95
    interval: Literal["symmetric", "shortest"] = "symmetric"
    rule: str = RULES[0]


class ScenarioFile(Table):
    """scenario/1"""

    vcmm: str
    name: str = ""
    machine: str | dict[str, Any]
    part: str | dict[str, Any]
    plan: str | dict[str, Any]
    pose: PoseTable = PoseTable()
    places: dict[str, PoseTable] = {}
    environment: str | dict[str, Any] = {}
    job: str | dict[str, Any] = {}
    effects: list[dict[str, Any]] = []
    inputs: list[dict[str, Any]] = []


def load_scenario(path: str | Path) -> Scenario:
    """Read a scenario. Raises DataError with every problem of the file (and of the files it names)."""
    document = read_toml(path)
    check_version(document, "scenario")
    model = read_model(ScenarioFile, document.data, document)
    problems = Problems(document)
    machine = problems.attempt(("machine",), lambda: _machine(document, model.machine))
    part = _section(document, "part", model.part, problems, lambda d, t, at: part_from(d, t, at, problems))
    planned = _section(
        document,
        "plan",
        model.plan,
        problems,
        lambda d, t, at: plan_from(d, t, at, part.part if part else None, problems),
    )
    environment = _section(
        document,
        "environment",
        model.environment,
        problems,
        lambda d, t, at: read_model(EnvironmentTable, t, d, at),
    )
    job = _section(document, "job", model.job, problems, lambda d, t, at: read_model(JobTable, t, d, at))
    settings = problems.attempt(("job",), lambda: _settings(job)) if job else None
    built = (
        _with_knowledge(model, machine, part, environment, problems)
        if machine and part and environment
        else None
    )
    problems.raise_if_any()
    assert built and planned and part and settings and environment
    machine, inputs = built
    plan, qualifications = planned
    places = {n: _pose(t) for n, t in model.places.items()}
    name = model.name or document.path.stem
    return Scenario(
        name,
        machine,
        part.part,
        plan,
        _pose(model.pose),
        columns_of(environment.temperature),
        inputs,
        part.forms,
        qualifications,
        settings,
        places,
    )


def _pose(table: PoseTable) -> Pose:
    return Pose.from_turns(np.array(table.shift), np.array(table.turn))


def _machine(document: Document, value: str | dict[str, Any]) -> Machine:
    if isinstance(value, str):
        return load_machine(document.path.parent / value)
    return machine_from(document, value, ("machine",))


def _section(document: Document, key: str, value: str | dict[str, Any], problems: Problems, make: Any) -> Any:
    """A table of this file, or the file it names (whose version line is checked)."""
    if not isinstance(value, str):
        return problems.attempt((key,), lambda: make(document, value, (key,)))

    def from_file() -> Any:
        other = read_toml(document.path.parent / value)
        check_version(other, key)
        return make(other, {k: v for k, v in other.data.items() if k != "vcmm"}, ())

    return problems.attempt((key,), from_file)


def _settings(job: JobTable) -> Settings:
    return Settings(job.seed, job.trials, job.p, job.interval, rule=job.rule)


def _with_knowledge(
    model: ScenarioFile, machine: Machine, part: PartData, environment: EnvironmentTable, problems: Problems
) -> tuple[Machine, tuple[Input, ...]]:
    effects: list[Effect] = list(part.effects(environment.part.compensated))
    for i, table in enumerate(model.effects):
        built = problems.attempt(("effects", i), lambda table=table: build_effect(table))
        effects += [built] if built is not None else []
    machine = machine.with_effect(*effects)
    inputs = [*part.inputs(), *_temperature_inputs(environment, machine, problems)]
    for i, table in enumerate(model.inputs):
        found = problems.attempt(("inputs", i), lambda table=table: build_input(table, machine.effects))
        inputs += [found] if found is not None else []
    return machine, tuple(inputs)


def _temperature_inputs(environment: EnvironmentTable, machine: Machine, problems: Problems) -> list[Input]:
    from vcmm.errors import UsageError, choose_from
    from vcmm.units import quantity

    inputs = []
    names = [n for n in Temperatures.model_fields if n != "gradient"]
    spread = {n: t for n, t in environment.u_temperature.items()}
    for name, text in spread.items():
        here: Location = ("environment", "u_temperature", name)
        if name not in names:
            problems.add(here, f'unknown temperature "{name}".{choose_from(name, names)}')
            continue
        try:
            u = quantity(text, "temperature difference", name)
        except UsageError as error:
            problems.add(here, str(error))
            continue
        inputs.append(
            Input("channel", "", f"temp_{name}_C", Normal(u), "machine", "temperature of the environment")
        )
    if environment.part.u_sensor and "part" not in spread:
        inputs.append(
            Input(
                "channel",
                "",
                "temp_part_C",
                Normal(environment.part.u_sensor),
                "machine",
                "temperature sensor of the part",
            )
        )
    return inputs


def columns_of(temperature: Temperatures) -> dict[str, float]:
    """Run columns: the temperatures, and as readings what the sensors say (the same numbers; Inputs move the truth)."""
    out = {}
    for name, value in temperature.model_dump().items():
        out[f"temp_{name}_C"] = value
        out[f"reading_{name}_C"] = value
    return out


__all__ = ["DataError", "ScenarioFile", "load_scenario"]
