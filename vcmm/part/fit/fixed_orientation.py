"""Association with a given orientation, as ISO 5459 requires of secondary and tertiary datums.

    held(base, axis)                  the axis is `axis`: it may shift and change its size, and turn no more
    held(base, axis, about)           the axis keeps its angle to `about` and turns about that direction alone

By the points where they are at hand (any criterion of vcmm.part.fit.criteria), else from the free least-squares element: about its
minimum the sum of squares is quadratic in the motion, so that the element whose tilt w is given moves and grows by

    z = -Mzz^-1 Mzw w,        M the normal matrix of the fit

(a shift only where the points do not surround the element evenly), and turns where w^T (Mww - Mwz Mzz^-1 Mzw) w is least. It errs
by tilt squared over the radius: (10 um)^2 / 2 / 5 mm = 10 nm for 10 um over the length and a radius of 5 mm. With neither points
nor matrix the element turns about its point, the middle of its points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.part.fit.checks import check_convergence, element_of
from vcmm.part.fit.criteria import ASIDE, NUDGE, ROUND, associate
from vcmm.part.fit.elements import (
    RX,
    RY,
    Array,
    FittedElement,
    Mask,
    frames,
    jacobian,
    rows_of,
    signed_residuals,
)
from vcmm.part.fit.exchange import ContactGoal, ContactProblem, Local, settle
from vcmm.part.fit.gauss import centre_points, gauss
from vcmm.part.fit.newton import State, magnitude, move_state, seat, to_local

STEPS = 50
TURNS = 4  # of Gauss-Newton for one angle, from a start that errs by mrad: 1e-3, 1e-6, 1e-12
CONVERGED_SHARE = 1e-12  # of the extent: a step of Gauss-Newton that moves nothing


def hold_axis(
    base: FittedElement,
    axis: Array,
    about: Array | None = None,
    points: Array | None = None,
    criterion: str = "G",
    inside: bool = False,
) -> FittedElement:
    """Fit the element of the kind of `base` (its free least-squares fit) whose axis is `axis` (..., 3), unit, on the side of base.axis.

    about (..., 3): unit direction about which it may turn, at the angle that axis has to it; None: axis is final.
    points (..., n, 3) mm: what is fitted. UsageError: a line by a criterion other than G. ModelLimit: as associate().
    """
    if points is None:
        return _by_matrix(base, axis, about)
    batch = np.broadcast_shapes(points.shape[:-2], axis.shape[:-1], () if about is None else about.shape[:-1])
    points = np.broadcast_to(points, (*batch, *points.shape[-2:]))
    if criterion != "G" and base.kind == "line":
        raise UsageError(
            f'a line as secondary or tertiary datum is by least squares; leave "{criterion}" out of datum_criterion.'
        )
    if about is not None:
        return _turning(base, axis, about, points, criterion, inside)
    start = FittedElement(base.kind, base.point, axis, base.sizes, base.residuals, base.normals)
    start = _broadcast(start, batch)
    if criterion == "G":
        return gauss(base.kind, points, start, fixed_axis=axis)
    association = associate(base.kind, criterion, points, start, fixed_axis=axis, inside=inside, judged=False)
    return association.element


def normal_matrix(fitted: FittedElement, points: Array) -> Array:
    """Return M (6 + s, 6 + s) of one fit and its points (n, 3): sum of squares per shift (mm), turn about its point (rad), sizes; outer frame."""
    element = element_of(fitted.kind)
    axis = fitted.axis if element.has_axis else np.array([0.0, 0.0, 1.0])
    frame = frames(axis)
    arms = points - fitted.point
    local = (frame @ arms.T)[None]
    rows = []
    for _, direction, partials in rows_of(element, local, fitted.sizes[None]):
        n = np.stack([np.broadcast_to(c, (1, len(points)))[0] for c in direction], axis=-1) @ frame
        s = [np.broadcast_to(p, (1, len(points)))[0] for p in partials]
        rows.append(np.concatenate([-n, -np.cross(arms, n), *(p[:, None] for p in s)], axis=1))
    all_rows = np.concatenate(rows)
    return np.asarray(all_rows.T @ all_rows)


def at_angle(axis: Array, about: Array, cosine: Array | float, sine: Array | float) -> Array:
    """Return the direction (..., 3) at an angle to `about` that is nearest to `axis`."""
    beside = axis - np.sum(axis * about, axis=-1, keepdims=True) * about
    size = np.linalg.norm(beside, axis=-1, keepdims=True)
    return np.asarray(cosine * about + sine * beside / np.maximum(size, 1e-300))


def _by_matrix(base: FittedElement, axis: Array, about: Array | None) -> FittedElement:
    """Return the element from the matrix of the fit: shifts and sizes follow the turn w = base.axis x axis, which is smallest in w^T S w,
    where S is the matrix less their contribution.
    """
    batch = np.broadcast_shapes(
        base.point.shape[:-1], axis.shape[:-1], () if about is None else about.shape[:-1]
    )
    factor, axis = _broadcast(base, batch), np.broadcast_to(axis, (*batch, 3))
    if base.moments is None:
        return replace(factor, axis=axis)
    tilts, others = np.arange(3, 6), np.r_[0:3, 6 : len(base.moments)]
    mixed, moments = base.moments[np.ix_(others, tilts)], base.moments[np.ix_(others, others)]
    size = np.sqrt(np.diag(moments))
    size[:3] = size[
        :3
    ].max()  # one scale for lengths: the way along an axis that is off by rounding stays free
    scale = np.where(size > 0.0, size, 1.0)
    gain = (
        -(np.linalg.pinv(moments / np.outer(scale, scale), rcond=1e-9) @ (mixed / scale[:, None]))
        / scale[:, None]
    )
    if about is not None:
        rest = base.moments[np.ix_(tilts, tilts)] + mixed.T @ gain
        axis = _easiest(factor.axis, axis, about, rest)
    change = np.cross(factor.axis, axis) @ gain.T
    return replace(
        factor, point=factor.point + change[..., :3], axis=axis, sizes=factor.sizes + change[..., 3:]
    )


def _easiest(free: Array, axis: Array, about: Array, rest: Array) -> Array:
    """Return the direction (..., 3) at the angle of `axis` to `about` with the least w^T rest w of its turn w from the free one."""
    cosine = np.sum(axis * about, axis=-1, keepdims=True)
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    for _ in range(TURNS):
        turn, way = np.cross(free, axis), np.cross(free, np.cross(about, axis))
        pull, stiff = (np.sum((v @ rest) * way, axis=-1, keepdims=True) for v in (turn, way))
        axis = axis - pull / np.maximum(stiff, 1e-300) * np.cross(about, axis)
        axis = at_angle(axis, about, cosine, sine)
    return axis


def _broadcast(fitted_element: FittedElement, batch: tuple[int, ...]) -> FittedElement:
    if fitted_element.point.shape[:-1] == batch:
        return fitted_element
    shaped = (
        np.broadcast_to(a, (*batch, a.shape[-1]))
        for a in (fitted_element.point, fitted_element.axis, fitted_element.sizes)
    )
    point, axis, sizes = shaped
    return replace(fitted_element, point=point, axis=axis, sizes=sizes)


@dataclass(frozen=True)
class _Turning(ContactProblem):
    """A problem whose element turns about the third axis of the data only, at one angle to it.

    Motions: those of `free` that are no tilts, then that turn.
    """

    cosine: float = 0.0
    sine: float = 1.0

    def at(self, data: Array, state: State) -> Local:
        local, frame = to_local(data, state)
        d, jac, _ = jacobian(self.element, (*self.free, RX, RY), local, state.sizes)
        k = len(self.free)
        share = frame[:, :2, 2]  # the third axis in the frame of the element
        turn = np.einsum("bk,bkm->bm", share, jac[:, k : k + 2])[:, None]
        parts = [jac[:, :k], turn, jac[:, k + 2 :]] if self.goal.has_size else [jac[:, :k], turn]
        return Local(self.goal.sign * d, self.goal.sign * np.concatenate(parts, axis=1), local, frame)

    def move(self, state: State, frame: Array, step: Array) -> State:
        k, s = len(self.free), len(self.element.sizes)
        sizes = step[:, k + 1 :] if self.goal.has_size else np.zeros((len(step), s))
        tilts = step[:, k, None] * frame[:, :2, 2]
        full = np.concatenate([step[:, :k], tilts, sizes], axis=1)
        out = move_state(self.element, (*self.free, RX, RY), state, frame, full)
        up = np.broadcast_to([0.0, 0.0, 1.0], out.axis.shape)
        return seat(self.element, out._replace(axis=at_angle(out.axis, up, self.cosine, self.sine)))


def _turning(
    base: FittedElement, axis: Array, about: Array, points: Array, criterion: str, inside: bool
) -> FittedElement:
    """Fit the element that turns about one direction, by its points (..., n, 3)."""
    element = element_of(base.kind)
    batch, n = points.shape[:-2], points.shape[-2]
    fitted_element = _broadcast(base, batch)
    flat = points.reshape(-1, n, 3)
    axes, ways = (np.broadcast_to(a, (*batch, 3)).reshape(-1, 3) for a in (axis, about))
    frame = frames(ways)
    data, centroid, scale = centre_points(flat)
    data = frame @ data
    unit = np.where(np.array(element.lengths, dtype=bool), scale, 1.0)
    turn = lambda v: np.einsum("bij,bj->bi", frame, v)  # noqa: E731
    back = lambda v: np.einsum("bji,bj->bi", frame, v)  # noqa: E731
    begin = State(
        turn((fitted_element.point.reshape(-1, 3) - centroid) / scale),
        turn(axes),
        fitted_element.sizes.reshape(len(flat), -1) / unit,
    )
    cosine = float(np.sum(axes[0] * ways[0]))
    free = tuple(j for j in element.pose if j not in (RX, RY))
    goal = _goal(element.kind, criterion, inside)
    problem = _Turning(element, free, goal, cosine, float(np.sqrt(max(1.0 - cosine * cosine, 0.0))))
    if criterion == "G":
        state, done = _least_squares(problem, data, begin)
    else:
        middle = _least_squares(problem, data, begin)[0]
        if criterion == "X":  # off the saddle between two opposite points, as in vcmm.part.fit.criteria
            form = np.ptp(problem.at(data, middle).d, axis=-1)[:, None]
            middle = middle._replace(point=middle.point + NUDGE * form * turn(np.tile(ASIDE, (len(flat), 1))))
        settled_state = settle(problem, data, middle)
        state, done = settled_state.state, settled_state.is_done | settled_state.is_lost
        if not goal.has_size:
            state = state._replace(sizes=state.sizes + goal.sign * settled_state.level[:, None])
    check_convergence(element, done, f"{base.kind} as a secondary datum")
    local, local_axis = to_local(data, state)
    residuals, normals = signed_residuals(rows_of(element, local, state.sizes), local_axis, local[:, 0].shape)
    outward = np.einsum("bji,bnj->bni", frame, normals)
    parts = (
        back(state.point) * scale + centroid,
        back(state.axis),
        state.sizes * unit,
        residuals * scale,
        outward,
    )
    point, shown, sizes, left, normals = (a.reshape((*batch, *a.shape[1:])) for a in parts)
    return FittedElement(base.kind, point, shown, sizes, left, normals)


def _goal(kind: str, criterion: str, inside: bool) -> ContactGoal:
    if criterion in ("G", "C"):
        return ContactGoal(two_sided=True, has_size=True)
    if criterion == "T" and kind not in ROUND:
        return ContactGoal(has_size=True, tangent=True, sign=-1.0 if inside else 1.0)
    return ContactGoal(sign=-1.0 if criterion == "X" else 1.0)


def _least_squares(problem: _Turning, data: Array, start: State) -> tuple[State, Mask]:
    """Solve by Gauss-Newton from the free element, which is near."""
    problem = replace(problem, goal=ContactGoal(two_sided=True, has_size=True))
    state, done = seat(problem.element, start), np.zeros(len(data), dtype=bool)
    for _ in range(STEPS):
        at = problem.at(data, state)
        matrix = at.jac @ at.jac.swapaxes(-1, -2)
        lift = 1e-15 * np.einsum("bii->b", matrix)[:, None, None] * np.eye(matrix.shape[-1])
        step = np.linalg.solve(matrix + lift, -(at.jac @ at.d[..., None]))[..., 0]
        state = problem.move(state, at.frame, np.where(done[:, None], 0.0, step))
        done = done | (np.abs(step).max(axis=-1) <= CONVERGED_SHARE * magnitude(state))
        if done.all():
            break
    return state, done
