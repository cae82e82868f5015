"""What an effect says of itself beside its formula: how large it usually is, its words, its prior, what it belongs to.

Everything here has a default, so an effect says only what is special about it, as class attributes and, where behaviour
differs, by one of the methods of `Declared`. Diagnosis, files, reports and jobs ask for these and never for a name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from vcmm.core.run import Array, Run

UM, URAD, HOUR = 1e-3, 1e-6, 3600.0  # in mm, rad, s
PLAY = 50 * URAD  # of an axis that turns: worm and gear drives 5-30 arcsec, direct drives less, arms to 60

OWNERS = ("machine", "tool", "setup", "part")


@dataclass(frozen=True)
class Typical:
    """How large one element of a linear parameter is when it matters, and where the figure comes from.

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
    """What an answer means at the machine: what is seen, what usually causes it, what confirms it.

    {where} is the place, {axis}, {direction} ... a place field, {gap} ... a parameter with its unit under the name that
    reports use. signed: parameters shown with their sign; of the others the size is shown.
    """

    seen: str
    causes: str
    confirm: str
    signed: tuple[str, ...] = ()
    opposite: Opposite | None = None


@dataclass(frozen=True)
class Prior:
    """How probable an effect is before anything was recorded, beside the equal share that every name has.

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
    """Where candidates are placed: the machine's own effects, the axes on the side of part and tool, the recorded rows."""

    effects: tuple[Any, ...]
    work: tuple[str, ...]
    tool: tuple[str, ...]
    run: Run


class Declared:
    """Declarations of an effect, all with defaults.

    family             the effect that it is a second shape of, and reported as
    belongs_to         one of OWNERS: who answers for it in a budget
    words, prior       see Words and Prior
    diagnosed          whether diagnosis may name it; not the forms of a stored table nor what setting up may err by
    needs_cut          it shows in recordings of cut parts only
    special_case_of    effects that hold every motion of this one, whatever is recorded: of two the simpler counts
    kin                word for the physics that it shares with names of fewer or more numbers ("play"): a diagnosis sums their
                       probability at one place
    holds_table_edits  every edit of a stored table of one axis is a special case of it
    simple             its one number is the same wherever it is looked at; a curve that is mostly that is called so
    free_curve         a freely shaped curve over its axis, which says nothing beyond the rows it was fitted to
    as_one             the one number that stands for an array: "rms", "sd", or for the length "amplitude", "arm" and, where
                       its elements are named too, the parameter itself
    several            it moves several directions at once: its forms are tried from the first, and the first counts of which
                       every number shows
    one_sided          its one linear number is never negative: a square, a length
    taken_up           parameter that is a way lost at a reversal: nearer to it rows may stand on either side
    over_raw_scale     periodic over the raw reading of the scale where that was recorded
    stored             parameter that holds the numbers of a stored error table
    calibrated         one of the errors that a calibration finds and states anew: its only parameter
    made_by            what makes it in a file, where no [[effects]] table can state it
    random             drawn anew again and again: its value is never known
    along_axis         its lengths lie along its `axis`, and are angles where that turns
    on_cut_part        a reading that acts on a part cut and measured later: "turned" (sign turned) or "stated" (as it is)
    over_volume        stated over workpiece axes, known with rotary axes at zero only
    of_qualification   what the qualification of a stylus may err by
    independent_draws  what must be said where its elements are drawn independently
    """

    family: ClassVar[str] = ""
    belongs_to: ClassVar[str] = "machine"
    words: ClassVar[Words | None] = None
    prior: ClassVar[Prior] = Prior()
    diagnosed: ClassVar[bool] = True
    needs_cut: ClassVar[bool] = False
    special_case_of: ClassVar[tuple[str, ...]] = ()
    kin: ClassVar[str] = ""
    holds_table_edits: ClassVar[bool] = False
    simple: ClassVar[bool] = False
    free_curve: ClassVar[bool] = False
    as_one: ClassVar[str] = "rms"
    several: ClassVar[bool] = False
    one_sided: ClassVar[bool] = False
    taken_up: ClassVar[str] = ""
    over_raw_scale: ClassVar[bool] = False
    stored: ClassVar[str] = ""
    calibrated: ClassVar[bool] = False
    made_by: ClassVar[str] = ""
    random: ClassVar[bool] = False
    along_axis: ClassVar[bool] = False
    on_cut_part: ClassVar[str] = ""
    over_volume: ClassVar[bool] = False
    of_qualification: ClassVar[bool] = False
    independent_draws: ClassVar[str] = ""

    @classmethod
    def placed(cls, place: Mapping[str, Any], site: Site) -> Any:
        """The effect at one place, with what it takes from stored tables, travel or chain. Raises UsageError where it
        cannot sit there.
        """
        return cls(**place)

    def told_by(self, run: Run) -> bool:
        """Whether these rows can tell it from something simpler."""
        return True

    def weighted_trials(self, name: str) -> list[tuple[dict[str, Any], float]] | None:
        """Changes to try for the field `name`, each with its ln weight; None = the declared tries."""
        return None

    def reported(self, values: Array) -> tuple[str, Array, str] | None:
        """(name, values, unit) under which its one linear parameter, values (n,), is reported; None = as it is."""
        return None

    def remark(self, run: Run) -> str:
        """What must be said beside an answer on this run; "" for nothing."""
        return ""

    def elements(self) -> tuple[str, ...]:
        """Names of the elements of its array, where each says something by itself: "x", "y". The length then is `as_one`."""
        return ()

    def said_in_file(self) -> str:
        """What a reader of a machine file must know of it; "" for nothing."""
        return ""

    def known_range(self) -> tuple[KnownRange, ...]:
        """Where a tabulated effect is known; outside it refuses."""
        return ()

    def own_nodes(self) -> Array | None:
        """Positions (k,) of the stored numbers over its own axis; None where it is no table over one axis."""
        return None

    def covariance(self) -> Array | None:
        """Covariance of the elements of its parameter where the effect fixes it itself; None where an Input says it."""
        return None

    def qualified(self, spheres: Mapping[str, Any]) -> Any:
        """The effect as seen through a qualification on these spheres (stylus -> sphere); itself where it is not seen."""
        return self
