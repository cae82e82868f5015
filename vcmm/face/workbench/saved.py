"""The scenario file with the knobs turned, as text to be saved: its owner's comments and layout stay."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from vcmm.core.text import read_text
from vcmm.files.own.placement_writer import number_text, placed_text
from vcmm.task.measuring.knobs import POSE, knobs_of, with_knobs
from vcmm.task.measuring.scenario import Scenario

UNITS = {"room": " K"}  # knobs whose value in a file is a text with its unit


def saved_text(source: Path, scenario: Scenario, values: Mapping[str, float]) -> str:
    """Text of a scenario file like `source` with the knobs at `values`: pose in [pose], all else in [knobs].

    scenario: that of the file before its [knobs] are turned. To be kept in the folder of `source`, whose files it names. A knob that
    stands where it stood is not written. UsageError: knobs that do not exist or are out of range.
    """
    chosen = with_knobs(scenario, values)
    starts = {k.name: k.start for k in knobs_of(scenario)}
    moved = {n: float(v) for n, v in values.items() if abs(v - starts[n]) > 1e-12}
    text = read_text(source)
    if any(n in POSE for n in moved):
        pose = np.concatenate([chosen.pose.shift, chosen.pose.turns()])
        text = placed_text(source, source, pose)
    return _with_knobs_table(text, {n: v for n, v in moved.items() if n not in POSE})


def _with_knobs_table(text: str, turned: Mapping[str, float]) -> str:
    """The text with [knobs] as given, and without where nothing is turned."""
    import tomlkit

    document = tomlkit.parse(text.rstrip() + "\n")
    document.pop("knobs", None)
    document = tomlkit.parse(document.as_string().rstrip() + "\n")
    if turned:
        table = tomlkit.table()
        for name, value in turned.items():
            table[name] = _value(name, value)
        document.add(tomlkit.nl())
        document["knobs"] = table
    return str(document.as_string())


def _value(name: str, value: float) -> str | int | float:
    if name in UNITS:
        return f"{number_text(value, 9)}{UNITS[name]}"
    return round(value) if name == "touches" else value
