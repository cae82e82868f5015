"""Setting up a machine tool: the work zero and the tool table are set with errors of their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Opposite, Trade, Typical, Words
from vcmm.core.effect import Effect, along, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import PROBE_LABEL, TOOL_AXIS_COLUMNS, Array, Run

TOOL_AXIS = np.array([0.0, 0.0, 1.0])  # workpiece axes, rotary axes at zero


@dataclass(frozen=True, eq=False)
class WorkOffset(Effect):
    """+shift along one direction: the work zero is set too far by `shift`, so the whole cut is shifted.

    An offset is added to the commanded X, Y and Z, so its directions are those of the machine: with a table turned by 90
    deg a shift in x shows along z of the part. Where the control leads the tip over the workpiece (columns led_xx ... : the commanded
    X, Y and Z for 1 mm along x, y, z of the part) it turns with the part.

    The machine's own errors while the zero is set are not part of it: the cutting job subtracts them. Where a program has probed
    its zero itself, the offset has no effect (columns held_x, held_y, held_z: 0).
    """

    name = "work_offset"
    about = About(
        cites="ISO 16907:2015, workpiece coordinate system; JCGM 100, 4.3",
        trade=Trade("setting of the work offset {where}", "set the work zero with more touches"),
        belongs_to="setup",
    )
    per = "direction, setup"
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    direction: str = at("x", "x, y or z, machine axes")
    shift: float = param(
        0.0,
        "um",
        "set minus true work zero",
        typical=Typical(5 * UM, "usual: edge finder or touch probe on the machine 2-10 um"),
    )

    def __post_init__(self) -> None:
        if self.direction not in ("x", "y", "z"):
            raise UsageError(f'work_offset: direction = "{self.direction}" must be "x", "y" or "z"')

    @property
    def link(self) -> str:
        return "command"

    def error_motion(self, run: Run) -> Array:
        amount = self.shift * _cut(run) * run.columns.get(f"held_{self.direction}", np.ones(run.n))
        if f"led_{self.direction}x" not in run.columns:
            return motion(run, **{self.direction.upper(): amount})
        shift = run.vector(*(f"led_{self.direction}{c}" for c in "xyz")) * amount[:, None]
        return motion(run, X=shift[:, 0], Y=shift[:, 1], Z=shift[:, 2])


@dataclass(frozen=True, eq=False)
class ToolLength(Effect):
    """-dl along Z of the tool frame: a tool longer than its table entry by `dl` cuts deeper (ISO 841: +Z leads out of the work)."""

    name = "tool_length"
    about = About(
        cites="ISO 841:2001; JCGM 100, 4.3",
        trade=Trade("length of tool {where} as set", "measure the tool in the machine"),
        words=Words(
            seen="the tool is longer than its table says ({dl})",
            causes="set wrongly, pulled out of its holder, or another tool",
            confirm="set the tool again",
            opposite=Opposite(
                "dl",
                "the tool is shorter than its table says ({dl})",
                "set wrongly, pushed into its holder or worn",
            ),
        ),
        belongs_to="tool",
        needs_cut=True,  # set by hand, and seen in the part only
    )
    per = "tool"
    tool: str = at("", "tool number; empty = all")
    dl: float = param(
        0.0, "um", "actual minus set tool length", typical=Typical(5 * UM, "usual: tool setter 2-10 um")
    )

    @property
    def link(self) -> str:
        return "tool"

    def error_motion(self, run: Run) -> Array:
        return motion(run, Z=-self.dl * run.label_mask("tool", self.tool) * _cut(run))


@dataclass(frozen=True, eq=False)
class ToolRadius(Effect):
    """-dr (n - z), n out of the part, z the tool axis: a cutter larger by `dr` takes that much more from a wall.

    The tip stays where the tool length was set, so a floor is not touched by it; on a slope a ball takes dr (1 - n_z).
    A turning insert is set at its imaginary tip: z becomes the way from there to the centre of the nose over its radius
    (columns nose_x nose_y nose_z), so that cylinders and faces keep their size and a 45 deg taper changes by 0.41 dr.
    """

    name = "tool_radius"
    about = About(
        cites="ISO 13399-3 (cutting diameter); JCGM 100, 4.3",
        trade=Trade(
            "radius of tool {where} as set", "measure the tool in the machine, or correct by the first part"
        ),
        words=Words(
            seen="the tool is larger in radius than its table says ({dr})",
            causes="set wrongly, another tool or insert, or its longest tooth protrudes (on a wall run-out is the same)",
            confirm="set the tool again",
            opposite=Opposite(
                "dr",
                "the tool is smaller in radius than its table says ({dr})",
                "set wrongly, reground or worn",
            ),
        ),
        belongs_to="tool",
        needs_cut=True,  # set by hand, and seen in the part only
    )
    per = "tool"
    needs = ("nx", "ny", "nz")
    tool: str = at("", "tool number; empty = all")
    dr: float = param(
        0.0,
        "um",
        "actual minus set cutting radius",
        typical=Typical(5 * UM, "usual: tool setter or presetter 2-10 um"),
    )

    @property
    def link(self) -> str:
        return "tip"

    def error_motion(self, run: Run) -> Array:
        return along(
            run, run.normal - _tool_axis(run), -self.dr * run.label_mask("tool", self.tool) * _cut(run)
        )


@dataclass(frozen=True, eq=False)
class ToolOffset(Effect):
    """-shift along x or y of the tool frame: an insert that protrudes by `shift` more than its table entry cuts deeper.

    x is the radius of a turned part, which the diameter has twice; y is the height of the tip, of second order there.
    """

    name = "tool_offset"
    about = About(
        cites="ISO 841:2001; JCGM 100, 4.3",
        trade=Trade(
            "offset of tool {where} as set",
            "correct the offset by the first part, or measure the tool in the machine",
        ),
        belongs_to="tool",
    )
    per = "tool, direction"
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    tool: str = at("", "tool number; empty = all")
    direction: str = at("x", "x or y of the tool frame")
    shift: float = param(
        0.0,
        "um",
        "actual minus set offset of the tool",
        typical=Typical(3 * UM, "usual: trial cut measured with a micrometer 2-5 um"),
    )

    def __post_init__(self) -> None:
        if self.direction not in ("x", "y"):
            raise UsageError(
                f'tool_offset: direction = "{self.direction}" must be "x" or "y"; along z it is tool_length'
            )

    @property
    def link(self) -> str:
        return "tool"

    def error_motion(self, run: Run) -> Array:
        amount = -self.shift * run.label_mask("tool", self.tool) * _cut(run)
        return motion(run, **{self.direction.upper(): amount})


@dataclass(frozen=True, eq=False)
class ProbeTouch(Effect):
    """-shift n in one touch of a program, n out of the part: the probe answers when its ball is `shift` deeper in it.

    It is nothing where the tool cuts; what the program makes of the reading takes it there.
    """

    name = "probe_touch"
    about = About(
        cites="ISO 230-10:2022, 6 (touch probe of a machine tool); JCGM 100, 4.2",
        trade=Trade("probing on the machine", "probe more slowly, and qualify the probe at that feed"),
        belongs_to="setup",
    )
    per = "touch of the program"
    needs = ("nx", "ny", "nz")
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    touch: str = at("", "number of the touch in the program, from 1; empty = all")
    shift: float = param(
        0.0,
        "um",
        "how much later it answers",
        typical=Typical(0.5 * UM, "usual: a spindle probe repeats within 1 um (2 s)"),
    )

    @property
    def link(self) -> str:
        return "tip"

    def error_motion(self, run: Run) -> Array:
        touched = run.label_mask(PROBE_LABEL, self.touch) * (
            run.labels[PROBE_LABEL] != "" if PROBE_LABEL in run.labels else 0.0
        )
        return along(run, run.normal, -self.shift * touched)


TOOL_TABLE = (ToolLength.name, ToolRadius.name, ToolOffset.name)  # what a tool setter measures


def _tool_axis(run: Run) -> Array:
    """Return the direction along which a cutter of larger radius moves away (n, 3), workpiece axes: from the tip to the spindle; of a
    turning tool set at its imaginary tip, the two sides of the nose.
    """
    if "nose_x" in run.columns:
        return run.vector("nose_x", "nose_y", "nose_z")
    if TOOL_AXIS_COLUMNS[0] in run.columns:
        return run.vector(*TOOL_AXIS_COLUMNS)
    return np.broadcast_to(TOOL_AXIS, (run.n, 3))


def _cut(run: Run) -> Array:
    """Return 1 in rows that cut, 0 in those in which offset and tool were set: errors of setting show in the cut alone."""
    return 1.0 - run.columns.get("setting", np.zeros(run.n))
