"""Cut parts: the work of `vcmm.cut` in steps, and departures of nets of points for many machines."""

from __future__ import annotations

from vcmm.compensation.result import CompensatedProgram
from vcmm.program.setup import TemperatureLog
from vcmm.shop.machining.cut_nets import CutNet, cut_net, decisive_contacts, departure
from vcmm.shop.machining.cut_world import Cutting
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.maps import Net, net
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import PreparedCut
from vcmm.shop.machining.warming import add_temperatures

__all__ = [
    "CompensatedProgram",
    "CutNet",
    "Cutting",
    "Net",
    "PreparedCut",
    "TemperatureLog",
    "add_temperatures",
    "cut_net",
    "decisive_contacts",
    "departure",
    "finished_part",
    "net",
    "set_up",
]
