"""Doubts from measured points about the assumptions of their evaluation, and the claims that they withdraw.

Check the facets of a mesh as nominal shape: report their share in a profile where it is not small.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.inversion import TrueValueByBelt
from vcmm.answer.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.answer.inference.given_points import GivenPoints
from vcmm.answer.inference.residual_tests import ALARM, MOST_FORM_POINTS, Ints, Memory, Outlier, ResidualTests
from vcmm.answer.inference.rounding import coarse, leading, said_of_digits, step_of
from vcmm.core.run import Array
from vcmm.part.fit import FittedElement
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.pointwise import PROFILE
from vcmm.part.mesh import sag_at
from vcmm.part.part import Characteristic
from vcmm.task.measuring.task import Task

LARGEST = 100_000  # touches beyond which residuals are not tested: their nulls would take gigabytes
MOST_NAMED = 5  # outliers named in one reason
IN_FRAME = ("position", *gps.PROFILE)  # evaluated in the frame of the alignment
NOT_TESTED = "the residuals of {n} points were not tested for outliers and memory (at most {most}): coverage rests on your own look at them"
ORDER_NOT_TESTED = (
    'the order of the {n} points of "{feature}" was not tested for noise with memory (at most {most} points of a feature are): if '
    "neighbouring points err alike, U is too small; take fewer points"
)
OUTLIER = (
    '{where}: this point of "{feature}" lies {size:.3g} um {side} what the other points say of its place, p = {p}: touch it again, '
    "clean the surface, or remove the row, and evaluate again; until then nothing is claimed of what needs {feature}"
)
MEMORY = (
    "the residuals go on from touch to touch as no form of the default families explains (correlation {rho:g}, p = {p}): the "
    "{n} points tell as much as {effective:.0f} independent ones; {cure}"
)
CURE = "state what drifts ([[inputs]] with another redraw), scan more slowly, or take points in another order and evaluate again"


@dataclass(frozen=True)
class Doubts:
    """notes: sentences for the result; features: per feature why claims that need it are withdrawn; all: why all are; digits: why those
    are in which the digits of the file contribute most.
    """

    notes: tuple[str, ...] = ()
    features: Mapping[str, str] | None = None
    all: str = ""
    digits: str = ""

    def reasons(self, task: Task, result: UncertaintyResult) -> dict[str, str]:
        """Return, by name of a characteristic, why its coverage may not be claimed."""
        out = {}
        for c, r in zip(task.part.characteristics, result.characteristics):
            named = (
                [self.features[n] for n in _features_needed(task, c) if n in self.features]
                if self.features
                else []
            )
            why = [*dict.fromkeys(named), self.all, self.digits if leading(r) > 0.0 else ""]
            if any(why):
                out[c.name] = "; ".join(w for w in why if w)
        return out


def _features_needed(task: Task, c: Characteristic) -> list[str]:
    """Return the features whose points a characteristic depends on, its frame among them."""
    scheme = task.plan.alignment
    frame = scheme.features if scheme is not None and c.type in IN_FRAME else ()
    return list(dict.fromkeys([*gps.needs(c), *frame]))


def doubts_of(
    tests: ResidualTests,
    task: Task,
    elements: tuple[Array, Mapping[str, FittedElement]],
    given: tuple[GivenPoints, Ints],
    result: UncertaintyResult,
) -> Doubts:
    """Return the doubts. elements: measured points (n, 3) of the touches and the elements through them; given: the file, and its row of every touch."""
    digits, step = coarse(task.machine), step_of(task.machine)
    notes = [w for r in result.characteristics for w in said_of_digits(r, step)]
    n = task.touches.run.n
    if n > LARGEST:
        return Doubts(
            (*notes, NOT_TESTED.format(n=n, most=LARGEST)),
            all=f"its {n} points were not tested",
            digits=digits,
        )
    long = [(name, f.n) for name, f in tests.features.items() if f.n > MOST_FORM_POINTS]
    notes += [ORDER_NOT_TESTED.format(n=count, feature=name, most=MOST_FORM_POINTS) for name, count in long]
    residuals = {name: outward(task, name, *elements) for name in tests.features}
    outliers = tests.outliers(residuals, step)
    order = {name: np.argsort(given[1][task.touches.rows[name]], kind="stable") for name in tests.features}
    memory = tests.memory(residuals, order)
    lines = [_of_outlier(o, given, task, tests) for o in outliers]
    lost = {
        name: _reason(name, [o for o in outliers if o.feature == name], given, task)
        for name in dict.fromkeys(o.feature for o in outliers)
    }
    why = ""
    if memory is not None and memory.p <= ALARM:
        why = _of_memory(memory, max(f.n for f in tests.features.values() if f.n <= MOST_FORM_POINTS), tests)
    return Doubts((*notes, *lines), lost, why, digits)


def outward(task: Task, name: str, points: Array, fitted: Mapping[str, FittedElement]) -> Array:
    """Return residuals (n,) of a feature, mm outwards; of a surface of nominal points its departures from nominal."""
    t, rows = task.touches, task.touches.rows[name]
    element = fitted.get(name)
    if task.part.features[name].free or element is None or len(element.residuals) != len(rows):
        return np.asarray(((points[rows] - t.points[rows]) * t.normals[rows]).sum(axis=1))
    side = np.sign((element.normals * t.normals[rows]).sum(axis=1))
    return np.asarray(element.residuals * np.where(side == 0.0, 1.0, side))


def _at(o: Outlier, given: tuple[GivenPoints, Ints], task: Task) -> str:
    return given[0].where[int(given[1][task.touches.rows[o.feature][o.place]])]


def _of_outlier(o: Outlier, given: tuple[GivenPoints, Ints], task: Task, tests: ResidualTests) -> str:
    side = "outside" if o.size > 0 else "inside"
    return OUTLIER.format(
        where=_at(o, given, task), feature=o.feature, size=abs(o.size) * 1e3, side=side, p=_p(o.p, tests)
    )


def _reason(name: str, outliers: list[Outlier], given: tuple[GivenPoints, Ints], task: Task) -> str:
    lines = [_at(o, given, task).rpartition(":")[2] for o in outliers]
    many = f"{', '.join(lines[:MOST_NAMED])}{f' and {len(lines) - MOST_NAMED} more' if len(lines) > MOST_NAMED else ''}"
    word = "line" if len(lines) == 1 else "lines"
    return f'points of "{name}" contradict the others ({word} {many}): outliers are to be dealt with first'


def _of_memory(memory: Memory, n: int, tests: ResidualTests) -> str:
    return MEMORY.format(rho=memory.rho, p=_p(memory.p, tests), n=n, effective=memory.effective(n), cure=CURE)


def _p(p: float, tests: ResidualTests) -> str:
    """Return the p value as text; the least p value of a Monte Carlo test is that of its draws: "below" it."""
    least = 1.0 / (tests.draws + 1)
    return f"{p:.2g}" if p > 1.5 * least else f"{least:.2g} or less"


def without_claim(r: CharacteristicResult, doubts: Mapping[str, str] | None) -> CharacteristicResult:
    """Return the result, without claimed coverage where there are doubts."""
    why = (doubts or {}).get(r.name, "")
    if not why:
        return r
    if isinstance(r.truth, TrueValueByBelt):
        return replace(r, truth=replace(r.truth, limit="; ".join(w for w in (r.truth.limit, why) if w)))
    both = "; ".join(w for w in (r.why_not_shown, why) if w)
    return replace(r, coverage_shown=False, why_not_shown=both)


FACET_SHARE_OF_LIMIT = 0.1
"""Share of U or the tolerance, the smaller: an unseen bias of a tenth of U makes an interval for 95 % miss in 5.5 % (docs/uncertainty.md)."""


def coarse_mesh(task: Task, results: Sequence[CharacteristicResult]) -> tuple[str, ...]:
    """Return one sentence for each profile to which the facets at its points may add more than `FACET_SHARE_OF_LIMIT`. task: with the measured places.

    A profile is twice the largest distance, so a sag adds up to twice itself.
    """
    out = []
    for c, result in zip(task.part.characteristics, results):
        names = [n for n in c.of if task.part.features[n].kind == "mesh"] if c.type in PROFILE else []
        limits = [result.expanded, *(result.tolerance[1:] if result.tolerance else ())]
        least = FACET_SHARE_OF_LIMIT * min((x for x in limits if np.isfinite(x) and x > 0.0), default=0.0)
        for name in names:
            assert task.part.mesh is not None  # Part has seen to it
            sag = float(sag_at(task.part.mesh, task.touches.points[task.touches.rows[name]]).max())
            if 2.0 * sag > least:
                out.append(_mesh_remark(result, name, sag, least))
    return tuple(out)


def _mesh_remark(c: CharacteristicResult, name: str, sag: float, least: float) -> str:
    against = f"U = {c.expanded * 1e3:.3g} um"
    if c.tolerance:
        against += f", the tolerance {c.tolerance[1] * 1e3:.3g} um"
    finer = f"with a chord tolerance of {least / 2 * 1e3:.2g} um" if least else "with a finer chord tolerance"
    return (
        f'{c.name}: the mesh is coarse where "{name}" was touched: a smooth surface would stand up to {sag * 1e3:.3g} um off its facets '
        f"(chord times turn / 8), which alone adds up to {2 * sag * 1e3:.3g} um to the {c.type} and is not in U ({against}); "
        f"export the mesh {finer}"
    )
