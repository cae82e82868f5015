"""Reversals of a turning axis: separate the errors of axis and artefact by several set-ups, order by order.

    reading(set-up, probe, q) = sense * (axial(q) + arm . tilt(q))  +  artefact(q - index)  +  mounting  +  noise

q angle of the axis. The error motions are those that a sensor with a fixed direction sees (ISO 230-7: fixed sensitive
direction). Everything is periodic, so that every order k of undulations per turn is a small linear problem of its own:

    direct       one set-up, the artefact taken as perfect
    donaldson    radial: artefact and probe turned by 180 deg             reading = a + m, a - m
    face         two probes, on the axis and at the arm; artefact and outer probe turned by 180 deg
    multi-step   the artefact turned by the angle that the set-up names (one step: two set-ups), the probe stays

What no set-up tells apart is not made up: `separate_errors` says of every error and order whether it is identified.
Sources: Donaldson, CIRP Annals 21 (1972) 125; Estler, Evans, Shao, Precision Engineering 20 (1997) 187; Marsh, Precision Spindle
Metrology, 2nd ed. (2010), ch. 5; Gao et al. and eq. 9, 10 of the X-C-Z paper for the face.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.run import Array
from vcmm.task.instruments.reversal_turns import Complex, TurnGroup

NORMAL, REVERSED = "normal", "reversed"
TESTS = ("direct", "donaldson", "face", "multi-step")
ARTEFACT = "artefact"
RANK = 1e-9
LEAST_SCATTER_SHARE = 1e-6  # of the largest coefficient: readings that repeat better are made up or rounded, and still need a weight
LEAST_SCATTER, STATED_NOISE_DOF = 1e-15, 1e9  # mm or rad; degrees of freedom of a stated noise
ON_AXIS = 1e-3  # of the longest arm: a probe nearer than this sees no artefact


@dataclass(frozen=True)
class ReversalTest:
    """test: one of TESTS. error: what the probe sees of the axis (EXC, EZC ...); tilt: of a face test (EBC, EAC), else "".

    arms: probe -> mm from the axis in the set-up `normal`, signed, of a face test; a tilt of 1 rad moves the face there by
    lever * arm. sense: +1 where a reading grows with the error. u_centre: standard uncertainty of the place of the inner probe,
    mm. Raises UsageError for an unknown test and a face test without a probe on the axis and one beside it.
    """

    test: str
    error: str
    tilt: str = ""
    arms: Mapping[str, float] | None = None
    lever: float = -1.0
    sense: float = 1.0
    u_centre: float = 0.0

    def __post_init__(self) -> None:
        if self.test not in TESTS:
            raise UsageError(f'unknown test "{self.test}".{choose_from(self.test, TESTS)}')
        if self.test == "face":
            near = [p for p in self.arms or {} if self.on_axis(p)]
            if not near or len(near) == len(self.arms or {}):
                raise UsageError(
                    'a face reversal needs a probe on the axis and one beside it: write probes = { centre = "0 mm", outer = "25 mm" }'
                )

    def on_axis(self, probe: str) -> bool:
        """Return whether a probe is on the axis, where the face does not pass under it."""
        arms = self.arms or {}
        return abs(arms[probe]) <= ON_AXIS * max(abs(a) for a in arms.values())

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Names of the unknowns: errors of the axis, then the artefact."""
        axis = (self.error, self.tilt) if self.test == "face" else (self.error,)
        return axis if self.test == "direct" else (*axis, ARTEFACT)


@dataclass(frozen=True, eq=False)
class SeparationResult:
    """names (u,); value (u, K) complex, orders 1 to K: mm or rad, curve = Re sum c_k exp(i k q); zero where not identified.

    covariance (K, u, u): of the cosine (and, the same, of the sine) coefficients. identified (u, K). dof: of the scatter. condition:
    the worst of all orders, unknowns scaled, of what is identified.
    """

    names: tuple[str, ...]
    value: Complex
    covariance: Array
    is_identified: np.ndarray
    dof: float
    condition: float = 1.0

    def curve(self, name: str, angle: Array, orders: Sequence[int] | None = None) -> Array:
        """Return the curve of one unknown (n,) at angles (n,) rad; of some orders only (default: all)."""
        kept = self.value[self.names.index(name)].copy()
        if orders is not None:
            kept[[k for k in range(len(kept)) if k + 1 not in orders]] = 0.0
        return np.real(np.exp(1j * np.outer(angle, np.arange(1, len(kept) + 1))) @ kept)

    def u(self, name: str) -> float:
        """Return the standard uncertainty of the curve, the same at every angle: that of its identified part."""
        i = self.names.index(name)
        return float(np.sqrt(self.covariance[self.is_identified[i], i, i].sum()))

    def draw(self, rng: np.random.Generator, trials: int) -> Complex:
        """Sample coefficients (trials, u, K) about the estimate, t-distributed with dof."""
        k, u = self.covariance.shape[:2]
        size, ways = np.linalg.eigh(self.covariance)
        factor = ways * np.sqrt(np.maximum(size, 0.0))[:, None, :]
        both = rng.standard_normal((trials, 2, k, u))
        moved = np.einsum("kij,tckj->tcik", factor, both)
        scale = np.sqrt(self.dof / rng.chisquare(self.dof, size=trials))[:, None, None]
        return np.asarray(self.value + (moved[:, 0] + 1j * moved[:, 1]) * scale * self.is_identified)

    def blind(self, name: str) -> list[int]:
        """Return the orders of an unknown that are not identified."""
        return [int(k) + 1 for k in np.flatnonzero(~self.is_identified[self.names.index(name)])]


def separate_errors(test: ReversalTest, groups: Sequence[TurnGroup]) -> SeparationResult:
    """Separate the errors by least squares, order by order, weighted by the scatter of the turns of each probe.

    Raises UsageError where set-ups or probes are missing or unknown to the test.
    """
    check_setups(test, groups)
    variance, dof = variances(groups)
    orders = groups[0].coefficients.shape[1]
    u = len(test.unknowns)
    value, condition = np.zeros((u, orders), dtype=complex), 1.0
    covariance, is_known = np.zeros((orders, u, u)), np.zeros((u, orders), dtype=bool)
    for k in range(1, orders + 1):
        design = design_of(test, groups, k)
        weight = 1.0 / np.sqrt(variance[:, k - 1])
        read = np.array([g.coefficients[:, k - 1].mean() for g in groups])
        scale = np.abs(design).max(axis=0)
        left, size, right = np.linalg.svd((design / scale) * weight[:, None], full_matrices=False)
        kept = size > RANK * size[0]
        condition = max(condition, float(size[0] / size[kept][-1]))
        hidden = np.eye(design.shape[1]) - right[kept].conj().T @ right[kept]
        inverse = (right[kept].conj().T / size[kept]) @ left[:, kept].conj().T
        solution = (inverse @ (read * weight)) / scale
        spread = np.real(inverse @ inverse.conj().T) / np.outer(scale, scale)
        sure = np.real(np.diag(hidden))[:u] < 1e-6
        is_known[:, k - 1], value[:, k - 1] = sure, np.where(sure, solution[:u], 0.0)
        covariance[k - 1] = spread[:u, :u] * np.outer(sure, sure)
    if test.test == "face" and test.u_centre > 0:
        i, far = test.unknowns.index(test.error), _tilt_of_face(test, groups)
        covariance[0, i, i] += (far * test.u_centre) ** 2
    return SeparationResult(test.unknowns, value, covariance, is_known, dof, condition)


def design_of(test: ReversalTest, groups: Sequence[TurnGroup], order: int) -> Complex:
    """Return the design matrix (groups, unknowns + mountings) of one order; the last columns are the position of the artefact in each set-up."""
    setups = list(dict.fromkeys(g.setup for g in groups))
    outer = list(dict.fromkeys(g.probe for g in groups if test.test == "face" and not test.on_axis(g.probe)))
    rows = np.zeros((len(groups), len(test.unknowns)), dtype=complex)
    mounting = np.zeros((len(groups), len(setups)), dtype=complex)
    for i, g in enumerate(groups):
        turned = g.setup == REVERSED
        rows[i, 0] = test.sense * (-1.0 if turned and test.test == "donaldson" else 1.0)
        arm = 1.0
        if test.test == "face":
            assert test.arms is not None
            arm = test.arms[g.probe] * (-1.0 if turned else 1.0)
            rows[i, 1] = test.sense * test.lever * arm
            rows[i, 2] = float(g.probe in outer)
        elif test.test == "donaldson":
            rows[i, 1] = 1.0
        elif test.test == "multi-step":
            rows[i, 1] = np.exp(-1j * order * np.radians(float(g.setup)))
        mounting[i, setups.index(g.setup)] = arm
    return np.concatenate([rows, mounting], axis=1) if order == 1 and _lies_anywhere(test) else rows


def _lies_anywhere(test: ReversalTest) -> bool:
    """Return whether once per turn is the position of the artefact: not of an angle about the axis (ECC), nor of a reading on the axis itself."""
    about = test.error[1] == test.error[2]
    return not about and not (test.test == "direct" and test.error[1] == "Z")


def _tilt_of_face(test: ReversalTest, groups: Sequence[TurnGroup]) -> float:
    """Return the largest once-per-turn slope of the face (rad) that an outer probe sees."""
    arms = test.arms or {}
    slopes = [abs(g.coefficients[:, 0].mean() / arms[g.probe]) for g in groups if not test.on_axis(g.probe)]
    return float(max(slopes))


def variances(groups: Sequence[TurnGroup]) -> tuple[Array, float]:
    """Return ((groups, K) variance of the mean cosine coefficient, dof): scatter of the turns, pooled over the set-ups of a probe.

    A stated noise (TurnGroup.noise_variance) is taken where there is only one turn.
    """
    out = np.zeros((len(groups), groups[0].coefficients.shape[1]))
    least = (
        max(LEAST_SCATTER_SHARE * max(float(np.abs(g.coefficients).max()) for g in groups), LEAST_SCATTER)
        ** 2
    )
    dof = np.inf
    for probe in dict.fromkeys(g.probe for g in groups):
        mine = [g for g in groups if g.probe == probe]
        free = 2.0 * sum(len(g.coefficients) - 1 for g in mine)
        if free > 0:
            squares = sum(
                (np.abs(g.coefficients - g.coefficients.mean(axis=0)) ** 2).sum(axis=0) for g in mine
            )
            dof = min(dof, free)
        for i, g in enumerate(groups):
            if g.probe == probe:
                out[i] = squares / free / len(g.coefficients) if free > 0 else g.noise_variance
    return np.maximum(out, least), (STATED_NOISE_DOF if np.isinf(dof) else dof)


def check_setups(test: ReversalTest, groups: Sequence[TurnGroup]) -> None:
    """Raises UsageError for set-ups and probes that the test does not have, or lacks."""
    setups, probes = {g.setup for g in groups}, {g.probe for g in groups}
    if test.test in ("donaldson", "face") and setups != {NORMAL, REVERSED}:
        raise UsageError(
            f'a {test.test} reversal has the set-ups "{NORMAL}" and "{REVERSED}" in the column setup; there are {_join_names(setups)}'
        )
    if test.test == "multi-step":
        wrong = [s for s in setups if not _is_number(s)]
        if wrong or len(setups) < 2:
            raise UsageError(
                "a multi-step test has in the column setup the angle in degrees by which the artefact was turned, two or more of them; "
                f"there are {_join_names(setups)}"
            )
    if test.test == "face" and probes != set(test.arms or {}):
        raise UsageError(
            f"the column instrument names the probes {_join_names(probes)}, [reversal] probes {_join_names(set(test.arms or {}))}; they must agree"
        )
    if test.test != "face" and len(probes) > 1:
        raise UsageError(
            f"a {test.test} test has one probe; the column instrument names {_join_names(probes)}"
        )


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False


def _join_names(names: set[str]) -> str:
    return " and ".join(f'"{n}"' for n in sorted(names)) or "none"
