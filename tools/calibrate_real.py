"""Published recordings calibrated and predicted crosswise: the table of docs/calibrate.md.

    VCMM_DATA=folder python tools/calibrate_real.py [geometry] [thermal]

The files are read where they are, converted in a temporary folder, and nothing of them is kept. Every calibration is written as a
machine file and read back; the other recording, or the other half, is then predicted from it. No noise is stated: it is what the
residuals of the calibration say.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.recordings import convert  # noqa: E402
from vcmm.core.errors import ModelLimit, VcmmError  # noqa: E402
from vcmm.files.learned.calibrated_machine import machine_texts  # noqa: E402
from vcmm.files.learned.thermal_terms import thermal_text  # noqa: E402
from vcmm.files.own.machine import load_machine  # noqa: E402
from vcmm.files.own.recording import load_recording  # noqa: E402
from vcmm.learn.calibration.job import bare_machine, calibrate  # noqa: E402
from vcmm.learn.calibration.result import rms  # noqa: E402
from vcmm.learn.calibration.thermal import thermal_model  # noqa: E402
from vcmm.learn.calibration.thermal_net import net_left  # noqa: E402
from vcmm.learn.calibration.verification import IndependentTest, put_to_test  # noqa: E402
from vcmm.task.response.recording import Recording  # noqa: E402

Maker = Callable[[Path, Path], Path]
SLIT = "recordings/iso230_2_linear_axis/slit_11358_axis{}_tidy.csv"
MCU = "recordings/iso230_2_linear_axis/mcu1025_ISO230.dat"
PLATE = "recordings/sdss_plugplate_cmm/{}.txt"
OLD, NEW, LAST = (
    PLATE.format(n) for n in ("D1597A_orig_meas_2003", "D1597A_orig_meas2010", "D1597A_redrilled_meas_2011")
)
GANTRY = "recordings/klipper_frame_thermal/{}.csv"
RUNS = [GANTRY.format(n) for n in ("run1_2021-06-13_05-41-53", "run2_2021-06-13_20-04-43")]


def as_it_is(source: Path, folder: Path) -> Path:
    return source


def odd(recording: Recording, label: str) -> np.ndarray:
    """(m,) every second run where runs are labelled, else every second row of the run: a hole stays whole."""
    _, codes = recording.groups(label)
    number = codes if codes.any() else recording.row
    return np.asarray(number % 2 == 1)


def wanted(recording: Recording) -> tuple[str, ...]:
    """A plate with one tip in one plane cannot tell yaw from straightness and squareness: it is looked at without yaw."""
    moves = [a for a, q in recording.run.position.items() if np.ptp(q) > 1]
    return ("EXX", "EYX", "EXY", "EYY", "C0Y") if len(moves) > 1 else ()


GEOMETRY: dict[str, tuple[str, Maker, str]] = {  # name: file, how it is read, structure
    "mcu1025": (MCU, partial(convert.positioning_runs, skip_first=True), "w b X t"),
    "slit axis 1": (SLIT.format(1), convert.slit_axis, "w b X t"),
    "slit axis 2": (SLIT.format(2), convert.slit_axis, "w b X t"),
    "slit axis 2, laser": (SLIT.format(2), partial(convert.slit_axis, column="ild2300_mm"), "w b X t"),
    "mcuA": ("recordings_2/mcuA/recording.toml", as_it_is, "w b Y t"),
    "mcuB": ("recordings_2/mcuB/recording.toml", as_it_is, "w b Y t"),
    "s60res": ("recordings_2/s60res/recording.toml", as_it_is, "w b X t"),
    "plate 2003": (OLD, convert.plug_plate, "w X' Y' b Z t"),
    "plate 2010": (NEW, convert.plug_plate, "w X' Y' b Z t"),
    "plate 2011": (LAST, convert.plug_plate, "w X' Y' b Z t"),
    "plateA": ("recordings_2/plateA/recording.toml", as_it_is, "w X' Y' b Z t"),
    "plateB": ("recordings_2/plateB/recording.toml", as_it_is, "w X' Y' b Z t"),
}
CROSS = (("mcuA", "mcuB"), ("mcuB", "mcuA"), ("plate 2003", "plate 2010"), ("plate 2010", "plate 2003"), ("plateA", "plateB"))  # fmt: skip
WARM: dict[str, tuple[str, Maker]] = {
    f"gantry {k + 1}{' heating' * h}": (f, partial(convert.gantry_heating, every=3, heating=h, sensors=("frame", "bed", "chamber")))
    for k, f in enumerate(RUNS)
    for h in (False, True)
} | {n: (f"recordings_2/{n}/recording.toml", as_it_is) for n in ("heatC1", "heatC2", "heatC", "heatK")}  # fmt: skip
WARMER = (
    ("gantry 1", "gantry 2"), ("gantry 2", "gantry 1"), ("gantry 1 heating", "gantry 1"), ("gantry 2 heating", "gantry 2"),
    ("heatC1", "heatC2"),
)  # fmt: skip


def predicted(kept: Recording, asked: Recording, structure: str) -> tuple[IndependentTest, str]:
    """Calibrate on `kept`, write, read back, predict `asked`; and the errors that were found."""
    bare = bare_machine(structure)
    found = calibrate([kept], bare, only=wanted(kept))
    noise = found.posterior.noise[0].u * rms(found.readings[0].u)
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "machine.toml"
        for name, text in machine_texts(found, target, [kept.name]).items():
            (target.parent / name).write_text(text)
        return put_to_test(asked, bare, load_machine(target), noise), " ".join(found.kept_model.names)


def row(name: str, fitted: str, asked: str, said: Callable[[], tuple[IndependentTest, str]]) -> str:
    try:
        test, words = said()
    except VcmmError as error:
        return f"| {name} | {fitted} | {asked} | | | | refused: {str(error).splitlines()[0]} |"
    return f"| {name} | {fitted} | {asked} | {test.before * 1e3:.2f} um | {test.after * 1e3:.2f} um | {test.inside:.3f} of {test.n} | {words} |"


def geometry(data: Path) -> None:
    print(
        "| recording | fitted on | predicted | rms before | after | within the 95 % band | errors in the file |"
    )
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as work:
        read = {}
        for name, (file, make, structure) in GEOMETRY.items():
            path = make(data / file, Path(work) / name.replace(" ", "_").replace(",", ""))
            read[name] = load_recording(path, bare_machine(structure))[0]
        for name, recording in read.items():
            structure = GEOMETRY[name][2]
            second = odd(recording, "run")
            for fitted, asked, words in (
                (~second, second, ("one half", "the other")),
                (second, ~second, ("the other", "one half")),
            ):
                halves = partial(predicted, recording.take(fitted), recording.take(asked), structure)
                print(row(name, *words, halves), flush=True)
        for first, other in CROSS:
            whole = partial(predicted, read[first], read[other], GEOMETRY[first][2])
            print(row(first, "all", other, whole), flush=True)


def warm(first: Path, other: Path, sensors: Sequence[str] = ()) -> tuple[IndependentTest, str]:
    """A thermal model of one recording, written, read back, and asked for another; what a net leaves of it beside."""
    recording, machine = load_recording(first)
    asked, _ = load_recording(other)
    model = thermal_model([recording], machine, sensors)
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "machine.toml"
        source = first.parent / "machine.toml"
        target.write_text(thermal_text(model, machine, source, target, [first.name]))
        try:
            test = put_to_test(asked, machine, load_machine(target), model.after)
            beyond = ""
        except ModelLimit:  # it refuses: what it would have said without the key
            kept = [t for t in target.read_text().splitlines() if not t.startswith("trained")]
            target.write_text("\n".join(kept) + "\n")
            test = put_to_test(asked, machine, load_machine(target), model.after)
            beyond = "refused, beyond its temperatures; without `trained`: "
    terms = beyond + ", ".join(f"{t.sensor} {lag:.0f} s" for t, lag in zip(model.terms, model.lags))
    net = net_left([recording], asked, machine, list(model.trained))
    return test, f"{terms}; net {net * 1e3:.2f} um"


def thermal(data: Path) -> None:
    print(
        "| recording | fitted on | predicted | rms before | after | within the 95 % band | sensors with lags |"
    )
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as work:
        paths = {n: make(data / f, Path(work) / n.replace(" ", "_")) for n, (f, make) in WARM.items()}
        for first, other in WARMER:
            print(row(first, "all", other, partial(warm, paths[first], paths[other])), flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", nargs="*", choices=["geometry", "thermal", []], help="default: both")
    what = parser.parse_args().what or ["geometry", "thermal"]
    folder = os.environ.get("VCMM_DATA")
    if not folder:
        print("VCMM_DATA is not set: it names the folder that holds data/recordings", file=sys.stderr)
        return 3
    if "geometry" in what:
        geometry(Path(folder) / "data")
    if "thermal" in what:
        thermal(Path(folder) / "data")
    return 0


if __name__ == "__main__":
    sys.exit(main())
