"""Association by criterion: minimax C, circumscribed N, inscribed X, tangent T, beside the Gauss element G.

    found = associate("cylinder", "X", points)        # found.element, found.contacts, found.unique

C  minimax (Chebyshev): the largest |distance| is smallest; the points lie in a zone as narrow as can be. For a line
   in space the zone is a cylinder. ISO 1101:2017 modifier C, QIF MINMAX.
N  minimum circumscribed circle, cylinder, sphere: the smallest that holds all points.
X  maximum inscribed circle, cylinder, sphere: the largest free of points, among those near the Gauss element.
T  tangent: no point on the free side of the element, sum of squared distances smallest (ISO 1101:2017; optimality:
   Shakarji and Srinivasan, NIST, constrained least-squares fitting of planes to establish datums). For planes, lines, cones, tori; of round
   features the element in contact outside the material is N (shaft) or X (bore).
G  least squares: vcmm.part.fit.gauss.

Inscribed elements are local optima in general; the search starts at the Gauss element. Distances are convex in the
motions but for terms of form^2 / radius, so that another optimum is larger by no more than this.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError, choose_from
from vcmm.part.fit.checks import check_convergence, element_of
from vcmm.part.fit.elements import (
    ELEMENTS,
    Array,
    Element,
    FittedElement,
    Mask,
    free_pose,
    rows_of,
    signed_residuals,
)
from vcmm.part.fit.exchange import ContactGoal, ContactProblem, SettledState, settle
from vcmm.part.fit.gauss import centre_points, gauss
from vcmm.part.fit.newton import State, to_local
from vcmm.part.fit.uniqueness import is_unique

CRITERIA: dict[str, str] = {
    "G": "least squares (Gauss)",
    "C": "minimax, minimum zone (Chebyshev)",
    "N": "minimum circumscribed",
    "X": "maximum inscribed",
    "T": "tangent outside the material, least squares",
}
ROUND = ("circle", "cylinder", "sphere")
SUITS: dict[str, tuple[str, ...]] = {
    "G": tuple(ELEMENTS),
    "C": ("line", "plane", "circle", "cylinder", "cone", "sphere", "torus"),
    "N": ROUND,
    "X": ROUND,
    "T": ("line", "plane", "cone", "torus"),
}
NUDGE = 0.1  # of the form: how far beside the Gauss element the search for an inscribed element begins
ASIDE = np.array([0.6, 0.48, 0.64])  # a direction of no symmetry
ROUGH = 1e-6  # of the extent: how well the Gauss element, from which the search begins, is fitted
_CHUNK = 16_384


@dataclass(frozen=True, eq=False)
class Association:
    """element: like that of gauss(). contacts (..., n): points that touch, or reach the border of the zone, within
    1e-11 of the extent. unique (...): False where other elements are as good (see vcmm.part.fit.uniqueness); None where not judged.
    """

    element: FittedElement
    contacts: Mask
    unique: Mask | None


def associate(
    kind: str,
    criterion: str,
    points: Array,
    start: FittedElement | None = None,
    *,
    fixed_axis: Array | None = None,
    inside: bool = False,
    judged: bool = True,
) -> Association:
    """Fit an element by criterion G, C, N, X or T through points (..., n, 3) mm.

    start, fixed_axis   as for gauss(). A circle without fixed_axis lies in the least-squares plane of its points.
    inside              T only: the material is on the side of increasing radius (bore). The normal of a tangent plane,
                        that of start, points out of the material
    judged              False: uniqueness is not judged, which saves a fifth of the time; `unique` is then None
    sizes               C: the middle of the zone, so that residuals run from -h to +h; N, X: the radius itself

    UsageError: kind, criterion, shapes, NaN. ModelLimit: what gauss() refuses (too few points, one circle for a
    cylinder, coplanar points), points that do not surround a circumscribed or inscribed element.
    """
    element = element_of(kind)
    check_criterion(kind, criterion, inside)
    if criterion == "T" and (kind == "line" or (kind == "plane" and start is None)):
        way = "use profile_line" if kind == "line" else "give start=, its normal out of the material"
        raise UsageError(f"a tangent {kind} needs to know on which side the material is: {way}.")
    close = 1e-12 if criterion == "G" else ROUGH
    base = gauss(kind, points, start, fixed_axis=fixed_axis, tolerance=close)
    points = np.asarray(points, dtype=np.float64)
    if criterion == "G":
        none = np.zeros(base.residuals.shape, dtype=bool)
        return Association(base, none, np.ones(points.shape[:-2], dtype=bool))
    has_axis = fixed_axis is not None or kind == "circle"
    batch, n = points.shape[:-2], points.shape[-2]
    flat = points.reshape(-1, n, 3)
    ask, size = _Ask(element, criterion, inside, has_axis, judged), max(1, _CHUNK // n)
    parts = [_chunk(ask, flat[i : i + size], _rows(base, n, i, size)) for i in range(0, len(flat), size)]
    columns = [np.concatenate(column) for column in zip(*parts)]
    lost, done = columns.pop(), columns.pop()
    _check_enclosure(kind, criterion, lost)
    check_convergence(element, done | lost, f"{kind} by criterion {criterion}")
    shaped = [a.reshape((*batch, *a.shape[1:])) for a in columns]
    point, axis, sizes, residuals, normals = shaped[:5]
    fitted_element = FittedElement(kind, point, axis, sizes, residuals, normals)
    return Association(fitted_element, shaped[5], shaped[6] if judged else None)


def check_criterion(kind: str, criterion: str, inside: bool = False) -> None:
    """Raise UsageError for an unknown criterion, or one that an element of this kind does not have."""
    if criterion not in CRITERIA:
        raise UsageError(f'"{criterion}" is no criterion of association.{choose_from(criterion, CRITERIA)}')
    if kind in SUITS[criterion]:
        return
    if criterion == "T" and kind in ROUND:
        use = f'the {kind} in contact outside the material is "{"X" if inside else "N"}"'
    else:
        use = f"a {kind} takes {', '.join(c for c, kinds in SUITS.items() if kind in kinds)}"
    raise UsageError(f'criterion "{criterion}" ({CRITERIA[criterion]}) is not for a {kind}; {use}.')


def _check_enclosure(kind: str, criterion: str, lost: Mask) -> None:
    if lost.any():
        grows = "shrink" if criterion == "N" else "grow"
        raise ModelLimit(
            f"{kind} by criterion {criterion}: the points do not surround it (in {int(lost.sum())} of {len(lost)} "
            f"fits, the first is number {int(np.argmax(lost))}): an element beside them could {grows} on and on. "
            'Measure all around, on every level, or use "C" or "G".'
        )


def _rows(base: FittedElement, n: int, first: int, size: int) -> FittedElement:
    """Return members first .. first + size - 1 of the Gauss elements of n points, in one leading dimension."""
    parts = (base.point, base.axis, base.sizes, base.residuals)
    cut = [
        a.reshape(-1, w)[first : first + size] for a, w in zip(parts, (3, 3, base.sizes.shape[-1] or 1, n))
    ]
    sizes = cut[2] if base.sizes.shape[-1] else np.empty((len(cut[0]), 0))
    return FittedElement(base.kind, cut[0], cut[1], sizes, cut[3], base.normals)


def _goal(kind: str, criterion: str, inside: bool) -> ContactGoal:
    if criterion == "T":
        return ContactGoal(has_size=True, tangent=True, sign=-1.0 if inside else 1.0)
    if criterion == "C" and kind != "line":
        return ContactGoal(two_sided=True, has_size=True)
    return ContactGoal(sign=-1.0 if criterion == "X" else 1.0)


class _Ask(NamedTuple):
    """Arguments that are common to all chunks of a batch."""

    element: Element
    criterion: str
    inside: bool
    has_axis: bool  # the axis is given
    checks_uniqueness: bool


def _chunk(ask: _Ask, points: Array, base: FittedElement) -> tuple[Array | Mask, ...]:
    """Fit a chunk (B, n, 3): return point, axis, sizes, residuals, normals, contacts, unique, done, lost."""
    element, criterion = ask.element, ask.criterion
    data, centroid, scale = centre_points(points)
    line = element.kind == "line"
    shape = element_of("cylinder") if line else element  # distances from a line: from a cylinder of radius 0
    unit = np.where(np.array(element.lengths, dtype=bool), scale, 1.0)
    sizes = np.zeros((len(data), 1)) if line else base.sizes / unit
    axis = base.axis if element.has_axis else np.tile([0.0, 0.0, 1.0], (len(data), 1))
    goal = _goal(element.kind, criterion, ask.inside)
    problem = ContactProblem(shape, free_pose(shape, ask.has_axis), goal)
    point = (base.point - centroid) / scale
    if criterion == "X":  # off the saddle between two opposite points
        point = point + NUDGE * np.ptp(base.residuals, axis=-1, keepdims=True) / scale * ASIDE
    settled: SettledState = settle(problem, data, State(point, axis, sizes))
    unique = is_unique(problem, data, settled) if ask.checks_uniqueness else settled.is_done
    state = settled.state
    if not (goal.has_size or line):
        state = state._replace(sizes=state.sizes + goal.sign * settled.level[:, None])
    if line:
        state = state._replace(sizes=np.empty((len(data), 0)))
    local, frame = to_local(data, state)
    residuals, normals = signed_residuals(rows_of(element, local, state.sizes), frame, local[:, 0].shape)
    shown = state.axis if element.has_axis else np.zeros_like(state.axis)
    point = state.point * scale + centroid
    return (
        point, shown, state.sizes * unit, residuals * scale, normals, settled.contacts, unique, settled.is_done, settled.is_lost
    )  # fmt: skip
