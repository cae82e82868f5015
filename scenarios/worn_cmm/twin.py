"""Two faults concealed in the log of a CMM: a worn Y drive and a ram that grows with the room.

A ball plate, turned, tilted and shifted, is touched 400 times in six hours. The machine that touches is the one of the
machine file, its calibration drawn once within its stated uncertainty, plus two mechanisms of which the file knows
nothing. They are written out here and share no line with the effects of the catalogue:

- play: the Y carriage follows its drive only after the gap has been taken up, walked along the whole path of the tip
- ram: its length follows the air as a first-order system, so that the tip stands the lower the warmer the last hour was

The answer of `diagnose` can thus be laid beside the truth, and the machine file that it writes beside the old one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vcmm import Array, Effect, Input, Machine, Recording, Run, Scenario, Series, diagnose, laws
from vcmm import diagnosis as vcmm_diagnosis
from vcmm import effects as fx
from vcmm import measuring as vcmm_measuring
from vcmm import tables as tb

GAP = 1.4e-3  # mm, play of the Y drive: a worn nut, the order of ISO 230-2 reversal errors of used machines
GROWTH, LAG = (
    1.0e-3,
    2700.0,
)  # mm per K of the air, s: 90 mm of unscaled steel ram; a slender column in still air
SCATTER, DOF = 0.4e-3, 10.0  # mm: the repeatability of the machine file
TOUCHES, HOURS, PLACEMENTS = 400, 6.0, 5
AIR = 22.0  # degC, room of the job
BACK = 5.0  # mm, retreat from the surface
STYLI = {"down": (0.0, 0.0, -110.0), "side": (60.0, 0.0, -90.0)}
SEED = 1
Progress = Callable[[str, float], None]
Learnt = tuple[
    tuple[Effect, tuple[Input, ...]], ...
]  # as vcmm.learn.diagnosis.improve.improve_machine takes them


@dataclass(frozen=True)
class Concealed:
    """One mechanism: the name of the catalogue that describes it, and its true parameters in the units of reports."""

    effect: str
    where: Mapping[str, str]
    parameters: Mapping[str, tuple[float, str]]


CONCEALED = (
    Concealed("backlash", {"axis": "Y"}, {"gap": (GAP * 1e3, "um")}),
    Concealed("thermal_drift", {"direction": "z"}, {"k": (-GROWTH * 1e3, "um/K"), "tau": (LAG, "s")}),
)


@dataclass(frozen=True, eq=False)
class Moved:
    """A characteristic of the job, as the machine file says and as it is: values and expanded uncertainties without the known bias, mm or rad."""

    name: str
    before: tuple[float, float]
    after: tuple[float, float]
    true: float


@dataclass(frozen=True, eq=False)
class WornTwin:
    recording: Recording
    machine: Machine
    diagnosis: vcmm_diagnosis.Diagnosis
    better: Machine
    job: tuple[Moved, ...]


def answer_to(diagnosis: vcmm_diagnosis.Diagnosis, hidden: Concealed) -> vcmm_diagnosis.Answer | None:
    """The answer that names the concealed mechanism, if there is one."""
    named = (a for a in diagnosis.answer if a.effect == hidden.effect)
    return next((a for a in named if hidden.where.items() <= a.where.items()), None)


def recorded(machine: Machine, seed: int = SEED) -> Recording:
    """The recording of the scenario: what this machine, with what is concealed in it, indicated."""
    rng = np.random.default_rng([seed, 20261122])
    run, normal = _touched(rng)
    empty = Recording(
        "worn_cmm",
        "probe",
        run,
        value=np.zeros(run.n),
        measuring=True,
        row=np.arange(run.n),
        direction=normal,
        other=np.full(run.n, -1),
    )
    known = vcmm_diagnosis.baseline(empty, machine)
    for _, columns in vcmm_diagnosis.calibration_columns(
        empty, machine
    ):  # the calibration is wrong, by as much as it states
        known = known + columns @ rng.standard_normal(columns.shape[1])
    noise = laws.StudentT(SCATTER, DOF)
    scatter = SCATTER * rng.standard_t(DOF, run.n)
    value = known + seen(play(run), normal) + seen(ram(run), normal) + scatter
    return replace(empty, value=value, nuisance={"rigid": "pose", "offset": "stylus"}, noise=noise)


def seen(tip: Array, normal: Array) -> Array:
    """What a tip that stands off by tip (n, 3), actual - nominal, lets the machine indicate along the normal (n,), mm.

    The tip touches at the true surface, so the machine indicates the surface on the other side: minus.
    """
    return -np.einsum("ni,ni->n", tip, normal)


def play(run: Run) -> Array:
    """(n, 3) mm: the carriage stays where it is until the drive has crossed the gap; the whole path is walked."""
    out, carriage = np.zeros((run.n, 3)), run.position["Y"][0]
    before = run.columns["before_Y"]
    for i, (start, end) in enumerate(zip(before, run.position["Y"])):
        for drive in (start, end):
            carriage = min(max(carriage, drive - GAP / 2), drive + GAP / 2)
        out[i, 1] = carriage - end
    return out


def ram(run: Run) -> Array:
    """(n, 3) mm: the tip sinks by GROWTH per K of an air temperature that is felt with a lag of LAG."""
    air = run.series["air"]
    felt = np.empty_like(air.value)
    felt[0] = air.value[0]
    share = 1.0 - np.exp(-np.diff(air.time) / LAG)
    for i, part in enumerate(share):
        middle = (air.value[i] + air.value[i + 1]) / 2
        felt[i + 1] = felt[i] + (middle - felt[i]) * part
    out = np.zeros((run.n, 3))
    out[:, 2] = -GROWTH * (np.interp(run.columns["time_s"], air.time, felt) - 20.0)
    return out


def _touched(rng: np.random.Generator) -> tuple[Run, Array]:
    """Where the plate was touched, and the outward normals (n, 3): 12 balls, five placements, two styli."""
    n = TOUCHES
    pose = np.arange(n) * PLACEMENTS // n
    x, y = np.meshgrid([-150.0, -50.0, 50.0, 150.0], [-100.0, 0.0, 100.0])
    balls = np.column_stack([x.ravel(), y.ravel(), np.zeros(12)])
    part = balls[rng.integers(0, len(balls), n)]
    turned = np.array([_turn(int(k)) @ p for k, p in zip(pose, part)])
    centre = rng.uniform([250, 220, -240], [340, 280, -200], (PLACEMENTS, 3))[pose]
    normal = rng.standard_normal((n, 3))
    normal[:, 2] = np.abs(normal[:, 2])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    tip = turned + centre + 15.0 * normal  # balls of 30 mm
    stylus = np.where(rng.random(n) < 0.5, "down", "side")
    offset = np.array([STYLI[s] for s in stylus])
    time = np.sort(rng.uniform(0.0, HOURS * 3600.0, n))
    carriage = tip - offset
    before = (
        carriage + BACK * normal
    )  # every touch begins BACK mm outside, after a way that came from anywhere
    before[:, 1] += rng.choice([-2.0, 2.0], n) * BACK * (np.abs(normal[:, 1]) < 0.2)
    columns = {"time_s": time, "before_Y": before[:, 1]}
    columns |= {f"n{c}": normal[:, i] for i, c in enumerate("xyz")}
    columns |= {f"part_{c}_mm": part[:, i] for i, c in enumerate("xyz")}
    columns["probe_angle_rad"] = np.arctan2(normal[:, 1], normal[:, 0])  # about the stem of the probe
    columns |= {f"sense_{a}": np.sign(carriage[:, i] - before[:, i]) for i, a in enumerate("XYZ")}
    series = _room(rng)
    columns |= {f"temp_{k}_C": np.interp(time, s.time, s.value) for k, s in series.items()}
    labels = {"pose": np.array([f"placement {k + 1}" for k in pose]), "stylus": stylus}
    position = {a: carriage[:, i] for i, a in enumerate("XYZ")}
    return Run(position, offset, columns, labels, series), normal


def _turn(k: int) -> Array:
    """Placement k of the plate: flat in three directions, then leaning on two sides."""
    a, b = np.deg2rad([0.0, 90.0, 37.0, 10.0, 75.0])[k], np.deg2rad([0.0, 0.0, 0.0, 25.0, -25.0])[k]
    about_z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
    about_x = np.array([[1.0, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    return np.asarray(about_z @ about_x)


def _room(rng: np.random.Generator) -> dict[str, Series]:
    """Air, scales and part over the six hours: a door, the plant's regulator, and everything following at its pace."""
    time = np.arange(0.0, HOURS * 3600.0 + 1.0, 300.0)
    air = (
        20.4 + 0.9 * np.sin(2 * np.pi * time / 11000.0 + 0.7) + 0.8 * (time > 9000.0) - 0.5 * (time > 15500.0)
    )
    air = air + 0.05 * rng.standard_normal(len(time))
    out = {"air": air}
    for i, name in enumerate(("scale_x", "scale_y", "scale_z", "part")):
        slow = 20.1 + 0.1 * i + 0.35 * np.sin(2 * np.pi * time / (17000.0 + 4000.0 * i) + 1.3 * i)
        out[name] = slow
    return {name: Series(time, np.round(value, 3)) for name, value in out.items()}


def texts(machine: Machine, seed: int = SEED) -> dict[str, str]:
    """File name -> text of the data files of the scenario, rounded to what a control writes."""
    found = recorded(machine, seed)
    run = found.run
    columns = {"time_s": _written(run.columns["time_s"], 1)}
    columns |= {f"{a}_mm": _written(run.position[a], 4) for a in "XYZ"}
    columns |= {f"offset_{c}_mm": _written(run.offset[:, i], 1) for i, c in enumerate("xyz")}
    columns |= {f"n{c}": _written(run.columns[f"n{c}"], 6) for c in "xyz"}
    columns |= {f"part_{c}_mm": _written(run.columns[f"part_{c}_mm"], 1) for c in "xyz"}
    columns["probe_angle_deg"] = _written(np.rad2deg(run.columns["probe_angle_rad"]), 2)
    columns |= {f"sense_{a}": _written(run.columns[f"sense_{a}"], 0) for a in "XYZ"}
    columns |= {name: [str(word) for word in run.labels[name]] for name in ("pose", "stylus")}
    columns["d_um"] = _written(found.value * 1e3, 3)
    logs = {"time_s": _written(run.series["air"].time, 0)}
    logs |= {f"temp_{name}_C": _written(log.value, 2) for name, log in run.series.items()}
    return {"touches.csv": _csv(columns), "temperatures.csv": _csv(logs)}


def _written(values: Array, decimals: int) -> list[str]:
    return [f"{v:.{decimals}f}" for v in np.round(values, decimals) + 0.0]  # + 0.0: no minus zero


def _csv(columns: Mapping[str, list[str]]) -> str:
    rows = zip(*columns.values(), strict=True)
    return tb.csv_of([list(columns), *rows])


def run(
    recording: Recording, machine: Machine, job: Scenario, *, seed: int = 1, progress: Progress | None = None
) -> WornTwin:
    """Diagnose the recording, and do a measuring job in a room at AIR by the machine as filed, as diagnosed, as it is."""
    found = diagnose(recording, machine, seed=seed, progress=progress)
    learnt = tuple(
        (a.fitted, a.inputs) for a in vcmm_diagnosis.answers_to_write(found.answer) if a.fitted is not None
    )
    return WornTwin(
        recording, machine, found, vcmm_diagnosis.improve_machine(machine, learnt), _job(job, learnt)
    )


def _job(job: Scenario, learnt: Learnt) -> tuple[Moved, ...]:
    """The job is for the same machine; its file adds what the room and the part do."""
    job, machine = replace(job, constants={**job.constants, "temp_air_C": AIR}), job.machine
    hidden = (
        fx.Backlash(axis="Y", gap=GAP),
        fx.ThermalDrift(direction="z", sensor="air", k=-GROWTH, tau=LAG),
    )
    really = replace(machine, effects=(*machine.effects, *hidden))
    true = vcmm_measuring.measure_task(replace(job, machine=really).task()).values
    before, after = (
        vcmm_measuring.evaluate(replace(job, machine=m).task(), job.settings)
        for m in (machine, vcmm_diagnosis.improve_machine(machine, learnt))
    )
    return tuple(
        Moved(v.name, (b.value, b.expanded - b.bias_in_U), (a.value, a.expanded - a.bias_in_U), v.value)
        for v, b, a in zip(true, before.characteristics, after.characteristics)
    )


def figures(result: WornTwin) -> dict[str, Any]:
    """The body of the JSON document; units as the keys say."""
    return {
        "verdict": result.diagnosis.verdict,
        "concealed": [
            {"effect": c.effect, "where": dict(c.where), "parameters": _compared(result.diagnosis, c)} for c in CONCEALED
        ],
        "job": [
            {"name": m.name, "filed_mm": m.before[0], "filed_U_mm": m.before[1], "diagnosed_mm": m.after[0],
             "diagnosed_U_mm": m.after[1], "true_mm": m.true} for m in result.job
        ],
    }  # fmt: skip


def _compared(diagnosis: vcmm_diagnosis.Diagnosis, hidden: Concealed) -> dict[str, Any]:
    answer = answer_to(diagnosis, hidden)
    out: dict[str, Any] = {}
    for name, (true, unit) in hidden.parameters.items():
        found = answer.parameters[name] if answer else None
        said = {"value": found.value, "interval95": list(found.interval95)} if found else {"value": None}
        out[name] = {"true": true, "unit": unit, **said}
    return out
