"""Multilateration with unknown stations and dead paths: find points of a machine from lengths to a reflector, without its model.

    w_ij = l_ij + l0_j - |x_i - X0_j|        minimised over all points x_i, stations X0_j and dead paths l0_j together

(eq. 2 of Gaska et al., Int. J. Adv. Manuf. Technol. 73 (2014) 497). I points and J stations leave I J - 3 I - 4 J + 6 degrees of
freedom: six numbers say where the whole lies, and are chosen so that the points lie nearest to where the machine says they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array

Ints = npt.NDArray[np.intp]
STEPS, CLOSE = 60, 1e-8  # mm
NEED = 4  # stations: fewer leave points and stations undetermined together
DIRECTION_ERROR = (
    0.01  # of a length: a beam that points wrong by so much changes a scatter across it by as much
)
WEAK = (
    1e-9  # of the largest eigenvalue: a seventh direction of the stations that is as free as the whole lies
)


@dataclass(frozen=True, eq=False)
class Lengths:
    """length (m,) mm less its dead path, from station (m,) to point (m,); nominal (I, 3) and start (J, 3) mm, roughly."""

    length: Array
    point: Ints
    station: Ints
    nominal: Array
    start: Array


@dataclass(frozen=True, eq=False)
class MultilaterationResult:
    """points (I, 3), stations (J, 3), dead paths (J,) mm; residual (m,) w of eq. 2; freedom: degrees of freedom.

    u: of a length, mm, from the residuals.   alone (I, 3, 3): covariance of a point for u = 1 with the stations known.
    common (I, 3, 3): what the stations add to it, for u = 1, the whole nearest to the nominal points.   condition: of the stations' normal equations without the six.
    """

    points: Array
    stations: Array
    dead_paths: Array
    residual: Array
    freedom: int
    alone: Array
    common: Array
    condition: float

    @property
    def u(self) -> float:
        return float(np.sqrt((self.residual**2).sum() / max(self.freedom, 1)))


def locate_points(data: Lengths) -> MultilaterationResult:
    """Solve for all points, stations and dead paths by Gauss-Newton, the points eliminated one by one (Schur complement).

    Raises ModelLimit for too few stations or lengths, and where they do not determine points and stations.
    """
    _check(data)
    points, stations = data.nominal.astype(float), data.start.astype(float)
    dead = np.zeros(len(stations))
    for k in range(len(dead)):  # a first dead path from nominal points
        mine = data.station == k
        way = np.linalg.norm(points[data.point[mine]] - stations[k], axis=1)
        dead[k] = float((way - data.length[mine]).mean())
    for _ in range(STEPS):
        system = _linearise(data, points, stations, dead)
        change, condition = _reduced_step(system)
        points = points + system.back(change)
        stations, dead = stations + change[:, :3], dead + change[:, 3]
        if np.abs(change).max() < CLOSE:
            break
    else:
        raise ModelLimit(
            f"points and stations still move by {np.abs(change).max():.2g} mm after {STEPS} steps; check from_x_mm ..., the unit of the "
            "values, and indicated - true against actual - commanded"
        )
    _check_stations(data, stations)
    system = _linearise(data, points, stations, dead)
    turn, shift = nearest_pose(points, data.nominal)
    alone, common, station = system.covariances(points)
    result = MultilaterationResult(
        points=points @ turn.T + shift, stations=stations @ turn.T + shift, dead_paths=dead, residual=system.residual,
        freedom=len(data.length) - 3 * len(points) - 4 * len(stations) + 6,
        alone=turn @ alone @ turn.T, common=turn @ common @ turn.T, condition=condition,
    )  # fmt: skip
    _check_known(data, result.u * np.sqrt(station))
    return result


def nearest_pose(points: Array, nominal: Array) -> tuple[Array, Array]:
    """Return the rotation (3, 3) and shift (3,) that bring points (n, 3) nearest to nominal ones (Kabsch); lengths stay as they are."""
    a, b = points.mean(axis=0), nominal.mean(axis=0)
    left, _, right = np.linalg.svd((points - a).T @ (nominal - b))
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = np.asarray((left @ sign @ right).T)
    return turn, b - turn @ a


def _check_stations(data: Lengths, stations: Array) -> None:
    """Check the stations. Raises ModelLimit where a station ends further from its stated place than that is from the nearest point."""
    near = _nearest(data)
    moved = np.linalg.norm(stations - data.start, axis=1)
    far = int((moved / near).argmax())
    if moved[far] > near[far]:
        raise ModelLimit(
            f"the lengths lead station {far + 1} to {moved[far]:.0f} mm away from its place in from_x_mm ...: they hardly determine the "
            "stations; add stations or nodes off the present lines and planes, or check from_x_mm ..."
        )


def _check_known(data: Lengths, u: Array) -> None:
    """Raises ModelLimit where a station is known worse than DIRECTED of its shortest length: its beams would point wrong by as much."""
    near = _nearest(data)
    worst = int((u / near).argmax())
    if u[worst] > DIRECTION_ERROR * near[worst]:
        raise ModelLimit(
            f"station {worst + 1} is known to {u[worst]:.2g} mm only; add stations or nodes off the present lines and planes"
        )


def _nearest(data: Lengths) -> Array:
    """Return the distance (J,) mm of the point nearest to each station, at its stated place."""
    way = np.linalg.norm(data.nominal[data.point] - data.start[data.station], axis=1)
    return np.array([way[data.station == k].min() for k in range(len(data.start))])


def _check(data: Lengths) -> None:
    stations, points = len(data.start), len(data.nominal)
    if stations < NEED:
        raise ModelLimit(
            f"lengths from {stations} stations; expected {NEED} or more, since stations, dead paths and points are found together"
        )
    is_measured = np.zeros((points, stations), dtype=bool)
    is_measured[data.point, data.station] = True
    few = np.flatnonzero(is_measured.sum(axis=1) < 3)
    if len(few):
        at = " ".join(f"{v:g}" for v in data.nominal[few[0]])
        raise ModelLimit(
            f"the point at ({at}) mm was seen from {is_measured[few[0]].sum()} stations; expected 3 or more"
        )
    if len(data.length) <= 3 * points + 4 * stations - 6:
        raise ModelLimit(
            f"{len(data.length)} lengths do not determine {points} points and {stations} stations; measure from one station more"
        )


@dataclass(frozen=True, eq=False)
class _LinearStep:
    """One step: residual (m,), beams (m, 3) from station to point, and the points' own normal matrices (I, 3, 3), inverted."""

    data: Lengths
    residual: Array
    beam: Array
    inverse: Array

    def eliminate_points(self) -> tuple[Array, Array, Array]:
        """Return the normal matrix (4J, 4J) and right side (4J,) of stations and dead paths without the points; coupling (I, 3, 4J)."""
        d, count, points = self.data, len(self.data.start), len(self.data.nominal)
        columns = np.concatenate(
            [self.beam, np.ones((len(d.length), 1))], axis=1
        )  # dw of station and dead path
        blocks, right, of_points = np.zeros((count, 4, 4)), np.zeros((count, 4)), np.zeros((points, 3))
        np.add.at(blocks, d.station, np.einsum("mi,mj->mij", columns, columns))
        np.add.at(right, d.station, -columns * self.residual[:, None])
        np.add.at(of_points, d.point, self.beam * self.residual[:, None])
        pairs = np.zeros((points * count, 3, 4))
        np.add.at(pairs, d.point * count + d.station, -np.einsum("mi,mj->mij", self.beam, columns))
        coupling = pairs.reshape(points, count, 3, 4).transpose(0, 2, 1, 3).reshape(points, 3, -1)
        whole = np.zeros((count, 4, count, 4))
        whole[np.arange(count), :, np.arange(count)] = blocks
        carried = self.inverse @ coupling
        matrix = whole.reshape(4 * count, -1) - np.einsum("pia,pib->ab", coupling, carried)
        return matrix, right.ravel() - np.einsum("pia,pi->a", carried, of_points), coupling

    def back(self, change: Array) -> Array:
        """Return the steps of the points (I, 3) that go with steps (J, 4) of stations and dead paths."""
        d = self.data
        columns = np.concatenate([self.beam, np.ones((len(d.length), 1))], axis=1)
        left = self.residual + (columns * change[d.station]).sum(axis=1)
        of_points = np.zeros((len(d.nominal), 3))
        np.add.at(of_points, d.point, self.beam * left[:, None])
        return np.asarray(np.einsum("pij,pj->pi", self.inverse, of_points))

    def covariances(self, points: Array) -> tuple[Array, Array, Array]:
        """See `MultilaterationResult`: of points (I, 3) for u = 1, their own lengths alone, and what the stations add where the whole lies nearest to the
        nominal points; largest variance (J,) of a station.
        """
        matrix, _, coupling = self.eliminate_points()
        values, vectors = np.linalg.eigh(matrix)
        root = vectors[:, 6:] / np.sqrt(values[6:])
        moved = (self.inverse @ coupling @ root).reshape(3 * len(points), -1)
        rigid = _rigid(points)
        moved = moved - rigid @ np.linalg.lstsq(rigid, moved, rcond=None)[0]
        moved = moved.reshape(len(points), 3, -1)
        places = root.reshape(len(self.data.start), 4, -1)[:, :3]
        largest = np.linalg.eigvalsh(places @ places.transpose(0, 2, 1))[:, -1]
        return self.inverse, np.asarray(moved @ moved.transpose(0, 2, 1)), largest


def _rigid(points: Array) -> Array:
    """Return the small shifts and turns of points (I, 3), as (3 I, 6)."""
    arms = points - points.mean(axis=0)
    turns = [np.cross(axis, arms).ravel() for axis in np.eye(3)]
    return np.column_stack([np.tile(np.eye(3), (len(points), 1)), *turns])


def _linearise(data: Lengths, points: Array, stations: Array, dead: Array) -> _LinearStep:
    """Linearise w = l + l0 - |x - X0|; dw/dx = -beam, dw/dX0 = beam, dw/dl0 = 1."""
    way = points[data.point] - stations[data.station]
    now = np.linalg.norm(way, axis=1)
    beam = way / now[:, None]
    normal = np.zeros((len(points), 3, 3))
    np.add.at(normal, data.point, np.einsum("mi,mj->mij", beam, beam))
    weak = np.linalg.eigvalsh(normal)[:, 0]
    if weak.min() < 1e-6:
        at = " ".join(f"{v:g}" for v in data.nominal[int(weak.argmin())])
        raise ModelLimit(f"the beams to the point at ({at}) mm lie in one plane; place a station out of it")
    return _LinearStep(data, data.length + dead[data.station] - now, beam, np.asarray(np.linalg.inv(normal)))


def _reduced_step(system: _LinearStep) -> tuple[Array, float]:
    """Step (J, 4) of stations and dead paths, the whole at rest, and the condition of what is determined."""
    matrix, right, _ = system.eliminate_points()
    values, vectors = np.linalg.eigh(matrix)
    if values[6] < WEAK * values[-1]:
        raise ModelLimit(
            "the lengths leave stations and points undetermined together: the stations or the points lie in one plane or on one quadric; "
            "add a station elsewhere"
        )
    kept = vectors[:, 6:]
    step = kept @ ((kept.T @ right) / values[6:])
    return step.reshape(-1, 4), float(values[-1] / values[6])
