"""Read [[setups]] of a plan: readings of an instrument at places, as recordings that are not read yet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from pydantic import Field

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.text import LARGEST
from vcmm.core.units import quantity, usual
from vcmm.files.own.touch_setups import touch_setup
from vcmm.files.schema import Distance, Point, Table
from vcmm.task.instruments import artefact, ball_bar, circular, find, laser, level, rotary, straight, tracker
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.response.recording import Recording

Recordings = tuple[Recording, ...]


class SetupTable(Table):
    """One set-up. Which keys matter depends on the instrument; see docs/calibrate.md."""

    name: str
    instrument: str = Field(examples=['"laser linear"'])
    minutes: float = Field(gt=0, allow_inf_nan=False, examples=["20"])
    u: str = Field(examples=['"0.2 um"'])
    own: dict[str, str] = Field(default_factory=dict, examples=['{ scale = "0.3 um/m" }'])
    serial: str = Field(default="", examples=['"L-2041"'])
    axis: str = Field(default="", examples=['"X"', '"C"'])
    across_axis: Literal["", "X", "Y", "Z"] = ""
    component: Literal["", "X", "Y", "Z", "A", "B", "C"] = ""
    at: dict[str, str] = Field(default_factory=dict, examples=['{ Y = "250 mm", Z = "-200 mm" }'])
    offset: Point | None = None
    reflector: Point | None = None
    n: int = Field(default=0, ge=0, examples=["13"])
    station: Point | None = None
    centre: Point | None = None
    radius: str = ""
    plane: Literal["", "XY", "YZ", "ZX"] = ""
    corner: Point | None = None
    start: Point | None = None
    end: Point | None = None
    ball: Point | None = None
    along: Point | None = None
    across: Point | None = None
    spheres: list[Point] = Field(default_factory=list, examples=['["150 0 80 mm", "-80 120 140 mm"]'])
    tip_diameter: Distance = 0.0
    rotary: dict[str, list[str]] = Field(
        default_factory=dict, examples=['{ A = ["-60 deg", "0 deg"], C = ["0 deg", "90 deg"] }']
    )
    spindle: list[str] = Field(default_factory=list, examples=['["0 deg", "180 deg"]'])
    zero: Point = (0.0, 0.0, 0.0)

    @property
    def tip(self) -> list[float]:
        """Offset of the tip (3,) mm."""
        return list(self.offset or (0.0, 0.0, 0.0))


def plan_setup(table: SetupTable, machine: Machine) -> tuple[Recordings, InstrumentCertificate]:
    """Return the recordings of one set-up, most often one, and the certificate of its instrument. Raises UsageError for keys that are missing."""
    instrument = find(table.instrument)
    dimension = "angle" if instrument.kind == "angle" else "length"
    u = quantity(table.u, dimension, "u", "0.2 um")
    if u < usual(dimension) / LARGEST:
        raise UsageError(f'u = "{table.u}" must be positive')
    made = MAKERS[instrument.name](table, machine, u)
    if len(made) == 1:
        made = (replace(made[0], name=table.name),)
    else:
        made = tuple(replace(setup, name=f"{table.name} {setup.name}") for setup in made)
    return made, InstrumentCertificate.of(instrument, table.own, serial=table.serial)


def _need(table: SetupTable, *keys: str) -> None:
    for key in keys:
        if getattr(table, key) in ("", None, 0, {}):
            raise UsageError(f'the set-up "{table.name}" with "{table.instrument}" needs {key}')


def _axis(table: SetupTable, machine: Machine) -> tuple[Array, Mapping[str, float]]:
    """Return targets of the axis that moves, and the positions of the others."""
    _need(table, "axis", "n")
    if table.axis not in machine.axes:
        raise UsageError(
            f'the set-up "{table.name}" moves "{table.axis}".{choose_from(table.axis, machine.axes)}'
        )
    at = {a: quantity(v, "length" if a in "XYZ" else "angle", a, _somewhere(a)) for a, v in table.at.items()}
    missing = [a for a in machine.chain.letters if a not in (table.axis, table.across_axis) and a not in at]
    if missing:
        raise UsageError(
            f'the set-up "{table.name}" does not say where {" ".join(missing)} stood; add at = {{ {missing[0]} = "{_somewhere(missing[0])}" }}'
        )
    return np.linspace(*machine.axes[table.axis].travel, table.n), at


def _somewhere(axis: str) -> str:
    """Return a position of an axis that a message shows."""
    return "0 deg" if is_rotary(axis) else "250 mm"


def _line(table: SetupTable, machine: Machine, u: float) -> Recordings:
    if table.start is not None or table.end is not None:
        _need(table, "start", "end", "n")
        ends = (list(table.start or ()), list(table.end or ()))
        return (laser.diagonal(machine, ends, table.n, u, table.tip),)
    targets, at = _axis(table, machine)
    component = table.component or table.axis
    if table.offset is not None and table.reflector is not None:
        raise UsageError(
            f'the set-up "{table.name}" has its reflector on the tool (offset) and on the table (reflector); keep one of them'
        )
    on_table = None if table.reflector is None else np.array(table.reflector)
    return (
        laser.line(
            machine,
            table.axis,
            targets,
            at,
            np.array(table.tip),
            component=component,
            u=u,
            reflector=on_table,
        ),
    )


def _level(table: SetupTable, machine: Machine, u: float) -> Recordings:
    targets, at = _axis(table, machine)
    component = table.component or table.axis
    about = "XYZ"["ABC".index(component)] if component in "ABC" else component
    return (level.readings(machine, table.axis, targets, at, about, u),)


def _six(table: SetupTable, machine: Machine, u: float) -> Recordings:
    """Return six_d recordings; u of lengths; angles as well as that over 1 m."""
    targets, at = _axis(table, machine)
    offset = None if table.offset is None else np.array(table.tip)
    spread = {"linear": u, "straightness": u, "angle": u / 1000.0}
    return tuple(laser.six_d(machine, table.axis, targets, at, offset, spread))


def _edge(table: SetupTable, machine: Machine, u: float) -> Recordings:
    targets, at = _axis(table, machine)
    _need(table, "component")
    return (
        straight.edge(machine, table.axis, targets, at, np.array(table.tip), component=table.component, u=u),
    )


def _square(table: SetupTable, machine: Machine, u: float) -> Recordings:
    """Return a square from the corner `at` along axis and across_axis, both arms as long as `radius`."""
    _need(table, "across_axis", "radius")
    _, at = _axis(table, machine)
    pair = (table.axis, table.across_axis)
    corner = {a: at.get(a, float(machine.axes[a].travel[0])) for a in pair}
    arm = quantity(table.radius, "length", "radius", "200 mm")
    targets = tuple(np.linspace(corner[a], corner[a] + arm, table.n) for a in pair)
    where = {**at, **corner}
    return (straight.square(machine, pair, targets, where, np.array(table.tip), u),)  # type: ignore[arg-type]


def _circle(table: SetupTable, machine: Machine, u: float) -> Recordings:
    """Return a circle; or, with a rotary axis, a ball held while it turns, against a cup at centre."""
    if table.axis and table.instrument == "ball bar":
        angles = _angles(table, machine)
        _need(table, "ball", "centre")
        ball, cup = list(table.ball or ()), list(table.centre or ())
        return (rotary.held_bar(machine, table.axis, angles, ball, cup=cup, u=u, offset=table.tip),)
    _need(table, "centre", "radius", "plane")
    radius = quantity(table.radius, "length", "radius", "150 mm")
    make: Callable[..., Recording] = (
        circular.grid_circle if table.instrument == "grid plate" else ball_bar.both_senses
    )
    place = list(table.centre or ())
    return (make(machine, place, radius, table.plane, u, points=table.n or 72, offset=table.tip),)


def _stations(table: SetupTable, machine: Machine, u: float) -> Recordings:
    _need(table, "station", "n")
    grid = [np.linspace(*machine.axes[a].travel, table.n) for a in "XYZ"]
    tips = np.stack([m.ravel() for m in np.meshgrid(*grid, indexing="ij")], axis=1) + np.array(table.tip)
    free = (
        {"station": "setup", "zero": "setup"} if table.instrument == "LaserTracer" else {"station": "setup"}
    )
    place = list(table.station or ())
    return (
        tracker.lengths_to(machine, table.name, tips, place, table.tip, nuisance=free, u=u, label=table.name),
    )


def _plate(table: SetupTable, machine: Machine, u: float) -> Recordings:
    _need(table, "corner", "along", "across")
    n = table.n or 5
    along, across = np.array(table.along), np.array(table.across)
    balls = artefact.grid_of_balls(list(table.corner or ()), along.tolist(), across.tolist(), (n, n))
    directions = "XYZ"
    if table.instrument == "hole plate":
        upright = np.abs(np.cross(along, across))
        if np.count_nonzero(upright > 1e-9 * upright.max()) != 1:
            raise UsageError(
                f'the set-up "{table.name}": a hole plate lies in a plane of two axes here (along, across)'
            )
        directions = "XYZ".replace("XYZ"[int(upright.argmax())], "")
    return (artefact.plate(machine, balls, table.name, table.tip, u, axes=directions),)


def _gauge(table: SetupTable, machine: Machine, u: float) -> Recordings:
    """Return lengths from the first face of a gauge between two places."""
    _need(table, "start", "end", "n")
    start, end = np.array(table.start), np.array(table.end)
    share = np.linspace(0, 1, table.n)[1:] if table.instrument == "step gauge" else np.ones(table.n)
    places = [(start.tolist(), (start + s * (end - start)).tolist()) for s in share]
    return (artefact.bar(machine, places, u, table.tip),)


def _sphere(table: SetupTable, machine: Machine, u: float) -> Recordings:
    from vcmm.task.certification.machines import half_sphere

    _need(table, "centre", "radius")
    radius = quantity(table.radius, "length", "radius", "12.5 mm")
    return (artefact.sphere(machine, list(table.centre or ()), 2 * radius, half_sphere(), u, table.tip),)


def _angles(table: SetupTable, machine: Machine) -> Array:
    """Return angles all round where the axis can, without the last angle, which is the first; else over its travel."""
    _need(table, "axis", "n")
    if table.axis not in machine.axes or table.axis in "XYZ":
        raise UsageError(f'the set-up "{table.name}" needs a rotary axis of the machine, not "{table.axis}"')
    low, high = machine.axes[table.axis].travel
    if high - low >= 2 * np.pi - 1e-9:
        return np.arange(table.n) * 2 * np.pi / table.n + max(low, 0.0 if high >= 2 * np.pi else low)
    return np.linspace(low, high, table.n)


def _r_test(table: SetupTable, machine: Machine, u: float) -> Recordings:
    angles = _angles(table, machine)
    _need(table, "ball")
    return (rotary.r_test(machine, table.axis, angles, list(table.ball or ()), u, table.tip),)


def _indexer(table: SetupTable, machine: Machine, u: float) -> Recordings:
    return (rotary.index_axis(machine, table.axis, _angles(table, machine), u),)


MAKERS: dict[str, Callable[[Any, Machine, float], Recordings]] = {
    "laser linear": _line,
    "laser straightness": _line,
    "laser angle": _line,
    "6-D laser": _six,
    "level": _level,
    "straightedge": _edge,
    "capacitance probe": _line,
    "optical probe": _line,
    "square": _square,
    "ball bar": _circle,
    "grid plate": _circle,
    "tracker": _stations,
    "LaserTracer": _stations,
    "ball plate": _plate,
    "hole plate": _plate,
    "step gauge": _gauge,
    "ball bar artefact": _gauge,
    "sphere": _sphere,
    "R-test": _r_test,
    "rotary indexer": _indexer,
    "touch probe": touch_setup,
}
