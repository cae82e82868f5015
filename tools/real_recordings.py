"""Put the published recordings to `vcmm diagnose` and print the tables of docs/real_recordings.md.

    VCMM_DATA=folder python tools/real_recordings.py [NAME ...] [--seed 1] [--terms]

The files are read where they are, converted in a temporary folder by tests/recordings/convert.py, and nothing of them is
kept. A recording whose file is missing is named and skipped. First table: what vcmm says of each recording. Second table:
predictions of rows that were not given at all, from the machine that the diagnosis improved. --terms: every named term with
its numbers and remarks, below its row.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.recordings import convert  # noqa: E402
from tests.recordings.judged import left, rms, without_nuisance  # noqa: E402
from vcmm.core.errors import VcmmError  # noqa: E402
from vcmm.files.own.recording import load_recording  # noqa: E402
from vcmm.learn.diagnosis.job import diagnose  # noqa: E402
from vcmm.learn.diagnosis.problem import Problem, make_problem  # noqa: E402
from vcmm.learn.diagnosis.result import Diagnosis  # noqa: E402

Maker = Callable[[Path, Path], Path]
SLIT, RESOLVER = "iso230_2_linear_axis/slit_11358_axis{}_tidy.csv", "resolver_cyclic_latency/{}.csv"
GANTRY, PLATE = "klipper_frame_thermal/{}.csv", "sdss_plugplate_cmm/{}.txt"
RUN1, RUN2 = GANTRY.format("run1_2021-06-13_05-41-53"), GANTRY.format("run2_2021-06-13_20-04-43")
MCU = "iso230_2_linear_axis/mcu1025_ISO230.dat"
MOUNT, PETALS = "gem_pointing_rotary_chain/{}.dat", "desi_petal_metrology/petals_2-7_POS_rows.csv"
OLD, NEW = PLATE.format("D1597A_orig_meas_2003"), PLATE.format("D1597A_orig_meas2010")


def plates(source: Path, folder: Path) -> Path:
    return convert.remeasured_plate(source, source.parent / Path(NEW).name, folder)


def petals(source: Path, folder: Path, which: tuple[int, ...] = (2, 3, 4, 5, 6, 7), every: int = 6) -> Path:
    nominal = source.parent / "positioner_locations_0530v18.csv"
    return convert.petals(source, nominal, folder, which, every)


COMMON = (3, 5, 6, 7)
RECORDINGS: dict[str, tuple[str, Maker]] = {
    "slit1": (SLIT.format(1), convert.slit_axis),
    "slit2": (SLIT.format(2), convert.slit_axis),
    "slit2-laser": (SLIT.format(2), partial(convert.slit_axis, column="ild2300_mm", u="1 um")),
    "mcu1025": (MCU, convert.positioning_runs),
    "mcu1025-settled": (MCU, partial(convert.positioning_runs, skip_first=True)),
    "resolver-divider": (RESOLVER.format("VoltageDividerSineCosCoils"), partial(convert.resolver, every=5)),
    "resolver-fault": (RESOLVER.format("ResolverCiclicError2"), partial(convert.resolver, every=5)),
    "gantry1": (RUN1, partial(convert.gantry_heating, every=3)),
    "gantry2": (RUN2, partial(convert.gantry_heating, every=3)),
    "plate2011": (PLATE.format("D1597A_redrilled_meas_2011"), partial(convert.plug_plate, every=3)),
    "plate2003": (OLD, partial(convert.plug_plate, every=3)),
    "plate2003-2010": (OLD, plates),
    "mount-cgx": (MOUNT.format("cgx-l-data"), convert.telescope_mount),
    "mount-cgx-J2000": (MOUNT.format("cgx-l-data"), partial(convert.telescope_mount, of_date=False)),
    "mount-warp": (MOUNT.format("warp-astron"), convert.telescope_mount),
    "mount-warp-J2000": (MOUNT.format("warp-astron"), partial(convert.telescope_mount, of_date=False)),
    "petals": (PETALS, petals),
    "petals-common": (PETALS, partial(petals, which=COMMON)),
}


@dataclass(frozen=True)
class Prediction:
    """Diagnose one recording, predict another; hidden(problem, source): which observations of it count."""

    given: tuple[str, Maker]
    asked: tuple[str, Maker]
    hidden: Callable[[Problem, Path], np.ndarray]


def all_rows(problem: Problem, source: Path) -> np.ndarray:
    return np.ones(problem.m, dtype=bool)


def cooling(problem: Problem, source: Path) -> np.ndarray:
    return problem.per_observation(problem.run.column("time_s")) > convert.switched_off(source)


HEATING = partial(convert.gantry_heating, every=3, heating=True)
PREDICTIONS: dict[str, Prediction] = {
    "gantry1: cool-down from heating": Prediction((RUN1, HEATING), RECORDINGS["gantry1"], cooling),
    "gantry2: cool-down from heating": Prediction((RUN2, HEATING), RECORDINGS["gantry2"], cooling),
    "gantry2 from gantry1": Prediction(RECORDINGS["gantry1"], RECORDINGS["gantry2"], all_rows),
    **{
        f"petals: {k} from {', '.join(str(j) for j in COMMON if j != k)}": Prediction(
            (PETALS, partial(petals, which=tuple(j for j in COMMON if j != k))),
            (PETALS, partial(petals, which=(k,))),
            all_rows,
        )
        for k in (7, 6, 2, 4)
    },
}


def unit_of(d: Diagnosis) -> tuple[str, float]:
    return ("urad", 1e6) if d.angle else ("um", 1e3)


def line(name: str, d: Diagnosis, seconds: float) -> str:
    """One row of the first table: what was said, and the rms of all rows as they are with what is written."""
    unit, scale = unit_of(d)
    named = "; ".join(
        ("candidate " if a.doubtful else "")
        + f"{a.effect} {' '.join(a.where.values())}".strip()
        + (f" (or {', '.join(a.cannot_be_told_from)})" if a.cannot_be_told_from else "")
        for a in d.answer
    )
    unknown = f"; unknown over {', '.join(d.unknown.covariates)}" if d.unknown else ""
    held = ", ".join(
        f"{h.fold} {h.rms_before * scale:.3g} -> {h.rms_after * scale:.3g}" for h in d.fit.held_out
    )
    fit = f"{d.fit.before * scale:.3g} -> {d.fit.after * scale:.3g} {unit}"
    rows = f"{d.fit.candidates * scale:.3g}"
    return f"| {name} | {d.verdict}: {named or 'no name'}{unknown} | {fit} | {rows} | {held or 'none'} | {seconds:.0f} s |"


def terms(d: Diagnosis) -> str:
    """Every answer with its numbers."""
    out = []
    for a in d.answer:
        values = ", ".join(f"{k} {e.value:.4g} +- {e.u:.2g} {e.unit}" for k, e in a.parameters.items())
        where = " ".join(a.where.values())
        out.append(f"    {a.effect} {where}: {values}; share {a.share:.2f}; {a.probability:.2f}; {a.remark}")
    return "\n".join(
        [*out, *(f"    noise: {f}" for f in d.noise_findings), *(f"    {w}" for w in d.warnings)]
    )


def find(folder: Path, stated: str) -> Path | None:
    """The file as stated, else the first of its folder with the same beginning."""
    if (folder / stated).is_file():
        return folder / stated
    place = (folder / stated).parent
    return next((p for p in sorted(place.glob(f"*{Path(stated).stem}*")) if p.is_file()), None)


def told(name: str, folder: Path, seed: int, details: bool) -> str:
    """The row of one recording."""
    stated, make = RECORDINGS[name]
    source = find(folder, stated)
    if source is None:
        return f"| {name} | file {stated} is missing | | | | |"
    with tempfile.TemporaryDirectory() as work:
        start = time.perf_counter()
        try:
            recording, machine = load_recording(make(source, Path(work)))
            d = diagnose(recording, machine, seed=seed)
        except VcmmError as error:
            return f"| {name} | refused: {error} | | | | |"
        seconds = time.perf_counter() - start
        row = line(name, d, seconds)
    return f"{row}\n{terms(d)}" if details else row


def predicted(name: str, folder: Path, seed: int) -> str:
    """The row of one prediction. The nuisance comes from the rows that were given; where there are none, from the others."""
    plan = PREDICTIONS[name]
    sources = [find(folder, stated) for stated, _ in (plan.given, plan.asked)]
    if None in sources:
        return f"| {name} | a file is missing | | |"
    with tempfile.TemporaryDirectory() as work:
        given, asked = (
            load_recording(make(s, Path(work) / f"{i}"))  # type: ignore[arg-type]
            for i, ((_, make), s) in enumerate(zip((plan.given, plan.asked), sources))
        )
        d = diagnose(*given, seed=seed)
        problem = make_problem(*asked)
    hidden = plan.hidden(problem, sources[1])  # type: ignore[arg-type]
    shown = ~hidden if (~hidden).any() else hidden
    before, after = (
        rms(without_nuisance(r, problem, shown)[hidden]) for r in (problem.residual, left(problem, d))
    )
    unit, scale = unit_of(d)
    named = "; ".join(f"{a.effect} {' '.join(a.where.values())}".strip() for a in d.answer) or "no name"
    return f"| {name} | {d.verdict}: {named} | {int(hidden.sum())} | {before * scale:.3g} -> {after * scale:.3g} {unit} |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "names", nargs="*", help=f"of {', '.join(RECORDINGS)}, or predictions; all by default"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--terms", action="store_true", help="every term with its numbers")
    args = parser.parse_args()
    data = os.environ.get("VCMM_DATA")
    if not data:
        print("VCMM_DATA is not set: it names the folder that holds data/recordings", file=sys.stderr)
        return 3
    folder = Path(data) / "data" / "recordings"
    single = [n for n in args.names if n in RECORDINGS]
    if single or not args.names:
        print(
            "| recording | what vcmm said | all rows, before -> written | with candidates | held-out rms | time |"
        )
        print("|---|---|---|---|---|---|")
    for name in single if args.names else RECORDINGS:
        print(told(name, folder, args.seed, args.terms), flush=True)
    if "predictions" in args.names or not args.names:
        print("\n| prediction | named from the rows given | observations predicted | rms before -> after |")
        print("|---|---|---|---|")
        for name in PREDICTIONS:
            print(predicted(name, folder, args.seed), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
