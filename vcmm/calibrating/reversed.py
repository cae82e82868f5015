"""Reversals to errors with covariance: what each file separates, what it cannot, and the machine file of all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.calibrating.identified import Combination
from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.files.reversal import ReversalFile
from vcmm.instruments.reversal import ARTEFACT, Separated, separated
from vcmm.instruments.reversal_line import (
    SquarenessReversal,
    StraightnessReversal,
    squareness_reversal,
    straightness_reversal,
)
from vcmm.instruments.reversal_turns import TurnGroup

CIRCLE = np.linspace(0.0, 2 * np.pi, 360, endpoint=False)


@dataclass(frozen=True, eq=False)
class ReversalResult:
    """One file separated: exactly one of straight, square, turning. scatter: rms between repeats, mm or rad."""

    file: ReversalFile
    scatter: float
    straight: StraightnessReversal | None = None
    square: SquarenessReversal | None = None
    turning: Separated | None = None

    @property
    def errors(self) -> tuple[str, ...]:
        """Errors of the machine that the test is about."""
        return (
            (self.file.error,)
            if self.turning is None
            else tuple(n for n in self.turning.names if n != ARTEFACT)
        )

    def rows(self) -> list[Mapping[str, object]]:
        """One row per error: size and standard uncertainty, um or urad."""
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
        """Largest condition of the equations, of what they identify; 1 of a plain reversal."""
        return 1.0 if self.turning is None else self.turning.condition

    def document(self) -> dict[str, object]:
        """Everything of one file, um and urad: curves of machine and artefact, or the angles of a half turn."""
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
        """Cosine and sine of every order, um or urad; null where not identified."""
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
            for k, (c, v, sure) in enumerate(zip(t.value[i], t.covariance[:, i, i], t.identified[i]))
        ]

    @property
    def combinations(self) -> tuple[Combination, ...]:
        """What the test cannot tell apart, in words."""
        if self.straight is not None:
            return (_of(self.file.error, "line", _STRAIGHT.format(error=self.file.error)),)
        if self.square is not None:
            return (
                ()
                if self.file.axis_tilt
                else (_of(self.file.error, "constant", _HALF_TURN.format(error=self.file.error)),)
            )
        assert self.turning is not None
        out = []
        for name in self.errors:
            blind = self.turning.blind(name)
            if 1 in blind:
                out.append(
                    _of(
                        name,
                        "1 per turn",
                        _ONCE.format(
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
_HALF_TURN = "{error}: the mean tilt motion of the turning axis at both angles is in it; where a face reversal knows that, state axis_tilt"
_ONCE = "{error}: once per turn cannot be told from {artefact}, which every set-up has anew"
_CLOSED = "{error}: {orders} per turn cannot be told from the artefact, which looks the same in all positions of the test"
_DIRECT = "{error}: the artefact is taken as perfect; a reversal (donaldson, multi-step) separates it"


def _turns(group: TurnGroup) -> dict[str, object]:
    return {
        "setup": group.setup,
        "probe": group.probe,
        "turns": len(group.coefficients),
        "dropped": group.dropped,
    }


def _lying(test: str) -> str:
    return "the tilt of the artefact on the axis" if test == "face" else "the artefact off the centre"


def _of(name: str, shape: str, text: str) -> Combination:
    return Combination(((name, shape, 1.0),), text)


def _is_angle(name: str) -> bool:
    return name[:1] in "ABC" or name[1:2] in "ABC"


def separate(file: ReversalFile) -> ReversalResult:
    """Machine and artefact of one file. Raises UsageError, naming the file, for set-ups that are missing or too few repeats."""
    try:
        if file.kind == "straightness":
            found = straightness_reversal(file.scans, file.sense, file.u)
            return ReversalResult(file, found.scatter, straight=found)
        if file.kind == "half-turn":
            square = squareness_reversal(file.scans, -file.lever * file.sense, file.u, file.axis_tilt)
            return ReversalResult(file, square.u, square=square)
        assert file.test is not None
        left = [g.plot - g.plot.mean(axis=0) for g in file.groups]
        scatter = float(np.sqrt(np.mean([(x**2).mean() for x in left])))
        return ReversalResult(file, scatter, turning=separated(file.test, file.groups))
    except UsageError as error:
        raise UsageError(f"{file.name}: {error}") from None


def check_apart(found: Sequence[ReversalResult]) -> None:
    """Raises UsageError where two files find the same error."""
    first: dict[str, str] = {}
    for one in found:
        for name in one.errors:
            if name in first:
                raise UsageError(
                    f"{first[name]} and {one.file.name} both find {name}; give one of them (repeats belong into one file, by run)"
                )
            first[name] = one.file.name


def turning_input(found: Separated, name: str) -> tuple[Array, Array]:
    """((2 K,) cosine and sine of each order in turn, (2 K, 2 K) covariance): the coefficients of a rotary_cyclic effect.

    Raises UsageError for an error of which nothing is identified.
    """
    i = found.names.index(name)
    if not found.identified[i].any():
        raise UsageError(f"of {name} no order is identified")
    value = np.stack([found.value[i].real, -found.value[i].imag], axis=1).ravel()
    return value, np.diag(np.repeat(found.covariance[:, i, i], 2))


def spans(found: Sequence[ReversalResult]) -> dict[str, tuple[float, float]]:
    """Linear axis -> the part of it that is known, mm: the length of its straightness, else what a half turn scanned."""
    out: dict[str, tuple[float, float]] = {}
    for one in sorted(found, key=lambda r: r.straight is None):
        places = [s.place for s in one.file.scans] if one.straight is None else [one.straight.nodes]
        if places and one.file.axis not in out:
            out[one.file.axis] = (min(float(p.min()) for p in places), max(float(p.max()) for p in places))
    return out


def turning_axes(found: Sequence[ReversalResult]) -> set[str]:
    """Axes whose error motions were seen in fixed directions."""
    return {one.file.axis for one in found if one.turning is not None and is_rotary(one.file.axis)}
