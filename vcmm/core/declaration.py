"""Declarations of an effect beside its formula: typical size, words for reports, prior probability, owner in a budget.

Two values, all of whose fields have a default, so an effect says only what is special about it: `About` for reports, files and jobs,
`ForDiagnosis` for what diagnosis alone asks. What a few effects can do besides is a base class that those take: `WithResponse`,
`Tabulated`, `ChoosesColumns`, `SeenByQualification`. Jobs ask for these and never for the name of an effect.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array, Run

UM, URAD, HOUR = 1e-3, 1e-6, 3600.0  # in mm, rad, s
PLAY = 50 * URAD  # of an axis that turns: worm and gear drives 5-30 arcsec, direct drives less, arms to 60

OWNERS = ("machine", "tool", "setup", "part")


@dataclass(frozen=True)
class Typical:
    """Size of one element of a linear parameter when it matters, and the source of the figure.

    amount: canonical unit (mm, rad, s, N, kg and what is made of them); turn: the same for a rotation (component EA.,
    EB., EC., or along an axis that turns); most: the largest size that a machine has, 0 = 64 times the amount;
    bounds: what physics allows, canonical unit. Diagnosis takes it as the width of a prior, spread over a wide range, so it need only be right within a factor
    of a few. A `why` with arithmetic is an estimate from mechanics or optics; "usual" is an order of magnitude quoted for
    CMMs and machining centres in the literature (Slocum, Precision Machine Design, 1992; Schwenke et al., CIRP Annals 57
    (2008) 660; Weckenmann et al., CIRP Annals 53 (2004) 657; Bryan, CIRP Annals 39 (1990) 645), no limit of any standard.
    """

    amount: float
    why: str
    turn: float = 0.0
    most: float = 0.0
    bounds: tuple[float, float] | None = None


@dataclass(frozen=True)
class Opposite:
    """Words that replace the usual ones where `parameter` is negative; "" keeps the usual ones.

    rare: what the machine does then, where that sense is so rare that all readings may have the opposite sign.
    """

    parameter: str
    seen: str
    causes: str = ""
    confirm: str = ""
    rare: str = ""


@dataclass(frozen=True)
class Words:
    """Meaning of a diagnosis of the effect at the machine: its signs, its usual cause, its confirmation.

    {where} is the place, {axis}, {direction} ... a place field, {gap} ... a parameter with its unit under the name that
    reports use. signed: parameters shown with their sign; of the others the size is shown.
    """

    seen: str
    causes: str
    confirm: str
    signed: tuple[str, ...] = ()
    opposite: Opposite | None = None


@dataclass(frozen=True)
class Trade:
    """Words of the workshop: what an operator calls the effect, and what reduces its share of U, each a few words; {where} is the place.

    Where nothing is declared, the words of the parameter and the label of its `redraw` speak.
    """

    name: str = ""
    change: str = ""


@dataclass(frozen=True)
class Prior:
    """Prior probability of an effect, relative to the equal share of every name.

    share: of a second shape of a family, against the first, also where it sits at places of its own. rare_in: kinds of recording in which it is ten times rarer;
    rare_without: it is so where the recording lacks this label; rare_with: where it has this column.
    """

    share: float = 1.0
    rare_in: tuple[str, ...] = ()
    rare_without: str = ""
    rare_with: str = ""


@dataclass(frozen=True)
class KnownRange:
    """Positions along x, y or z (direction 0, 1, 2) that something allows, mm. of: "axis" positions or "tip" positions."""

    what: str
    direction: int
    low: float
    high: float
    of: str = "axis"


@dataclass(frozen=True, eq=False)
class Site:
    """Places of candidates: the machine's own effects, the axes on the side of part and tool, the recorded rows."""

    effects: tuple[Any, ...]
    work: tuple[str, ...]
    tool: tuple[str, ...]
    run: Run


def _named_at(cls: Any, place: Mapping[str, Any], site: Site) -> Any:
    """Return the effect with only the fields of its place set."""
    return cls(**place)


@dataclass(frozen=True)
class ForDiagnosis:
    """Data of an effect for the diagnosis beside its formula, all optional.

    family              the effect that it is a second shape of, and reported as
    is_named            whether diagnosis may name it; not the forms of a stored table nor what setting up may err by
    prior               see Prior
    special_case_of     effects that hold every motion of this one, whatever is recorded: of two the simpler counts
    shared_physics      word for the physics that it shares with names of fewer or more numbers ("play"): a diagnosis sums their
                        probability at one place
    holds_table_edits   every edit of a stored table of one axis is a special case of it
    is_uniform          its one number is the same wherever it is looked at; a curve that is mostly that is called so
    is_free_curve       a freely shaped curve over its axis, which says nothing beyond the rows it was fitted to
    size_name           the one number that represents an array: "rms", "sd", or for the length "amplitude", "arm" and, where
                        its elements are named too, the parameter itself
    moves_together      it moves several directions at once: its forms are tried from the first, and the first counts of which
                        every number shows
    is_never_negative   its one linear number is never negative: a square, a length
    follows_raw_scale   periodic over the raw reading of the scale where that was recorded

    Functions, of the effect first (`make_at`: of its class):

    make_at     (class, place, site): the effect at one place, with what it takes from stored tables, travel or chain. Raises
                UsageError where it cannot sit there
    shows_in    (effect, run): whether these rows can tell it from something simpler
    shows_at    (effect, run): the same of the scanned values that the effect has
    trials      (effect, name): changes to try for the field `name`, each with its ln weight; None = the declared tries
    report      (effect, values): (name, values, unit) under which its one linear parameter, values (n,), is reported; None = as it is
    remark      (effect, run): what must be said beside an answer on this run; "" for nothing
    elements    (effect): names of the elements of its array, where each says something by itself: "x", "y". The length then is
                `size_name`
    file_note   (effect): what a reader of a machine file must know of it; "" for nothing
    """

    family: str = ""
    is_named: bool = True
    prior: Prior = Prior()
    special_case_of: tuple[str, ...] = ()
    shared_physics: str = ""
    holds_table_edits: bool = False
    is_uniform: bool = False
    is_free_curve: bool = False
    size_name: str = "rms"
    moves_together: bool = False
    is_never_negative: bool = False
    follows_raw_scale: bool = False
    make_at: Callable[[Any, Mapping[str, Any], Site], Any] = _named_at
    shows_in: Callable[[Any, Run], bool] = lambda effect, run: True
    shows_at: Callable[[Any, Run], bool] = lambda effect, run: True
    trials: Callable[[Any, str], list[tuple[dict[str, Any], float]] | None] = lambda effect, name: None
    report: Callable[[Any, Array], tuple[str, Array, str] | None] = lambda effect, values: None
    remark: Callable[[Any, Run], str] = lambda effect, run: ""
    elements: Callable[[Any], tuple[str, ...]] = lambda effect: ()
    file_note: Callable[[Any], str] = lambda effect: ""


def reported_name(kind: Any) -> str:
    """Return the name of the answers of an effect or its class: that of its family."""
    return str(kind.diagnosis.family or kind.name)


@dataclass(frozen=True)
class About:
    """Data of an effect for files, reports and jobs beside its formula, all optional.

    cites            source of the formula
    words            what an answer means at the machine, see Words
    trade            what an operator calls it, and what makes its share of U smaller, see Trade
    aliases          name in files -> parameter that is kept in another, linear form
    belongs_to       one of OWNERS: who answers for it in a budget
    needs_cut        it shows in recordings of cut parts only
    gap_parameter    parameter that is a way lost at a reversal: nearer to it rows may stand on either side
    table_parameter  parameter that holds the numbers of a stored error table
    is_calibrated    one of the errors that a calibration finds and states anew: its only parameter
    is_random        drawn anew again and again: its value is never known
    along_axis       its lengths lie along its `axis`, and are angles where that turns
    on_cut_part      a reading that acts on a part cut and measured later: "turned" (sign turned) or "stated" (as it is)
    """

    cites: str = ""
    words: Words | None = None
    trade: Trade | None = None
    aliases: Mapping[str, str] = field(default_factory=dict)
    belongs_to: str = "machine"
    needs_cut: bool = False
    gap_parameter: str = ""
    table_parameter: str = ""
    is_calibrated: bool = False
    is_random: bool = False
    along_axis: bool = False
    on_cut_part: str = ""


class WithResponse:
    """An effect with an array parameter of many elements whose unit response is computed faster by a formula than by unit steps."""

    def response(self, name: str, run: Run) -> Array | None:
        """Return the unit response (n, 6, k) of an array parameter, or None to compute it by unit steps. A test compares the two."""
        return None

    def projection(self, name: str, run: Run, weights: Array) -> Array | None:
        """Sum over the six numbers of weights (n, 6) times the unit response, (n, k); None = by `response`.

        Only worth writing where that is large and nearly empty (fields of many nodes).
        """
        return None


class Tabulated:
    """An effect of stored numbers, known at some places only."""

    def known_range(self) -> tuple[KnownRange, ...]:
        """Return where the effect is known; elsewhere it raises an error."""
        return ()

    def own_nodes(self) -> Array | None:
        """Return the positions (k,) of the stored numbers over its own axis, or None where it is no table over one axis."""
        return None

    def covers(self, tip: Array) -> npt.NDArray[np.bool_] | None:
        """Return whether the effect is known at tips (n, 3), as (n,); None where `known_range` says it all."""
        return None


class ChoosesColumns:
    """An effect that needs other columns of a run than `needs` says, as its place or its parameters are."""

    def required_columns(self) -> tuple[str, ...]:
        """Return the columns that this instance needs."""
        raise NotImplementedError


class SeenByQualification:
    """A reading error that the qualification of a stylus sees too and removes in part."""

    def after_qualification(self, spheres: Mapping[str, Any]) -> Any:
        """Return the effect that remains after a qualification on these spheres (stylus -> sphere)."""
        raise NotImplementedError
