"""Errors of a fit and their messages: too few points, undetermined directions, no convergence."""

from __future__ import annotations

import math

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError, choose_from
from vcmm.part.fit.elements import ELEMENTS, RX, TX, TZ, Array, Element, Mask, free_pose

# Singular value of the scaled Jacobian, relative to the largest, below which a motion counts as undetermined:
# 1 nm in the points would move the element by 10 mm per 1 mm of extent.
RANK = 1e-7

_CURE = {
    "point": "measure it at least once",
    "line": "the points must not all lie at one place",
    "plane": "add points beside the line on which they lie",
    "circle": "the points must not lie on a straight line and must span an arc",
    "sphere": "add points off the circle on which they lie",
    "cylinder": "spread the points around the axis and over at least two levels along it",
    "cone": "spread the points around the axis and over at least two levels along it",
    "torus": "spread the points around the ring and around the tube",
}


def element_of(kind: str) -> Element:
    """Return the element called `kind`; raises UsageError with the allowed words otherwise."""
    if kind not in ELEMENTS:
        raise UsageError(f'"{kind}" is not an element that can be fitted.{choose_from(kind, ELEMENTS)}')
    return ELEMENTS[kind]


def check_points(element: Element, points: Array, axis_is_fixed: bool, name: str) -> None:
    """Raise UsageError: wrong shape, NaN, an axis that the element does not have. ModelLimit: too few points."""
    if points.ndim < 2 or points.shape[-1] != 3:
        raise UsageError(f"{name}: points must have the shape (..., n, 3), got {points.shape}.")
    if 0 in points.shape[:-2]:
        raise UsageError(f"{name}: the batch {points.shape[:-2]} is empty. Give at least one set of points.")
    if axis_is_fixed and not element.has_axis:
        raise UsageError(f"{name}: fixed_axis makes no sense, a {element.kind} has no axis. Leave it out.")
    n, unknowns = points.shape[-2], len(free_pose(element, axis_is_fixed)) + len(element.sizes)
    least = math.ceil(unknowns / element.rows)
    if n < least:
        axis_text = " with a fixed axis" if axis_is_fixed and element.kind != "circle" else ""
        plural = "" if least == 1 else "s"
        raise ModelLimit(
            f"{name}{axis_text} needs at least {least} point{plural}, got {n}. Measure more points."
        )
    finite = np.isfinite(points)
    if not finite.all():
        where = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise UsageError(f"{name}: coordinate {where} is not a finite number. Leave that point out.")


def check_spread(element: Element, points: Array, axis_is_fixed: bool, name: str) -> None:
    """Raise ModelLimit when points (B, n, 3) of a cylinder, cone or torus all lie in one plane: several fit as well."""
    if axis_is_fixed or element.kind not in ("cylinder", "cone", "torus"):
        return
    arm = points - points.mean(axis=-2, keepdims=True)
    extent = np.linalg.eigvalsh(np.swapaxes(arm, -1, -2) @ arm)
    flat = np.flatnonzero(~(extent[..., 0] > RANK**2 * extent[..., -1]))
    if len(flat):
        raise ModelLimit(
            f"{name}: all points lie in one plane{_of_fits(len(flat), len(extent))}; more than one "
            f"{element.kind} passes through them. Cure: {_CURE[element.kind]}."
        )


def check_convergence(element: Element, done: Mask, name: str) -> None:
    """Raise ModelLimit when members of the batch (B,) did not reach a minimum."""
    if done.all():
        return
    bad = np.flatnonzero(~done)
    raise ModelLimit(
        f"{name}: {len(bad)} of {len(done)} fits did not converge (the first is number {bad[0]}): the points "
        f"have no clear best {element.kind}, which may slide or turn without a change, or lie far from where it is sought. "
        f"Cure: {_CURE[element.kind]}."
    )


def check_rank(element: Element, free: tuple[int, ...], matrix: Array, frame: Array, name: str) -> None:
    """Raise ModelLimit naming the undetermined direction when a normal matrix (B, p, p), scaled, lacks rank.

    frame (B, 3, 3): rows are the element frames, to name directions in the coordinates of the points.
    """
    values = np.linalg.eigvalsh(matrix)
    bad = np.flatnonzero(~(values[:, 0] > RANK**2 * values[:, -1]))
    if len(bad) == 0:
        return
    first = bad[0]
    vector = np.linalg.eigh(matrix[first])[1][:, 0]
    raise ModelLimit(
        f"{name}: the points do not determine {_direction(element, free, vector, frame[first])}"
        f"{_of_fits(len(bad), len(matrix))}. Cure: {_CURE[element.kind]}."
    )


def _of_fits(bad: int, all_of_them: int) -> str:
    """Return how many fits of a batch are affected, as text; empty for a single fit."""
    return "" if all_of_them == 1 else f" (in {bad} of {all_of_them} fits)"


def _direction(element: Element, free: tuple[int, ...], vector: Array, frame: Array) -> str:
    """Describe a null vector (p,) in words: every part that holds a good share of it."""
    motion = np.zeros(6)
    motion[list(free)] = vector[: len(free)]
    shift, turn, sizes = motion[TX : TZ + 1], motion[RX:], vector[len(free) :]
    parts = [(float(np.linalg.norm(shift)), f"the position along {_words(shift @ frame)}")]
    tilt = "direction of the line" if element.kind == "line" else f"tilt of the {element.kind}"
    parts += [(float(np.linalg.norm(turn)), f"the {tilt} about {_words(turn @ frame)}")]
    parts += [(abs(float(s)), f"the {label}") for s, label in zip(sizes, element.sizes)]
    largest = max(weight for weight, _ in parts)
    return " together with ".join(text for weight, text in parts if weight > 0.3 * largest)


def _words(direction: Array) -> str:
    """Return a direction as text, '(1.000, 0.000, 0.000)', with its largest component positive."""
    length = float(np.linalg.norm(direction))
    unit = direction / length if length > 0.0 else direction
    unit = unit * np.copysign(1.0, unit[np.argmax(np.abs(unit))]) + 0.0
    return "(" + ", ".join(f"{c:.3f}" for c in np.where(np.abs(unit) < 5e-4, 0.0, unit)) + ")"
