"""Reversals along a linear axis: straightness against a straightedge, squareness to a turning axis by a half turn.

    straightness  the straightedge is turned over about its length, the probe goes to its other side:
                      normal   = a(x) + sense m(x) + zero + slope x       reversed = a(x) - sense m(x) + zero + slope x
                  m = sense (normal - reversed) / 2; zero and slope are how straightedge and probe were set up, free in every scan:
                  the slope of m is squareness, and no reversal of a straightedge tells it.
    squareness    a flat on the turning axis is scanned along x, at 0 and at 180 deg of the axis:
                      slope at 0 = sense (-s + tau)                        slope at 180 = sense (-s - tau)
                  s squareness of the turning axis to x (B0C of X and C), tau how the flat lies on the axis (it turns with it). The
                  axis's own tilt at both angles is in s; `tilt` takes it off (eq. 11 of the X-C-Z paper).

Sources: Evans, Hocken, Estler, CIRP Annals 45 (1996) 617; ISO 230-1:2012, annex on reversal and 10.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.run import Array

NODES = 101
PLACE = 1e-3  # mm: targets that are nearer are one
FEW = 3


@dataclass(frozen=True, eq=False)
class LineScan:
    """One scan: set-up, place (n,) mm, value (n,) mm."""

    setup: str
    place: Array
    value: Array


@dataclass(frozen=True, eq=False)
class StraightnessReversal:
    """nodes (k,) mm; machine, artefact (k,) mm less their lines; covariance (k, k) of machine, and, the same, of artefact.

    scatter: standard deviation of one scan at a node, mm; dof: of it, more than that of the scans, as their places tell of one
    process (Satterthwaite: trace^2 over the sum of squares of its covariance). slopes: of (machine, artefact) as set up, mm/mm; they tell
    nothing of the machine.
    """

    nodes: Array
    machine: Array
    artefact: Array
    covariance: Array
    scatter: float
    dof: float
    slopes: tuple[float, float]

    @property
    def u(self) -> Array:
        """Standard uncertainty at the nodes (k,) mm."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    def draw(self, rng: np.random.Generator, trials: int) -> Array:
        """Sample machine curves (trials, k) mm about the estimate, t-distributed with dof."""
        size, ways = np.linalg.eigh(self.covariance)
        factor = ways * np.sqrt(np.maximum(size, 0.0))
        scale = np.sqrt(self.dof / rng.chisquare(self.dof, size=trials))[:, None]
        return np.asarray(self.machine + scale * (rng.standard_normal((trials, len(size))) @ factor.T))


@dataclass(frozen=True)
class SquarenessReversal:
    """angle: squareness, rad; flat: how the flat lies on the axis, rad; u of either; dof; slopes of the two set-ups."""

    angle: float
    flat: float
    u: float
    dof: float
    slopes: tuple[float, float]


def straightness_reversal(
    scans: Sequence[LineScan], sense: float = 1.0, u: float | None = None
) -> StraightnessReversal:
    """Separate straightness and straightedge. u: stated noise of one reading, mm, used where no set-up was scanned twice.

    The covariance is that of the scatter between the scans of one set-up, as a stationary process along the line. Raises
    UsageError for missing set-ups, scans that do not overlap, and no scatter to judge by.
    """
    _check(scans, "straightness")
    nodes = _nodes(scans)
    curves = np.stack([_without_line(nodes, _on_nodes(nodes, s)) for s in scans])
    raw = np.stack([_on_nodes(nodes, s) for s in scans])
    turned = np.array([s.setup == "reversed" for s in scans])
    means = [curves[~turned].mean(axis=0), curves[turned].mean(axis=0)]
    left = np.where(turned[:, None], curves - means[1], curves - means[0])
    dof = float(len(scans) - 2)
    if dof > 0:
        scatter = _stationary(left, dof)
    elif u is not None:
        per_node = max(min(len(s.place) for s in scans) / len(nodes), 1.0)
        scatter, dof = u**2 / per_node * np.eye(len(nodes)), 1e9
    else:
        raise UsageError(
            'one scan in each set-up shows no scatter; repeat the scans (three each are usual), or state [noise] u = "1 nm"'
        )
    keep = np.eye(len(nodes)) - _line(nodes)
    scatter = keep @ scatter @ keep
    dof *= float(np.trace(scatter) ** 2 / (scatter**2).sum())
    share = (1.0 / (~turned).sum() + 1.0 / turned.sum()) / 4.0
    slopes = [float(np.polyfit(nodes, raw[m].mean(axis=0), 1)[0]) for m in (~turned, turned)]
    return StraightnessReversal(
        nodes=nodes,
        machine=sense * (means[0] - means[1]) / 2.0,
        artefact=(means[0] + means[1]) / 2.0,
        covariance=share * scatter,
        scatter=float(np.sqrt(np.trace(scatter) / len(nodes))),
        dof=dof,
        slopes=(sense * (slopes[0] - slopes[1]) / 2.0, (slopes[0] + slopes[1]) / 2.0),
    )


def squareness_reversal(
    scans: Sequence[LineScan], sense: float = 1.0, u: float | None = None, tilt: float = 0.0
) -> SquarenessReversal:
    """Compute squareness from the slopes at both ends of a half turn; tilt: mean of the axis's tilt motion (EBC) at both angles, rad.

    Raises UsageError for missing set-ups and no scatter to judge by.
    """
    _check(scans, "half-turn")
    slope = np.array([np.polyfit(s.place - s.place.mean(), s.value, 1)[0] for s in scans])
    turned = np.array([s.setup == "reversed" for s in scans])
    first, second = float(slope[~turned].mean()), float(slope[turned].mean())
    dof = float(len(scans) - 2)
    if dof > 0:
        left = np.where(turned, slope - second, slope - first)
        variance = float((left**2).sum()) / dof
    elif u is not None:
        least = min(float(((s.place - s.place.mean()) ** 2).sum()) for s in scans)
        variance, dof = u**2 / least, 1e9
    else:
        raise UsageError(
            'one scan at each angle shows no scatter; repeat the scans, or state [noise] u = "1 nm"'
        )
    share = (1.0 / (~turned).sum() + 1.0 / turned.sum()) / 4.0
    return SquarenessReversal(
        angle=-sense * (first + second) / 2.0 - tilt,
        flat=sense * (first - second) / 2.0,
        u=float(np.sqrt(variance * share)),
        dof=dof,
        slopes=(first, second),
    )


def _check(scans: Sequence[LineScan], what: str) -> None:
    setups = {s.setup for s in scans}
    if setups != {"normal", "reversed"}:
        raise UsageError(
            f'a {what} reversal has the set-ups "normal" and "reversed" in the column setup; there are {" and ".join(sorted(setups))}'
        )
    short = [s for s in scans if len(s.place) < FEW or float(np.ptp(s.place)) < PLACE]
    if short:
        raise UsageError(
            f'a scan of the set-up "{short[0].setup}" has {len(short[0].place)} readings along the axis; {FEW} are the fewest'
        )


def _nodes(scans: Sequence[LineScan]) -> Array:
    """Return the targets that all scans have, where they are few; else even nodes over the length that all scans share."""
    sets = [np.unique(np.round(s.place / PLACE)) for s in scans]
    common = sets[0]
    for nodes in sets[1:]:
        common = np.intersect1d(common, nodes)
    if len(common) >= FEW and all(len(nodes) == len(common) for nodes in sets) and len(common) <= NODES:
        return np.asarray(common * PLACE)
    low, high = max(float(s.place.min()) for s in scans), min(float(s.place.max()) for s in scans)
    if high - low < PLACE * FEW:
        raise UsageError("the scans have no length in common; scan the same part of the axis in both set-ups")
    n = min(NODES, min(len(s.place) for s in scans))
    return np.linspace(low, high, n)


def _on_nodes(nodes: Array, scan: LineScan) -> Array:
    """Fit a broken line through the nodes (k,) by least squares; readings beyond the nodes are left out."""
    from scipy.linalg import solveh_banded

    inside = (scan.place >= nodes[0] - PLACE) & (scan.place <= nodes[-1] + PLACE)
    x, y = np.clip(scan.place[inside], nodes[0], nodes[-1]), scan.value[inside]
    left = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    t = (x - nodes[left]) / (nodes[left + 1] - nodes[left])
    k, near = len(nodes), 1.0 - t
    main = np.bincount(left, near**2, k) + np.bincount(left + 1, t**2, k)
    beside = np.bincount(left, near * t, k)
    if (main <= 0).any():
        at = nodes[int(np.argmin(main))]
        raise UsageError(
            f'a scan of the set-up "{scan.setup}" has no reading near {at:.4g} mm; scan without gaps'
        )
    right = np.bincount(left, near * y, k) + np.bincount(left + 1, t * y, k)
    band = np.stack([np.concatenate([[0.0], beside[:-1]]), main])
    return np.asarray(solveh_banded(band, right))


def _line(nodes: Array) -> Array:
    """Return the projection on straight lines (k, k)."""
    q, _ = np.linalg.qr(np.stack([np.ones(len(nodes)), nodes - nodes.mean()], axis=1))
    return np.asarray(q @ q.T)


def _without_line(nodes: Array, values: Array) -> Array:
    return np.asarray(values - _line(nodes) @ values)


def _stationary(left: Array, dof: float) -> Array:
    """Return the covariance of one scan by lag (k, k); (k - 2) / k of a scan are free beside its line."""
    k = left.shape[1]
    lags = np.array([(left[:, : k - lag] * left[:, lag:]).sum() for lag in range(k)]) / (dof * max(k - 2, 1))
    where = np.abs(np.arange(k)[:, None] - np.arange(k))
    return np.asarray(lags[where])
