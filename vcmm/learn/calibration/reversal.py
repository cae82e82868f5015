"""Reversals to errors with covariance: errors that each file separates, those that it cannot, and the machine file of all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.learn.calibration.identifiability import Combination
from vcmm.task.instruments.reversal import ARTEFACT, ReversalTest, SeparationResult, separate_errors
from vcmm.task.instruments.reversal_line import (
    PLACE,
    LineScan,
    SquarenessReversal,
    StraightnessReversal,
    squareness_reversal,
    straightness_reversal,
)
from vcmm.task.instruments.reversal_turns import TurnGroup

CIRCLE = np.linspace(0.0, 2 * np.pi, 360, endpoint=False)


@dataclass(frozen=True, eq=False)
class ReversalFile:
    """One test: error such as EZX, B0C, EXC; axis; scans of a line test, or test and groups of a turning one.

    lever, axis_tilt (rad): of a half turn. u: stated noise of a reading, mm or rad, or None.
    """

    name: str
    kind: str
    error: str
    axis: str
    sense: float
    u: float | None
    scans: tuple[LineScan, ...] = ()
    lever: float = -1.0
    axis_tilt: float = 0.0
    test: ReversalTest | None = None
    groups: tuple[TurnGroup, ...] = ()


@dataclass(frozen=True, eq=False)
class ReversalResult:
    """One file separated: exactly one of straight, square, turning. scatter: rms between repeats, mm or rad.

    with_straight, with_tilt: of a half turn, whether straightness and tilt motion were taken off.
    """

    file: ReversalFile
    scatter: float
    straight: StraightnessReversal | None = None
    square: SquarenessReversal | None = None
    turning: SeparationResult | None = None
    with_straight: bool = False
    with_tilt: bool = False

    @property
    def errors(self) -> tuple[str, ...]:
        """Errors of the machine that the test measures."""
        return (
            (self.file.error,)
            if self.turning is None
            else tuple(n for n in self.turning.names if n != ARTEFACT)
        )

    def rows(self) -> list[Mapping[str, object]]:
        """Return one row per error: size and standard uncertainty, um or urad."""
        out: list[Mapping[str, object]] = []
        for name in self.errors:
            scale = 1e6 if _is_angle(name) else 1e3
            row: dict[str, object] = {"error": name, "unit": "urad" if _is_angle(name) else "um"}
            if self.square is not None:
                out.append(row | {"value": self.square.angle * scale, "u": self.square.u * scale})
                continue
            if self.straight is not None:
                curve, u = self.straight.machine, float(np.sqrt((self.straight.u**2).mean()))
            else:
                assert self.turning is not None
                curve, u = self.turning.curve(name, CIRCLE), self.turning.u(name)
            out.append(
                row | {"low": float(curve.min() * scale), "high": float(curve.max() * scale), "u": u * scale}
            )
        return out

    @property
    def condition(self) -> float:
        """Largest condition of the equations, of the identified part; 1 of a plain reversal."""
        return 1.0 if self.turning is None else self.turning.condition

    def document(self) -> dict[str, object]:
        """Return everything of one file, um and urad: curves of machine and artefact, or the angles of a half turn."""
        out: dict[str, object] = {"recording": self.file.name, "test": self.file.kind}
        if self.straight is not None:
            s = self.straight
            curves = {"artefact_um": s.artefact, "machine_um": s.machine, "u_um": s.u}
            return out | {
                "place_mm": s.nodes.tolist(),
                "dof": s.dof,
                **{k: (v * 1e3).tolist() for k, v in curves.items()},
            }
        if self.square is not None:
            q = self.square
            return out | {
                "angle_urad": q.angle * 1e6,
                "artefact_urad": q.flat * 1e6,
                "u_urad": q.u * 1e6,
                "dof": q.dof,
            }
        assert self.turning is not None
        orders = {name: self._orders(name) for name in self.turning.names}
        return out | {
            "dof": self.turning.dof,
            "orders": orders,
            "turns": [_turns(g) for g in self.file.groups],
        }

    def _orders(self, name: str) -> list[dict[str, object]]:
        """Return cosine and sine of every order, um or urad; null where not identified."""
        assert self.turning is not None
        t, i = self.turning, self.turning.names.index(name)
        scale = 1e6 if _is_angle(name) or self.file.error[1] in "ABC" else 1e3
        return [
            {
                "order": k + 1,
                "cos": float(c.real * scale),
                "sin": float(-c.imag * scale),
                "u": float(np.sqrt(v) * scale),
            }
            if sure
            else {"order": k + 1, "cos": None, "sin": None, "u": None}
            for k, (c, v, sure) in enumerate(zip(t.value[i], t.covariance[:, i, i], t.is_identified[i]))
        ]

    @property
    def combinations(self) -> tuple[Combination, ...]:
        """Errors that the test cannot separate, in words."""
        if self.straight is not None:
            return (_of(self.file.error, "line", _STRAIGHT.format(error=self.file.error)),)
        if self.square is not None:
            error, words = self.file.error, []
            if not self.with_straight:
                words.append(_HALF_SLOPE.format(error=error, axis=self.file.axis))
            if not self.with_tilt:
                words.append(_HALF_TURN.format(error=error))
            return tuple(_of(error, "constant", text) for text in words)
        assert self.turning is not None
        out = []
        for name in self.errors:
            blind = self.turning.blind(name)
            if 1 in blind:
                out.append(
                    _of(
                        name,
                        "1 per turn",
                        _ONCE_PER_TURN.format(
                            error=name, artefact=_lying(self.file.test.test if self.file.test else "")
                        ),
                    )
                )
            if more := [k for k in blind if k > 1]:
                orders = ", ".join(map(str, more))
                out.append(_of(name, f"{orders} per turn", _CLOSED.format(orders=orders, error=name)))
        if self.file.kind == "direct":
            out.append(_of(self.file.error, "artefact", _DIRECT.format(error=self.file.error)))
        return tuple(out)


_STRAIGHT = "{error}: its slope cannot be told from how the straightedge lies along the axis; it is squareness, to be measured apart"
_HALF_TURN = "{error}: the mean tilt motion of the turning axis at both angles is in it; give a face reversal with it, or state axis_tilt"
_HALF_SLOPE = "{error}: the slope that EZ{axis} has over the scanned part is in it; give a straightness reversal with it that covers the scans"
_ONCE_PER_TURN = "{error}: once per turn cannot be told from {artefact}, which every set-up has anew"
_CLOSED = "{error}: {orders} per turn cannot be told from the artefact, which looks the same in all positions of the test"
_DIRECT = "{error}: the artefact is taken as perfect; a reversal (donaldson, multi-step) separates it"


def _turns(group: TurnGroup) -> dict[str, object]:
    return {
        "setup": group.setup,
        "probe": group.probe,
        "turns": len(group.coefficients),
        "dropped": group.incomplete,
    }


def _lying(test: str) -> str:
    return "the tilt of the artefact on the axis" if test == "face" else "the artefact off the centre"


def _of(name: str, shape: str, text: str) -> Combination:
    return Combination(((name, shape, 1.0),), text)


def _is_angle(name: str) -> bool:
    return name[:1] in "ABC" or name[1:2] in "ABC"


def separate(file: ReversalFile, beside: Sequence[ReversalResult] = ()) -> ReversalResult:
    """Separate machine and artefact of one file. beside: results from which a half turn takes the straightness and the tilt motion.

    Raises UsageError, naming the file, for set-ups that are missing or too few repeats.
    """
    try:
        if file.kind == "straightness":
            separation = straightness_reversal(file.scans, file.sense, file.u)
            return ReversalResult(file, separation.scatter, straight=separation)
        if file.kind == "half-turn":
            return _half_turn(file, beside)
        assert file.test is not None
        left = [g.plot - g.plot.mean(axis=0) for g in file.groups]
        scatter = float(np.sqrt(np.mean([(x**2).mean() for x in left])))
        return ReversalResult(file, scatter, turning=separate_errors(file.test, file.groups))
    except UsageError as error:
        raise UsageError(f"{file.name}: {error}") from None


def separate_all(files: Sequence[ReversalFile]) -> list[ReversalResult]:
    """Separate every file, in their order; half turns with the results of the others for the same axes. Raises UsageError for two of one error."""
    others = [separate(f) for f in files if f.kind != "half-turn"]
    apart = iter(others)
    results = [separate(f, others) if f.kind == "half-turn" else next(apart) for f in files]
    check_apart(results)
    return results


def _half_turn(file: ReversalFile, beside: Sequence[ReversalResult]) -> ReversalResult:
    """Separate a half turn: straightness is subtracted from the scans and tilt motion from the angle, with their uncertainty, where they
    are known."""
    scans, tilt, more = file.scans, file.axis_tilt, 0.0
    straight = next((o.straight for o in beside if o.straight and o.file.error == f"EZ{file.axis}"), None)
    is_covered = straight is not None and _covers(straight, file.scans)
    if straight is not None and is_covered:
        scans = tuple(replace(s, value=s.value - file.sense * _on(straight, s.place)) for s in scans)
        weights = _slope(scans[0].place) @ _interpolation(straight.nodes, scans[0].place)
        more += float(weights @ straight.covariance @ weights)
    axis = file.error[2:]
    name = f"E{file.error[0]}{axis}"
    turning = next((o.turning for o in beside if o.turning and name in o.turning.names), None)
    if turning is not None and not tilt:
        i = turning.names.index(name)
        tilt = float(turning.curve(name, np.array([0.0, np.pi])).mean())
        more += float(turning.covariance[1::2, i, i].sum())  # odd orders cancel
    square = squareness_reversal(scans, -file.lever * file.sense, file.u, tilt)
    square = replace(square, u=float(np.hypot(square.u, np.sqrt(more))))
    return ReversalResult(file, square.u, square=square, with_straight=is_covered, with_tilt=bool(tilt))


def _covers(straight: StraightnessReversal, scans: Sequence[LineScan]) -> bool:
    low, high = straight.nodes[0] - PLACE, straight.nodes[-1] + PLACE
    return all(low <= float(s.place.min()) and float(s.place.max()) <= high for s in scans)


def _on(straight: StraightnessReversal, place: Array) -> Array:
    return np.interp(place, straight.nodes, straight.machine)


def _interpolation(nodes: Array, place: Array) -> Array:
    """Return the values at the places from those at the nodes, as (n, k)."""
    return np.stack([np.interp(place, nodes, unit) for unit in np.eye(len(nodes))], axis=1)


def _slope(place: Array) -> Array:
    """Return weights (n,) of the least-squares slope."""
    way = place - place.mean()
    return np.asarray(way / float((way**2).sum()))


def check_apart(results: Sequence[ReversalResult]) -> None:
    """Raises UsageError where two files find the same error."""
    first: dict[str, str] = {}
    for result in results:
        for name in result.errors:
            if name in first:
                raise UsageError(
                    f"{first[name]} and {result.file.name} both find {name}; give one of them (repeats belong into one file, by run)"
                )
            first[name] = result.file.name


def turning_input(separation: SeparationResult, name: str) -> tuple[Array, Array]:
    """Return ((2 K,) cosine and sine of each order in turn, (2 K, 2 K) covariance): the coefficients of a rotary_cyclic effect.

    Raises UsageError for an error of which nothing is identified.
    """
    i = separation.names.index(name)
    if not separation.is_identified[i].any():
        raise UsageError(f"of {name} no order is identified")
    value = np.stack([separation.value[i].real, -separation.value[i].imag], axis=1).ravel()
    return value, np.diag(np.repeat(separation.covariance[:, i, i], 2))


def spans(results: Sequence[ReversalResult]) -> dict[str, tuple[float, float]]:
    """Return linear axis -> its known part, mm: the length of its straightness, else the scan of a half turn."""
    out: dict[str, tuple[float, float]] = {}
    for result in sorted(results, key=lambda r: r.straight is None):
        places = [s.place for s in result.file.scans] if result.straight is None else [result.straight.nodes]
        if places and result.file.axis not in out:
            out[result.file.axis] = (min(float(p.min()) for p in places), max(float(p.max()) for p in places))
    return out


def turning_axes(results: Sequence[ReversalResult]) -> set[str]:
    """Return the axes whose error motions were seen in fixed directions."""
    return {
        result.file.axis for result in results if result.turning is not None and is_rotary(result.file.axis)
    }


def student_variance(dof: float) -> float:
    """Return the variance of Student's law over its squared scale, dof / (dof - 2): an Input has a normal law. Three degrees are the fewest."""
    return dof / (dof - 2.0) if dof > 2.0 else 3.0
