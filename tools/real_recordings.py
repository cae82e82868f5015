"""Put the published recordings to `vcmm diagnose` and print the table of docs/real_recordings.md.

    VCMM_DATA=folder python tools/real_recordings.py [NAME ...] [--seed 1]

The files are read where they are, converted in a temporary folder by tests/recordings/convert.py, and nothing of them is
kept. A recording whose file is missing is named and skipped.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "recordings"))

import convert  # noqa: E402

from vcmm.diagnosing import diagnose  # noqa: E402
from vcmm.diagnosis.result import Diagnosis  # noqa: E402
from vcmm.errors import VcmmError  # noqa: E402
from vcmm.files.recording import load_recording  # noqa: E402

Maker = Callable[[Path, Path], Path]
SLIT, RESOLVER = "iso230_2_linear_axis/slit_11358_axis{}_tidy.csv", "resolver_cyclic_latency/{}.csv"
GANTRY, PLATE = "klipper_frame_thermal/{}.csv", "sdss_plugplate_cmm/{}.txt"
RECORDINGS: dict[str, tuple[str, Maker]] = {
    "slit1": (SLIT.format(1), convert.slit_axis),
    "slit2": (SLIT.format(2), convert.slit_axis),
    "slit2-laser": (SLIT.format(2), partial(convert.slit_axis, column="ild2300_mm", u="1 um")),
    "resolver-divider": (RESOLVER.format("VoltageDividerSineCosCoils"), partial(convert.resolver, every=5)),
    "resolver-fault": (RESOLVER.format("ResolverCiclicError2"), partial(convert.resolver, every=5)),
    "gantry1": (GANTRY.format("run1_2021-06-13_05-41-53"), partial(convert.gantry_heating, every=3)),
    "gantry2": (GANTRY.format("run2_2021-06-13_20-04-43"), partial(convert.gantry_heating, every=3)),
    "plate2011": (PLATE.format("D1597A_redrilled_meas_2011"), partial(convert.plug_plate, every=3)),
    "mcu1025": ("iso230_2_linear_axis/mcu1025_ISO230.dat", convert.positioning_runs),
}


def line(name: str, d: Diagnosis, seconds: float) -> str:
    """One row of the table."""
    unit, scale = ("urad", 1e6) if d.angle else ("um", 1e3)
    named = "; ".join(
        f"{a.effect} {' '.join(a.where.values())}".strip()
        + (f" (or {', '.join(a.cannot_be_told_from)})" if a.cannot_be_told_from else "")
        for a in d.answer
    )
    unknown = f"; unknown over {', '.join(d.unknown.covariates)}" if d.unknown else ""
    held = ", ".join(
        f"{h.fold} {h.rms_before * scale:.3g} -> {h.rms_after * scale:.3g}" for h in d.fit.held_out
    )
    fit = f"{d.fit.before * scale:.3g} -> {d.fit.after * scale:.3g} {unit}"
    return f"| {name} | {d.verdict}: {named or 'no name'}{unknown} | {fit} | {held or 'none'} | {seconds:.0f} s |"


def find(folder: Path, stated: str) -> Path | None:
    """The file as stated, else the first of its folder with the same beginning."""
    if (folder / stated).is_file():
        return folder / stated
    place = (folder / stated).parent
    return next((p for p in sorted(place.glob(f"*{Path(stated).stem}*")) if p.is_file()), None)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(RECORDINGS)}; all by default")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    data = os.environ.get("VCMM_DATA")
    if not data:
        print("VCMM_DATA is not set: it names the folder that holds data/recordings", file=sys.stderr)
        return 3
    print("| recording | what vcmm said | rms before -> after | held-out rms | time |")
    print("|---|---|---|---|---|")
    for name in args.names or RECORDINGS:
        stated, make = RECORDINGS[name]
        source = find(Path(data) / "data" / "recordings", stated)
        if source is None:
            print(f"| {name} | file {stated} is missing | | | |")
            continue
        with tempfile.TemporaryDirectory() as folder:
            start = time.perf_counter()
            try:
                d = diagnose(*load_recording(make(source, Path(folder))), seed=args.seed)
            except VcmmError as error:
                print(f"| {name} | refused: {error} | | | |")
                continue
            print(line(name, d, time.perf_counter() - start), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
