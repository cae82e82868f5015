"""Results of the compensation of a program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from vcmm.compensation.path_deviations import FollowedPath
from vcmm.core.readable import Readable, Reading
from vcmm.core.run import Array


@dataclass(frozen=True)
class Departure:
    """Distance of the path that the machine runs from the programmed one, mm; line: of the source, where it is largest."""

    largest: float
    rms: float
    line: int


@dataclass(frozen=True)
class OrientationProof:
    """Angle between the tool and where the program points it, over the cuts; `largest` and `rms` in rad."""

    before: Departure
    after: Departure


@dataclass(frozen=True)
class Rounding:
    """Cost of the last decimal: step mm, largest and rms at the ends of blocks, and its share of the mean square residual."""

    step: float
    largest: float
    rms: float
    share: float


@dataclass(frozen=True)
class BlockCounts:
    """blocks with motion before and after; changed and added lines; blocks per second at the programmed feed."""

    before: int
    after: int
    changes: int
    additions: int
    rate_before: float
    rate_after: float
    rate_line: int

    @property
    def growth(self) -> float:
        return self.after / self.before if self.before else 1.0


@dataclass(frozen=True, eq=False)
class CompensatedProgram(Readable):
    """text and data: the new program. shifts: best correction of each work offset alone, mm (3,).

    before: the program as it is; offset_only: with the work offsets shifted; after: the new program, all re-simulated.
    tolerance: the one asked; tolerance_used: the one kept after relaxation; is_met: the residual less rounding is within the tolerance.
    """

    name: str
    dialect: str
    machine: str
    text: str
    data: bytes
    tolerance: float
    tolerance_used: float
    is_met: bool
    before: Departure
    offset_only: Departure
    after: Departure
    shifts: Mapping[str, Array]
    rounding: Rounding
    blocks: BlockCounts
    digest: str
    warnings: tuple[str, ...]
    source_lines: tuple[int, ...]  # of each line of the new program, from 1; 0 for lines of the mark
    whole: tuple[Departure, Departure] | None = (
        None  # before and after with reversal and lag too, which are not corrected
    )
    paths: tuple[FollowedPath, FollowedPath] | None = None  # before and after, where they are requested
    orientation: OrientationProof | None = None  # where angles of the tool are corrected too
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        before, after = (1e3 * d.largest for d in (self.before, self.after))
        met = "met" if self.is_met else "NOT met"
        return (
            f"<CompensatedProgram {self.name}: {before:.3g} to {after:.3g} µm of the path, tolerance {met}>"
        )
