"""Compute the pose of the part from its measured features: 3-2-1 alignments and datum systems, batched over trials.

    scheme = Alignment(plane="top", line="front", origin="bore")
    part_from_measured = align(scheme, features, fitted)

3-2-1. The fitted normal (or axis) of `plane` is turned onto its nominal direction; about that direction the
part is turned until the direction of `line` (a plane's normal, an axis, or the way from one feature to a
second) agrees with nominal; then it is shifted until `plane`, `origin` and, where these leave freedom, `line`
lie where the drawing puts them. A plane holds one coordinate, its height; an axis holds two, a centre three;
each feature only fixes what the ones before left free. An axis that pierces the plane is located there.

A datum system (ISO 5459) has one order for turning and shifting: primary, secondary, tertiary. Each datum is associated anew
with the orientation that those before it give: a secondary axis drawn square to the primary plane is square to it, however
the bore leans. A direction, or the way to a datum from an earlier one, turns the part as long as a turn is free.
Freedom that no feature holds follows `start`, the rough pose; without `start` an error names the freedom.

Directions must be signed as in the drawing (a fit that starts from nominal does this); with `start` they are
turned over where they oppose it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.pose import Array, Pose, dot, length, triad, unit
from vcmm.part.fit import FittedElement
from vcmm.part.fit import hold_axis as held_by
from vcmm.part.part import FEATURE_KINDS, Feature, Shape, centre, frame

AXES = ("line", "cylinder", "cone")
FitAgain = Callable[[str, Array, Array | None], Shape]  # name, axis, direction about which it may turn
PARALLEL = 0.02  # sine below which two directions count as parallel, about 1 deg


@dataclass(frozen=True)
class Alignment:
    """Names for a 3-2-1 alignment (see the docstring of the module). `line` takes one feature, or two to join."""

    plane: str
    line: str | tuple[str, ...] = ()
    origin: str | tuple[str, ...] = ()

    @property
    def features(self) -> tuple[str, ...]:
        """Names of all features of the alignment."""
        return (self.plane, *_names(self.line), *_names(self.origin))


@dataclass(frozen=True, eq=False)
class _Pair:
    """A nominal feature and what was fitted to it."""

    nominal: Feature
    shape: Shape
    gauge: bool = False  # of a cone: it also holds the place along its axis where it has its nominal diameter


@dataclass(frozen=True, eq=False)
class _Direction:
    """A direction as measured (..., 3) and as drawn (3,)."""

    measured: Array
    nominal: Array


def align(
    scheme: Alignment, features: Mapping[str, Feature], fitted: Mapping[str, Shape], start: Pose | None = None
) -> Pose:
    """Return part_from_measured of a 3-2-1 alignment, batched like the fitted elements.

    UsageError: an unknown name, a feature without direction, freedom left without `start`.
    """
    primary = _pair(scheme.plane, features, fitted)
    line = [_pair(name, features, fitted) for name in _names(scheme.line)]
    origin = [_pair(name, features, fitted) for name in _names(scheme.origin)]
    first = _direction(primary, start)
    if len(line) > 2:
        raise UsageError(f"line takes one feature, or two whose connection is the line, not {len(line)}.")
    second = _connection(primary, line) if len(line) == 2 else [_direction(pair, start) for pair in line]
    if line and not _square_to(second, primary.nominal.axis):
        raise UsageError(
            f'"{line[0].nominal.name}" is parallel to "{scheme.plane}"; name another feature for the line.'
        )
    return _pose(primary, first, second, [primary, *origin, *line], start)


def datum_system(
    datums: str | Sequence[str],
    features: Mapping[str, Feature],
    fitted: Mapping[str, Shape],
    start: Pose | None = None,
    again: FitAgain | None = None,
) -> Pose:
    """Return part_from_measured of a datum system (ISO 5459): primary, secondary, tertiary datum.

    again(name, axis, about): a datum associated anew with a given axis, or with the angle of that axis to `about`; without it
    the fitted ones turn about their points. Centres have no direction: the way from one datum to the next then orients.
    """
    pairs: list[_Pair] = []
    directions: list[_Direction] = []
    away: _Pair | None = None  # the first datum from which another one can lie in a direction
    for name in _names(datums):
        pair = replace(_pair(name, features, fitted), gauge=features[name].kind == "cone")
        if _has_direction(pair) and not (
            directions and pair.nominal.kind == "circle"
        ):  # a circle has its drawn direction
            turn = _direction(pair, start)
            if directions:
                pair, turn = _restrain(pair, turn, directions, again)
            _add(directions, turn)
        pairs.append(pair)
        if pair.nominal.kind not in ("plane", "point", "line"):
            if away is not None:
                for way in _connection(pairs[0], [away, pair]):
                    _add(directions, way)
            away = away or pair
    if not directions:
        _no_direction(pairs[0], start)
    first = directions[0] if directions else _Direction(*_upright(start))
    return _pose(pairs[0], first, directions[1:], pairs, start)


def _add(directions: list[_Direction], direction: _Direction) -> None:
    """Add a direction, if it is the first or the first that is not parallel to it."""
    if not directions or (len(directions) == 1 and _sine(direction, directions[0]) > PARALLEL):
        directions.append(direction)


def _sine(a: _Direction, b: _Direction) -> float:
    return float(length(np.cross(unit(a.nominal), unit(b.nominal))))


def _no_direction(primary: _Pair, start: Pose | None) -> None:
    if start is None:
        _direction(primary, start)  # raises


def _upright(start: Pose | None) -> tuple[Array, Array]:
    assert start is not None
    up = np.array([0.0, 0.0, 1.0])
    return start.inverse().turn(up), up


def _restrain(
    pair: _Pair, direction: _Direction, directions: Sequence[_Direction], again: FitAgain | None
) -> tuple[_Pair, _Direction]:
    """Return the datum with the orientation that the directions before it give, and its own direction then."""
    first, drawn = directions[0], unit(directions[0].nominal)
    w, about = unit(first.measured), None
    along = float(direction.nominal @ drawn)
    if len(directions) == 2:
        measured_triads, wanted = _triads(w, directions[1].measured), _triads(drawn, directions[1].nominal)
        axis = np.einsum("...ji,...j->...i", measured_triads, wanted @ direction.nominal)
    else:
        across = math.sqrt(max(1.0 - along * along, 0.0))
        beside = direction.measured - dot(direction.measured, w)[..., None] * w
        axis = along * w + (across * unit(beside) if across > 1e-9 else 0.0)
        about = np.broadcast_to(w, axis.shape) if across > PARALLEL else None
    side = np.where(dot(pair.shape.axis, axis) < 0.0, -1.0, 1.0)[..., None]
    anew = (
        _turn_shape(pair.shape, side * axis, about)
        if again is None
        else again(pair.nominal.name, side * axis, about)
    )
    return replace(pair, shape=anew), _Direction(side * anew.axis, direction.nominal)


def _turn_shape(shape: Shape, axis: Array, about: Array | None) -> Shape:
    return held_by(shape, axis, about) if isinstance(shape, FittedElement) else replace(shape, axis=axis)  # type: ignore[type-var]


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


def _has_direction(pair: _Pair) -> bool:
    return FEATURE_KINDS[pair.nominal.kind].direction and pair.nominal.kind != "point"


def _direction(pair: _Pair, start: Pose | None) -> _Direction:
    if not _has_direction(pair):
        kind = pair.nominal.kind
        raise UsageError(f'"{pair.nominal.name}" is a {kind}: it has no direction; name a plane or an axis.')
    measured = pair.shape.axis
    if start is not None:
        agree = dot(start.turn_each(measured), pair.nominal.axis)
        measured = np.where(agree < 0.0, -1.0, 1.0)[..., None] * measured
    return _Direction(measured, pair.nominal.axis)


def _connection(primary: _Pair, pairs: Sequence[_Pair]) -> list[_Direction]:
    """Return the way from one feature to another, taken where they pierce the primary plane, else at their points."""
    (_, from_measured, from_drawn), (_, to_measured, to_drawn) = (_locate(primary, p, None) for p in pairs)
    if length(to_drawn - from_drawn) < 1e-9:
        return []
    return [_Direction(to_measured - from_measured, to_drawn - from_drawn)]


def _square_to(directions: Sequence[_Direction], axis: Array) -> list[_Direction]:
    """Return the directions that are not parallel to the first."""
    return [d for d in directions if length(np.cross(unit(d.nominal), axis)) > PARALLEL]


def _pose(
    primary: _Pair,
    first: _Direction,
    others: Sequence[_Direction],
    pairs: Sequence[_Pair],
    start: Pose | None,
) -> Pose:
    rotation = _rotation(primary, first, _square_to(others, unit(first.nominal)), start)
    rough = Pose(rotation, _shift(rotation, primary, pairs, None, start))
    return rough.shifted_to(_shift(rotation, primary, pairs, rough, start))


def _rotation(primary: _Pair, first: _Direction, others: Sequence[_Direction], start: Pose | None) -> Array:
    """Return the rotation that turns the measured triad of two directions onto the drawn one."""
    if others:
        second = others[0]
    elif start is not None:
        u = frame(primary.nominal)[0] if _has_direction(primary) else triad(unit(first.nominal))[0]
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
    """Return the orthonormal rows (..., 3, 3): the second direction squared to the first, their product, the first."""
    w = unit(first)
    u = unit(towards - dot(towards, w)[..., None] * w)
    w, u = np.broadcast_arrays(w, u)
    return np.stack([u, np.cross(w, u), w], axis=-2)


def _shift(
    rotation: Array, primary: _Pair, pairs: Sequence[_Pair], rough: Pose | None, start: Pose | None
) -> Array:
    """Shift (..., 3): every located feature holds, by least squares, the directions that the ones before left free."""
    shift, free = np.zeros(3), np.eye(3)  # free (3, f): directions still free
    for pair in pairs:
        rows, measured, drawn = _locate(primary, pair, rough)
        wanted = drawn - np.einsum("...ij,...j->...i", rotation, measured)
        left, size, right = np.linalg.svd(rows @ free)
        count = int((size > PARALLEL).sum())
        answer = free @ right[:count].T @ (left[:, :count] / size[:count]).T @ rows
        shift = shift + (wanted - shift) @ answer.T
        free = free @ right[count:].T
    if free.shape[1]:
        shift = shift + _free_shift(rotation, primary, free @ free.T, start)
    return np.asarray(shift)


def _free_shift(rotation: Array, primary: _Pair, free: Array, start: Pose | None) -> Array:
    """Return the shift of `start` along the directions that no feature holds: the primary point stays where `start` puts it."""
    if start is None:
        loose = np.linalg.eigh(free)[1][:, -1]
        raise UsageError(
            f"The alignment leaves the shift along {np.round(loose, 3).tolist()} free; "
            "name more features as origin, or give the rough pose of the part."
        )
    point = primary.shape.point
    return np.asarray((start.apply_each(point) - np.einsum("...ij,...j->...i", rotation, point)) @ free)


def _locate(primary: _Pair, pair: _Pair, rough: Pose | None) -> tuple[Array, Array, Array]:
    """Return the directions held (k, 3), the measured point (..., 3) that counts, and its place in the drawing (3,).

    With a `rough` pose the point of a plane or axis is the one nearest to the nominal centre of the feature.
    """
    nominal, fitted = pair.nominal, pair.shape
    plane = primary.nominal
    if nominal.kind in AXES and plane.kind == "plane" and abs(nominal.axis @ plane.axis) > 0.1:
        drawn = _pierce_plane(nominal.point, nominal.axis, plane.point, plane.axis)
        measured = _pierce_plane(fitted.point, fitted.axis, primary.shape.point, primary.shape.axis)
        return frame(plane)[:2], measured, drawn
    rows = _rows(nominal)
    if pair.gauge:
        back = (nominal.sizes[0] - fitted.sizes[..., 0]) / np.tan(fitted.sizes[..., 1])
        return frame(nominal), fitted.point + back[..., None] * fitted.axis, nominal.point
    if rough is None or nominal.kind not in ("plane", *AXES):
        return rows, fitted.point, centre(nominal)
    near = rough.inverse().apply(centre(nominal)) - fitted.point
    along = dot(near, fitted.axis)[..., None] * fitted.axis
    return rows, fitted.point + (near - along if nominal.kind == "plane" else along), centre(nominal)


def _rows(feature: Feature) -> Array:
    """Return the directions (k, 3) in which a feature locates the part: those in which its fit determines its place."""
    axes = frame(feature)
    if feature.kind in ("plane", "point"):
        return axes[2:]
    if feature.kind == "line":
        return axes[:1]
    return axes if feature.kind in ("sphere", "torus") else axes[:2]


def _pierce_plane(point: Array, axis: Array, on_plane: Array, normal: Array) -> Array:
    """Return the point (..., 3) where a line (..., 3) meets a plane (..., 3)."""
    travel = dot(on_plane - point, normal) / dot(axis, normal)
    return np.asarray(point + travel[..., None] * axis)
