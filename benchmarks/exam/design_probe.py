"""Probe recordings of a multi-sphere artefact on a bridge CMM: rich (poses, styli, speeds, hours) and poor."""

from __future__ import annotations

import numpy as np

from benchmarks.exam.design import Design, motion_columns, room, since_reversal, unit
from benchmarks.exam.kinema import Array, turn
from benchmarks.exam.machines import BRIDGE

BODY = 110.0  # mm from the ram to the stylus mount
STYLI = (  # direction, stylus length mm, tip radius mm, head A and B deg
    ((0.0, 0.0, -1.0), 20.0, 1.0, 0.0, 0.0),
    ((0.7071, 0.0, -0.7071), 50.0, 2.0, 45.0, 90.0),
    ((0.0, -0.7071, -0.7071), 50.0, 1.5, 45.0, 0.0),
    ((0.0, 0.0, -1.0), 100.0, 2.0, 0.0, 0.0),
)
SENSORS = (
    "temp_scale_x_C",
    "temp_scale_y_C",
    "temp_scale_z_C",
    "temp_part_C",
    "temp_air_C",
    "temp_gradient_C",
)


def artefact(rng: np.random.Generator) -> Array:
    """Ten sphere centres (10, 3) in the part frame, mm."""
    grid = np.array([(x, y) for x in (-120, -40, 40, 120) for y in (-90, 0, 90)], dtype=float)[:10]
    return np.column_stack([grid + rng.uniform(-12, 12, grid.shape), rng.uniform(-60, 60, 10)])


def probe(rng: np.random.Generator, rows: int = 500, rich: bool = True, radius_free: bool = False) -> Design:
    """Rich: five turned poses, four styli, touches and scans, 8 h. Poor: one of each, four directions per sphere."""
    for _ in range(200):
        found = _probe(rng, rows, rich, radius_free)
        if all(
            (found.q[a] >= low).all() and (found.q[a] <= high).all()
            for a, (low, high) in BRIDGE.travel.items()
        ):
            return found
    raise RuntimeError("no placement of the artefact inside the travels")


def _probe(rng: np.random.Generator, rows: int, rich: bool, radius_free: bool) -> Design:
    poses = 5 if rich else 1
    centres = artefact(rng)
    shifts = np.column_stack(
        [rng.uniform(310, 490, poses), rng.uniform(280, 420, poses), rng.uniform(-430, -370, poses)]
    )
    turns = turn(
        np.column_stack([rng.normal(0, 0.35, (poses, 2)), np.linspace(0, 5.5, poses) + rng.uniform(0, 0.7)])
    )
    if not rich:
        turns = turn(np.array([[0.0, 0.0, 0.1]]))
    pose = np.sort(np.arange(rows) * poses // rows)
    styli = 4 if rich else 1
    stylus = (np.arange(rows) * poses * styli // rows) % styli
    event = np.cumsum(np.concatenate([[1], (np.diff(stylus) != 0) | (np.diff(pose) != 0)]))
    ball = np.concatenate([rng.permutation(10) for _ in range(rows // 10 + 1)])[:rows]
    axis = unit(np.array([STYLI[s][0] for s in stylus]))
    normal = _normals(rng, axis, rich)
    length = np.array([STYLI[s][1] for s in stylus])
    tip_radius = np.array([STYLI[s][2] for s in stylus])
    part = centres[ball] + 0.0
    part_normal = np.einsum("nji,nj->ni", turns[pose], normal)
    place = np.einsum("nij,nj->ni", turns[pose], part) + shifts[pose] + (12.5 + tip_radius)[:, None] * normal
    offset = axis * (BODY + length)[:, None]
    q = place - offset
    scan = (rng.random(rows) < 0.4) if rich else np.zeros(rows, dtype=bool)
    nodes, row_node, way = _path(rng, q, normal, scan, rich)
    sense, since = since_reversal(nodes)
    speed = rng.choice([2.0, 5.0, 10.0], rows) if rich else np.full(rows, 5.0)
    speed = np.where(scan, rng.choice([5.0, 20.0, 50.0], rows), speed)
    accel = rng.choice([-150.0, -40.0, 0.0, 40.0, 150.0], rows) if rich else np.zeros(rows)
    time = np.cumsum(rng.uniform(35, 65, rows)) + 1200.0 * pose + 60.0 * event
    if not rich:
        time = time / 10
    columns = {"time_s": time, "stylus_length_mm": length, "tip_radius_mm": tip_radius}
    columns |= {"load_kg": np.array([0.0, 25.0, 60.0, 10.0, 90.0])[pose] if rich else np.full(rows, 20.0)}
    columns |= {
        "head_A_deg": np.array([STYLI[s][3] for s in stylus]),
        "head_B_deg": np.array([STYLI[s][4] for s in stylus]),
    }
    columns |= motion_columns(sense[row_node], since[row_node], speed[:, None] * way, accel[:, None] * way)
    columns["probe_angle_deg"], lateral = _about_stylus(axis, normal)
    labels = {
        "pose": [f"p{i}" for i in pose], "stylus": [f"s{i}" for i in stylus], "event": [f"e{i}" for i in event],
        "part": ["plate"] * rows, "clamp": [f"c{i}" for i in pose], "mode": ["scan" if s else "touch" for s in scan],
        "feature": [f"ball{i}" for i in ball],
    }  # fmt: skip
    nuisance = {"rigid": "pose", "offset": "stylus"} | ({"radius": "stylus"} if radius_free else {})
    hidden = {"lateral": lateral, "part_frame": part + (12.5) * part_normal, "part_normal": part_normal,
              "turns": turns[pose], "axis": axis, "pose": pose.astype(float), "ball_radius": 12.5 + tip_radius}  # fmt: skip
    columns |= {f"raw_{a}_mm": q[:, i] + 0.0137 * (i + 1) for i, a in enumerate("XYZ")}
    return Design(
        "probe rich" if rich else "probe poor", BRIDGE, "probe", "indicated - true",
        {a: q[:, i] for i, a in enumerate("XYZ")}, offset, normal, columns, labels, nuisance,
        room(rng, float(time[-1]), SENSORS, 1.6 if rich else 0.15), hidden, nodes, row_node,
    )  # fmt: skip


def _normals(rng: np.random.Generator, axis: Array, rich: bool) -> Array:
    """Directions that the stylus can reach: away from its own shaft."""
    if not rich:
        four = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
        return four[np.arange(len(axis)) % 5]
    out = unit(rng.normal(size=axis.shape))
    for _ in range(50):
        wrong = (out * axis).sum(axis=1) > 0.35
        out[wrong] = unit(rng.normal(size=(int(wrong.sum()), 3)))
    return out


def _path(
    rng: np.random.Generator, q: Array, normal: Array, scan: Array, rich: bool
) -> tuple[Array, Array, Array]:
    """Dense path of way points, the node of each row, and the direction of motion at each row."""
    nodes, row_node = [q[0] + np.array([3.0, 4.0, 20.0])], []
    across = unit(np.cross(normal, unit(rng.normal(size=q.shape))))
    tilt = rng.uniform(0.2, 0.8, (len(q), 1)) if rich else 0.0
    way = unit(np.where(scan[:, None], across, -normal + tilt * across))
    run_in = np.where(scan, np.exp(rng.uniform(np.log(0.05), np.log(8.0), len(q))), 3.0)
    for i in range(len(q)):
        nodes += [q[i] + 25.0 * normal[i] + rng.normal(0, 4.0, 3)]
        if scan[i]:  # settles on the surface a little further on, then comes back along it
            nodes += [q[i] - way[i] * run_in[i] + rng.normal(0, 0.3, 3), q[i] - way[i] * run_in[i]]
        else:
            nodes += [q[i] - way[i] * run_in[i]]
        nodes += [q[i]]
        row_node.append(len(nodes) - 1)
        nodes += [q[i] + 4.0 * normal[i]]
    return np.array(nodes), np.array(row_node), way


def _about_stylus(axis: Array, normal: Array) -> tuple[Array, Array]:
    """Angle of the contact about the stylus axis, deg, from a fixed direction across it, and the lateral share."""
    first = unit(np.cross(np.array([0.0, 1.0, 0.0]) + 0.0 * axis, axis))
    second = np.cross(axis, first)
    angle = np.degrees(np.arctan2((normal * second).sum(axis=1), (normal * first).sum(axis=1)))
    return angle, np.sqrt(np.clip(1 - (normal * axis).sum(axis=1) ** 2, 0, 1))
