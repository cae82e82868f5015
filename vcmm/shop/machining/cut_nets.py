"""Departures of a virtually cut surface on nets of points, for many machines: the contact of each point is searched once.

Which cutter touches a point does not depend on the errors of the machine; only how far the surface moves does. So the
search is done once for a net, and every further machine costs one evaluation of its errors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.shop.cutting.contactmap import Contacts
from vcmm.shop.cutting.envelope import UNCUT
from vcmm.shop.machining.contact_path import surface_at, tool_side
from vcmm.shop.machining.maps import Net
from vcmm.shop.machining.process import PreparedCut
from vcmm.shop.machining.tool_errors import ToolSide


@dataclass(frozen=True, eq=False)
class CutNet:
    """A net whose points are all cut: their contacts and the times of the cut."""

    net: Net
    tool: ToolSide
    contacts: Contacts


def cut_net(job: PreparedCut, net: Net) -> CutNet:
    """Find out once what cuts the points of a net. Raises ModelLimit where the program leaves points of it uncut."""
    surface = surface_at(job, net.points, net.normals)
    uncut = int((surface.status == UNCUT).sum())
    if uncut:
        raise ModelLimit(f"{net.feature}: {uncut} of {len(net.points)} points are not cut by the program")
    names = np.array([f"{net.feature} {i}" for i in range(len(net.points))])
    tool, contacts = tool_side(job, surface, names, np.full(len(net.points), net.feature))
    return CutNet(net, tool, contacts)


def decisive_contacts(cut: CutNet) -> CutNet:
    """Keep of every point only the contact that makes it on a machine without errors: 20 times fewer rows, for sums over many machines.

    Errors that would let another edge cut deeper are missed: 0.01 um for errors of 50 um, 0.5 um at a corner
    that two moves share (tests/papers).
    """
    contacts, tool = cut.contacts, cut.tool
    row, _ = contacts.deepest(tool.known_error)
    zero = np.unique(tool.setting[row])
    kept = np.concatenate([row, zero[zero >= 0]])
    number = np.full(tool.run.n + 1, -1, dtype=np.intp)
    number[kept[len(row) :]] = np.arange(len(row), len(kept))
    first = np.arange(len(row))[:, None]
    best = contacts.heights(tool.known_error).argmin(axis=1)[:, None]
    few = Contacts(
        np.take_along_axis(contacts.height, best, 1),
        np.take_along_axis(contacts.cutter, best[:, :, None], 1),
        contacts.normal,
        first,
    )
    side = replace(
        tool,
        run=tool.run.take(kept),
        setting=number[tool.setting[kept]],
        known_error=tool.known_error[kept],
        passes=None,
    )
    return CutNet(cut.net, side, few)


def departure(cut: CutNet, machine: Machine, zero_set_here: bool = True) -> Array:
    """Return the surface with the errors of `machine` less the surface without (n,) mm, along the normal; plus is material left.

    zero_set_here: the work offset was set on this machine, so that its error there is subtracted; else nothing is.
    """
    setting = cut.tool.setting if zero_set_here else np.full_like(cut.tool.setting, -1)
    tool = replace(cut.tool, machine=machine, setting=setting)
    return cut.contacts.surface(tool.errors()) - cut.contacts.surface(cut.tool.known_error)
