"""Results and budgets of an uncertainty evaluation, as frozen values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.answer.evaluation.interval import Linear
from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.one_line import answer, first_few, of_name
from vcmm.answer.evaluation.summary import Summary
from vcmm.answer.evaluation.truth import Additive, Truth
from vcmm.core.readable import Readable, Reading, frame_of
from vcmm.core.run import Array
from vcmm.core.views import draw
from vcmm.part.gps.decision import Decision

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# why nothing is decided
BIAS_IN_REACH = "its known bias is not corrected, and with U + |bias| a limit is in reach"
SHOWN_IN = {"mm": ("µm", 1e3), "rad": ("µrad", 1e6)}


@dataclass(frozen=True)
class BudgetLine:
    """One row of the budget. estimate, u_input in `unit` (None for arrays); sensitivity: mm (rad) per `unit`; u: contribution.

    `unit` is that of files ("um/m", "degC"); u in mm or rad; `what` says the same as `input` in plain words.
    """

    input: str
    what: str
    distribution: str
    dof: float
    redraw: str
    estimate: float | None
    u_input: float | None
    unit: str
    sensitivity: float | None
    u: float
    share: float
    evidence: str
    cause: str = ""  # physical cause, where several lines have it in common


class PlottedBudget(tuple[BudgetLine, ...]):
    """The lines of a budget, with a picture."""

    def plot(self, ax: Any = None, title: str = "budget") -> Axes:
        """Plot shares of u^2, the largest first."""
        drawn: Axes = draw(self, ax, title)
        return drawn

    def to_dataframe(self, library: str | None = None) -> Any:
        """Return the lines as a data frame of pandas or polars; u in mm or rad, share of u^2."""
        return frame_of([vars(line) for line in self], library)


def common_causes(budget: Sequence[BudgetLine]) -> dict[str, tuple[float, tuple[str, ...]]]:
    """Return physical cause -> (share of u^2, names of its lines), for those that more than one line has."""
    out: dict[str, tuple[float, tuple[str, ...]]] = {}
    for line in budget:
        if line.cause:
            share, names = out.get(line.cause, (0.0, ()))
            out[line.cause] = (share + line.share, (*names, line.input))
    return {cause: entry for cause, entry in out.items() if len(entry[1]) > 1}


CLOSED_BARS = 80  # of the picture of a closed form
ROUNDING = 5e-4  # of u^2: less is printed as 0.0 %
LEAST_U = 1e-6  # mm or rad: no shares are stated for a u below a nanometre


def budget_interaction(c: CharacteristicResult) -> float:
    """Return the interaction of the inputs as a share of u^2: 1 less the shares of the lines; 0 where that is rounding.

    A line is the standard deviation with one input alone, the others held at their estimates (JCGM 101:2008, Annex B); only of a
    linear output do the squares add to u^2 (JCGM 100, 5.1.2).
    """
    share = c.interaction_share
    matters = c.u >= LEAST_U and math.isfinite(share) and abs(share) > ROUNDING
    return share if matters else 0.0


@dataclass(frozen=True)
class TrueValue:
    """Statement about the true value beside the indicated one, mm. is_claimed: whether the interval was shown to hold it;
    counted_coverage: the share of sampled parts in which it did, and the share of parts of another kind. interval_u: standard uncertainty of
    its two ends from the number of draws, None where that is not known.
    """

    estimate: float
    interval: tuple[float, float]
    is_claimed: bool
    counted_coverage: tuple[float, float] | None = None
    interval_u: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class CharacteristicResult:
    """Result of one characteristic; lengths in mm, angles in rad (`unit`).

    value: what the machine indicates with all errors at their estimates, less the bias when `corrected` and less the mean
    of laws that have one; of a part still to be cut what is expected of it, the mean of its law; mean: of all trials, departs from the value where noise alone moves an extreme value; bias:
    indicated value minus what a machine without errors would indicate at the same points (ISO 15530 reports it apart), of an
    extreme value minus the estimate of the true one, which is what the interval takes off (NaN where the points bound nothing).
    U, k and interval hold a bias that is left in (`bias_in_U`): U = k_p u + |bias| (JCGM 100, F.2.4.5).
    interval and decision are about the true value, given that `indicated` was read; `truth` says the same of any reading
    (vcmm.answer.evaluation.indication.at_indication).
    """

    name: str
    type: str
    unit: str
    nominal: float
    value: float
    mean: float
    bias: float
    corrected: bool
    u: float
    k: float
    p: float
    interval: tuple[float, float]
    interval_kind: str
    coverage_shown: bool
    extreme: bool  # an extreme value or root, or curved over its own spread: noise moves it one way
    tolerance: tuple[float, float] | None
    decision: Decision | None
    budget: PlottedBudget
    interaction_share: float
    tier: str
    trials: int
    linear_error: float
    summary: Summary | None
    indicated: float = float("nan")
    one_sided: bool = False  # the lower limit is a bound of nature
    why_not_shown: str = ""  # why the coverage is not demonstrated; empty where it is
    truth: Truth | None = None
    half_width: float | None = (
        None  # U of a part that is off as far as it may be, where U depends on the true value
    )
    true_value: TrueValue | None = None  # of extreme values
    filtered: str = ""  # filter, cut-off and tip radius with which a form is stated
    production: tuple[float, float] | None = (
        None  # mean from the middle of the tolerance, and u, of what the process makes
    )

    not_covered: tuple[str, ...] = ()  # what the claim does not hold for, in sentences

    def __repr__(self) -> str:
        return f"<{self.name}: {answer(self)}>"

    @property
    def bias_in_U(self) -> float:
        """|bias|, mm or rad, where a known bias is left in the value and U holds it; else 0."""
        return abs(self.truth.bias) if isinstance(self.truth, Additive) else 0.0

    @property
    def expanded(self) -> float:
        """U: half the width of the coverage interval; of an extreme value that of parts off as far as the zone allows."""
        if self.half_width is not None:
            return self.half_width
        return (self.interval[1] - self.interval[0]) / 2

    @property
    def stated(self) -> tuple[float, float]:
        """U and k as a result states them: NaN where the interval of the true value has no end, so that value +- U would be misleading.
        u and `expanded` then still give the uncertainty that the machine adds, by which places and plans are compared.

        u and `expanded` then still say what the machine adds: by them places and plans are compared.
        """
        if not all(map(math.isfinite, self.interval)):
            return math.nan, math.nan
        return self.expanded, self.k

    def plot(self, ax: Any = None) -> Axes:
        """Plot the distribution of the trials as deviation from nominal (um or urad), with the coverage interval and the limits."""
        drawn: Axes = draw(self, ax)
        return drawn


def closed_form(c: CharacteristicResult) -> tuple[Array, Array]:
    """Return the edges and the probabilities between them by the law of the true value (or of the part to come), where no trials were run."""
    law = c.truth.of(c.indicated) if isinstance(c.truth, Additive) else getattr(c.truth, "law", None)
    if not isinstance(law, Linear) or not (0.0 < c.u < math.inf):
        return np.zeros(1), np.zeros(0)
    edges = law.mean + c.u * np.linspace(-4.0, 4.0, CLOSED_BARS + 1)
    return edges, np.diff(law.cdf(edges)).clip(0.0)


class Budgets(dict[str, PlottedBudget]):
    """The budget of each characteristic by its name."""

    def plot(self) -> list[Axes]:
        """Plot one picture below the other."""
        drawn: list[Axes] = draw(self)
        return drawn

    def to_dataframe(self, library: str | None = None) -> Any:
        """Return all lines as one data frame of pandas or polars, with the characteristic that each belongs to."""
        return frame_of(
            [{"characteristic": c, **vars(b)} for c, lines in self.items() for b in lines], library
        )


@dataclass(frozen=True, eq=False)
class UncertaintyResult(Readable):
    """All characteristics of a task. trials: the number requested; each result states the number used."""

    characteristics: tuple[CharacteristicResult, ...]
    trials: int
    seed: int
    warnings: tuple[str, ...]
    model: LinearModel
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        return f"<UncertaintyResult: {first_few(f'{c.name} {answer(c)}' for c in self.characteristics)}>"

    def __getitem__(self, name: str) -> CharacteristicResult:
        """Return the characteristic of this name. KeyError: none has it."""
        return of_name(self.characteristics, name)

    @property
    def budget(self) -> Budgets:
        """The budgets by characteristic."""
        return Budgets((c.name, c.budget) for c in self.characteristics)

    def plot(self) -> list[Axes]:
        """Plot distribution, coverage interval and limits of every characteristic, one below the other."""
        drawn: list[Axes] = draw(self)
        return drawn
