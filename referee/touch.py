"""Five-axis machines drawn, touched and read by an R-test with kinematics of its own; what vcmm calibrate finds is counted.

The machine is "w C' A' b Y X Z t": a table C on a trunnion A, the linear axes carry the spindle. A place s of the table stands in the machine at

    P = L_A Rx(-a + EAA(a)) L_C Rz(-c + ECC(c)) s       L: shift X0 Y0 Z0 and turn A0 B0 C0 about the centre

(ISO 230-1 names; a table turns against the commanded sense, ISO 841). The probe goes along a straight line until its ball meets the sphere,
then its pre-travel further; the control takes the ball off along that line and prints one line.

    python -m referee.touch --machines 100 --seed 1 --out touch.jsonl     goes on where it stopped
    python -m referee.touch --table touch.jsonl                           the count as Markdown
"""

import argparse
import json
import math
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from referee.kinematics import turn

Array = NDArray[np.float64]
LOCATIONS = ("Y0A", "Z0A", "B0A", "C0A", "X0C", "Y0C", "A0C", "B0C")
SPHERES = ((150.0, 0.0, 80.0), (-80.0, 120.0, 140.0), (-60.0, -130.0, 60.0))
RADIUS, BALL = 12.5, 3.0  # mm: spheres, ball of the stylus
TILTS, TURNS = (-60.0, -30.0, 0.0, 30.0, 60.0), tuple(range(0, 360, 45))  # deg
WAYS = ((-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1))
LENGTH, ZERO = -150.0, (0.0, 0.0, 250.0)  # mm: stylus below the spindle, work offset of the tip
SCATTER, READING = 0.5e-3, 0.2e-3  # mm: of a touch, of an R-test
HELD, STANDOFF = 1.959964, 10.0


@dataclass
class Five:
    """Errors of one machine, mm and rad; angle: by axis (offsets, amplitudes, phases) of harmonics 1 to 3, EAA about its mean."""

    place: dict = field(default_factory=dict)
    angle: dict = field(default_factory=dict)
    probe: dict = field(default_factory=dict)

    def angular(self, axis: str, q: Array) -> Array:
        """EAA or ECC at q rad."""
        waves = self.angle.get(axis, ())
        value = sum((a * np.sin(k * q + p) for k, a, p in waves), np.zeros_like(q))
        if axis == "A" and waves:
            grid = np.radians(np.linspace(TILTS[0], TILTS[-1], 2001))
            value = value - np.mean([sum(a * np.sin(k * g + p) for k, a, p in waves) for g in grid])
        return value


def draw(rng: np.random.Generator) -> Five:
    """Location errors of 20 um and 40 urad, angular position errors of 10 urad, a probe with offset, lobes and pre-travel."""
    place = {n: rng.normal() * (0.02 if n[0] in "XYZ" else 40e-6) for n in LOCATIONS}
    angle = {
        axis: [(k, rng.normal() * 10e-6 / k, rng.uniform(0, 2 * math.pi)) for k in (1, 2, 3)] for axis in "AC"
    }
    probe = {
        "offset": rng.normal(size=3) * 1e-3,
        "lobes": rng.normal(size=4) * 0.3e-3,
        "axial": rng.normal() * 0.5e-3,
        "mean": 4e-3 + rng.normal() * 1e-3,
    }
    return Five(place, angle, probe)


def located(machine: Five, axis: str) -> tuple[Array, Array]:
    """Turn matrix and shift of the centre line."""
    shift = np.array([machine.place.get(f"{c}0{axis}", 0.0) for c in "XYZ"])
    tilt = np.array([machine.place.get(f"{c}0{axis}", 0.0) for c in "ABC"])
    return turn(tilt), shift


def on_table(machine: Five, a: float, c: float) -> tuple[Array, Array]:
    """Turn R (3, 3) and shift t (3,): a place s of the table stands at R s + t in the machine."""
    ra, ta = located(machine, "A")
    rc, tc = located(machine, "C")
    about_a = turn(np.array([-a + float(machine.angular("A", np.array([a]))[0]), 0.0, 0.0]))
    about_c = turn(np.array([0.0, 0.0, -c + float(machine.angular("C", np.array([c]))[0])]))
    return ra @ about_a @ rc @ about_c, ra @ about_a @ tc + ta


def pre_travel(machine: Five, normal: Array) -> float:
    """How far the probe goes on after it met the surface, by the outward normal in the frame of the probe."""
    if not machine.probe:
        return 0.0
    lateral, angle = math.hypot(normal[0], normal[1]), math.atan2(normal[1], normal[0])
    waves = [math.cos(2 * angle), math.sin(2 * angle), math.cos(3 * angle), math.sin(3 * angle)]
    lobes = lateral * float(np.dot(waves, machine.probe["lobes"]))
    return float(machine.probe["mean"] + lobes + machine.probe["axial"] * normal[2] ** 2)


def touch(machine: Five, sphere: Array, start: Array, way: Array) -> Array:
    """Where the tip is believed to be when the probe has triggered, (3,) mm. Its ball goes from start along way."""
    offset = machine.probe["offset"] if machine.probe else np.zeros(3)
    between = start + offset - sphere
    along = float(between @ way)
    root = along**2 - float(between @ between) + (RADIUS + BALL) ** 2
    met = -along - math.sqrt(root)
    normal = (between + met * way) / (RADIUS + BALL)
    return start + (met + pre_travel(machine, normal) / float(-normal @ way)) * way


def touches(machine: Five, rng: np.random.Generator) -> list[str]:
    """The log of the control: every sphere from five sides at every rotary position, unless its stem is there."""
    lines, nominal = [], Five()
    standing = [np.array(s) + rng.normal(size=3) * 0.1 for s in SPHERES]
    for a_deg in TILTS:
        for c_deg in TURNS:
            a, c = math.radians(a_deg), math.radians(c_deg)
            meant, (really, shift) = on_table(nominal, a, c)[0], on_table(machine, a, c)
            for number, (where, stands) in enumerate(zip(SPHERES, standing), 1):
                for way in np.array(WAYS, float):
                    if (meant.T @ -way)[2] < -0.5:
                        continue
                    start = meant @ np.array(where) - way * (RADIUS + BALL + STANDOFF)
                    tip = touch(machine, really @ stands + shift, start, way)
                    tip = tip + way * rng.normal() * SCATTER
                    x, y, z = tip + way * BALL - np.array(ZERO)
                    i, j, k = way
                    lines.append(
                        f"TOUCH F{number} I{i:g} J{j:g} K{k:g} X{x:.5f} Y{y:.5f} Z{z:.5f} A{a_deg:g} C{c_deg:g}"
                    )
    return lines


def r_test(machine: Five, rng: np.random.Generator, place: Array) -> list[str]:
    """Rows of an R-test: where the ball in the spindle is seen from the table, less where it should be, as indicated - true."""
    rows = ["X_mm,Y_mm,Z_mm,A_deg,C_deg,offset_x_mm,offset_y_mm,offset_z_mm,dx_um,dy_um,dz_um"]
    nominal = Five()
    for a_deg in TILTS:
        for c_deg in TURNS:
            a, c = math.radians(a_deg), math.radians(c_deg)
            tip = on_table(nominal, a, c)[0] @ place
            really, shift = on_table(machine, a, c)
            seen = -(really.T @ (tip - shift) - place) + rng.normal(size=3) * READING
            at = tip - np.array([0.0, 0.0, LENGTH])
            words = [*at, a_deg, c_deg, 0.0, 0.0, LENGTH, *(seen * 1e3)]
            rows.append(",".join(f"{w:.7f}" for w in words))
    return rows


MACHINE = """vcmm = "machine/1"
name = "drawn"
kind = "machine-tool"
structure = "w C' A' b Y X Z t"
[axes.X]
travel = ["-500 mm", "500 mm"]
[axes.Y]
travel = ["-500 mm", "500 mm"]
[axes.Z]
travel = ["-300 mm", "800 mm"]
[axes.A]
travel = ["-110 deg", "110 deg"]
[axes.C]
travel = ["0 deg", "360 deg"]
"""


def write(folder: Path, machine: Five, rng: np.random.Generator) -> tuple[list[str], list[str]]:
    """Machine file, log with its recording, three R-tests; names of the recordings of either."""
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "touch.log").write_text("\n".join(touches(machine, rng)) + "\n")
    spheres = "".join(
        f'[touch.features.{k}]\npoint = "{x:g} {y:g} {z:g} mm"\ndiameter = "{2 * RADIUS} mm"\n'
        for k, (x, y, z) in enumerate(SPHERES, 1)
    )
    (folder / "touch.toml").write_text(
        'vcmm = "recording/1"\nname = "touch"\ndata = "touch.log"\nformat = "touches"\nmachine = "machine.toml"\nkind = "probe"\n'
        f'[noise]\nu = "{SCATTER * 1e3} um"\n[instrument]\nname = "touch probe"\n'
        'u = { offset = "1 um", lobing = "0.3 um", axial = "0.5 um" }\n'
        f'[touch]\ntip_diameter = "{2 * BALL} mm"\noffset = "0 0 {LENGTH:g} mm"\nzero = "{ZERO[0]:g} {ZERO[1]:g} {ZERO[2]:g} mm"\n{spheres}'
    )
    names = []
    for k, place in enumerate(SPHERES, 1):
        (folder / f"r{k}.csv").write_text("\n".join(r_test(machine, rng, np.array(place))) + "\n")
        (folder / f"r{k}.toml").write_text(
            f'vcmm = "recording/1"\nname = "r{k}"\ndata = "r{k}.csv"\nmachine = "machine.toml"\nkind = "displacement"\n'
            f'[nuisance]\nrigid = ""\n[noise]\nu = "{READING * 1e3} um"\n[instrument]\nname = "R-test"\n'
        )
        names.append(f"r{k}.toml")
    return ["touch.toml"], names


def ask(folder: Path, names: list[str], errors: str) -> dict:
    """What vcmm calibrate writes: name, for a curve with its position, -> (value, u), mm and rad."""
    out = folder / f"found_{Path(names[0]).stem}.toml"
    words = [command(), "calibrate", "fit", *names, "--machine", "machine.toml", "--json", "--out", out.name]
    words += ["--errors", errors] if errors else []
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(words)}\n{done.stderr}")
    values = stated_errors((folder / f"{out.stem}_errors.csv").read_text())
    found = {}
    for k, line in enumerate((folder / f"{out.stem}_covariance.csv").read_text().splitlines()[1:]):
        cells = line.split(",")
        name, at = cells[0], cells[1]
        value = values[name][float(at)] if at else values[name]
        found[f"{name}@{at}" if at else name] = (value, math.sqrt(max(float(cells[2 + k]), 0.0)))
    return found


def command() -> str:
    """The command line that is judged."""
    found = shutil.which("vcmm") or str(Path(sys.executable).parent / "vcmm")
    if not Path(found).exists():
        raise SystemExit("there is no command vcmm; install the package first")
    return found


def stated_errors(text: str) -> dict:
    """An error table: name -> value, or of a curve -> position -> value."""
    found: dict = {}
    for block in text.split("#"):
        rows = [r.split() for r in block.strip().splitlines() if r.strip() and not r.startswith("//")]
        if rows and rows[0][0] in "ABCXYZ":
            for name, column in zip(rows[0][1:], range(1, len(rows[0]))):
                found[name] = {float(r[0]): float(r[column]) for r in rows[1:]}
        elif rows:
            found |= {name: float(value) for name, value in zip(rows[0], rows[1])}
    return found


def one(seed: int, number: int) -> dict:
    """Pulls (found - true) / u of every number, and u of the locations in um and urad, by touches and by R-tests."""
    rng = np.random.default_rng([seed, number])
    machine = draw(rng)
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        touched, tested = write(folder, machine, rng)
        errors = " ".join(("EAA", "ECC", *LOCATIONS))
        found = {"touches": ask(folder, touched, ""), "R-test": ask(folder, tested, errors)}
    result: dict = {"number": number, "seed": seed}
    for way, numbers in found.items():
        result[way] = {
            name: [
                (value - truth(machine, name)) / u,
                u * scale(name),
                (value - truth(machine, name)) * scale(name),
            ]
            for name, (value, u) in numbers.items()
            if u > 0
        }
    return result


def truth(machine: Five, name: str) -> float:
    """Of a location error, or of an angular position error at "EAA@position"."""
    if "@" in name:
        axis, at = name[1], float(name.split("@")[1])
        return float(machine.angular(axis, np.array([at]))[0])
    return machine.place[name]


def table(lines: list[dict]) -> str:
    """Markdown: per parameter and way how often the 95 % interval holds the truth, rms error and rms u."""
    rows = [
        "| parameter | touches: held | rms error | rms u | R-test: held | rms error | rms u |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in (*LOCATIONS, "EAA", "ECC"):
        cells = []
        for way in ("touches", "R-test"):
            mine = [v for line in lines for n, v in line[way].items() if n.split("@")[0] == name]
            pull, u, error = np.array(mine).T
            unit = "um" if name[0] in "XYZ" else "urad"
            held = int((np.abs(pull) <= HELD).sum())
            cells += [
                f"{held} of {len(pull)}",
                f"{math.sqrt((error**2).mean()):.3g} {unit}",
                f"{math.sqrt((u**2).mean()):.3g} {unit}",
            ]
        rows.append(f"| {name} | {' | '.join(cells)} |")
    for way in ("touches", "R-test"):
        pulls = np.array([v[0] for line in lines for n, v in line[way].items() if "@" not in n])
        rows.append("")
        rows.append(
            f"{way}: locations {int((np.abs(pulls) <= HELD).sum())} of {len(pulls)}, {(np.abs(pulls) <= HELD).mean():.3f}, in {len(lines)} machines"
        )
    return "\n".join(rows)


def main(words: list[str] | None = None) -> int:
    """The command line of this file."""
    parser = argparse.ArgumentParser(prog="referee.touch", description=__doc__)
    parser.add_argument("--machines", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("touch.jsonl"))
    parser.add_argument("--table", type=Path)
    chosen = parser.parse_args(words)
    if chosen.table is not None:
        print(table([json.loads(line) for line in chosen.table.read_text().splitlines()]))
        return 0
    done = set()
    if chosen.out.exists():
        done = {json.loads(line)["number"] for line in chosen.out.read_text().splitlines()}
    for number in range(chosen.machines):
        if number not in done:
            result = json.dumps(one(chosen.seed, number))
            with chosen.out.open("a") as file:
                file.write(result + "\n")
    return 0


def scale(name: str) -> float:
    """um or urad of mm or rad."""
    return 1e3 if name[0] in "XYZ" else 1e6


if __name__ == "__main__":
    raise SystemExit(main())
