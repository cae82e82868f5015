"""Blocks of the exam: which cases they hold, and how a case is built from (block, seed, number)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from benchmarks.exam import concealed_axis, concealed_heat, concealed_readings, files, foreign, machines
from benchmarks.exam.case import Concealed, Maker
from benchmarks.exam.design import Design
from benchmarks.exam.design_lines import laser, r_test, tracer
from benchmarks.exam.design_part import machined
from benchmarks.exam.design_probe import probe
from benchmarks.exam.design_traces import ball_bar, servo
from benchmarks.exam.kinema import Array
from benchmarks.exam.noise import WORLDS, scatter
from benchmarks.exam.observe import Hidden, join, nuisance_draw, observed, real_errors, tip_motion
from benchmarks.exam.strength import Whitener, amplitude_for, whitener

Rng = np.random.Generator
FAMILIES: dict[str, Maker] = concealed_axis.FAMILIES | concealed_heat.FAMILIES | concealed_readings.FAMILIES
DESIGNS: dict[str, Callable[..., Design]] = {
    "probe": probe, "ball-bar": ball_bar, "laser": laser, "tracer": tracer, "r-test": r_test, "part": machined, "servo": servo,
}  # fmt: skip
SEEN_BY: dict[str, tuple[str, ...]] = {  # designs that are rich for a family
    "probe": (
        "scale_factor", "squareness", "geometric_change", "abbe_offset", "abbe_counted_twice", "map_interpolation",
        "cross_axis_flexure", "part_load", "scale_expansion", "part_expansion", "thermal_drift", "linear_drift",
        "step_change", "reindexing", "gradient_bending", "backlash", "lost_motion", "hysteresis", "reversal_spike",
        "screw_pitch", "encoder_interpolation", "readout_delay", "dynamic_pitch", "trigger_delay", "tip_radius",
        "probe_lobing", "stylus_bending", "tip_form", "clamping",
    ),
    "ball-bar": ("squareness", "scale_factor", "backlash", "reversal_spike", "servo_lag"),
    "laser": ("scale_factor", "screw_pitch", "encoder_interpolation", "backlash", "lost_motion", "map_interpolation",
              "cosine_error", "air_index", "dead_path", "screw_heating", "scale_expansion"),
    "tracer": ("squareness", "scale_factor", "geometric_change", "cross_axis_flexure"),
    "r-test": ("rotary_location", "rotary_cyclic"),
    "part": ("tool_deflection", "tool_wear", "tool_runout", "workpiece_heating", "spindle_growth"),
    "servo": ("servo_lag", "structural_vibration"),
}  # fmt: skip
POOR: dict[str, tuple[str, ...]] = {
    "probe": ("backlash", "dynamic_pitch", "tip_form", "tip_radius", "trigger_delay", "probe_lobing", "squareness",
              "scale_factor", "stylus_bending", "linear_drift", "thermal_drift", "hysteresis"),
    "ball-bar": ("servo_lag", "squareness", "backlash", "reversal_spike", "scale_factor"),
    "laser": ("scale_factor", "cosine_error", "air_index", "backlash", "lost_motion"),
    "part": ("tool_wear", "tool_deflection", "workpiece_heating"),
}  # fmt: skip
RICH = tuple((d, f) for d, names in SEEN_BY.items() for f in names)
MISTAKES = ("sign", "swapped", "unit", "missing", "counted twice")


@dataclass(frozen=True, eq=False)
class Truth:
    """What is known of a case. items: what was concealed; amplitudes; deltas as reached; simple: simpler names that count."""

    block: str
    seed: int
    number: int
    design: str
    world: str
    items: tuple[Concealed, ...] = ()
    amplitudes: tuple[float, ...] = ()
    deltas: tuple[float, ...] = ()
    simple: tuple[tuple[str, ...], ...] = ()
    stale: float = 1.0
    stale_delta: float = 0.0
    invisible: bool = False
    remarks: tuple[str, ...] = field(default_factory=tuple)

    def summary(self) -> dict[str, object]:
        what = [
            {"effect": c.effect, "where": dict(c.where), "amplitude": a, "delta": d, "counts_too": list(s), "note": c.note,
             "parameters": {k: list(v) for k, v in c.parameters(a).items()}}
            for c, a, d, s in zip(self.items, self.amplitudes, self.deltas, self.simple)
        ]  # fmt: skip
        return {"block": self.block, "seed": self.seed, "case": self.number, "design": self.design, "world": self.world,
                "stale": self.stale, "stale_delta": self.stale_delta, "concealed": what, "invisible": self.invisible, "remarks": list(self.remarks)}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Case:
    truth: Truth
    design: Design
    machine: machines.Machine
    values: Array
    white: Whitener
    recording: Path


@dataclass(frozen=True, eq=False)
class Setting:
    design: Design
    machine: machines.Machine
    white: Whitener


def _setting(design: Design, rng: Rng) -> Setting:
    return Setting(design, machines.draw(design.machine, rng), whitener(design))


def effect_of(s: Setting, hidden: Hidden, stale: float = 1.0) -> Array:
    """What the concealed effect changes in the observations, on the real machine."""
    none = Hidden()
    with_it = observed(
        s.design, tip_motion(s.design, real_errors(s.design, s.machine, hidden, stale), hidden.shift), hidden
    )
    without = observed(s.design, tip_motion(s.design, real_errors(s.design, s.machine, none, stale)), none)
    return np.asarray(with_it - without)


def _counts_too(s: Setting, item: Concealed, amplitude: float) -> tuple[str, ...]:
    """Simpler names that leave less than delta 4 unexplained."""
    whole = s.white.apply(effect_of(s, item.build(amplitude)))
    names = []
    for name, builds in item.simpler.items():
        basis = np.column_stack([s.white.apply(effect_of(s, b(1.0))) for b in builds])
        left = whole - basis @ np.linalg.lstsq(basis, whole, rcond=None)[0]
        if np.linalg.norm(left) < 4.0:
            names.append(name)
    return tuple(names)


def _conceal(s: Setting, item: Concealed, delta: float) -> tuple[float, float, tuple[str, ...]]:
    a = amplitude_for(delta, lambda k: s.white.delta(effect_of(s, item.build(k))), item.start)
    return a, s.white.delta(effect_of(s, item.build(a))), _counts_too(s, item, a)


def _stretched(
    s: Setting, make: Callable[[machines.Machine], Concealed], delta: float
) -> tuple[Setting, Concealed]:
    """For fixed coefficients: the stored table of the component is made larger or smaller until delta is reached."""
    item = make(s.machine)
    word = item.where.get("component") or ""
    axis = item.where.get("axis", word[-1:])
    which = [3, 4, 5] if not word else [("EX", "EY", "EZ", "EA", "EB", "EC").index(word[:2])]
    if "swapped" in item.where.get("what", ""):
        which.append(("EX", "EY", "EZ", "EA", "EB", "EC").index(item.where["what"].split()[-1][:2]))

    def at(k: float) -> Setting:
        table = {a: t.copy() for a, t in s.machine.table.items()}
        table[axis][:, which] *= k
        return replace(s, machine=replace(s.machine, table=table))

    def seen(k: float) -> float:
        here = at(k)
        return here.white.delta(effect_of(here, make(here.machine).build(1.0)))

    k = amplitude_for(delta, seen)
    here = at(k)
    return here, make(here.machine)


def _maker(name: str, s: Setting, seed: tuple[int, ...]) -> Callable[[machines.Machine], Concealed]:
    return lambda machine: FAMILIES[name](s.design, machine, np.random.default_rng(seed))


def _mistake_maker(
    what: str, design: Design, seed: tuple[int, ...]
) -> Callable[[machines.Machine], Concealed]:
    return lambda machine: foreign.mistake(design, machine, np.random.default_rng(seed), what)


def plan(block: str, number: int) -> tuple[str, tuple[str, ...], str]:
    """Design, concealed names and world of case `number` of a block: all families in turn."""
    if block in ("A", "M"):
        design, family = RICH[(number * 7) % len(RICH)] if block == "A" else ("probe", "backlash")
        return design, (family,), "t6"
    if block == "B":
        return tuple(DESIGNS)[number // len(WORLDS) % len(DESIGNS)], (), WORLDS[number % len(WORLDS)]
    if block == "C":
        return ("probe", "tracer", "ball-bar", "laser")[number % 4], (), "t6"
    if block == "D":
        names = SEEN_BY["probe"]
        first = number * 5 % len(names)
        return "probe", (names[first], names[(first + 1 + number * 11 % (len(names) - 1)) % len(names)]), "t6"
    if block == "E":
        return "probe", (tuple(foreign.FOREIGN)[number % len(foreign.FOREIGN)],), "t6"
    if block == "F":
        poor = [(d, f) for d, names in POOR.items() for f in names]
        design, family = poor[number * 7 % len(poor)]
        return design, (family,), "t6"
    if block == "G":
        return (
            "probe",
            (("thermal_drift", "linear_drift", "scale_expansion", "part_expansion")[number % 4],),
            "t6",
        )
    if block == "H":
        return (
            ("probe", "tracer", "probe", "laser")[number // len(MISTAKES) % 4],
            (MISTAKES[number % len(MISTAKES)],),
            "t6",
        )
    raise ValueError(
        f"block {block} holds no cases of its own; A B C D E F G H M do, I J K are scored from them"
    )


def build(
    block: str, seed: int, number: int, folder: Path, delta: float = 10.0, rows: int | None = None
) -> Case:
    """The case, its files written to `folder`."""
    name, concealed, world = plan(block, number)
    key = (seed, ord(block), number)
    rng = np.random.default_rng(key)
    arguments = {} if rows is None else {"rows": rows}
    if block == "M":
        arguments = {"rows": rows or 1000}
    if block == "F":
        arguments["rich"] = False
    s = _setting(DESIGNS[name](rng, **arguments), rng)
    truth = Truth(block, seed, number, s.design.name, world)
    if block == "G":
        s, remark = _decoy(s, number)
        truth = replace(truth, remarks=(remark,))
    if block == "C":
        truth = replace(truth, stale=float(rng.uniform(1.5, 3.0)))
        apart = [
            observed(s.design, tip_motion(s.design, real_errors(s.design, s.machine, Hidden(), f)), Hidden())
            for f in (truth.stale, 1.0)
        ]
        truth = replace(truth, stale_delta=s.white.delta(apart[0] - apart[1]))
    s, truth, hidden = _with(s, truth, concealed, delta, key)
    values = observed(
        s.design,
        tip_motion(s.design, real_errors(s.design, s.machine, hidden, truth.stale), hidden.shift),
        hidden,
    )
    values = values + nuisance_draw(s.design, rng) + scatter(world, s.design, len(values), rng)
    shown = _shown(s.design, block, number)
    return Case(truth, s.design, s.machine, values, s.white, files.write(folder, shown, s.machine, values))


def _with(s: Setting, truth: Truth, names: tuple[str, ...], delta: float, key: tuple[int, ...]):
    items, amplitudes, deltas, simple = [], [], [], []
    for i, name in enumerate(names):
        seed = (*key, i)
        if name in MISTAKES or name == "abbe_counted_twice":
            make = _maker(name, s, seed)
            if name in MISTAKES:
                what = name
                make = _mistake_maker(what, s.design, seed)
            s, item = _stretched(s, make, delta)
            found = (1.0, s.white.delta(effect_of(s, item.build(1.0))), ())
        else:
            maker = FAMILIES.get(name) or foreign.FOREIGN[name]
            item = maker(s.design, s.machine, np.random.default_rng(seed))
            try:
                found = _conceal(s, item, delta)
            except ValueError:
                truth = replace(truth, invisible=True)
                found = (item.start, 0.0, ())
        items.append(item)
        for store, value in zip((amplitudes, deltas, simple), found):
            store.append(value)
    hidden = join([item.build(a) for item, a in zip(items, amplitudes)])
    truth = replace(
        truth, items=tuple(items), amplitudes=tuple(amplitudes), deltas=tuple(deltas), simple=tuple(simple)
    )
    return s, truth, hidden


def _decoy(s: Setting, number: int) -> tuple[Setting, str]:
    """G, even: all temperatures climb together, so time and every sensor look alike. Odd: see `_shown`."""
    if number // 4 % 2:
        return s, "the columns of two sensors are exchanged in the file"
    t = s.design.series["time_s"]
    ramp = 20.5 + 2.5 * (t / t[-1])
    series = {
        k: (t if k == "time_s" else ramp + 0.1 * i + 0.02 * np.sin(t / (700.0 + 90 * i)))
        for i, (k, _) in enumerate(s.design.series.items())
    }
    return replace(s, design=replace(s.design, series=series)), "all temperatures climb with time"


def _shown(design: Design, block: str, number: int) -> Design:
    """What the file shows: in half of block G two logs are exchanged."""
    if block != "G" or number // 4 % 2 == 0:
        return design
    series = dict(design.series)
    for one, two in (("temp_scale_x_C", "temp_scale_y_C"), ("temp_part_C", "temp_air_C")):
        series[one], series[two] = series[two], series[one]
    return replace(design, series=series)


def families() -> Mapping[str, tuple[str, ...]]:
    return SEEN_BY
