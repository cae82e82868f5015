"""Setup: data that a program does not contain. Machine, dialect, work offsets, tools, stock and its material, reference points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.run import Array, Series
from vcmm.program.limits import Control
from vcmm.program.moves import Move, Point, Program
from vcmm.program.touching import Surface

ZERO: Point = (0.0, 0.0, 0.0)

# Orientation of a turning tool, 1 to 9: where its imaginary tip lies as seen from the centre of the nose, in X and Z.
# 0 and 9 are the centre itself. Source: Fanuc, "imaginary tool nose"; LinuxCNC, "lathe tool orientation".
FANUC_TIPS: dict[int, tuple[int, int]] = {
    1: (1, 1), 2: (1, -1), 3: (-1, -1), 4: (-1, 1), 5: (0, 1), 6: (1, 0), 7: (0, -1), 8: (-1, 0), 9: (0, 0),
}  # fmt: skip
LINUXCNC_TIPS: dict[int, tuple[int, int]] = {
    1: (-1, 1), 2: (-1, -1), 3: (1, -1), 4: (1, 1), 5: (0, 1), 6: (-1, 0), 7: (0, -1), 8: (1, 0), 9: (0, 0),
}  # fmt: skip


def imaginary_nose(
    orientation: int, radius: float, plane: str, tips: Mapping[int, tuple[int, int]] = FANUC_TIPS
) -> Point:
    """Return the vector from the centre of a nose of `radius` mm to the imaginary tip at which the offsets of a turning tool are
    measured; none beside G18."""
    x, z = tips.get(orientation, (0, 0)) if plane == "ZX" else (0, 0)
    return x * abs(radius), 0.0, z * abs(radius)


DIRECTIONS: dict[str, Point] = {
    "x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0), "-x": (-1.0, 0.0, 0.0), "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}  # fmt: skip


@dataclass(frozen=True)
class Tool:
    """A tool, mm. shape bull has a corner_radius, turning a nose_radius and an orientation 0 to 9 of its imaginary tip; a probe is a
    ball that cuts nothing, its length counts to the lowest point of the ball.

    The radius that cutter radius compensation uses is `radius`; diameter None = not known. length_stated: else 0 mm is taken.
    """

    number: int
    length: float = 0.0
    diameter: float | None = None
    shape: str = "flat"
    corner_radius: float = 0.0
    nose_radius: float | None = None
    orientation: int = 0
    offset_x: float = 0.0
    offset_y: float = 0.0
    name: str = ""
    teeth: int | None = None
    helix: float | None = None  # of the cutting edges, rad; 0 straight, None not known
    stick_out: float | None = None
    cutting_length: float | None = None  # height of the cutting edges over the tip
    shank_diameter: float | None = None  # of what follows above them: shank or holder
    width: float | None = None  # of a groove tool
    length_stated: bool = True
    driven: str | None = (
        None  # driven tool of a lathe, angle head: the way from tip to holder, a word of DIRECTIONS
    )

    @property
    def radius(self) -> float | None:
        """mm; None = not known."""
        if self.shape == "turning" and self.nose_radius is not None:
            return self.nose_radius
        return None if self.diameter is None else self.diameter / 2.0

    @property
    def direction(self) -> Point:
        """From the tip to the holder, a unit vector in machine axes."""
        return DIRECTIONS[self.driven or "z"]

    @property
    def offset(self) -> Point:
        """Distance of the axes from the tip, mm."""
        return (self.offset_x, self.offset_y, self.length)


@dataclass(frozen=True)
class Bar:
    """Round stock of a lathe, mm: front = Z of its face in work coordinates; bore = 0: solid.

    thrust: force across the edge over the main cutting force, None = the usual rule.
    """

    diameter: float
    length: float
    bore: float = 0.0
    front: float = 0.0
    thrust: float | None = None


@dataclass(frozen=True, eq=False)
class TemperatureLog:
    """Temperatures of the machine's sensors (degC) over the time of the program, s from its start; zero_set: when the zeros were set, s."""

    sensors: Mapping[str, Series]
    zero_set: float = 0.0
    path: Path | None = None


@dataclass(frozen=True, eq=False)
class Setup:
    """Set-up of a run of the program. Points in mm, machine frame.

    offsets: G54 ... -> machine position of the work zero; rotations: the same -> rad about the tool axis (G10 L2 R).
    reference: machine position of G28; second_reference: of G30. stock: size of the box, None = not stated;
    stock_corner: its lowest corner in work coordinates, None = centred, top at work zero.
    material of the stock: for cutting forces, None = none are computed. thrust: force square to the edge over the main one.
    strict: nothing is assumed, what a program lacks is refused; else it is taken as the machine would,
    with a remark (levels).
    surfaces: what a probing move meets, machine axes: the stock and what is stated. read_out: mm by which each touch of the program
    reads further along its way than where ball and surface meet. expected_at: tips (machine axes) at which its touches answer where no
    surface is stated, whatever the program expects.
    path: the set-up file, for messages. control: tolerance of corners, time of a tool change; None = not stated.
    """

    machine: Path | None = None
    dialect: str | None = None
    offsets: Mapping[str, Point] = field(default_factory=dict)
    rotations: Mapping[str, float] = field(default_factory=dict)
    tools: Mapping[int, Tool] = field(default_factory=dict)
    reference: Point = ZERO
    second_reference: Point = ZERO
    stock: Point | None = None
    stock_corner: Point | None = None
    bar: Bar | None = None
    material: str | None = None
    thrust: float | None = None
    decimal_point: str | None = None
    arc_centre: str | None = None
    block_delete: bool = False
    unit: float | None = None  # mm per unit of a program that states none
    drawing_dimensions: bool | None = None  # whether A of a lathe is the angle of a line
    axes: frozenset[str] | None = None  # letters of the axes of the machine; None = not known
    strict: bool = True
    subprograms: tuple[Path, ...] = ()  # further folders in which they are looked for
    surfaces: tuple[Surface, ...] = ()
    read_out: tuple[float, ...] = ()
    channel: int = 1  # which channel of a program with several ($1, $2) is read
    work_spindles: Mapping[str, int] = field(
        default_factory=dict
    )  # work offset -> spindle that holds its part
    expected_at: tuple[Point, ...] = ()
    path: Path | None = None
    control: Control | None = None
    set_at: Point | None = None  # where offsets and tools were set; None = at each work zero
    set_as_cut: bool = False  # with the rotary axes where they stand while the offset cuts, not at zero
    set_with: int | None = (
        None  # tool with which X and Y of the work offsets were set; None = the first that cuts
    )
    constants: Mapping[str, float] = field(default_factory=dict)  # columns of the whole run: temperatures
    log: TemperatureLog | None = None  # temperatures that change meanwhile
    compensation: tuple[str, ...] | None = (
        None  # what the control itself compensates while the program runs; None = not said
    )


def has_driven(setup: Setup) -> bool:
    """Return whether there are tools with a spindle of their own, so that the main spindle holds the part."""
    return any(t.driven is not None for t in setup.tools.values())


def first_tool(moves: Sequence[Move], setup: Setup) -> int:
    """Return the tool with which X and Y of the work offsets were set: the stated one, else the first that cuts; 0: none is known."""
    if setup.set_with is not None:
        return setup.set_with
    cuts = (
        m.tool
        for m in moves
        if m.kind != "rapid" and m.tool in setup.tools and setup.tools[m.tool].shape != "probe"
    )
    return next(cuts, 0)


def turns_with(setup: Setup, program: Program) -> bool:
    """Return whether the program cuts with turning tools of the set-up; those that it does not use are of no matter."""
    used = {m.tool for m in program.moves if m.kind != "rapid"}
    return any(t.shape == "turning" for n, t in setup.tools.items() if n in used)


@dataclass(frozen=True)
class LinearEdge:
    """Coefficients of the linear edge model: cutting in N/mm2, edge in N/mm; numbers, or one per move (m,)."""

    tangential: float | Array
    radial: float | Array
    axial: float | Array
    edge_tangential: float | Array
    edge_radial: float | Array
    edge_axial: float | Array
    source: str


@dataclass(frozen=True)
class Kienzle:
    """Specific cutting force at h = b = 1 mm (N/mm2) and exponent of the main cutting force."""

    kc11: float
    mc: float
    source: str


LINEAR_EDGE = {
    "Al7075": LinearEdge(
        tangential=796.1,
        radial=168.8,
        axial=222.0,
        edge_tangential=27.7,
        edge_radial=30.8,
        edge_axial=1.4,
        source="CutPro example set for Al7075-T6 as found in public milling codes",
    )
}
_TABLE = "fitted to the kc table of the Roehm catalogue RN-1391, 45 deg entering angle"
KIENZLE = {
    "St50-2": Kienzle(1991.0, 0.257, _TABLE),
    "St60-2": Kienzle(2085.0, 0.173, _TABLE),
    "18CrNi8": Kienzle(2272.0, 0.297, _TABLE),
    "42CrMo4": Kienzle(2526.0, 0.250, _TABLE),
    "16MnCr5": Kienzle(2109.0, 0.262, _TABLE),
    "GG25": Kienzle(1186.0, 0.246, _TABLE),
}


def linear_edge(material: str) -> LinearEdge:
    """Return the coefficients from the library."""
    if material not in LINEAR_EDGE:
        raise UsageError(f'no milling coefficients of "{material}".{choose_from(material, LINEAR_EDGE)}')
    return LINEAR_EDGE[material]


def kienzle(material: str) -> Kienzle:
    """Return the coefficients from the library."""
    if material not in KIENZLE:
        raise UsageError(f'no Kienzle coefficients of "{material}".{choose_from(material, KIENZLE)}')
    return KIENZLE[material]
