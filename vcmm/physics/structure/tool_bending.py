"""The tool bends under the cutting force. Tip errors, actual - commanded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import UM, About, Trade, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.run import FORCE_COLUMNS, TOOL_AXIS_COLUMNS, Array, Run

CARBIDE = 580e3  # N/mm2, lower end of 580 to 600 GPa
STIFFNESS_RATIO = 0.8  # diameter of a plain rod as stiff as the fluted one, over the tool diameter


@dataclass(frozen=True, eq=False)
class ToolDeflection(Effect):
    """+compliance x force, force = that of the part on the tool, workpiece axes: pushed away, it leaves material.

    rod: the part of the force along the axis of the tool (z, where no rotary axis turns it) moves nothing.
    """

    name = "tool_deflection"
    about = About(
        cites="Kline, DeVor & Shareef, J. Eng. for Industry 104 (1982) 272: surface accuracy in end milling",
        trade=Trade("bending of the tool {where}", "a spring pass, half the feed or a stiffer tool"),
        words=Words(
            seen="the cutting force bends the tool ({compliance})",
            causes="slender tool, high chip load",
            confirm="a spring pass, or half the feed",
        ),
        belongs_to="tool",
    )
    per = "tool"
    needs = FORCE_COLUMNS
    compliance: float = param(
        0.0,
        "um/N",
        "displacement of the cutting edge per force",
        typical=Typical(0.1 * UM, "carbide d 10 mm, 50 mm out: 50^3 / (3 x 6e5 x 491) mm/N = 0.14 um/N"),
    )
    rod: int = at(
        0,
        "1 = bends across its axis, z, and is stiff along it; 0 = yields alike in all directions",
        quiet=True,
        tries=(0, 1),
    )

    @property
    def link(self) -> str:
        return "tip"

    @classmethod
    def of_rod(cls, compliance: float, tool: str) -> ToolBending:
        """Return the bending of one tool as a rod."""
        return ToolBending(compliance, tool=tool)

    @classmethod
    def of_edge(cls, compliance: float, tool: str) -> ToolYielding:
        """Return the yielding of one turning tool, whose edge yields equally in all directions."""
        return ToolYielding(compliance, tool=tool)

    def error_motion(self, run: Run) -> Array:
        force = run.vector(*self.needs)
        if self.rod:  # a rod 4 d long gives way along its axis by 3 d^2 / (16 l^2), 1 % of its bending
            force = across_tool(run, force)
        x, y, z = self.compliance * force.T
        return motion(run, X=x, Y=y, Z=z)


@dataclass(frozen=True, eq=False)
class ToolBending(ToolDeflection):
    """tool_deflection of one tool as a rod: it bends across its axis and is stiff along it.

    The cutting job makes it of the stick-out in the set-up; files and diagnosis say `rod = 1` of every tool.
    """

    tool: str = at("", "tool number; empty = all")

    def error_motion(self, run: Run) -> Array:
        compliance = self.compliance * run.label_mask("tool", self.tool)
        x, y, z = compliance * across_tool(run, run.vector(*self.needs)).T
        return motion(run, X=x, Y=y, Z=z)


@dataclass(frozen=True, eq=False)
class ToolYielding(ToolBending):
    """tool_deflection of one turning tool, whose edge yields alike in all directions."""

    def error_motion(self, run: Run) -> Array:
        return ToolDeflection.error_motion(self, run) * run.label_mask("tool", self.tool)[:, None]


def across_tool(run: Run, force: Array) -> Array:
    """Return the part (n, 3) of forces (n, 3) across the axis of the tool, workpiece axes."""
    if TOOL_AXIS_COLUMNS[0] not in run.columns:
        return force * np.array([1.0, 1.0, 0.0])
    axis = run.vector(*TOOL_AXIS_COLUMNS)
    return np.asarray(force - np.einsum("ni,ni->n", force, axis)[:, None] * axis)


def bending(radius: float, stick_out: float) -> float:
    """Return the compliance of a cantilever at its end, mm/N: L^3 / 3 E I, I = pi d^4 / 64, d = 0.8 D.

    Cutter and its stick-out only; holder, spindle and machine come on top.
    """
    diameter = STIFFNESS_RATIO * 2.0 * radius
    inertia = math.pi * diameter**4 / 64.0
    return stick_out**3 / (3.0 * CARBIDE * inertia)
