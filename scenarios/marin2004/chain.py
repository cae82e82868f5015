"""The chain of Marin (SISOM 2004) multiplied out: "w X' Y' b Z t", equations 7 to 26, without vcmm's kinematics.

    work   R -> T1 (carriage Y) -> T2 (carriage X on Y) -> workpiece      tool   R -> T3 (head Z) -> tip
    T = translation (travel and offset a, b, c) times E, E = [[1 -ez ey dx] [ez 1 -ex dy] [-ey ex 1 dz]]   (5), (7)-(11)

Signs and readings:

- x and y of the paper move the table in plus direction, so x = -X and y = -Y of the contract (a primed axis is commanded
  relative to the tool); the errors are the carriages' own motions in both.
- The offsets a, b, c are where the errors were measured: `measured_at`. a1 is that of Y, a1 + a2 that of X, a3 that of Z.
- Squareness sits on X (8), (9): dy2 = dy2' + axy x, dz2 = dz2' + axz x. The third, ayz, is not shown in (10), (11); here it
  is on Z, dy3 = dy3' + ayz z.   In the contract's pairs: axy = C0X, axz = -B0X, ayz = -A0Z.
- (11) prints the error z1 for z3; minus signs are lost in (21) to (25). `expanded` is derived again from (22).
- The correction is expressed in reference axes, tool less workpiece: actual - nominal of the tip. vcmm states the tip
  error in workpiece axes, which the errors have turned: `in_workpiece_axes`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm import Array, Machine, Run, UsageError, kinematics

STRUCTURE = "w X' Y' b Z t"
LETTERS = ("Y", "X", "Z")  # carriages 1, 2, 3 of the paper


@dataclass(frozen=True, eq=False)
class Carriages:
    """Per carriage Y, X, Z: travel (n, 3), offset (3,), translation and rotation errors (n, 3) each; tip (n, 3): T."""

    travel: tuple[Array, Array, Array]
    offset: tuple[Array, Array, Array]
    shift: tuple[Array, Array, Array]
    turn: tuple[Array, Array, Array]
    tip: Array

    @property
    def work(self) -> Array:
        """Nominal workpiece coordinates W (n, 3), equation (19)."""
        ends = [t + o for t, o in zip(self.travel, self.offset)]
        return np.asarray(ends[2] + self.tip - ends[0] - ends[1])


def carriages(machine: Machine, run: Run) -> Carriages:
    """The paper's parameters at the rows of a run. Raises UsageError for another structure or errors it does not have."""
    if machine.chain.structure != STRUCTURE:
        raise UsageError(f'this chain is "{STRUCTURE}", not "{machine.chain.structure}"')
    places = {a: np.array(machine.axes[a].measured_at or (0.0, 0.0, 0.0)) for a in LETTERS}
    offset = (places["Y"], places["X"] - places["Y"], places["Z"])
    unit = np.eye(3)
    travel = (
        -run.q("Y")[:, None] * unit[1], -run.q("X")[:, None] * unit[0], run.q("Z")[:, None] * unit[2]
    )  # fmt: skip
    six = {a: np.zeros((run.n, 6)) for a in LETTERS}
    square = {"C0X": 0.0, "B0X": 0.0, "A0Z": 0.0}
    for effect in machine.effects:
        if effect.name == "squareness" and effect.where in square:
            square[effect.where] += float(effect.angle)  # type: ignore[attr-defined]
        elif effect.own and effect.place == "motion" and effect.link in six:
            six[effect.link] += effect.error_motion(run)
        elif effect.link != "reading" and np.any(effect.error_motion(run)):
            raise UsageError(f"{effect.id} has no place in the chain of Marin (2004)")
    six["X"][:, 1] += square["C0X"] * travel[1][:, 0]
    six["X"][:, 2] -= square["B0X"] * travel[1][:, 0]
    six["Z"][:, 1] -= square["A0Z"] * travel[2][:, 2]
    shift, turn = (tuple(six[a][:, part] for a in LETTERS) for part in (slice(0, 3), slice(3, 6)))
    return Carriages(travel, offset, shift, turn, run.offset - offset[2])  # type: ignore[arg-type]


def matrix(travel: Array, offset: Array, shift: Array, turn: Array, exact: bool = False) -> Array:
    """T actual (n, 4, 4), equation (6); exact: a true rotation by one rotation vector in place of 1 + [e]x."""
    out = np.zeros((len(travel), 4, 4))
    x, y, z = turn.T
    if exact:
        out[:, :3, :3] = kinematics.rotation_from_vector(turn)
    else:
        out[:, 0, 0] = out[:, 1, 1] = out[:, 2, 2] = 1.0
        out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -z, y, -x
        out[:, 1, 0], out[:, 2, 0], out[:, 2, 1] = z, -y, x
    out[:, :3, 3] = travel + offset + shift
    out[:, 3, 3] = 1.0
    return out


def product(c: Carriages, exact: bool = False) -> tuple[Array, Array]:
    """(correction vector (n, 3) of (22) in reference axes, rotation of the table (n, 3, 3)) by multiplying the matrices."""
    one, two, three = (matrix(*parts, exact) for parts in zip(c.travel, c.offset, c.shift, c.turn))
    table = one @ two
    ones = np.ones((len(c.tip), 1))
    tool = np.einsum("nij,nj->ni", three, np.hstack([c.tip, ones]))
    work = np.einsum("nij,nj->ni", table, np.hstack([c.work, ones]))
    return (tool - work)[:, :3], table[:, :3, :3]


def relation(c: Carriages, exact: bool = False) -> Array:
    """E_V (n, 4, 4) of equation (20), in the frame of the tool point as its text says: workpiece frame = tool frame times E_V.

    Both frames at the cutting point. Its translation is what the tool must be moved by, minus the correction vector of (22) but for
    the turn of the tool (second order); its rotation is that of the workpiece against the tool. (As printed, E_V on the left, it would
    be about the origin of the reference frame.)
    """
    one, two, three = (matrix(*parts, exact) for parts in zip(c.travel, c.offset, c.shift, c.turn))
    return np.asarray(np.linalg.inv(_moved_to(three, c.tip)) @ _moved_to(one @ two, c.work))


def _moved_to(frame: Array, point: Array) -> Array:
    """The frames (n, 4, 4) with their origins at points (n, 3) in them."""
    out = np.array(frame)
    out[:, :3, 3] += np.einsum("nij,nj->ni", frame[:, :3, :3], point)
    return out


def orientation(relation: Array) -> Array:
    """(n, 3) rad: rotation of the workpiece against the tool, from the antisymmetric part of E_V."""
    r = relation[:, :3, :3]
    pairs = ((2, 1), (0, 2), (1, 0))
    return np.stack([(r[:, i, j] - r[:, j, i]) / 2 for i, j in pairs], axis=1)


def volumetric_error(correction: Array) -> Array:
    """(n,) mm: equation (26), the length of the vector."""
    return np.asarray(np.linalg.norm(correction, axis=1))


def in_workpiece_axes(correction: Array, table: Array) -> Array:
    """The same vector in the axes of the table as it really stands."""
    return np.asarray(np.linalg.solve(table, correction[:, :, None])[:, :, 0], dtype=np.float64)


def expanded(c: Carriages) -> Array:
    """Equations (23) to (25) with the signs that (22) gives (n, 3), mm."""
    (x1, y1, z1), (x2, y2, z2), (x3, y3, z3) = (t.T for t in c.turn)
    tx, ty, tz = c.tip.T
    wx, wy, wz = c.work.T
    first, second, third = (t + o + s for t, o, s in zip(c.travel, c.offset, c.shift))
    ux, uy, uz = second.T
    px = tx - ty * z3 + tz * y3 + third[:, 0]
    px -= (1 - z1 * z2 - y1 * y2) * wx + (-z2 - z1 + y1 * x2) * wy + (y2 + z1 * x2 + y1) * wz
    px -= ux - z1 * uy + y1 * uz + first[:, 0]
    py = ty + tx * z3 - tz * x3 + third[:, 1]
    py -= (z1 + z2 + x1 * y2) * wx + (1 - z1 * z2 - x1 * x2) * wy + (z1 * y2 - x2 - x1) * wz
    py -= z1 * ux + uy - x1 * uz + first[:, 1]
    pz = tz + ty * x3 - tx * y3 + third[:, 2]
    pz -= (x1 * z2 - y1 - y2) * wx + (y1 * z2 + x1 + x2) * wy + (1 - y1 * y2 - x1 * x2) * wz
    pz -= -y1 * ux + x1 * uy + uz + first[:, 2]
    return np.stack([px, py, pz], axis=1)
