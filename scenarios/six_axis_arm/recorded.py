"""A six-axis arm before a laser tracker, what `vcmm new six_axis_arm` copies. Made without vcmm: turns about lines, one after the other.

Lines of the joints lie 0.3 mm and 0.6 mrad off, zero positions 1 mrad; the shoulder yields by 0.40 mrad x sin of its angle under its own link and by
0.25 mrad x cos of both angles under the forearm, the elbow by 0.30 mrad x cos of both. The tracker reads with 20 um and 50 urad.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
SEED, POSES, OTHERS = 7, 40, 60
U, U_TURN = 0.02, 5e-5  # mm, rad, of a coordinate
POINTS = np.array(
    [[0, 0, 0], [150, 0, 450], [150, 0, 1050], [300, 0, 1200], [800, 0, 1200], [850, 0, 1200]], dtype=float
)
WAYS = np.array([[0, 0, 1], [0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]], dtype=float)
TARGET = np.array([970.0, 30.0, 1160.0])  # mm, all joints at zero
TRACKER = (np.array([0.5, -1.7, 0.9]), np.array([2500.0, -800.0, 300.0]))  # rotation vector, shift
ON_TOOL = np.array([0.3, 0.6, -0.15])  # rotation vector of the target on the tool
LOW, HIGH = np.radians([-150, -60, -60, -150, -100, -170]), np.radians([150, 80, 90, 150, 100, 170])


def turn(vector: Array) -> Array:
    """exp([v]x) by Rodrigues."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / angle if angle else vector
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def pose(q: Array, lines: tuple[Array, Array], zero: Array) -> tuple[Array, Array]:
    """Position (3,) and orientation (3, 3) that the tracker would read without noise."""
    a = q + zero
    upper, fore = a[1], a[1] + a[2]
    a = a + np.array([0, 4e-4 * np.sin(upper) + 2.5e-4 * np.cos(fore), 3e-4 * np.cos(fore), 0, 0, 0])
    rotation, origin = np.eye(3), np.zeros(3)
    for point, way, angle in zip(*lines, a):
        own = turn(angle * way)
        origin = origin + rotation @ (point - own @ point)
        rotation = rotation @ own
    seen = turn(TRACKER[0])
    return seen @ (origin + rotation @ TARGET) + TRACKER[1], seen @ rotation @ turn(ON_TOOL)


def texts() -> dict[str, str]:
    """Name -> text of the tables in scenarios/six_axis_arm."""
    rng = np.random.default_rng(SEED)
    shift, tilt, zero = rng.normal(0, 0.3, (6, 3)), rng.normal(0, 6e-4, (6, 3)), rng.normal(0, 1e-3, 6)
    lines = POINTS + shift, np.stack([turn(t) @ w for t, w in zip(tilt, WAYS)])
    head = "C1_deg,B2_deg,B3_deg,A4_deg,B5_deg,A6_deg,x_mm,y_mm,z_mm," + ",".join(
        f"r{i}{j}" for i in "123" for j in "123"
    )
    out = {}
    for name, n in (("poses.csv", POSES), ("others.csv", OTHERS)):
        rows = [head]
        for q in rng.uniform(LOW, HIGH, (n, 6)):
            position, orientation = pose(q, lines, zero)
            position = position + rng.normal(0, U, 3)
            orientation = turn(rng.normal(0, U_TURN, 3)) @ orientation
            numbers = [
                *(f"{v:.6f}" for v in np.degrees(q)),
                *(f"{v:.4f}" for v in position),
                *(f"{v:.7f}" for v in orientation.ravel()),
            ]
            rows.append(",".join(numbers))
        out[name] = "\n".join(rows) + "\n"
    return out
