"""``python -m referee.loops``: effects concealed in a cut part, counted through ``vcmm loop``.

A part is cut by `referee.cutter` on the machine of `vcmm new measured_block` with one effect (or none) added, measured with noise
per point, per move or per pass, and handed to ``vcmm loop`` as points. Counted: the first name, what is said where there is no name,
names where nothing was concealed, and the part that the written program makes, cut by the same cutter on the same machine.

delta is the Mahalanobis length of the effect at the measured points, with everything in the covariance that differs from part to part:
offset of the work, radius and length of the tools, squareness, scale, noise of points, and scatter. Nobody tells the loop whether that is drawn per
pass or per move, so the smaller of both lengths counts. Where the part lay when it was measured is free: points are given in the drawing frame.
"""

import argparse
import csv
import json
import math
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from referee.__main__ import commit
from referee.concealed import NAMED, TEETH, UNNAMED, Shape
from referee.count import bounds
from referee.cutter import Cutter, Error, Moment, read_program
from referee.forces import Blank, forces

Array = NDArray[np.float64]
RADIUS = {1: 8.0, 2: 6.0}
BLANK = Blank(157.0, 117.0, 30.0)
SQUARENESS, SCALE = 20e-6, 20e-6  # what the machine file says of C0Y and of X
U_SQUARENESS, U_SCALE, U_SETTING, U_PASS, U_POINT = 3e-6, 4e-6, 0.002, 0.0005, 0.0003
FREE = 1.0  # mm: of the place of the part, and as much of its turns at 100 mm
GAIN, FORWARD = 33.0, 0.98


NULLS = ("pass", "move", "less")  # scatter as stated; the same drawn per move; half of it


@dataclass
class Part:
    """Points of the drawing and who they belong to."""

    names: list[str]
    points: Array
    normals: Array


def points_of(scenario: dict) -> Part:
    """A grid of points on every plane (4 x 2 of a wall, 3 x 3 of a floor) and 2 x 8 on every bore (upwards of its point) of a scenario."""
    names, points, normals = [], [], []
    for name, feature in scenario["part"]["features"].items():
        mm = lambda text: np.array([float(v) for v in text.removesuffix("mm").split()])  # noqa: E731
        middle = mm(feature["point"])
        if feature["type"] == "plane":
            normal = np.array(feature["normal"], float)
            normal /= np.linalg.norm(normal)
            wide, high = mm(feature["size"])
            first = np.array([1.0, 0, 0]) if normal[2] > 0.9 else np.array([-normal[1], normal[0], 0])
            second = np.cross(normal, first)
            grid = [(u, v) for u in (-0.4, 0, 0.4) for v in (-0.4, 0, 0.4)]
            if normal[2] < 0.9:
                grid = [(u, v) for u in (-0.42, -0.14, 0.14, 0.42) for v in (-0.3, 0.3)]
            here = [middle + u * wide * first + v * high * second for u, v in grid]
            out = [normal] * len(here)
        else:
            radius, long = mm(feature["diameter"])[0] / 2, mm(feature["length"])[0]
            turn = np.arange(8) * np.pi / 4 + 0.2
            ring = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
            here = [middle + radius * r + (0, 0, z * long) for z in (0.1, 0.5) for r in ring]
            out = [-r for _ in range(2) for r in ring]
        names += [name] * len(here)
        points += here
        normals += out
    return Part(names, np.array(points), np.array(normals))


def known(m: Moment, n: Array) -> tuple[Array, Array]:
    """What the machine file says: X too long, Y leaning, and drives that cut circles small: a/k^2 (1 - f^2)/2."""
    tip = m.pull * (1 - FORWARD**2) / GAIN**2 / 2
    tip[:, 0] += SCALE * m.q[:, 0] - SQUARENESS * m.q[:, 1]
    return tip, np.zeros(len(m.time))


def uncertain(rng: np.random.Generator, scatter: str) -> Error:
    """One draw of everything that the scenario states as uncertain, and of the scatter of passes or moves."""
    offset = rng.normal(0, U_SETTING, 3)
    radius, length = rng.normal(0, U_SETTING, 3), rng.normal(0, U_SETTING, 3)
    square, scale = rng.normal(0, U_SQUARENESS), rng.normal(0, U_SCALE)
    each = rng.normal(0, U_PASS * (0.5 if scatter == "less" else 1.0), (1000, 3))

    def error(m: Moment, n: Array) -> tuple[Array, Array]:
        tip = offset + each[m.block if scatter == "move" else m.cutting]
        tip[:, 0] += scale * m.q[:, 0] - square * m.q[:, 1]
        tip[:, 2] += length[m.tool]
        return tip, radius[m.tool]

    return error


def delta(shape: Array, m: Moment, part: Part) -> float:
    """Mahalanobis length of deviations (n,) mm along the normals, the smaller of scatter drawn per pass and per move."""
    normals = part.normals
    wall = np.abs(normals[:, 2]) < 0.9
    columns = [U_SETTING * normals[:, k] for k in range(3)]
    for tool in (1, 2):
        columns += [U_SETTING * wall * (m.tool == tool), U_SETTING * normals[:, 2] * (m.tool == tool)]
    columns += [U_SQUARENESS * m.q[:, 1] * normals[:, 0], U_SCALE * m.q[:, 0] * normals[:, 0]]
    g = np.column_stack([*columns, FREE * normals, FREE * np.cross(part.points / 100.0, normals)])
    lengths = []
    for group in (m.cutting, m.block):
        same = group[:, None] == group[None]
        covariance = g @ g.T + U_PASS**2 * same * (normals @ normals.T) + U_POINT**2 * np.eye(len(shape))
        lengths.append(math.sqrt(float(shape @ np.linalg.solve(covariance, shape))))
    return min(lengths)


def name_of(found: dict) -> str:
    """effect[place] of an entry of `found`."""
    return f"{found['effect']}[{','.join(str(v) for v in found['where'].values())}]"


def _is_among(found: dict, right: tuple[str, ...]) -> bool:
    """Does the first entry say that it cannot be told from the right name? A rival without a place is one of its family."""
    rivals = found["cannot_be_told_from"]
    return any(r.startswith(right) or r in {n.split("[")[0] for n in right} for r in rivals)


def case(folder: Path, kind: str, strength: float, scatter: str, seed: int) -> dict:
    """One part: cut, measured, handed over, and the next part cut. Lengths in um."""
    rng = np.random.default_rng([seed, *kind.encode()])
    vcmm(folder, "new", "measured_block")
    scenario = tomllib.loads((folder / "measured_block.toml").read_text())
    part = points_of(scenario)
    cutter = Cutter(read_program((folder / "measured_block/part.nc").read_text()), RADIUS)
    truth: list[Error] = [known]
    one = (NAMED | UNNAMED).get(kind)
    if kind == "bending":
        cutter.force_of = partial(forces, cutter, BLANK, TEETH)
    if one:
        shape = one.draw(rng)
        base, moments = cutter.cut(part.points, part.normals, [known])
        tiny, _ = cutter.cut(part.points, part.normals, [known, _times(shape, 1e-6)])
        size = strength / delta((tiny - base) / 1e-6, moments, part) * rng.choice([-1.0, 1.0])
        if kind in ("growth", "wear", "lag_y", "bending"):
            size = abs(size)
        truth.append(_times(shape, size))
    measured, _ = cutter.cut(part.points, part.normals, [*truth, uncertain(rng, scatter)])
    measured = measured + rng.normal(0, U_POINT, len(measured))
    with (folder / "points.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["feature", "x_mm", "y_mm", "z_mm"])
        for name, point in zip(part.names, part.points + measured[:, None] * part.normals, strict=True):
            writer.writerow([name, *(f"{v:.6f}" for v in point)])
    words = (
        "loop",
        "measured_block.toml",
        "--measured",
        "points.csv",
        "--u-point",
        "0.3 um",
        "--out",
        "next",
        "--json",
    )
    document = json.loads(vcmm(folder, *words))
    names = [name_of(f) for f in document["found"]]
    row = {
        "kind": kind, "delta": strength if one else 0.0, "scatter": scatter, "seed": seed, "verdict": document["verdict"],
        "found": names, "probability": [f["probability"] for f in document["found"]],
        "written": [bool(f["written"]) for f in document["found"]], "refused": document["refused"],
        "open_with": [f["cannot_be_told_from"] for f in document["found"]],
    }  # fmt: skip
    if one and one.names:
        row["right_first"] = bool(names) and names[0].startswith(one.names)
        row["right_open"] = (
            bool(names) and not row["right_first"] and _is_among(document["found"][0], one.names)
        )
    before, _ = cutter.cut(part.points, part.normals, truth)
    row |= {
        "rms_before_um": _rms(before),
        "largest_before_um": float(np.abs(before).max() * 1e3),
        "aligned_before_um": _rms(aligned(before, part)),
    }
    if document["program"]:
        after = Cutter(read_program((folder / document["program"]).read_text()), RADIUS)
        if kind == "bending":
            after.force_of = partial(forces, after, BLANK, TEETH)
        departs, _ = after.cut(part.points, part.normals, truth)
        row |= {
            "rms_after_um": _rms(departs),
            "largest_after_um": float(np.abs(departs).max() * 1e3),
            "aligned_after_um": _rms(aligned(departs, part)),
        }
    return row


def aligned(departs: Array, part: Part) -> Array:
    """Departures (n,) less the best shift and turn of the part: as its points show them in the drawing frame."""
    base = np.hstack([part.normals, np.cross(part.points / 100.0, part.normals)])
    return np.asarray(departs - base @ np.linalg.lstsq(base, departs, rcond=None)[0])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)) * 1e3)


def _times(shape: Shape, size: float) -> Error:
    def error(m: Moment, n: Array) -> tuple[Array, Array]:
        tip, grown = shape(m, n)
        return size * tip, size * grown

    return error


def vcmm(folder: Path, *words: str) -> str:
    """What the command prints. Raises RuntimeError where it prints no answer."""
    beside = Path(sys.executable).parent / "vcmm"
    command = [str(beside) if beside.exists() else "vcmm", *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=3600)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"exit {done.returncode}: {(done.stderr or done.stdout)[-400:]}")
    return done.stdout


def cases(seeds: int) -> list[tuple[str, float, str]]:
    """Kind, delta and scatter of every case of one seed, repeated."""
    one: list[tuple[str, float, str]] = []
    for i, (kind, scatter) in enumerate(zip(NAMED, ("pass", "move") * len(NAMED), strict=False)):
        # a part with nothing concealed beside each, so that a count that stops early has both
        one += [(kind, 10.0, scatter), ("nothing", 0.0, NULLS[i % len(NULLS)])]
    one += [(k, 15.0, s) for k, s in zip(UNNAMED, ("pass", "move") * len(UNNAMED), strict=False)]
    return one * seeds


def markdown(rows: list[dict]) -> str:
    """The count, a line per kind, and the four figures."""
    lines = [
        "| concealed | cases | right first | explained | any name | part 2 / part 1 (rms, median) | worse |",
        "|---|---|---|---|---|---|---|",
    ]
    for kind in dict.fromkeys(r["kind"] for r in rows):
        these = [r for r in rows if r["kind"] == kind and "failed" not in r]
        ratios = [r["rms_after_um"] / r["rms_before_um"] for r in these if "rms_after_um" in r]
        right = f"{sum(r['right_first'] for r in these)}" if these and "right_first" in these[0] else ""
        explained = sum(r["verdict"] == "explained" for r in these)
        worse = sum(x > 1 for x in ratios)
        middle = f"{np.median(ratios):.2f} of {len(ratios)}" if ratios else "none written"
        lines.append(
            f"| {kind} | {len(these)} | {right} | {explained} | {sum(bool(r['found']) for r in these)} | {middle} | {worse} |"
        )
    good = [r for r in rows if "failed" not in r]
    named = [r["right_first"] for r in good if "right_first" in r]
    nulls = [bool(r["found"]) for r in good if r["kind"] == "nothing"]
    unknown = [r["verdict"] == "explained" for r in good if r["kind"] in UNNAMED]
    for words, hits in (
        ("named first", named),
        ("names where nothing was concealed", nulls),
        ("without a name, explained", unknown),
    ):
        if hits:
            low, high = bounds(sum(hits), len(hits))
            lines.append(f"\n{words}: {sum(hits)} of {len(hits)} (95 % {low:.2f} to {high:.2f})")
    failed = [r for r in rows if "failed" in r]
    lines += [f"\nfailed: {r['kind']} {r['failed'][:200]}" for r in failed]
    return "\n".join(lines)


def main(words: list[str] | None = None) -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="referee.loops", description=__doc__)
    parser.add_argument(
        "--seeds",
        type=int,
        default=4,
        help="of each effect; 5 are 60 effects with names, 60 parts with nothing concealed and 25 effects without names",
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", default="loops.jsonl", help="goes on where it stopped")
    parser.add_argument("--shard", default="1/1")
    parser.add_argument("--table", metavar="FILE", help="print the table of a file and stop")
    parser.add_argument("--keep", help="folder that keeps the files of every case")
    chosen = parser.parse_args(words)
    if chosen.table:
        print(markdown([json.loads(line) for line in Path(chosen.table).read_text().splitlines()]))
        return 0
    path, mark = Path(chosen.out), commit()
    done = {json.loads(line)["number"] for line in path.read_text().splitlines()} if path.exists() else set()
    part, of = (int(v) for v in chosen.shard.split("/"))
    todo = [(i, *c) for i, c in enumerate(cases(chosen.seeds)) if i not in done][part - 1 :: of]
    for number, kind, strength, scatter in todo:
        with tempfile.TemporaryDirectory() as passing:
            folder = Path(chosen.keep) / str(number) if chosen.keep else Path(passing)
            folder.mkdir(parents=True, exist_ok=True)
            try:
                row = case(folder, kind, strength, scatter, chosen.seed * 1000 + number)
            except Exception as error:  # one case must not stop the others
                row = {"kind": kind, "failed": f"{type(error).__name__}: {error}"}
        with path.open("a") as file:
            file.write(json.dumps({"number": number, "commit": mark, **row}) + "\n")
        print(json.dumps(row), file=sys.stderr, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
