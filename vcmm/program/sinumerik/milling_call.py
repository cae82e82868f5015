"""A call of a milling cycle of Sinumerik: its reader, and the values common to all tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from vcmm.program.cutter import CycleCutter
from vcmm.program.cycle_tables import Values
from vcmm.program.faults import BlockFault
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner

if TYPE_CHECKING:
    from vcmm.program.sinumerik.paths import SinumerikPaths


class MillingCall(NamedTuple):
    """A call of a milling cycle: its reader, the written call, the tool."""

    paths: SinumerikPaths
    runner: SinumerikRunner
    item: Item
    cutter: CycleCutter

    def floor(self, v: Values) -> float:
        """Return DP, or RFP less DPR; refused where it lies above RFP."""
        depth = v["DP"] if v["DP"] or not v["DPR"] else v["RFP"] - v["DPR"]
        if depth >= v["RFP"]:
            raise BlockFault(
                self.item.first, f"{self.item.name}: the depth must lie below RFP; correct the planes"
            )
        return depth

    def radius(self) -> float:
        """Return the radius of the tool, mm."""
        return self.cutter.radius("a pocket")

    def note_clearing(self, how: str, codes: str = "G1") -> None:
        """Note the control's own way of clearing."""
        what = f"how {self.item.name} clears"
        self.paths.r.assume(
            what, how, f"{what} is the control's own affair and not known; write its motion with {codes}", column=self.item.first,
        )  # fmt: skip

    def note(self, what: str, value: str) -> None:
        """Note effects that depend on setting data, or move the tool beside the workpiece alone."""
        self.paths.r.assume(f"{what} in {self.item.name}", value, column=self.item.first, matters=False)
