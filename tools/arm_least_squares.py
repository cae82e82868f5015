"""An arm by plain least squares: numpy and scipy alone, nothing of the package. Beside it what vcmm's file leaves of the same poses.

    python tools/arm_least_squares.py machine.toml fit.csv others.csv           # two CSV files with the usual columns of poses
    python tools/arm_least_squares.py --drawn 3                                 # three drawn six-axis arms, 40 poses and 3600 others each

Every joint is a turn about a line; line (shift and tilt), zero position, tracker and target are free, and with `elastic` joint 2 yields by the sine and
cosine of q2 and q2 + q3, joint 3 by those of q2 + q3. What poses do not tell stays where it is (steps of minimum norm).
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
LETTERS = {"A": (1.0, 0.0, 0.0), "B": (0.0, 1.0, 0.0), "C": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Poses:
    """joints (n, 6) rad, position (n, 3) mm, orientation (n, 3, 3) or None."""

    joints: Array
    position: Array
    orientation: Array | None


def turns(vectors: Array) -> Array:
    """Rotation matrices of rotation vectors (n, 3): Rodrigues."""
    angle = np.linalg.norm(vectors, axis=1)
    k = vectors / np.where(angle > 0, angle, 1.0)[:, None]
    cross = np.zeros((len(k), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -k[:, 2], k[:, 1], -k[:, 0]
    cross -= cross.transpose(0, 2, 1)
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + s * cross + (1 - c) * cross @ cross)


def lines_of(machine: Path) -> tuple[Array, Array]:
    """Points (k, 3) mm and directions (k, 3) of the joints in a machine file, in the order of its structure."""
    data = tomllib.loads(machine.read_text())
    names = data["structure"].split()[2:-1]
    points, ways = [], []
    for name in names:
        axis = data["axes"][name]
        text = axis.get("centre", "0 0 0 mm")
        text = " ".join(t.removesuffix(" mm") for t in text) + " mm" if isinstance(text, list) else text
        points.append([float(v) for v in text.removesuffix("mm").split()])
        ways.append(axis.get("direction", LETTERS[name[0]]))
    way = np.array(ways, dtype=float)
    return np.array(points), way / np.linalg.norm(way, axis=1)[:, None]


def predict(
    parameters: Array, poses: Poses, lines: tuple[Array, Array], elastic: bool
) -> tuple[Array, Array]:
    """Position and orientation that the tracker reads."""
    points, ways = lines
    k = len(points)
    shift, tilt = parameters[: 3 * k].reshape(k, 3), parameters[3 * k : 6 * k].reshape(k, 3)
    zero, place = parameters[6 * k : 7 * k], parameters[7 * k : 7 * k + 12]
    q = poses.joints + zero
    if elastic:
        e = parameters[7 * k + 12 :]
        upper, fore = q[:, 1], q[:, 1] + q[:, 2]
        yielded = np.zeros_like(q)
        yielded[:, 1] = (
            e[0] * np.cos(upper) + e[1] * np.sin(upper) + e[2] * np.cos(fore) + e[3] * np.sin(fore)
        )
        yielded[:, 2] = e[4] * np.cos(fore) + e[5] * np.sin(fore)
        q = q + yielded
    n = len(q)
    rotation, origin = np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3))
    for i in range(k):
        z = turns(tilt[i][None])[0] @ ways[i]
        p = points[i] + shift[i]
        turn = turns(q[:, i, None] * z)
        origin = origin + np.einsum("nij,nj->ni", rotation, p - turn @ p)
        rotation = rotation @ turn
    target = origin + rotation @ place[6:9]
    tracker = turns(place[None, 3:6])[0]
    return target @ tracker.T + place[:3], tracker @ rotation @ turns(place[None, 9:12])[0]


def rest(
    parameters: Array, poses: Poses, lines: tuple[Array, Array], elastic: bool, start: Poses, u: Array
) -> Array:
    """Departures over u. start: tracker and target as placed at first, whose frames the small turns are seen from."""
    assert start.orientation is not None
    position, orientation = predict(parameters, poses, lines, elastic)
    seen = (poses.position - start.position[0]) @ start.orientation[0]
    out = [(seen - position).ravel() / u[0]]
    if poses.orientation is not None:
        turned = (
            start.orientation[0].T
            @ poses.orientation
            @ start.orientation[1].T
            @ orientation.transpose(0, 2, 1)
        )
        small = 0.5 * np.stack(
            [
                turned[:, 2, 1] - turned[:, 1, 2],
                turned[:, 0, 2] - turned[:, 2, 0],
                turned[:, 1, 0] - turned[:, 0, 1],
            ],
            1,
        )
        out.append(small.ravel() / u[1])
    return np.concatenate(out)


def fit(
    poses: Poses, lines: tuple[Array, Array], elastic: bool, start: Poses, target: Array, u: Array
) -> Array:
    """Gauss-Newton with central differences, steps of minimum norm in units of 1 mm and 1 mrad."""
    k = len(lines[0])
    size = 7 * k + 12 + 6 * elastic
    scale = np.full(size, 1e-3)
    scale[: 3 * k], scale[7 * k : 7 * k + 3], scale[7 * k + 6 : 7 * k + 9] = 1.0, 1.0, 1.0
    x = np.zeros(size)
    x[7 * k + 6 : 7 * k + 9] = target
    for _ in range(12):
        r = rest(x, poses, lines, elastic, start, u)
        ends = [
            [rest(x + f * s, poses, lines, elastic, start, u) for f in (0.1, -0.1)] for s in np.diag(scale)
        ]
        slope = np.stack([(up - down) / 0.2 for up, down in ends], axis=1)
        step = np.linalg.lstsq(slope, -r, rcond=1e-6)[0]
        x = x + scale * step
        if np.abs(step).max() < 1e-7:
            break
    return x


def placed(poses: Poses, lines: tuple[Array, Array], target: Array) -> Poses:
    """Tracker (shift, turn) by the positions and turn of the target by the mean of the orientations, with the nominal arm."""
    k = len(lines[0])
    x = np.zeros(7 * k + 12)
    x[7 * k + 6 : 7 * k + 9] = target
    points, frames = predict(x, poses, lines, False)
    a, b = points - points.mean(0), poses.position - poses.position.mean(0)
    left, _, right = np.linalg.svd(b.T @ a)
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    on_tool = np.eye(3)
    if poses.orientation is not None:
        left, _, right = np.linalg.svd(
            np.mean(frames.transpose(0, 2, 1) @ turn.T @ poses.orientation, axis=0)
        )
        on_tool = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    shift = poses.position.mean(0) - turn @ points.mean(0)
    return Poses(poses.joints[:1], shift[None], np.stack([turn, on_tool]))


def rms_left(x: Array, poses: Poses, lines: tuple[Array, Array], elastic: bool, start: Poses) -> float:
    """um per coordinate of position."""
    r = rest(x, Poses(poses.joints, poses.position, None), lines, elastic, start, np.ones(2))
    return float(np.sqrt(np.mean(r**2))) * 1e3


def read(path: Path, names: list[str]) -> Poses:
    """CSV with NAME_deg, x_mm y_mm z_mm, and r11 ... r33 where orientations were read."""
    with path.open() as file:
        rows = list(csv.DictReader(file))
    get = lambda columns: np.array([[float(r[c]) for c in columns] for r in rows])  # noqa: E731
    matrix = [f"r{i}{j}" for i in "123" for j in "123"]
    turned = get(matrix).reshape(-1, 3, 3) if matrix[0] in rows[0] else None
    return Poses(np.radians(get([f"{n}_deg" for n in names])), get(["x_mm", "y_mm", "z_mm"]), turned)


def compare(machine: Path, first: Path, others: Path) -> list[str]:
    """Cells of one arm: geometry alone, with elastic joints, and the file of the command, each on its poses and on the others."""
    names = tomllib.loads(machine.read_text())["structure"].split()[2:-1]
    lines, here, there = lines_of(machine), read(first, names), read(others, names)
    cells = [first.parent.name]
    with tempfile.TemporaryDirectory() as work:
        found = by_command(machine, first, others, Path(work))
    target = np.array(found["placements"][0]["target_mm"])
    start = placed(here, lines, target)
    u = np.array([found["u_um"] * 1e-3, max((found["turn_after_urad"] or 100.0) * 1e-6, 1e-9)])
    for elastic in (False, True):
        x = fit(here, lines, elastic, start, target, u)
        cells += [f"{rms_left(x, p, lines, elastic, start):.1f}" for p in (here, there)]
    test = found["tests"][0]
    further = sorted(
        {f"{t['effect']} {t['where']}" for t in found["terms"] if t["effect"] != "rotary_location"}
    )
    return [
        *cells,
        f"{found['rms_after_um']:.1f}",
        f"{test['rms_held_um'] or float('nan'):.1f}",
        f"{test['rms_after_um']:.1f}",
        "; ".join(further),
    ]


def by_command(machine: Path, first: Path, others: Path, work: Path) -> dict:
    """The document of vcmm calibrate."""
    files = []
    for path in (first, others):
        file = work / f"{path.stem}.toml"
        file.write_text(
            f'vcmm = "recording/1"\nmachine = "{machine.resolve()}"\nkind = "pose"\ndata = "{path.resolve()}"\n'
        )
        files.append(str(file))
    code = "from vcmm.face.cli import main; main()"
    words = [
        "calibrate",
        files[0],
        "--machine",
        str(machine),
        "--out",
        str(work / "found.toml"),
        "--test",
        files[1],
        "--json",
    ]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


ARM = """vcmm = "machine/1"
name = "drawn arm"
kind = "machine-tool"
structure = "w b C1 B2 B3 A4 B5 A6 t"
[axes.C1]
travel = ["-180 deg", "180 deg"]
[axes.B2]
travel = ["-120 deg", "120 deg"]
centre = "150 0 450 mm"
[axes.B3]
travel = ["-120 deg", "120 deg"]
centre = "150 0 1050 mm"
[axes.A4]
travel = ["-180 deg", "180 deg"]
centre = "300 0 1200 mm"
[axes.B5]
travel = ["-120 deg", "120 deg"]
centre = "800 0 1200 mm"
[axes.A6]
travel = ["-180 deg", "180 deg"]
centre = "850 0 1200 mm"
"""
LOW, HIGH = np.radians([-150, -60, -60, -150, -100, -170]), np.radians([150, 80, 90, 150, 100, 170])


def drawn_parameters(rng: np.random.Generator) -> Array:
    """Lines off by 0.3 mm and 0.6 mrad, zeros by 1 mrad, a tracker 2.6 m away, a target 120 mm out, joints that yield by 0.25 to 0.4 mrad."""
    lines = np.concatenate([rng.normal(0, 0.3, 18), rng.normal(0, 6e-4, 18), rng.normal(0, 1e-3, 6)])
    place = [2500.0, -800.0, 300.0, 0.5, -1.7, 0.9, 970.0, 30.0, 1160.0, 0.3, 0.6, -0.15]
    return np.concatenate([lines, place, [0.0, 4e-4, 2.5e-4, 0.0, 3e-4, 0.0]])


def draw(
    x: Array,
    lines: tuple[Array, Array],
    n: int,
    rng: np.random.Generator,
    u: tuple[float, float] = (0.02, 5e-5),
) -> Poses:
    """n poses of an arm with noise u (mm, rad) of a coordinate."""
    q = rng.uniform(LOW, HIGH, (n, 6))
    position, orientation = predict(x, Poses(q, np.zeros((n, 3)), None), lines, True)
    return Poses(q, position + rng.normal(0, u[0], (n, 3)), turns(rng.normal(0, u[1], (n, 3))) @ orientation)


def write(path: Path, poses: Poses, names: list[str]) -> None:
    """A CSV with the usual columns."""
    head = [f"{n}_deg" for n in names] + ["x_mm", "y_mm", "z_mm"]
    table = [np.degrees(poses.joints), poses.position]
    if poses.orientation is not None:
        head += [f"r{i}{j}" for i in "123" for j in "123"]
        table.append(poses.orientation.reshape(-1, 9))
    rows = [",".join(f"{v:.12g}" for v in row) for row in np.concatenate(table, axis=1)]
    path.write_text("\n".join([",".join(head), *rows]) + "\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--drawn", type=int, default=0)
    args = parser.parse_args()
    print(
        "| arm | geometry | others | with elastic joints | others | vcmm | others, tracker held | others | beside the geometry |"
    )
    print("|" + "---|" * 9)
    if args.files:
        print("| " + " | ".join(compare(*args.files)) + " |")
    for seed in range(args.drawn):
        with tempfile.TemporaryDirectory() as work:
            folder = Path(work) / f"drawn {seed}"
            folder.mkdir()
            (folder / "arm.toml").write_text(ARM)
            lines, rng = lines_of(folder / "arm.toml"), np.random.default_rng(seed)
            x = drawn_parameters(rng)
            for name, n in (("fit", 40), ("others", 3600)):
                write(folder / f"{name}.csv", draw(x, lines, n, rng), ["C1", "B2", "B3", "A4", "B5", "A6"])
            print(
                "| "
                + " | ".join(compare(folder / "arm.toml", folder / "fit.csv", folder / "others.csv"))
                + " |",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
