"""Fleets of machines that wander, drawn by an own kinematics: a year of checks of each, with what happened and when.

A machine `w Y' X b Z t` would need frames; here `w b Y X Z t` (all axes carry the tool, no rotation of the frame): the tip errs by

    x:  s_X x + p_X (x/L)(x/L - 1) 4 - c y + b z        s slope (scale), p bow of the positioning error (zero at both ends)
    y:  s_Y y + p_Y ... - a z
    z:  s_Z z + p_Z ...

with c = C0Y, b = B0Z, a = A0Z (ISO 230-1: tool-side Y with C0Y = c shifts the tip by (-c y, 0, 0); Z with B0Z by (b z, 0, 0), with A0Z by (0, -a z, 0)).
Every number drifts as a random walk, faster on one machine than on another; the slopes and B0Z also go with a season of their machine; one slope wears
steadily (a screw, a scale that comes loose). A collision moves a squareness, a replaced encoder a slope; a door left open warms the frame while one
check is done: all slopes and B0Z are off that day, and back the next. Checks:
a probed grid of spheres (daily shape: 12 places, x y z), a ball bar (monthly; distances from a centre), a laser along one axis (yearly).
"""

import argparse
import json
from pathlib import Path

import numpy as np

LENGTH = 500.0  # mm, of every travel
NODES = np.linspace(0.0, LENGTH, 6)
NAMES = ("sX", "sY", "sZ", "pX", "pY", "pZ", "c", "b", "a")
# u of the machine file at its date: slopes 4 um/m, bows 1.5 um, squareness 5 urad
KNOWN = np.array([4e-6] * 3 + [1.5e-3] * 3 + [5e-6] * 3)
# random walk in a year
WALK = np.array([6e-6] * 3 + [0.5e-3] * 3 + [8e-6] * 3)
SEASON, SEASON_B = 3e-6, 3e-6  # usual amplitudes of the slopes and of B0Z over the year
WEAR = 4e-6  # of one slope in a year, usual size
DOOR, DOOR_B = 20e-6, 15e-6  # a frame 2 K warmer: slopes, B0Z
SPREAD = 0.5  # of log2 of the walks (each group) and seasons from machine to machine
PROBE, BAR, LASER = 0.8e-3, 0.4e-3, 0.2e-3  # mm, noise of one reading
COLLISION, ENCODER = 40e-6, 30e-6
DAYS = 365


def tip(theta, q):
    """Tip error (n, 3) mm at positions q (n, 3)."""
    out = np.zeros((len(q), 3))
    bow = 4.0 * (q / LENGTH) * (q / LENGTH - 1.0)
    for k in range(3):
        out[:, k] = theta[k] * q[:, k] + theta[3 + k] * bow[:, k]
    out[:, 0] += -theta[6] * q[:, 1] + theta[7] * q[:, 2]
    out[:, 1] += -theta[8] * q[:, 2]
    return out


def tabulated(theta, nodes, q):
    """The same with the bow and slope as straight lines between nodes, as an error table has them."""
    out = np.zeros((len(q), 3))
    for k in range(3):
        curve = theta[k] * nodes + theta[3 + k] * 4.0 * (nodes / LENGTH) * (nodes / LENGTH - 1.0)
        out[:, k] = np.interp(q[:, k], nodes, curve)
    out[:, 0] += -theta[6] * q[:, 1] + theta[7] * q[:, 2]
    out[:, 1] += -theta[8] * q[:, 2]
    return out


def draw_year(rng, events, start=None, every=7):
    """theta of every day (DAYS + 1, 9), and what happened: [(day, name, number)]; number -1: everything, that day alone."""
    theta = np.zeros((DAYS + 1, 9))
    theta[0] = KNOWN * rng.normal(size=9) if start is None else start
    speed = np.repeat(2.0 ** (SPREAD * rng.normal(size=3)), 3)
    steps = rng.normal(size=(DAYS, 9)) * speed * WALK / np.sqrt(365.25)
    steps[:, int(rng.integers(0, 3))] += WEAR * rng.normal() / 365.25
    told = []
    if events:
        for _ in range(2):
            day, which = int(rng.integers(40, 340)), int(rng.integers(6, 9))
            steps[day, which] += rng.choice([-1, 1]) * COLLISION
            told.append((day + 1, "collision", which))
        day, which = int(rng.integers(40, 340)), int(rng.integers(0, 3))
        steps[day, which] += rng.choice([-1, 1]) * ENCODER
        told.append((day + 1, "encoder", which))
    theta[1:] = theta[0] + np.cumsum(steps, axis=0)
    phase, size = rng.uniform(0, 2 * np.pi), 2.0 ** (SPREAD * rng.normal(size=2))
    days = np.arange(DAYS + 1)
    season = np.sin(2 * np.pi * days / 365.25 + phase) - np.sin(phase)
    theta[:, :3] += SEASON * size[0] * season[:, None]
    theta[:, 7] += SEASON_B * size[1] * season
    if events:
        day = int(rng.integers(40, 340)) // every * every  # while the machine is probed
        theta[day, :3] += DOOR
        theta[day, 7] += DOOR_B
        told.append((day, "door", -1))
    return theta, sorted(told)


def machine_text(name):
    """A machine file with zero tables and the uncertainty of its date."""
    lines = [
        'vcmm = "machine/1"', f'name = "{name}"', 'kind = "machine-tool"', 'structure = "w b Y X Z t"',
        *(f'[axes.{a}]\ntravel = ["0 mm", "{LENGTH:g} mm"]' for a in "XYZ"),
        '[errors]\ntable = "errors.csv"\nstate = "residual"',
        '[repeatability]\nlaw = "normal"', f'u = "{PROBE * 1e3:g} um"',
    ]  # fmt: skip
    for k, axis in enumerate("XYZ"):
        cov = known_curve(k)
        rows = ", ".join(f"[{', '.join(f'{v:.8g}' for v in row)}]" for row in cov)  # mm^2
        lines.append(
            f'[[inputs]]\neffect = "component_table"\ncomponent = "E{axis}{axis}"\nparameter = "values"\nlaw = "multivariate"\n'
            f"covariance = [{rows}]"
        )
    for pair in ("C0Y", "B0Z", "A0Z"):
        lines.append(
            f'[[inputs]]\neffect = "squareness"\npair = "{pair}"\nparameter = "angle"\nlaw = "normal"\nu = "{KNOWN[6] * 1e6:g} urad"'
        )
    table = "X EXX\n" + "".join(f"{q:g} 0\n" for q in NODES)
    tables = "#\n".join([table, table.replace("X EXX", "Y EYY"), table.replace("X EXX", "Z EZZ")])
    return "\n".join(lines) + "\n", tables + "#\nC0Y B0Z A0Z\n0 0 0\n"


def known_curve(k):
    """(6, 6) mm^2 of the curve of axis k at the nodes."""
    line, bow = NODES, 4.0 * (NODES / LENGTH) * (NODES / LENGTH - 1.0)
    return KNOWN[k] ** 2 * np.outer(line, line) + KNOWN[3 + k] ** 2 * np.outer(bow, bow)


def probe_places():
    """12 places of spheres in the volume."""
    return np.array([[x, y, z] for x in (50.0, 250.0, 450.0) for y in (50.0, 450.0) for z in (50.0, 400.0)])


def write_probe(folder, name, date, theta, rng, times=1):
    """Twelve spheres of a calibrated plate, x y z each, each `times` times; where it lies is free (rigid)."""
    q = np.tile(probe_places(), (times, 1))
    error = -tabulated(theta, NODES, q)  # measuring: indicated - true = -tip error
    shift, turn = rng.normal(size=3) * 0.05, rng.normal(size=3) * 20e-6
    seen = error + shift + np.cross(turn, q) + PROBE * rng.normal(size=q.shape)
    rows = ["X_mm,Y_mm,Z_mm,dx_um,dy_um,dz_um"]
    rows += [",".join(f"{v:.6f}" for v in (*a, *(b * 1e3))) for a, b in zip(q, seen)]
    _write(folder, name, date, "probe", rows, 'rigid = ""')


def write_bar(folder, name, date, theta, rng):
    """A ball bar of 150 mm about the middle in the three planes; its length is free (radius of the sphere: zero)."""
    centre, radius = np.array([250.0, 250.0, 200.0]), 150.0
    angles = np.radians(np.arange(0, 360, 15))
    rows, ways = [], []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        way = np.zeros((len(angles), 3))
        way[:, i], way[:, j] = np.cos(angles), np.sin(angles)
        ways.append(way)
    way = np.concatenate(ways)
    q = centre + radius * way
    moved = tabulated(theta, NODES, q) - tabulated(theta, NODES, centre[None])
    # actual distance less the commanded one is what the bar indicates; "actual - commanded"
    d = np.einsum("ij,ij->i", moved, way) + 0.002 * rng.normal() + BAR * rng.normal(size=len(q))
    centre_off = rng.normal(size=3) * 0.01
    d += way @ centre_off
    head = "X_mm,Y_mm,Z_mm,from_x_mm,from_y_mm,from_z_mm,d_um,u_um"
    rows = [head] + [",".join(f"{v:.6f}" for v in (*a, *centre, b * 1e3, BAR * 1e3)) for a, b in zip(q, d)]
    _write(folder, name, date, "length", rows, 'zero = ""\ncentre = ""', "actual - commanded")


def write_laser(folder, name, date, theta, rng, axis):
    """A laser along one axis at 11 positions, there and back; where it is zeroed is free."""
    q = np.tile([250.0, 250.0, 200.0], (22, 1))
    q[:, axis] = np.r_[np.linspace(0, LENGTH, 11), np.linspace(LENGTH, 0, 11)]
    way = np.eye(3)[axis]
    d = -(tabulated(theta, NODES, q) @ way) + 0.01 * rng.normal() + LASER * rng.normal(size=len(q))
    rows = ["X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,u_um"]
    rows += [",".join(f"{v:.6f}" for v in (*a, *way, b * 1e3, LASER * 1e3)) for a, b in zip(q, d)]
    _write(folder, name, date, "displacement", rows, 'zero = ""')


def _write(folder, name, date, kind, rows, nuisance, observed=""):
    (folder / f"{name}.csv").write_text("\n".join(rows) + "\n")
    more = f'observed = "{observed}"\n' if observed else ""
    (folder / f"{name}.toml").write_text(
        f'vcmm = "recording/1"\ndata = "{name}.csv"\nmachine = "../machine.toml"\nkind = "{kind}"\ndate = "{date}"\n'
        f"{more}[nuisance]\n{nuisance}\n"
    )


def date_of(day):
    return str(np.datetime64("2026-01-01") + int(day))


def write_machine(folder, seed, events=True, every=7, days=DAYS):
    """A folder machine.toml, errors.csv, checks/ and truth.json: probing every `every` days, a bar every 30, a laser on day 180."""
    rng = np.random.default_rng([seed, 33])
    folder = Path(folder)
    (folder / "checks").mkdir(parents=True, exist_ok=True)
    text, tables = machine_text(f"machine {seed}")
    (folder / "machine.toml").write_text(text)
    (folder / "errors.csv").write_text(tables)
    theta, told = draw_year(rng, events, every=every)
    for day in range(days + 1):
        date = date_of(day)
        if day % every == 0:
            write_probe(folder / "checks", f"{day:03d}_probe", date, theta[day], rng)
        if day % 30 == 15:
            write_bar(folder / "checks", f"{day:03d}_bar", date, theta[day], rng)
        if day == 180:
            write_laser(folder / "checks", f"{day:03d}_laser", date, theta[day], rng, seed % 3)
    (folder / "truth.json").write_text(json.dumps({"theta": theta.tolist(), "events": told}))
    return theta, told


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("folder", type=Path)
    words.add_argument("--machines", type=int, default=1)
    words.add_argument("--every", type=int, default=7)
    words.add_argument("--quiet", action="store_true", help="no collisions and no new encoder")
    given = words.parse_args()
    for seed in range(given.machines):
        write_machine(given.folder / f"machine_{seed:02d}", seed, not given.quiet, given.every)
