"""Cutting: the tool bends, wears and runs out. Tip errors, actual - commanded; n points out of the part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import UM, About, ChoosesColumns, Trade, Typical, Words
from vcmm.core.effect import Effect, along, at, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class _Cutting(Effect):
    per = "tool"

    @property
    def link(self) -> str:
        return "tip"


@dataclass(frozen=True, eq=False)
class ToolWear(_Cutting):
    """+rate x cut length along n: a worn tool is smaller and leaves material, so shafts grow and bores shrink.

    It is a loss of radius: where the axis of the tool is known (column across_tool, the share of n across it, 0 on a floor),
    that share of it counts.
    """

    name = "tool_wear"
    about = About(
        cites="ISO 8688-2:1989: tool life testing in milling, end milling",
        trade=Trade("wear of the tool {where}", "change the tool earlier"),
        words=Words(
            seen="the tool loses radius while it cuts ({rate})",
            causes="wear",
            confirm="the same program with a new tool",
        ),
        belongs_to="tool",
    )
    needs = ("cut_length_mm", "nx", "ny", "nz")
    rate: float = param(
        0.0,
        "um/m",
        "loss of radius per length cut",
        typical=Typical(0.2 * UM / 1e3, "flank wear 0.3 mm x tan 7 deg = 37 um in about 200 m"),
    )
    tool: str = at("", "tool name; empty = all")

    def error_motion(self, run: Run) -> Array:
        return along(run, run.normal, self.rate * run.column("cut_length_mm") * _across(run, self.tool))


@dataclass(frozen=True, eq=False)
class ToolRunout(_Cutting, ChoosesColumns):
    """-(cosine cos(h phi) + sine sin(h phi)) along n, phi = spindle angle: a larger cutting radius takes more away.

    harmonic h = 0 (default): the constant part, an edge that runs on a larger circle; 1: once per turn, which needs the
    column spindle_angle. As a gain of radius it counts with the share of n across the tool, as tool_wear does.
    """

    name = "tool_runout"
    about = About(
        cites="Kline & DeVor, Int. J. Mach. Tool Des. Res. 23 (1983) 123: effect of runout in end milling",
        trade=Trade("run-out of the tool {where}", "a better holder, or turn the tool in it by 180 degrees"),
        words=Words(
            seen="the tool runs out ({amplitude})",
            causes="collet or holder",
            confirm="turn the tool in its holder by 180 degrees",
        ),
        aliases={"amplitude": "cosine"},
        belongs_to="tool",
    )
    needs = ("nx", "ny", "nz")
    cosine: float = param(
        0.0,
        "um",
        "gain of radius, or its cosine part; `amplitude` in files",
        typical=Typical(5 * UM, "collets and holders: 2-20 um"),
    )
    sine: float = param(
        0.0,
        "um",
        "sine part; nothing for the constant part",
        typical=Typical(5 * UM, "collets and holders: 2-20 um"),
    )
    harmonic: int = at(0, "0 = constant part, 1 = once per turn, 2 = twice ...", quiet=True, tries=(0, 1))
    tool: str = at("", "tool name; empty = all")

    def __post_init__(self) -> None:
        if self.harmonic < 0:
            raise UsageError("tool_runout: harmonic must be 0 (constant) or the number of waves per turn")

    def required_columns(self) -> tuple[str, ...]:
        return (*self.needs, "spindle_angle_rad") if self.harmonic else self.needs

    def error_motion(self, run: Run) -> Array:
        phi = self.harmonic * run.column("spindle_angle_rad") if self.harmonic else np.zeros(run.n)
        gain = self.cosine * np.cos(phi) + self.sine * np.sin(phi)
        return along(run, run.normal, -gain * _across(run, self.tool))


def _across(run: Run, tool: str) -> Array:
    """Return how much of a change of the tool's radius shows along n (n,); 0 in rows of other tools."""
    return run.label_mask("tool", tool) * run.columns.get("across_tool", 1.0)
