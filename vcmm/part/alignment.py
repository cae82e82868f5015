"""Where the part lies, from what was measured on it: 3-2-1 and datum systems; batched over trials.

    scheme = Alignment(plane="top", line="front", origin="bore")
    part_from_measured = align(scheme, features, fitted)

3-2-1. The fitted normal (or axis) of `plane` is turned onto its nominal direction; about that direction the
part is turned until the direction of `line` (a plane's normal, an axis, or the way from one feature to a
second) agrees with nominal; then it is shifted until `plane`, `origin` and, where these leave freedom, `line`
lie where the drawing puts them. A plane holds one coordinate, its height; an axis holds two, a centre three;
each feature only fixes what the ones before left free. An axis that pierces the plane is located there.

A datum system (ISO 5459) is the same with one order for turning and shifting: primary, secondary, tertiary.
Freedom that nothing holds follows `start`, the rough pose; without it that is an error, by name.

Directions must be signed as in the drawing (a fit that starts from nominal does this); with `start` they are
turned over where they oppose it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.pose import Array, Pose, dot, length, unit
from vcmm.part.part import KINDS, Feature, Shape, centre, frame

AXES = ("line", "cylinder", "cone")
PARALLEL = 0.02  # sine below which two directions count as parallel, about 1 deg


@dataclass(frozen=True)
class Alignment:
    """Names for a 3-2-1 alignment (see the head of the module). `line` takes one feature, or two to join."""

    plane: str
    line: str | tuple[str, ...] = ()
    origin: str | tuple[str, ...] = ()

    @property
    def features(self) -> tuple[str, ...]:
        """All that it names."""
        return (self.plane, *_names(self.line), *_names(self.origin))


@dataclass(frozen=True, eq=False)
class _Pair:
    """A nominal feature and what was fitted to it."""

    nominal: Feature
    fitted: Shape


@dataclass(frozen=True, eq=False)
class _Direction:
    """A direction as measured (..., 3) and as drawn (3,)."""

    measured: Array
    nominal: Array


def align(
    scheme: Alignment, features: Mapping[str, Feature], fitted: Mapping[str, Shape], start: Pose | None = None
) -> Pose:
    """part_from_measured of a 3-2-1 alignment, batched like the fitted elements.

    UsageError: an unknown name, a feature without direction, freedom left without `start`.
    """
    primary = _pair(scheme.plane, features, fitted)
    line = [_pair(name, features, fitted) for name in _names(scheme.line)]
    origin = [_pair(name, features, fitted) for name in _names(scheme.origin)]
    first = _direction(primary, start)
    if len(line) > 2:
        raise UsageError(f"line takes one feature, or two whose connection is the line, not {len(line)}.")
    second = _connection(primary, line) if len(line) == 2 else [_direction(pair, start) for pair in line]
    if line and not _square_to(second, primary):
        raise UsageError(
            f'"{line[0].nominal.name}" is parallel to "{scheme.plane}"; name another feature for the line.'
        )
    return _pose(primary, first, second, [primary, *origin, *line], start)


def datum_system(
    datums: str | Sequence[str],
    features: Mapping[str, Feature],
    fitted: Mapping[str, Shape],
    start: Pose | None = None,
) -> Pose:
    """part_from_measured of a datum system (ISO 5459, least squares): primary, secondary, tertiary datum.

    The first datum needs a direction. Two axes or centres also orient, by the way from one to the other.
    """
    pairs = [_pair(name, features, fitted) for name in _names(datums)]
    directions = [_direction(pair, start) for pair in pairs[1:] if _directed(pair)]
    located = [pair for pair in pairs if pair.nominal.kind not in ("plane", "point", "line")]
    if len(located) > 1:
        directions += _connection(pairs[0], located[:2])
    return _pose(pairs[0], _direction(pairs[0], start), directions, pairs, start)


def _names(names: str | Sequence[str]) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else tuple(names)


def _pair(name: str, features: Mapping[str, Feature], fitted: Mapping[str, Shape]) -> _Pair:
    if name not in features:
        raise UsageError(f'The alignment names the unknown feature "{name}".{choose_from(name, features)}')
    if name not in fitted:
        raise UsageError(
            f'The alignment needs "{name}", which is not measured; add a step for it to the plan.'
        )
    return _Pair(features[name], fitted[name])


def _directed(pair: _Pair) -> bool:
    return KINDS[pair.nominal.kind].direction and pair.nominal.kind != "point"


def _direction(pair: _Pair, start: Pose | None) -> _Direction:
    if not _directed(pair):
        kind = pair.nominal.kind
        raise UsageError(f'"{pair.nominal.name}" is a {kind}: it has no direction; name a plane or an axis.')
    measured = pair.fitted.axis
    if start is not None:
        agree = dot(start.turn_each(measured), pair.nominal.axis)
        measured = np.where(agree < 0.0, -1.0, 1.0)[..., None] * measured
    return _Direction(measured, pair.nominal.axis)


def _connection(primary: _Pair, pairs: Sequence[_Pair]) -> list[_Direction]:
    """The way from one feature to another, taken where they pierce the primary plane, else at their
    points.
    """
    (_, from_measured, from_drawn), (_, to_measured, to_drawn) = (_located(primary, p, None) for p in pairs)
    if length(to_drawn - from_drawn) < 1e-9:
        return []
    return [_Direction(to_measured - from_measured, to_drawn - from_drawn)]


def _square_to(directions: Sequence[_Direction], primary: _Pair) -> list[_Direction]:
    """Those that are not parallel to the primary direction."""
    axis = primary.nominal.axis
    return [d for d in directions if length(np.cross(unit(d.nominal), axis)) > PARALLEL]


def _pose(
    primary: _Pair,
    first: _Direction,
    others: Sequence[_Direction],
    held: Sequence[_Pair],
    start: Pose | None,
) -> Pose:
    rotation = _rotation(primary, first, _square_to(others, primary), start)
    rough = Pose(rotation, _shift(rotation, primary, held, None, start))
    return rough.shifted_to(_shift(rotation, primary, held, rough, start))


def _rotation(primary: _Pair, first: _Direction, others: Sequence[_Direction], start: Pose | None) -> Array:
    """Turns the measured triad of two directions onto the drawn one."""
    if others:
        second = others[0]
    elif start is not None:
        u = frame(primary.nominal)[0]
        second = _Direction(start.inverse().turn(u), u)
    else:
        name = primary.nominal.name
        raise UsageError(
            f'The alignment leaves the turn about the direction of "{name}" free; name a line for it, '
            "or give the rough pose of the part."
        )
    drawn, measured = _triads(first.nominal, second.nominal), _triads(first.measured, second.measured)
    return np.asarray(np.swapaxes(drawn, -1, -2) @ measured)


def _triads(first: Array, towards: Array) -> Array:
    """Orthonormal rows (..., 3, 3): the second direction squared to the first, their product, the first."""
    w = unit(first)
    u = unit(towards - dot(towards, w)[..., None] * w)
    w, u = np.broadcast_arrays(w, u)
    return np.stack([u, np.cross(w, u), w], axis=-2)


def _shift(
    rotation: Array, primary: _Pair, held: Sequence[_Pair], rough: Pose | None, start: Pose | None
) -> Array:
    """Shift (..., 3): every located feature holds the directions that the ones before left free."""
    basis: list[Array] = []
    values: list[Array] = []
    for pair in held:
        rows, measured, drawn = _located(primary, pair, rough)
        wanted = drawn - np.einsum("...ij,...j->...i", rotation, measured)
        for row in rows:
            rest = row - sum((row @ q * q for q in basis), np.zeros(3))
            size = float(length(rest))
            if size > PARALLEL:
                known = sum((row @ q * value for q, value in zip(basis, values)), np.zeros(()))
                basis.append(rest / size)
                values.append((dot(wanted, row) - known) / size)
    shift = np.asarray(sum((value[..., None] * q for q, value in zip(basis, values)), np.zeros(3)))
    if len(basis) == 3:
        return shift
    free = np.eye(3) - sum((np.outer(q, q) for q in basis), np.zeros((3, 3)))
    return shift + _free_shift(rotation, primary, free, start)


def _free_shift(rotation: Array, primary: _Pair, free: Array, start: Pose | None) -> Array:
    """What `start` says of the directions that no feature holds: the primary point stays where it puts it."""
    if start is None:
        loose = np.linalg.eigh(free)[1][:, -1]
        raise UsageError(
            f"The alignment leaves the shift along {np.round(loose, 3).tolist()} free; "
            "name more features as origin, or give the rough pose of the part."
        )
    point = primary.fitted.point
    return np.asarray((start.apply_each(point) - np.einsum("...ij,...j->...i", rotation, point)) @ free)


def _located(primary: _Pair, pair: _Pair, rough: Pose | None) -> tuple[Array, Array, Array]:
    """Directions held (k, 3), the measured point (..., 3) that counts, and where the drawing has it (3,).

    With a `rough` pose the point of a plane or axis is the one nearest to the nominal centre of the feature.
    """
    nominal, fitted = pair.nominal, pair.fitted
    plane = primary.nominal
    if nominal.kind in AXES and plane.kind == "plane" and abs(nominal.axis @ plane.axis) > 0.1:
        drawn = _pierced(nominal.point, nominal.axis, plane.point, plane.axis)
        measured = _pierced(fitted.point, fitted.axis, primary.fitted.point, primary.fitted.axis)
        return frame(plane)[:2], measured, drawn
    rows = _rows(nominal)
    if rough is None or nominal.kind not in ("plane", *AXES):
        return rows, fitted.point, centre(nominal)
    near = rough.inverse().apply(centre(nominal)) - fitted.point
    along = dot(near, fitted.axis)[..., None] * fitted.axis
    return rows, fitted.point + (near - along if nominal.kind == "plane" else along), centre(nominal)


def _rows(feature: Feature) -> Array:
    """Directions (k, 3) in which a feature locates the part: what its fit determines of its place."""
    axes = frame(feature)
    if feature.kind in ("plane", "point"):
        return axes[2:]
    if feature.kind == "line":
        return axes[:1]
    return axes if feature.kind in ("sphere", "torus") else axes[:2]


def _pierced(point: Array, axis: Array, on_plane: Array, normal: Array) -> Array:
    """Where a line (..., 3) meets a plane (..., 3)."""
    travel = dot(on_plane - point, normal) / dot(axis, normal)
    return np.asarray(point + travel[..., None] * axis)
