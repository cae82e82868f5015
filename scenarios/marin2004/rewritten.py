"""The paper's figure 3 on NC files: read, corrected and written again by `compensate`, the correction following the sensors meanwhile.

Models of a machine that `compensate` and `cut` take: the geometry learnt from readings, and the regression of the thermal parameters
on the sensors as one `component_warming` per parameter and sensor, with a log of the sensors in the set-up. What the machine really
does is made the same way of its true parameters.

    at the start   one set of parameters for the whole cut: what the sensors say when it begins
    updated        the sensors' log over the program: every block is corrected for its own time
    table          the control's table, written anew every some minutes (the paper's second route), subtracted by the control
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vcmm import (
    Array,
    CutScenario,
    Effect,
    Machine,
    Series,
    Setup,
    compensate,
    example,
    load_setup,
    machining,
)
from vcmm import effects as fx
from vcmm.core.run import T0_DEG_C

from .day import PARAMETERS, SENSORS, Day, Regression, read_before

TOLERANCE, DECIMALS = 0.2e-3, 4  # mm, of the rewritten programs
MINUTE = 60.0
TRUE = tuple(f"p{i}" for i in range(len(PARAMETERS)))  # logs that hold the true parameters themselves
UNIT = np.array([1e-3, 1e-3, 1e-6, 1e-3, 1e-3, 1e-3])  # of PARAMETERS, to mm and rad (per m)


def warming(parameter: int, sensor: str, per_kelvin: float) -> Effect:
    """One parameter (number in PARAMETERS) as it goes with one sensor; per_kelvin in the unit of the parameter."""
    name, per_metre = PARAMETERS[parameter][:3], PARAMETERS[parameter].endswith("per m")
    amount = per_kelvin * UNIT[parameter]
    coefficients = np.array([0.0, amount]) if per_metre else np.array([amount, 0.0])
    return fx.ComponentWarming(name, sensor=sensor, coefficients=coefficients)


def true_effects() -> tuple[Effect, ...]:
    """The thermal parameters as they are, for a log of `true_log`."""
    return tuple(warming(i, sensor, 1.0) for i, sensor in enumerate(TRUE))


def learnt_effects(model: Regression) -> tuple[Effect, ...]:
    """The regression as effects, for a log of `sensor_log`."""
    names = sensor_names(model.lags)
    return tuple(
        warming(i, name, float(model.coefficients[s, i]))
        for s, name in enumerate(names)
        for i in range(len(PARAMETERS))
    )


def sensor_names(lags: tuple[int, ...]) -> list[str]:
    """Names of the columns of a regression: the sensors, and what they said some minutes before."""
    return [s.replace(" ", "_") + (f"_{lag}min" if lag else "") for lag in lags for s in SENSORS]


def true_log(today: Day, start: int, held: bool = False) -> machining.TemperatureLog:
    return _log(dict(zip(TRUE, (T0_DEG_C + today.parameters).T)), today, start, held)


def sensor_log(today: Day, start: int, lags: tuple[int, ...], held: bool = False) -> machining.TemperatureLog:
    """What the sensors say, over the time of a program that begins at minute `start`; the zero was set cold, at minute 0.

    held: as at the start for ever.
    """
    return _log(dict(zip(sensor_names(lags), read_before(today.sensors, lags).T)), today, start, held)


def _log(columns: Mapping[str, Array], today: Day, start: int, held: bool) -> machining.TemperatureLog:
    time = (today.minute - start) * MINUTE
    if held:
        now = {n: np.where(today.minute == 0, v, v[start]) for n, v in columns.items()}
        return machining.TemperatureLog({n: Series(time, v) for n, v in now.items()}, float(time[0]))
    return machining.TemperatureLog({n: Series(time, v) for n, v in columns.items()}, float(time[0]))


@dataclass(frozen=True)
class RewrittenProgram:
    """An NC file and how far off it runs: as it was and rewritten, um; lines before and after."""

    name: str
    before: float
    after: float
    lines: int
    blocks: int


def rewritten(
    program: Path, setup: Setup, machine: Machine, log: machining.TemperatureLog | None
) -> machining.CompensatedProgram:
    """The file with the errors of the machine taken out, as `vcmm compensate` does."""
    known = replace(setup, log=log, compensation=())
    return compensate(program, known, machine, tolerance=TOLERANCE, decimals=DECIMALS)


def other_programs(machine: Machine, log: machining.TemperatureLog) -> list[RewrittenProgram]:
    """Programs of others on this mill: arcs, radius compensation, a bored hole; `compensate` takes any it can read."""
    out = []
    for name in ("test_piece/part.nc", "abbe_milling/slot.nc"):
        file = example(name.split("/")[0]).parent / name
        setup = load_setup(file.parent / "setup.toml")
        setup = replace(setup, offsets={"G54": (400.0, 250.0, -350.0)}, machine=None)
        found = rewritten(file, setup, machine, log)
        out.append(
            RewrittenProgram(
                name,
                before=1e3 * found.before.largest,
                after=1e3 * found.after.largest,
                lines=found.blocks.before,
                blocks=found.blocks.after,
            )
        )
    return out


def looked_at(
    scenario: CutScenario, log: machining.TemperatureLog, text: bytes | None = None
) -> tuple[machining.CutNet, ...]:
    """Every feature of the part as a program cuts it, whose state goes on meanwhile; text: instead of the scenario's file."""
    scenario = replace(scenario, setup=replace(scenario.setup, log=log))
    if text is None:
        return _nets(scenario)
    with tempfile.TemporaryDirectory() as home:
        file = Path(home) / "part.nc"
        file.write_bytes(text)
        return _nets(replace(scenario, program=file))


def _nets(scenario: CutScenario) -> tuple[machining.CutNet, ...]:
    shop = machining.set_up(scenario)
    nets = [machining.net(f, 15) for f in scenario.part.features.values()]
    return tuple(machining.cut_net(shop, one) for one in nets if one is not None)


def departures(
    views: tuple[machining.CutNet, ...], machine: Machine, log: machining.TemperatureLog
) -> dict[str, Array]:
    """Departure of each feature from the drawing, um, on a machine with that log; the zero was set cold on this machine."""
    out = {}
    for v in views:
        now = replace(v, tool=replace(v.tool, run=machining.add_temperatures(v.tool.run, log)))
        out[v.net.feature] = 1e3 * (
            machining.departure(now, machine) + v.contacts.surface(v.tool.known_error)
        )
    return out


def by_table(
    views: tuple[machining.CutNet, ...],
    truth: tuple[Machine, machining.TemperatureLog],
    table: tuple[Machine, machining.TemperatureLog],
) -> dict[str, Array]:
    """Departures with the control taking a table off; its errors count at the edge that cuts, as a volumetric compensation's do."""
    nominal = {v.net.feature: 1e3 * v.contacts.surface(v.tool.known_error) for v in views}
    real, off = departures(views, *truth), departures(views, *table)
    return {n: real[n] - off[n] + nominal[n] for n in real}


def held_between(log: machining.TemperatureLog, minutes: float) -> machining.TemperatureLog:
    """The log as a control has it whose table is written anew every so many minutes, the first time when the program begins."""
    out = {}
    for name, one in log.sensors.items():
        fine = np.arange(one.time[0], one.time[-1], 1.0)
        taken = np.maximum(np.floor(fine / (minutes * MINUTE)) * minutes * MINUTE, one.time[0])
        taken = np.where(fine < 0.0, fine, taken)
        out[name] = Series(fine, np.interp(taken, one.time, one.value))
    return replace(log, sensors=out)


def along_the_axes(machine: Machine) -> Machine:
    """What a table of one axis at a time holds: the error of each along itself (LinuxCNC, pitch compensation)."""
    kept = tuple(e for e in machine.effects if getattr(e, "component", "") in ("EXX", "EYY", "EZZ"))
    return replace(machine, effects=kept)


def steepest(today: Day, minutes: float) -> int:
    """Minute of the day at which a cut of so many minutes sees the head move most."""
    head, span = today.parameters[:, 0], int(np.ceil(minutes))
    return int(np.argmax(np.abs(head[span:] - head[:-span])))
