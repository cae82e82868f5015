"""Published recordings to recording/1 files in a folder: one small function per data set, nothing added, nothing fitted.

Every function takes the published files and a folder, writes machine.toml, recording.toml and a CSV, and returns the
recording file. The machines state what was known before: axes, travels, a scatter from the resolution. No errors.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path


def write(
    folder: Path, machine: str, recording: str, header: Sequence[str], rows: Iterable[Sequence[object]]
) -> Path:
    """Write the three files; returns the path of recording.toml."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "machine.toml").write_text(machine)
    with (folder / "data.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)
    path = folder / "recording.toml"
    head = 'vcmm = "recording/1"\n' + ("" if "\ndata =" in recording else 'data = "data.csv"\n')
    path.write_text(head + 'machine = "machine.toml"\n' + recording)
    return path


def machine(structure: str, travels: dict[str, tuple[str, str]], u: str) -> str:
    """A machine without errors, normal scatter with standard uncertainty u."""
    axes = "".join(f'[axes.{a}]\ntravel = ["{low}", "{high}"]\n' for a, (low, high) in travels.items())
    head = f'vcmm = "machine/1"\nstructure = "{structure}"\n'
    return f'{head}{axes}[repeatability]\nlaw = "normal"\nu = "{u}"\n'


def plug_plate(source: Path, folder: Path, every: int = 1) -> Path:
    """Holes drilled by one machine, centres measured by another: measured - nominal x, y as the part that a tool left.

    Four lines of header; Meas X, Meas Y, Nom X, Nom Y ... in mm. The alignment is free: nuisance rigid.
    every: keep every n-th hole.
    """
    table = [line.split() for line in source.read_text().splitlines()[4:]]
    numbers = [[float(v) for v in row[:4]] for row in table if len(row) >= 4]
    kept = numbers[::every]
    rows = [(nx, ny, 0, f"{(mx - nx) * 1e3:.1f}", f"{(my - ny) * 1e3:.1f}") for mx, my, nx, ny in kept]
    travels = {"X": ("-400 mm", "400 mm"), "Y": ("-400 mm", "400 mm"), "Z": ("-50 mm", "50 mm")}
    recording = 'kind = "path"\nhistory = "none"\n[nuisance]\nrigid = ""\n'
    header = ("X_mm", "Y_mm", "Z_mm", "dx_um", "dy_um")
    return write(folder, machine("w X' Y' b Z t", travels, "4 um"), recording, header, rows)


def remeasured_plate(first: Path, second: Path, folder: Path) -> Path:
    """The same holes measured twice on a CMM: second - first session, at the nominal places."""
    one, two = ([line.split() for line in p.read_text().splitlines()[4:]] for p in (first, second))
    places = {(row[2], row[3]): row for row in one if len(row) >= 4}
    rows = []
    for row in two:
        if len(row) >= 4 and (row[2], row[3]) in places:
            before = places[row[2], row[3]]
            shift = [f"{(float(row[i]) - float(before[i])) * 1e3:.1f}" for i in (0, 1)]
            rows.append((row[2], row[3], 0, *shift))
    travels = {"X": ("-400 mm", "400 mm"), "Y": ("-400 mm", "400 mm"), "Z": ("-50 mm", "50 mm")}
    recording = 'kind = "probe"\nhistory = "none"\n[nuisance]\nrigid = ""\n'
    header = ("X_mm", "Y_mm", "Z_mm", "dx_um", "dy_um")
    return write(folder, machine("w b Y X Z t", travels, "3 um"), recording, header, rows)


def positioning_runs(source: Path, folder: Path, u: str = "1 um", skip_first: bool = False) -> Path:
    """An ISO 230-2 file of an ecmc test script, read as it is. skip_first: without the first forward approaches."""
    text = source.read_text()
    if skip_first:
        text = "\n".join(line for line in text.splitlines() if not _first_forward(line)) + "\n"
    recording = 'data = "runs.dat"\nformat = "iso230"\nkind = "displacement"\n[line]\naxis = "X"\n[nuisance]\nzero = ""\n'
    path = write(folder, machine("w b X t", {"X": ("0 mm", "100 mm")}, u), "\n" + recording, ("unused",), [])
    (folder / "runs.dat").write_text(text)
    return path


def _first_forward(line: str) -> bool:
    return line.startswith("REF_DATA_FWD[") and line.split("]")[0].endswith(",1")


def slit_axis(source: Path, folder: Path, column: str = "resolver_mm", u: str = "0.1 um") -> Path:
    """Runs of a slit axis: tests of accuracy and repeatability, one actual position (`column`) per approach."""
    with source.open() as file:
        table = [
            row
            for row in csv.DictReader(file)
            if row["test"] in ("accuracy", "repeatability") and row[column]
        ]
    rows = [(r["target_mm"], f"{r['test']} {r['run']}", r["approach"], r[column]) for r in table]
    recording = 'format = "iso230"\nkind = "displacement"\nhistory = "none"\n[line]\naxis = "X"\n[nuisance]\nzero = ""\n'
    travels = {"X": ("0 mm", "100 mm")}
    header = ("target_mm", "run", "direction", "actual_mm")
    return write(folder, machine("w b X t", travels, u), recording, header, rows)


def resolver(source: Path, folder: Path, u: str = "0.05 deg", every: int = 1) -> Path:
    """Step counter (commanded) against resolver (actual) of a rotary axis: a trace with a FILETIME clock.

    every: keep only every n-th row of numbers (the trace is sampled at 10 ms).
    """
    lines = source.read_text(errors="replace").splitlines()
    head = next(i for i, line in enumerate(lines) if line[:15].isdigit())
    kept = lines[head::every]
    text = "\n".join(["Name;counter;speed;resolver", *(line for line in kept if line.count(";") == 3)]) + "\n"
    recording = (
        'data = "trace.csv"\nformat = "scope"\nkind = "angle"\nobserved = "actual - commanded"\n'
        '[scope]\ntime = "Name"\ntime_unit = "filetime"\nunit = "deg"\naxes = { C = ["counter", "resolver"] }\n'
        f'[nuisance]\nzero = ""\n[noise]\nu = "{u}"\n'
    )
    known = machine("w b C t", {"C": ("-10 deg", "370 deg")}, "1 um")
    path = write(folder, known, "\n" + recording, ("unused",), [])
    (folder / "trace.csv").write_text(text)
    return path


def gantry_heating(
    source: Path,
    folder: Path,
    step: float = 0.0025,
    every: int = 1,
    sensors: Sequence[str] = ("frame", "bed"),
    heating: bool = False,
) -> Path:
    """Homing of a Z axis onto a switch while bed and frame heat: mcu_pos_z x step mm, with the logged temperatures.

    The switch stands still; where the axis finds it is what is indicated. Rows more than 1 mm from the middle are
    no homings. every: keep every n-th row; sensors: the temperatures that are given; heating: only while the bed is
    switched on.
    """
    lines = [line for line in source.read_text().splitlines() if not line.startswith("#")]
    table = list(csv.DictReader(lines))
    times = [datetime.strptime(r["time"], "%Y/%m/%d-%H:%M:%S").timestamp() for r in table]
    heights = [int(r["mcu_pos_z"]) * step for r in table]
    middle = sorted(heights)[len(heights) // 2]
    rows = [
        (0, 0, 0, 0, 0, 1, f"{(z - middle) * 1e3:.1f}", t - times[0], *(r[f"{s}_t"] for s in sensors))
        for r, t, z in zip(table, times, heights)
        if abs(z - middle) < 1.0 and (not heating or float(r["bed_target"]) > 0)
    ][::every]
    header = ["X_mm", "Y_mm", "Z_mm", "nx", "ny", "nz", "d_um", "time_s"]
    header += [f"temp_{s}_C" for s in sensors]
    travels = {"X": ("-1 mm", "350 mm"), "Y": ("-1 mm", "350 mm"), "Z": ("-1 mm", "340 mm")}
    recording = 'kind = "displacement"\nhistory = "none"\n[nuisance]\nzero = ""\n'
    return write(folder, machine("w Y' b Z X t", travels, "2 um"), recording, header, rows)


def telescope_mount(
    source: Path,
    folder: Path,
    nuisance: str = 'index = ""\noffset = ""\n',
    u: str = "10 arcsec",
    of_date: bool = True,
) -> Path:
    """Stars sighted through a mount of two rotary axes: encoder readings against the true direction, machine frame x to
    the meridian on the equator, z to the pole. C = - hour angle, B = - declination read; the tube lies along x.

    Five lines of header; of the fifth the latitude, temperature and pressure. The air lifts a star by
    1.02' cot(h + 10.3 / (h + 5.11)) P / 1010 283 / (273 + T) (Saemundsson, Sky and Telescope 72 (1986) 70). The file does
    not state the equinox of its places. of_date: they are taken as they stand, else as J2000 and precessed to the year
    (Lieske et al., Astronomy and Astrophysics 58 (1977) 1).
    """
    lines = source.read_text().splitlines()
    head = [float(w) for w in lines[4].split()]
    latitude, air = math.radians(head[0] + head[1] / 60 + head[2] / 3600), (head[6], head[7])
    rows = []
    for words in (line.split() for line in lines[5:]):
        if len(words) < 14:
            continue
        ra, dec, read, tilt = (_sexagesimal(words[i : i + 3]) for i in (0, 3, 6, 9))
        sidereal = 15 * (float(words[12]) + float(words[13]) / 60)
        ra, dec = (15 * ra, dec) if of_date else _precessed(15 * ra, dec, head[3] + (head[4] - 0.5) / 12)
        star = _lifted(_direction(sidereal - ra, dec), latitude, *air)
        c = (180.0 - sidereal + 15 * read) % 360 - 180
        rows.append((f"{c:.7f}", f"{-tilt:.7f}", 1000, 0, 0, *(f"{v:.10f}" for v in star)))
    down = f"{-math.cos(latitude):.8f}, 0, {-math.sin(latitude):.8f}"
    recording = (
        f'kind = "angle"\nobserved = "actual - commanded"\nhistory = "none"\ndown = [{down}]\n'
        f'[nuisance]\n{nuisance}[noise]\nu = "{u}"\n'
    )
    header = (
        "C_deg",
        "B_deg",
        "offset_x_mm",
        "offset_y_mm",
        "offset_z_mm",
        "pointed_x",
        "pointed_y",
        "pointed_z",
    )
    travels = {"C": ("-270 deg", "270 deg"), "B": ("-270 deg", "270 deg")}
    known = machine("w b C B t", travels, "1 um")
    return write(folder, known, recording, header, rows)


def _precessed(ra: float, dec: float, year: float) -> tuple[float, float]:
    """A place of J2000 in degrees, at the mean equinox of the year."""
    t = (year - 2000.0) / 100.0
    arc = [
        (2306.2181 * t + 0.30188 * t**2) / 3600,
        (2306.2181 * t + 1.09468 * t**2) / 3600,
        (2004.3109 * t - 0.42665 * t**2) / 3600,
    ]
    first, second, tilt = (math.radians(v) for v in arc)
    a, d = math.radians(ra) + first, math.radians(dec)
    x = math.cos(tilt) * math.cos(d) * math.cos(a) - math.sin(tilt) * math.sin(d)
    y = math.cos(d) * math.sin(a)
    z = math.sin(tilt) * math.cos(d) * math.cos(a) + math.cos(tilt) * math.sin(d)
    return math.degrees(math.atan2(y, x) + second), math.degrees(math.asin(z))


def _sexagesimal(words: Sequence[str]) -> float:
    size = abs(float(words[0])) + float(words[1]) / 60 + float(words[2]) / 3600
    return -size if words[0].startswith("-") else size


def _direction(hour_angle: float, declination: float) -> tuple[float, float, float]:
    h, d = math.radians(hour_angle), math.radians(declination)
    return math.cos(d) * math.cos(h), -math.cos(d) * math.sin(h), math.sin(d)


def _lifted(
    p: tuple[float, float, float], latitude: float, celsius: float, hectopascal: float
) -> tuple[float, ...]:
    """A direction raised by the refraction of the air."""
    zenith = (math.cos(latitude), 0.0, math.sin(latitude))
    sine = sum(a * b for a, b in zip(p, zenith))
    height = math.degrees(math.asin(sine))
    lift = 1.02 / 60 / math.tan(math.radians(height + 10.3 / (height + 5.11)))
    lift = math.radians(lift * hectopascal / 1010 * 283 / (273 + celsius))
    across = [(z - sine * a) / math.sqrt(1 - sine**2) for a, z in zip(p, zenith)]
    return tuple(math.cos(lift) * a + math.sin(lift) * b for a, b in zip(p, across))


def switched_off(source: Path) -> float:
    """Seconds from the first row of a heating run to the last one with the bed switched on."""
    lines = [line for line in source.read_text().splitlines() if not line.startswith("#")]
    table = list(csv.DictReader(lines))
    times = [datetime.strptime(r["time"], "%Y/%m/%d-%H:%M:%S").timestamp() for r in table]
    return max(t for t, r in zip(times, table) if float(r["bed_target"]) > 0) - times[0]


def petals(
    source: Path, nominal: Path, folder: Path, which: Sequence[int] = (2, 3, 4, 5, 6, 7), every: int = 1
) -> Path:
    """Hole axes of nominally equal parts from one CMM: measured - nominal, placement free for every part.

    pose and part name the petal: a field of the machine is common to all, what a part has of its own is not.
    """
    with nominal.open() as file:
        due = {r["device_location_id"]: [float(r[c]) for c in "XYZ"] for r in csv.DictReader(file)}
    with source.open() as file:
        table = [r for r in csv.DictReader(file) if int(r["PETAL_ID"]) in which and r["DEVICE_LOC"] in due]
    table.sort(key=lambda r: (int(r["PETAL_ID"]), int(r["DEVICE_LOC"])))
    rows = []
    for r in table:
        if int(r["DEVICE_LOC"]) % every:
            continue
        place = due[r["DEVICE_LOC"]]
        gap = [f"{(float(r[f'{c}_PTL']) - at) * 1e3:.2f}" for c, at in zip("XYZ", place)]
        rows.append((*place, *gap, f"petal {r['PETAL_ID']}", f"petal {r['PETAL_ID']}"))
    travels = {"X": ("-10 mm", "450 mm"), "Y": ("-150 mm", "250 mm"), "Z": ("-100 mm", "50 mm")}
    recording = 'kind = "path"\nhistory = "none"\n[nuisance]\nrigid = "pose"\n'
    header = ("X_mm", "Y_mm", "Z_mm", "dx_um", "dy_um", "dz_um", "pose", "part")
    return write(folder, machine("w X' Y' b Z t", travels, "3 um"), recording, header, rows)
