"""Results of virtual machining: deviations of the features with their uncertainty, and the surface itself."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.answer.evaluation.one_line import answer, first_few
from vcmm.answer.evaluation.result import LEAST_U, BudgetLine, CharacteristicResult, UncertaintyResult
from vcmm.answer.evaluation.truth import PredictedPart
from vcmm.core.declaration import OWNERS
from vcmm.core.readable import Readable, Reading
from vcmm.core.run import Array
from vcmm.core.views import draw
from vcmm.physics import BY_NAME
from vcmm.shop.machining.blank import Blank
from vcmm.shop.machining.grooves import CutGroove
from vcmm.shop.machining.maps import Net
from vcmm.shop.machining.recut import Recut
from vcmm.shop.machining.threads import CutThread
from vcmm.shop.machining.turned_blank import TurnedBlank

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GROUPS = (*OWNERS, "measurement")
SCATTERS = (
    "touch",
    "pass",
    "part",
    "run",
    "event",
    "clamp",
)  # drawn anew from part to part; the rest repeats in a batch


@dataclass(frozen=True, eq=False)
class Patch:
    """The cut surface over one net: height (ny nx,) mm above nominal, nan where no cutter came; with and without errors."""

    net: Net
    height: Array
    nominal: Array  # of the same program on a machine without errors


@dataclass(frozen=True)
class SurfaceExtremes:
    """Summary over all patches, um: largest and rms departure (None where no point was cut, with the reason), number of points, of those left uncut,
    and of gouges. without: features that have no net.

    A gouge is a point that the program itself, on a perfect machine, cuts deeper than `deep_um`.
    """

    max_um: float | None
    rms_um: float | None
    points: int
    uncut: int
    gouges: int
    deep_um: float
    without: tuple[str, ...] = ()

    @property
    def reason(self) -> str:
        """Why there is no figure; "" where there is one."""
        if self.max_um is not None:
            return ""
        if self.points:
            return f"the tools reach none of the {self.points} points of the nets on the features"
        return f"{', '.join(self.without) or 'the part'}: points, lines and meshes have no net to look at; what was inspected are the points of the plan"


@dataclass(frozen=True, eq=False)
class CutResult(Readable):
    """uncertainty: characteristics of the finished part; seconds: cycle time; shares: characteristic -> group -> u^2 share.

    repeats, scatters: characteristic -> standard uncertainty that all parts of a batch share, and of their differences.
    """

    uncertainty: UncertaintyResult
    surface: SurfaceExtremes
    patches: tuple[Patch, ...]
    seconds: float
    shares: Mapping[str, Mapping[str, float]]
    repeats: Mapping[str, float]
    scatters: Mapping[str, float]
    warnings: tuple[str, ...] = ()
    blank: Blank | TurnedBlank | None = None
    recut: Recut | None = None
    own_reading: UncertaintyResult | None = (
        None  # what the machine that cut the part would read of it, where it probes it
    )
    threads: tuple[CutThread, ...] = ()
    grooves: tuple[CutGroove, ...] = ()
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        return f"<CutResult: {first_few(f'{c.name} {answer(c)}' for c in self.characteristics)}>"

    def __getitem__(self, name: str) -> CharacteristicResult:
        """Return the characteristic of this name. KeyError: none has it."""
        return self.uncertainty[name]

    @property
    def characteristics(self) -> tuple[CharacteristicResult, ...]:
        return self.uncertainty.characteristics

    def plot(self, ax: Any = None) -> Axes:
        """Plot the cut surface, coloured by remaining material (+) or excess removal (-), um."""
        drawn: Axes = draw(self, ax)
        return drawn


def rms_text(surface: SurfaceExtremes) -> str:
    """Return the rms of the cut surface for the head of a picture; "" where it is unknown."""
    return "" if surface.rms_um is None else f", rms {surface.rms_um:.3g} µm"


def expected_deviation(c: CharacteristicResult) -> float:
    """Return the expected deviation from nominal, mm or rad: of the finished part `value`, the mean of its law; of an extreme value that a
    machine would read the mean of the trials, which noise enlarges.
    """
    read = c.extreme and not isinstance(c.truth, PredictedPart)
    return (c.mean if read else c.value) - c.nominal


def group_of(line: BudgetLine) -> str:
    """Return the owner of a contribution; Inputs of the measuring machine carry its name before theirs."""
    if ": " in line.input:
        return "measurement"
    effect = line.input.split("[")[0].split(".")[0]
    if line.input == "channel.temp_part_C":
        return "part"
    return BY_NAME[effect].about.belongs_to if effect in BY_NAME else "machine"


def shares_by_group(c: CharacteristicResult) -> dict[str, float]:
    """Return the share of u^2 by group, the sum of its lines; interaction (`budget_interaction`) is left out, and so is a u of next to nothing."""
    out = dict.fromkeys(GROUPS, 0.0)
    if c.u < LEAST_U:
        return out
    for line in c.budget:
        out[group_of(line)] += line.share if np.isfinite(line.share) else 0.0
    return out


def batch(c: CharacteristicResult) -> tuple[float, float]:
    """Return (u that repeats from part to part, u that scatters), mm or rad: the rest of u^2 counts as repeating."""
    scatter = sum(line.u**2 for line in c.budget if line.redraw in SCATTERS)
    return float(np.sqrt(max(c.u**2 - scatter, 0.0))), float(np.sqrt(min(scatter, c.u**2)))


def extremes(patches: tuple[Patch, ...], deep: float, features: Iterable[str] = ()) -> SurfaceExtremes:
    """Return the summary of the surface; deep: depth in mm from which a cut below nominal counts as a gouge. features: of the part."""
    height = np.concatenate([p.height for p in patches]) if patches else np.zeros(0)
    nominal = np.concatenate([p.nominal for p in patches]) if patches else np.zeros(0)
    cut = np.isfinite(height)
    there = height[cut] * 1e3
    return SurfaceExtremes(
        max_um=float(np.abs(there).max()) if len(there) else None,
        rms_um=float(np.sqrt(np.mean(there**2))) if len(there) else None,
        points=len(height),
        uncut=int((~cut).sum()),
        gouges=int((nominal[cut] < -deep).sum()),
        deep_um=deep * 1e3,
        without=tuple(name for name in features if name not in {p.net.feature for p in patches}),
    )
