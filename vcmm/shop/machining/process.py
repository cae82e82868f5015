"""A prepared cut, and the interface of milling, milling with rotary axes off zero, and turning.

The way from a program to the errors of its surface is walked once, in vcmm.shop.machining.contact_path:

    points -> surface and its contacts -> candidates of the deepest cut -> rows of a run -> states there -> zero -> errors

A `Process` answers its steps: MillingProcess (vcmm.shop.machining.milling), RotaryMillingProcess (rotary_milling) and
TurningProcess (turning). Steps that are equal for all of them, or empty for most, are defined here.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import VcmmError
from vcmm.core.inputs import Input
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array, Run
from vcmm.part.part import Feature
from vcmm.program.moves import Program
from vcmm.shop.cutting.contactmap import Contacts, Ints, MovedCutters
from vcmm.shop.cutting.envelope import CutSurface
from vcmm.shop.cutting.sweeps import Sweep
from vcmm.shop.machining.blank import Blank
from vcmm.shop.machining.maps import Net, net
from vcmm.shop.machining.tool_errors import ToolSide
from vcmm.shop.machining.touched_zero import TouchedZero
from vcmm.shop.machining.turned_blank import TurnedBlank
from vcmm.shop.motion.toolpath import Toolpath
from vcmm.task.measuring.cut_scenario import CutScenario
from vcmm.task.measuring.settings import Settings

DEPTH, HEIGHT = 0.5, 2.0  # mm, how far below and above nominal the surface is looked for
DEEPEST = 20.0  # mm, for points that are gouged deeper
GOUGE = 0.01  # mm below nominal by the program alone
Words = np.typing.NDArray[np.str_]


@dataclass(frozen=True, eq=False)
class PreparedCut:
    """A prepared scenario: the program read, its motion in time, the tools swept (process), the part placed."""

    scenario: CutScenario
    program: Program
    path: Toolpath
    pose: Pose
    process: Process
    blank: Blank | TurnedBlank | None = None
    touched_zero: TouchedZero | None = None  # what the program itself probes

    @property
    def machine(self) -> Machine:
        return self.scenario.machine

    @property
    def sweep(self) -> Sweep:
        return self.process.sweep

    @property
    def seconds(self) -> float:
        return self.path.seconds

    def line_of(self, row: int) -> int:
        """Return the line of the program that made a row of the sweep."""
        return self.program.moves[int(self.sweep.move[row])].source.line


@dataclass(frozen=True, eq=False)
class CutCandidates:
    """P points, K candidates: height (P, K) mm, cutter normal and tip (P, K, 3), row of the sweep and share of it (P, K).

    row is -1 where there is none; the first column is the contact on a perfect machine.
    """

    height: Array
    cutter: Array
    tip: Array
    row: Ints
    share: Array


@dataclass(frozen=True, eq=False)
class ContactRows:
    """The rows of the run of a cut, one for every candidate of every point.

    point, candidate (rows,): which of `surface` and of `contacts`; row, share (rows,): of the sweep; tip (rows, 3): as
    programmed; at (rows, 3): where the cutter meets the surface; mm, in the axes in which the process sees its contacts.
    """

    surface: CutSurface
    contacts: Contacts
    point: Ints
    candidate: Ints
    row: Ints
    share: Array
    tip: Array
    at: Array


class Process(ABC):
    """Interface of a way of cutting: the steps of vcmm.shop.machining.contact_path."""

    sweep: Sweep

    # -- the surface and what cuts it ---------------------------------------------------------------------------------
    @abstractmethod
    def surface(self, job: PreparedCut, points: Array, normals: Array, exact: bool) -> CutSurface:
        """Return the surface at points (n, 3) of the workpiece. exact=False: as the search sees it."""

    @abstractmethod
    def candidates(self, job: PreparedCut, surface: CutSurface) -> CutCandidates:
        """Return the contacts of a surface and all other places that may cut deeper under errors."""

    @abstractmethod
    def cutters(self, surface: CutSurface, candidates: CutCandidates) -> MovedCutters:
        """Return the cutting edges of the candidates, to be met by rays when they are moved."""

    def contacts_seen(self, surface: CutSurface) -> tuple[Array, Array]:
        """Return the points and normals (n, 3) in the axes in which the process sees its contacts."""
        return surface.points, surface.normals

    @abstractmethod
    def cusp_lift(self, job: PreparedCut, surface: CutSurface, some: Ints, radius: float) -> Array:
        """Return how much higher (k,) mm than the surface in the points `some` (k,) a ball of `radius` rests on the cusps beside."""

    def net(self, job: PreparedCut, feature: Feature, across: int) -> Net | None:
        """Return the points at which the surface of a feature is evaluated for pictures and extremes."""
        return net(feature, across)

    # -- the machine when it cuts there -------------------------------------------------------------------------------
    @abstractmethod
    def states(self, job: PreparedCut, rows: ContactRows) -> tuple[Run, Array]:
        """Return the states of the machine with its cutting point at `rows.at`, and the known deviations of the path (rows, 3) mm."""

    def columns(self, job: PreparedCut, rows: ContactRows) -> dict[str, Array]:
        """Return the columns of the surface in each row, workpiece axes: normal and place in the part."""
        place = rows.at - job.pose.shift
        return by_axis("n{}", rows.surface.normals[rows.point]) | by_axis("part_{}_mm", place)

    def fed_in_part(self, job: PreparedCut) -> Mapping[str, float] | None:
        """Return the mm that each tool is fed in one part; None: as the toolpath says."""
        return None

    @abstractmethod
    def force(self, job: PreparedCut, rows: ContactRows, forces: Array) -> Array:
        """Return the force (rows, 3) N of the part on the tool, workpiece axes; forces: that of each row of the sweep."""

    # -- where its zero was set ---------------------------------------------------------------------------------------
    rows_per_zero = 1  # rows of the run whose mean error is in a zero
    each_tool_set = False  # whether every tool was set in all axes, as on a lathe; else only its length

    def set_at(self, job: PreparedCut, rows: Run) -> Run:
        """Return rows of setting with the rotary axes as they were then."""
        return rows

    def angle_set(self, job: PreparedCut, offset: str) -> Array:
        """Return A, B, C (3,) rad at which the zero of a work offset was set."""
        return np.zeros(3)

    @abstractmethod
    def tool_side(
        self, job: PreparedCut, run: Run, setting: Ints, known_error: Array, inputs: tuple[Input, ...]
    ) -> ToolSide:
        """Return the errors of the tool in all rows, in the axes of the contacts."""

    # -- the job ------------------------------------------------------------------------------------------------------
    @abstractmethod
    def blank(self, job: PreparedCut, zero: Array) -> Blank | TurnedBlank | None:
        """Return the remaining stock; zero (3,): work zero, workpiece axes."""

    def refusal(self, job: PreparedCut) -> VcmmError | None:
        """Return the error to raise for effects that have no meaning here; None where all have."""
        return None

    def why_fixed(self, job: PreparedCut) -> str | None:
        """Return why the part cannot be cut elsewhere by the same program; None where it can."""
        return None

    def engine(self, settings: Settings) -> tuple[Settings, tuple[str, ...]]:
        """Return the default settings of the evaluation, and remarks on them."""
        return settings, ()

    def remarks(self) -> Sequence[str]:
        """Return the remarks of the process on the program."""
        return ()

    def remarks_on(self, surface: CutSurface, features: Words) -> Sequence[str]:
        """Return the remarks on features (n,) as they are cut."""
        return ()


def by_axis(name: str, vectors: Array) -> dict[str, Array]:
    """Return vectors (n, 3) as three columns, where {} in the name is replaced by x, y, z."""
    return {name.format(c): vectors[:, i] for i, c in enumerate("xyz")}


def zeros(job: PreparedCut, names: Words) -> Array:
    """Return where each work offset was set (k, 3): at the stated place, else at the work zero itself; workpiece axes."""
    scenario = job.scenario
    if scenario.set_at is not None:
        return np.tile(np.array(scenario.set_at), (len(names), 1))
    return np.array([scenario.setup.offsets.get(str(name), (0.0, 0.0, 0.0)) for name in names], dtype=float)
