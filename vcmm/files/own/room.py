"""Changes of the room in time and place, as [environment] states them: K/h, K/d and K/m to effects and Inputs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.laws import Arcsine, Law, Uniform
from vcmm.core.units import quantity
from vcmm.files.problems import Problems
from vcmm.files.toml import Document, Location
from vcmm.physics.structure.expansion import PartExpansion, ScaleExpansion
from vcmm.physics.structure.room import RoomDrift, RoomDriftOfScale, RoomGradient

KEYS = {  # key of [environment]: unit behind the bar, dimension, example
    "room_hour": ("h", "temperature rate", "0.5 K/h"),
    "room_day": ("d", "temperature rate", "1.5 K/d"),
    "room_gradient": ("m", "temperature gradient", "0.3 K/m"),
}


def room_changes(
    document: Document, environment: Any, effects: Sequence[Effect], problems: Problems
) -> tuple[list[Effect], list[Input]]:
    """Return effects and Inputs of a room that changes; effects: of machine and part, whose expansions it acts through.

    room_hour H: the rate is anything up to H, for as long as the plan takes. room_day D: a course of a day, D / 2 sin(2 pi t / 24 h + f)
    with any f, has the rate pi D / 24 h cos f: an arcsine law (JCGM 101:2008, 6.4.6). room_gradient G: up to G in each direction.
    """
    part = next((e.alpha for e in effects if isinstance(e, PartExpansion)), 0.0)
    stated = {key: _stated_value(document, environment, key, part, problems) for key in KEYS}
    hour, day, gradient = (stated[key] for key in KEYS)
    made: list[Effect] = []
    inputs: list[Input] = []
    if hour or day:
        scales = [e for e in effects if isinstance(e, ScaleExpansion) and e.alpha and not e.corrected]
        made = [RoomDrift(alpha=part), *(RoomDriftOfScale(e.axis, alpha=e.alpha) for e in scales)]
        if hour:
            inputs.append(_rate("room_hour", Uniform(hour), made, "change of the room within an hour, up to"))
        if day:
            law = Arcsine(math.pi * day)  # D is held as a rate, D / 24 h
            inputs.append(_rate("room_day", law, made, "course of the room over a day, up to"))
        inputs = [i for i in inputs if i.members]
    if gradient:
        why = "gradient of the room over the part, up to the stated one in every direction"
        made += [RoomGradient(d, alpha=part) for d in "xyz"]
        inputs += [Input(RoomGradient.name, d, "g", Uniform(gradient), "machine", why) for d in "xyz"]
    return made, inputs


def _rate(key: str, law: Law, made: Sequence[Effect], why: str) -> Input:
    """Return one draw for the part and all scales: they are in one room."""
    members = tuple(Input(e.name, e.where, "rate", law) for e in made if getattr(e, "alpha", 0.0))
    label = f"{why} the stated one: part and uncorrected scales follow it"
    return Input(
        "", "", f"environment.{key}", law, "machine", label, members=members, shares=np.ones(len(members))
    )


def _stated_value(document: Document, environment: Any, key: str, part: float, problems: Problems) -> float:
    """Return the canonical number of a key, 0 where it is not stated or wrong; noted where nothing would follow the room."""
    text = getattr(environment, key)
    if not text:
        return 0.0
    inside = isinstance(document.data.get("environment"), dict)
    here: Location = ("environment", key) if inside else ("environment",)
    over, dimension, example = KEYS[key]
    if not text.replace(" ", "").endswith(f"/{over}"):
        problems.add(
            here, f'{key} = "{text}" is a change in K per {over}; write for example {key} = "{example}"'
        )
        return 0.0
    value = problems.attempt(here, lambda: _positive(quantity(text, dimension, key, example), key, text))
    if not part:
        problems.add(
            here,
            f'{key} acts through the expansion of the part; add [part] expansion = "11.5 um/(m K)", or leave {key} out',
        )
    return value or 0.0


def _positive(value: float, key: str, text: str) -> float:
    if value < 0:
        raise UsageError(f'{key} = "{text}" is the size of a change and is not negative')
    return value


def refuse_room_changes(document: Document, environment: Any, problems: Problems) -> None:
    """Refuse room changes for a cut: nothing there would follow the room; screws, spindle and part have effects of their own."""
    for key in KEYS:
        if getattr(environment, key):
            inside = isinstance(document.data.get("environment"), dict)
            problems.add(
                ("environment", key) if inside else ("environment",),
                f"{key} is of a measurement; in a cut state what moves: effects linear_drift, thermal_drift or workpiece_heating",
            )
