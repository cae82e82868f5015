"""Laser tracker and LaserTracer: lengths from fixed stations to a reflector at the tip.

    tracker       absolute lengths, stations anywhere                     nuisance station
    LaserTracer   changes of length: stations and dead paths anywhere     nuisance station and zero

Stations need only be known roughly: `locate_stations` finds them from the lengths themselves (multilateration), and the remaining problem
is linear. Own error: scale.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.kinematics import nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.instruments.instrument import SCALE, Instrument
from vcmm.task.instruments.laying import layout, rows
from vcmm.task.response.recording import Recording

TRACKER = Instrument(
    "tracker",
    "length",
    (SCALE,),
    ("station",),
    "ISO 10360-10:2021; Schwenke et al., CIRP Annals 57 (2008) 660",
)
LASER_TRACER = Instrument(
    "LaserTracer", "length", (SCALE,), ("station", "zero"), "Schwenke et al., CIRP Annals 54 (2005) 475"
)
FROM = ("from_x_mm", "from_y_mm", "from_z_mm")
STEPS, CONVERGED_MM = 50, 1e-7  # mm


def lengths_to(
    machine: Machine,
    name: str,
    tips: Array,
    station: Sequence[float],
    offset: Sequence[float],
    nuisance: Mapping[str, str],
    u: float,
    label: str = "",
) -> Recording:
    """Lay out lengths from one station (workpiece axes, mm) to tips (n, 3), reached with a tip offset (3,); linear axes only."""
    tips = np.asarray(tips, dtype=float)
    shifted = tips - np.asarray(offset, dtype=float)
    position = {
        a: shifted[:, "XYZ".index(a)] if a in "XYZ" else np.zeros(len(tips)) for a in machine.chain.letters
    }
    run = rows(position, np.asarray(offset), {"setup": [label or "1"] * len(tips)})
    return at_station(
        layout(name, "length", run, np.eye(3)[0], nuisance, u), machine, np.tile(station, (len(tips), 1))
    )


def at_station(recording: Recording, machine: Machine, station: Array) -> Recording:
    """Return the same rows with stations (n, 3) in from_x_mm ..., the directions and lengths that follow."""
    run, station = recording.run, np.asarray(station, dtype=float)
    line = _tip(machine, run) - station
    length = np.linalg.norm(line, axis=1)
    columns = {c: station[:, i] for i, c in enumerate(FROM)} | {"length_mm": length}
    return replace(
        recording, run=run.with_columns(columns), direction=(line / length[:, None])[recording.row]
    )


def _tip(machine: Machine, run: Run) -> Array:
    return nominal_tip(machine.chain, machine.axes, run)


def move_stations(recording: Recording, machine: Machine, station: Array) -> Recording:
    """Return the same measured lengths, counted from other stations (n, 3): values, directions and lengths change together."""
    new = at_station(recording, machine, station)
    change = (new.run.column("length_mm") - recording.run.column("length_mm"))[recording.row]
    return replace(new, value=recording.value - recording.sign * change)


def locate_stations(recording: Recording, machine: Machine) -> tuple[Recording, dict[str, float]]:
    """Return the recording with every station where the lengths put it; label -> how far it was moved, mm.

    Only lengths with a nuisance `station` or `centre` and columns from_x_mm ... are changed. Least squares over station
    and, with `zero` or `radius` or `dead_path`, a constant. Raises ModelLimit for too few points or points in one plane or
    line with the station undetermined.
    """
    word = next((w for w in ("station", "centre") if w in recording.nuisance), "")
    if recording.kind != "length" or not word or FROM[0] not in recording.run.columns:
        return recording, {}
    values, codes = recording.groups(recording.nuisance[word])
    station = recording.run.vector(*FROM)
    tip = _tip(machine, recording.run)
    free = any(w in recording.nuisance for w in ("zero", "radius", "dead_path"))
    moved_by: dict[str, float] = {}
    for code, value in enumerate(values):
        mine = np.flatnonzero(codes == code)
        at = recording.row[mine]
        start = station[at[0]]
        if np.abs(station[at] - start).max() > 1e-6:
            raise ModelLimit(
                f'{recording.name}: {word} "{value}" has different places in from_x_mm ...; give one place per value'
            )
        length = np.linalg.norm(tip[at] - start, axis=1) + recording.sign * recording.value[mine]
        located = _resect(tip[at], length, start, free, f'{recording.name}: {word} "{value}"')
        moved_by[value] = float(np.linalg.norm(located - start))
        station[at] = located
    return move_stations(recording, machine, station), moved_by


def _resect(tip: Array, length: Array, start: Array, free: bool, what: str) -> Array:
    """Solve for the station (3,) from lengths (n,) to points (n, 3), with a free constant or not; Gauss-Newton with limited steps.

    A direction that the points hardly determine keeps its value: there the linear nuisance decides.
    """
    need = 4 if free else 3
    if len(tip) < need:
        raise ModelLimit(f"{what} has {len(tip)} lengths; expected {need} or more to find its place")
    place, constant = start.astype(float), 0.0
    for _ in range(STEPS):
        line = place - tip
        now = np.linalg.norm(line, axis=1)
        slope = line / now[:, None]
        columns = np.concatenate([slope, np.ones((len(tip), 1))], axis=1) if free else slope
        step = np.linalg.lstsq(columns, length - now - constant, rcond=1e-6)[0]
        step *= min(1.0, 0.5 * float(now.min()) / max(float(np.linalg.norm(step[:3])), 1e-300))
        place, constant = place + step[:3], constant + (float(step[3]) if free else 0.0)
        if np.linalg.norm(step[:3]) < CONVERGED_MM:
            return place
    raise ModelLimit(
        f"{what}: no place fits its lengths (still {np.linalg.norm(step[:3]):.2g} mm off after {STEPS} steps); check from_x_mm ..., "
        "the unit of the values, and indicated - true against actual - commanded"
    )
