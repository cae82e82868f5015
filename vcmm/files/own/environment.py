"""Read [environment] of a scenario: temperatures, their uncertainties, and the room they have in common."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import Field

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal, Uniform
from vcmm.core.run import T0_DEG_C
from vcmm.core.units import ABSOLUTE_ZERO, quantity
from vcmm.files.problems import Problems
from vcmm.files.schema import (
    Gradient,
    KelvinSpread,
    Table,
    Temperature,
    TemperatureOrDifference,
)
from vcmm.files.toml import Document, Location

# names the random stream and the budget line of what all temperatures have in common
ROOM_INPUT = "environment.room"


class Temperatures(Table):
    part: Temperature = T0_DEG_C
    scale_x: Temperature = T0_DEG_C
    scale_y: Temperature = T0_DEG_C
    scale_z: Temperature = T0_DEG_C
    air: Temperature = T0_DEG_C
    spindle: Temperature = T0_DEG_C
    gradient: Gradient = 0.0


NAMES = tuple(n for n in Temperatures.model_fields if n != "gradient")


class TaskTemperatures(Table):
    """Temperatures in degC, or differences to the room in K where `room` is given."""

    part: TemperatureOrDifference | None = None
    scale_x: TemperatureOrDifference | None = None
    scale_y: TemperatureOrDifference | None = None
    scale_z: TemperatureOrDifference | None = None
    air: TemperatureOrDifference | None = None
    spindle: TemperatureOrDifference | None = None
    gradient: Gradient = 0.0


class PartCompensation(Table):
    compensated: bool = False
    u_sensor: KelvinSpread = 0.0


class EnvironmentTable(Table):
    """room: of part, scales, spindle and air together; u_room or half_width: how well it is known.

    room_hour, room_day, room_gradient: what it changes by in an hour, over a day, over a metre (`vcmm.files.own.room`).

    sensors: temperatures of the machine's own sensors, which its effects name.
    """

    room: Temperature | None = None
    u_room: KelvinSpread = 0.0
    half_width: KelvinSpread = 0.0
    room_hour: str = Field(default="", examples=['"0.5 K/h"'])
    room_day: str = Field(default="", examples=['"1.5 K/d"'])
    room_gradient: str = Field(default="", examples=['"0.3 K/m"'])
    temperature: TaskTemperatures = Field(default_factory=TaskTemperatures)
    sensors: dict[str, str] = Field(default_factory=dict, examples=['{ bridge = "21.5 degC" }'])
    u_temperature: dict[str, str] = Field(default_factory=dict, examples=['{ part = "0.1 K" }'])
    part: PartCompensation = Field(default_factory=PartCompensation)


def temperatures_of(document: Document, environment: EnvironmentTable, problems: Problems) -> Temperatures:
    """Return the temperatures in degC; notes differences without a room, and temperatures where differences are expected."""
    room, inside = environment.room, isinstance(document.data.get("environment"), dict)
    temperatures: dict[str, float] = {"gradient": environment.temperature.gradient}
    for name in NAMES:
        text = getattr(environment.temperature, name)
        if text is None:
            temperatures[name] = T0_DEG_C if room is None else room
            continue
        here: Location = ("environment", "temperature", name) if inside else ("environment",)
        value = problems.attempt(here, lambda n=name, t=text: _temperature(n, t, room))  # type: ignore[misc]
        temperatures[name] = T0_DEG_C if value is None else value
    for key in ("u_room", "half_width"):
        here = ("environment", key) if inside else ("environment",)
        if room is None and getattr(environment, key):
            problems.add(here, f'{key} belongs to a room; add room = "20 degC"')
        elif key == "half_width" and environment.u_room and environment.half_width:
            problems.add(here, "u_room and half_width say the same thing; keep one of them")
    return Temperatures.model_construct(None, **temperatures)


def sensor_columns(document: Document, environment: EnvironmentTable, problems: Problems) -> dict[str, float]:
    """Run columns of the machine's own sensors, degC."""
    inside, out = isinstance(document.data.get("environment"), dict), {}
    for name, text in environment.sensors.items():
        here: Location = ("environment", "sensors", name) if inside else ("environment",)
        if name in Temperatures.model_fields:
            problems.add(
                here, f'{name} is no sensor of its own; write it in temperature = {{ {name} = "{text}" }}'
            )
            continue
        value = problems.attempt(here, lambda n=name, t=text: _temperature(n, t, environment.room))  # type: ignore[misc]
        out[f"temp_{name}_C"] = T0_DEG_C if value is None else value
    return out


def _temperature(name: str, text: str, room: float | None) -> float:
    """Return degC from a temperature, or from a difference to the room."""
    plain = text.replace("°C", "degC")
    if room is None:
        if "degC" not in plain:
            raise UsageError(
                f'{name} = "{text}" is a temperature and takes degC, as there is no room to differ from; write for example '
                f'{name} = "20.4 degC", or add room = "20 degC"'
            )
        return quantity(text, "temperature", name, "20.4 degC")
    if "degC" in plain:
        raise UsageError(
            f'{name} = "{text}": beside room, temperatures are differences to it in K; write for example {name} = "0.4 K"'
        )
    value = room + quantity(text, "temperature difference", name, "0.4 K")
    if value < ABSOLUTE_ZERO:
        raise UsageError(
            f'{name} = "{text}" is {value:g} degC with the room, below absolute zero ({ABSOLUTE_ZERO:g} degC)'
        )
    return value


def temperature_inputs(
    document: Document, environment: EnvironmentTable, problems: Problems
) -> list[tuple[Location, Input]]:
    """Return (place in the file, Input) for the room and for every temperature with an uncertainty."""
    inside = isinstance(document.data.get("environment"), dict)
    out: list[tuple[Location, Input]] = []
    if environment.u_room or environment.half_width:
        out.append((("environment",), room_input(environment.u_room, environment.half_width)))
    for name, text in environment.u_temperature.items():
        here: Location = ("environment", "u_temperature", name) if inside else ("environment",)
        names = [*Temperatures.model_fields, *environment.sensors]
        if name not in names:
            problems.add(here, f'unknown temperature "{name}".{choose_from(name, names)}')
            continue
        try:
            law = Normal(quantity(text, "temperature difference", name, "0.1 K"))
        except UsageError as error:
            problems.add(here, str(error))
            continue
        out.append((here, _of_column(name, law, "temperature of the environment")))
    u_sensor = environment.part.u_sensor
    if u_sensor and "part" in environment.u_temperature:
        here = ("environment", "u_temperature", "part") if inside else ("environment",)
        problems.add(here, "u_temperature.part and part.u_sensor say the same thing; keep one of them")
    elif u_sensor:
        out.append((("environment",), _of_column("part", Normal(u_sensor), "temperature sensor of the part")))
    return out


def _of_column(name: str, law: Normal, why: str) -> Input:
    return Input("channel", "", f"temp_{name}_C", law, "machine", why)


def room_input(u: float, half_width: float) -> Input:
    """Return the departure of the room from its stated temperature: one draw for everything in it, sensors included.

    A sensor reads the actual temperature: the room's departure is in its reading, and compensation by it remains valid.
    """
    columns = [f"{kind}_{name}_C" for name in NAMES for kind in ("temp", "reading")]
    law = Uniform(half_width) if half_width else Normal(u)
    members = tuple(Input("channel", "", column, law) for column in columns)
    why = "room temperature, common to part, scales, spindle, air and their sensors"
    return Input("", "", ROOM_INPUT, law, "machine", why, members=members, shares=np.ones(len(members)))


def columns_of(temperature: Temperatures) -> dict[str, float]:
    """Run columns: the temperatures, and as readings what the sensors say (the same numbers; Inputs move the truth)."""
    out: dict[str, Any] = {}
    for name, value in temperature.model_dump().items():
        out[f"temp_{name}_C"] = value
        out[f"reading_{name}_C"] = value
    return out
