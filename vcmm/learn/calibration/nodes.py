"""Nodes of a residual field from LaserTracer lengths: places at which the machine stops when it is sent to one place from many sides.

Every place was approached several times, from every station alike; one approach of one place is one point, whose coordinates come from
all stations together (`multilateration`). Over the approaches of a node:

    deviation   mean less nominal                                  d            standard deviation (Gaska et al. 2014, Table 2)
    instrument  what the lengths' own u puts into d                changing     what differs from station to station puts into d
    single      standard deviation of one approach: d freed of `changing`, and what the machine alone puts into that, as it acts on one
                approach and not on a mean over stations; alike in all directions, which is all that the residuals tell
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.kinematics import nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.multilateration import Ints, Lengths, MultilaterationResult, locate_points
from vcmm.task.instruments.tracker import FROM
from vcmm.task.response.recording import Recording

SENSES = ("sense_X", "sense_Y", "sense_Z")
LEAST_APPROACHES = 3  # approaches of a node: fewer have no standard deviation worth the name
NULL_DRAWS, NULL_SEED = 20_000, 52


@dataclass(frozen=True, eq=False)
class NodeScatter:
    """See the docstring of this module: place, deviation, d, instrument, changing, single (K, 3) mm; dof (K,); test (K, 3): p of the law.

    deviation_u (K, 3) mm: of the deviation, by its approaches and by how well the stations are known.

    at (K, n, 3): coordinates of every approach less their mean, nan where a node has fewer; located: points, stations, residuals.
    test: chi-squared of the approaches against the t-law of n - 1 degrees of freedom.
    """

    place: Array
    deviation: Array
    deviation_u: Array
    d: Array
    instrument: Array
    changing: Array
    single: Array
    dof: Ints
    test: Array
    at: Array
    multilateration: MultilaterationResult

    @property
    def u(self) -> float:
        """rms of the residuals of eq. 2 for its degrees of freedom, mm."""
        return self.multilateration.u

    def rejection_share(self) -> float:
        """Return the share of the tests below 0.05; under the law it is about 0.05."""
        return float((self.test < 0.05).mean())


def node_scatter(recording: Recording, machine: Machine) -> NodeScatter:
    """Return all nodes of a recording of lengths with `from_x_mm` ..., labels of the station (nuisance `station`) and of the approach.

    Approaches are identified by the label `repeat`, else by sense_X sense_Y sense_Z, else by their order. Raises UsageError for other recordings,
    ModelLimit where the lengths determine no points.
    """
    data, node, place = lengths_of(recording, machine)
    result = locate_points(data)
    length_u = _length_uncertainties(recording)
    share = _propagate(data, result, length_u**2)  # (I, 3) variance of a point by the lengths' own u
    groups = [np.flatnonzero(node == k) for k in range(len(place))]
    few = [k for k, g in enumerate(groups) if len(g) < LEAST_APPROACHES]
    if few:
        where = " ".join(f"{v:g}" for v in place[few[0]])
        raise UsageError(
            f"the node at ({where}) mm has {len(groups[few[0]])} approaches; expected {LEAST_APPROACHES} or more for a standard deviation"
        )
    count = np.array([len(g) for g in groups])
    at = np.full((len(place), count.max(), 3), np.nan)
    for k, g in enumerate(groups):
        at[k, : len(g)] = result.points[g]
    mean = np.nanmean(at, axis=1)
    at = at - mean[:, None]
    d = np.sqrt(np.nansum(at**2, axis=1) / (count - 1)[:, None])
    instrument = np.sqrt(np.array([share[g].mean(axis=0) for g in groups]))
    per_length = _changing(
        data, result, node, len(place)
    )  # (K,) variance of a length that changes between stations
    dilution = np.array([np.einsum("pii->pi", result.alone[g]).mean(axis=0) for g in groups])
    stated = np.array([(length_u[np.isin(data.point, g)] ** 2).mean() for g in groups])
    changing = per_length[:, None] * dilution
    single = np.maximum(d**2 - changing + np.maximum(per_length - stated, 0.0)[:, None], 0.0)
    common = np.array([np.einsum("pii->pi", result.common[g]).mean(axis=0) for g in groups]) * result.u**2
    return NodeScatter(
        place=place, deviation=mean - place, deviation_u=np.sqrt(d**2 / count[:, None] + common), d=d, instrument=instrument, changing=np.sqrt(changing),
        single=np.sqrt(single), dof=count - 1, test=t_tests(at, count), at=at, multilateration=result,
    )  # fmt: skip


def lengths_of(recording: Recording, machine: Machine) -> tuple[Lengths, Ints, Array]:
    """Return the lengths of all points, the node (I,) of each point, the nodes (K, 3) mm. Raises UsageError for other recordings."""
    run = recording.run
    if recording.kind != "length" or FROM[0] not in run.columns or (recording.other >= 0).any():
        raise UsageError(
            f'{recording.name}: nodes are found from lengths of a LaserTracer: kind = "length" with from_x_mm from_y_mm from_z_mm'
        )
    label = next((recording.nuisance[w] for w in ("station", "zero") if w in recording.nuisance), "setup")
    names, station = recording.groups(label)
    tip = nominal_tip(machine.chain, machine.axes, run)[recording.row]
    place, node = np.unique(np.round(tip, 6), axis=0, return_inverse=True)
    node = node.ravel()
    approach = _approaches(recording, node, station)
    pairs, point = np.unique(np.stack([node, approach], axis=1), axis=0, return_inverse=True)
    point = point.ravel()
    _check_once(recording, point, station)
    start = run.vector(*FROM)[recording.row]
    first = np.array([start[np.flatnonzero(station == k)[0]] for k in range(len(names))])
    length = np.linalg.norm(tip - start, axis=1) + recording.sign * recording.value
    return Lengths(length, point, station, place[pairs[:, 0]], first), pairs[:, 0], place


def _approaches(recording: Recording, node: Ints, station: Ints) -> Ints:
    run = recording.run
    if "repeat" in run.labels:
        return recording.groups("repeat")[1]
    sense_columns = [c for c in SENSES if c in run.columns]
    if sense_columns:
        senses = np.stack([run.column(c)[recording.row] for c in sense_columns], axis=1)
        return np.asarray(np.unique(senses, axis=0, return_inverse=True)[1]).ravel()
    order = np.zeros(recording.m, dtype=np.intp)
    counts: dict[tuple[int, int], int] = {}
    for i, key in enumerate(zip(node.tolist(), station.tolist())):
        order[i] = counts.get(key, 0)
        counts[key] = int(order[i]) + 1
    return order


def _check_once(recording: Recording, point: Ints, station: Ints) -> None:
    """Raises UsageError where one approach of a node was read twice from one station."""
    _, first, count = np.unique(
        np.stack([point, station], axis=1), axis=0, return_index=True, return_counts=True
    )
    twice = np.flatnonzero(count > 1)
    if len(twice):
        where = recording.places(np.array([first[twice[0]]]))
        raise UsageError(
            f"{recording.name}: {where}: one approach of one place is read {count[twice[0]]} times from one station; tell repeats apart by a "
            "label column repeat"
        )


def _length_uncertainties(recording: Recording) -> Array:
    """Return the standard uncertainty of every length as the file states it, as (m,) mm: u_d_um of a row, else [noise]."""
    if recording.u is not None:
        return recording.u
    return np.full(recording.m, 0.0 if recording.noise is None else float(np.ravel(recording.noise.u)[0]))


def _propagate(data: Lengths, result: MultilaterationResult, variance: Array) -> Array:
    """Return (I, 3) mm²: variance of every point by variances (m,) of its lengths, the stations known."""
    way = result.points[data.point] - result.stations[data.station]
    beam = way / np.linalg.norm(way, axis=1)[:, None]
    gain = np.einsum("mij,mj->mi", result.alone[data.point], beam)
    out = np.zeros((len(result.points), 3))
    np.add.at(out, data.point, gain**2 * variance[:, None])
    return out


def _changing(data: Lengths, result: MultilaterationResult, node: Ints, nodes: int) -> Array:
    """Return (K,) mm²: mean square of the residuals at each node for its share of the degrees of freedom."""
    square, count = np.zeros(nodes), np.zeros(nodes)
    np.add.at(square, node[data.point], result.residual**2)
    np.add.at(count, node[data.point], 1.0)
    return np.asarray(square / (count * result.freedom / len(data.length)))


def t_tests(at: Array, count: Ints) -> Array:
    """Return p (K, 3) that a sample of this size of the t-law of n - 1 degrees of freedom has so large a chi-squared."""
    out = np.full((at.shape[0], 3), np.nan)
    for n in np.unique(count):
        null = _null(int(n))
        for k in np.flatnonzero(count == n):
            statistic = chi_squared_statistics(at[k, :n].T)
            out[k] = 1.0 - np.searchsorted(null, statistic - 1e-9) / len(null)
    return out


def chi_squared_statistics(values: Array) -> Array:
    """Return the chi-squared (r,) of samples (r, n): counts in cells of equal probability under the t-law of n - 1 degrees of freedom,
    placed at mean and standard
    deviation of the sample; about 3.5 expected in a cell, four cells at least.
    """
    from scipy.stats import t

    n = values.shape[1]
    cells = max(4, round(n / 5))
    spread = values.std(axis=1, ddof=1) / np.sqrt((n - 1) / (n - 3)) if n > 3 else values.std(axis=1, ddof=1)
    scaled = (values - values.mean(axis=1, keepdims=True)) / np.maximum(spread, 1e-300)[:, None]
    which = np.searchsorted(t.ppf(np.arange(1, cells) / cells, n - 1), scaled)
    counts = (which[:, :, None] == np.arange(cells)).sum(axis=1)
    return np.asarray(((counts - n / cells) ** 2).sum(axis=1) / (n / cells))


@cache
def _null(n: int) -> Array:
    """Return the sorted chi-squared of samples of n from the t-law itself: mean and spread are estimated from so few values that the
    table misleads."""
    rng = np.random.default_rng([NULL_SEED, n])
    return np.sort(chi_squared_statistics(rng.standard_t(n - 1, size=(NULL_DRAWS, n))))
