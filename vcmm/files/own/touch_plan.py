"""Convert a plan of touches (design/1 with one set-up of a touch probe) to a probing program, its recording file and its set-up file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.machine import MOVE_IT, Machine
from vcmm.core.run import Array, Run
from vcmm.core.units import quantity
from vcmm.files.own.design import DesignFile, load_design
from vcmm.files.own.instruments import instrument_text
from vcmm.files.own.setups import SetupTable
from vcmm.files.own.touch_setups import SIDES, poses_of
from vcmm.files.toml import read_toml
from vcmm.program.probing_program import PlannedTouch, ProbingJob, turning_height
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.probe_frame import SPINDLE, head_axes, machine_directions
from vcmm.task.instruments.touch_probe import TOUCH_PROBE, touches
from vcmm.task.response.recording import Recording

PlannedTuple = tuple[str, tuple[Recording, ...], float, InstrumentCertificate]


@dataclass(frozen=True, eq=False)
class TouchPlan:
    """path; table: the set-up; setup: as `load_design` gives it; poses: its rotary positions, rad; budget in minutes or None."""

    path: Path
    machine_file: Path | None
    table: SetupTable
    setup: PlannedTuple
    machine: Machine
    poses: list[dict[str, float]]
    budget: float | None

    @property
    def ball(self) -> float:
        """Radius of the ball of the stylus, mm."""
        return self.table.tip_diameter / 2

    @property
    def sphere(self) -> float:
        """Radius of the spheres, mm."""
        return quantity(self.table.radius, "length", "radius", "12.5 mm")


def load_touch_plan(path: str | Path) -> TouchPlan:
    """Read a plan whose program is to be written. Raises DataError and UsageError with the expected content."""
    path = Path(path)
    setups, machine, budget = load_design(path)
    model = DesignFile.model_validate(read_toml(path).data)
    if len(setups) != 1 or setups[0][3].instrument.name != TOUCH_PROBE.name:
        names = ", ".join(f"{s[0]} ({s[3].instrument.name})" for s in setups)
        raise UsageError(
            f'{path}: a probing program is written for one set-up with "touch probe"; this plan has {names}'
        )
    table = model.setups[0]
    if not table.tip_diameter:
        raise UsageError(
            f'{path}: the set-up "{table.name}" needs tip_diameter, that of the ball of the stylus, such as "6 mm"'
        )
    _check_axes(machine, path)
    file = path.parent / model.machine if model.machine else None
    return TouchPlan(
        path=path,
        machine_file=file,
        table=table,
        setup=setups[0],
        machine=machine,
        poses=poses_of(table, machine),
        budget=budget,
    )


def _check_axes(machine: Machine, path: Path) -> None:
    """Raises UsageError where the tip does not move along X, Y and Z of the machine as the axes do."""
    still = {a: np.zeros(1) for a in machine.chain.letters}
    for i, letter in enumerate("XYZ"):
        if letter not in still:
            raise UsageError(f"{path}: the machine has no axis {letter}; a probing program moves X, Y and Z")
        if any(a[0] not in "ABC" for a in machine.chain.letters if is_rotary(a)) or i > 2:
            raise UsageError(f"{path}: rotary axes are A, B and C")


def probing_job(
    given: TouchPlan, poses: Sequence[dict[str, float]], standoff: float, above: float, tool: int
) -> ProbingJob:
    """Return touches in the work offset, sphere after sphere at every rotary position. standoff, above: mm."""
    table, machine = given.table, given.machine
    spindle = [quantity(text, "angle", "spindle", "180 deg") for text in table.spindle] or [0.0]
    spheres = [list(s) for s in table.spheres]
    made = touches(
        machine,
        spheres,
        given.sphere + given.ball,
        poses,
        directions=SIDES,
        u=1e-3,
        offset=table.tip,
        spindle=spindle,
    )
    run = made.run
    zero, offset = np.array(table.zero), np.array(table.tip)
    axes = np.stack([run.q(a) for a in "XYZ"], axis=1)
    outward = np.einsum("nij,nj->ni", machine_directions(machine, run), made.direction)
    surface = axes + offset - zero - given.ball * outward
    letters = [a for a in machine.chain.letters if is_rotary(a)]
    planned = tuple(_touch(run, i, surface[i], outward[i], letters) for i in range(run.n))
    clear = turning_height(_heights(machine, spheres, given.sphere, zero), above)
    machine.check_travels(run)
    try:
        machine.check_travels(_lift_where_rotary_axes_turn(run, clear + zero[2] - offset[2] + given.ball))
    except ModelLimit as error:
        raise ModelLimit(
            f"{given.path}: rotary axes turn at Z {clear:g} mm of the work offset, above all that the spheres can reach about their centres: "
            f"{str(error).removesuffix(MOVE_IT)}; put the spheres lower or nearer to these centres, or take a shorter probe"
        ) from None
    return ProbingJob(planned, clear, standoff, given.ball, tool, leads_tip=bool(head_axes(machine)))


def _touch(run: Run, i: int, surface: Array, outward: Array, letters: Sequence[str]) -> PlannedTouch:
    x, y, z = (round(float(v), 6) for v in surface)
    i1, i2, i3 = (int(v) for v in -np.rint(outward))
    rotary = {a[0]: round(float(np.degrees(run.q(a)[i])), 6) for a in letters}
    turned = float(np.degrees(run.columns[SPINDLE][i])) if SPINDLE in run.columns else 0.0
    return PlannedTouch(int(run.labels["feature"][i]), (x, y, z), (i1, i2, i3), rotary, turned)


def _heights(machine: Machine, spheres: Sequence[Sequence[float]], radius: float, zero: Array) -> list[float]:
    """Return the largest Z (work offset) of a sphere for all angles of the rotary axes: its farthest from their centres, above these."""
    centres = [np.array(machine.axes[a].centre) for a in machine.chain.letters if is_rotary(a)]
    if not centres:
        return [float(s[2] + radius - zero[2]) for s in spheres]
    middle = centres[0]
    apart = sum(float(np.linalg.norm(c - middle)) for c in centres[1:])
    return [
        float(np.linalg.norm(np.array(s) - middle) + apart + radius + middle[2] - zero[2]) for s in spheres
    ]


def _lift_where_rotary_axes_turn(run: Run, z: float) -> Run:
    """Return the run with Z where rotary axes turn, to be checked against the travels."""
    return Run({**run.position, "Z": np.full(run.n, z)}, run.offset)


def recording_text(given: TouchPlan, log: str, folder: Path) -> str:
    """Return the recording file for the log that the program prints; folder: where it will lie."""
    table, machine = given.table, _machine_line(given, folder)
    parts = [
        f'vcmm = "recording/1"\nname = "touch"\ndata = "{log}"\nformat = "touches"\n{machine}kind = "probe"\n[noise]\nu = "{table.u}"\n'
    ]
    parts.append(instrument_text(given.setup[3]))
    parts.append(
        f'[touch]\ntip_diameter = "{table.tip_diameter:g} mm"\noffset = "{_three(table.tip)}"\nzero = "{_three(table.zero)}"\n'
        + ('head = "axes"\n' if head_axes(given.machine) else "")
    )
    for k, place in enumerate(table.spheres, 1):
        parts.append(
            f'[touch.features.{k}]\npoint = "{_three(place)}"\ndiameter = "{2 * given.sphere:g} mm"\n'
        )
    return "".join(parts)


def _machine_line(given: TouchPlan, folder: Path) -> str:
    """The machine file of the plan as seen from a folder, so that both can be moved together; of another drive whole."""
    if given.machine_file is None:
        return ""
    there = given.machine_file.resolve()
    try:
        name = Path(os.path.relpath(there, folder.resolve()))
    except ValueError:
        name = there
    return f'machine = "{name.as_posix()}"\n'


def setup_text(given: TouchPlan, job: ProbingJob, control: str, folder: Path) -> str:
    """Return the set-up file with which `vcmm nc` reads the program; folder: where it will lie."""
    x, y, z = (f'"{v:g} mm"' for v in given.table.zero)
    length = given.ball - given.table.tip[2]
    dialect = {"fanuc": "fanuc", "haas": "haas"}.get(control, control)
    machine = _machine_line(given, folder)
    return (
        f'vcmm = "setup/1"\n{machine}dialect = "{dialect}"\n[offsets]\n{job.offset} = [{x}, {y}, {z}]\n'
        f'[tools.{job.tool}]\nlength = "{length:g} mm"\ndiameter = "{given.table.tip_diameter:g} mm"\nshape = "probe"\n'
    )


def _three(values: Sequence[float]) -> str:
    return " ".join(f"{v:g}" for v in values) + " mm"
