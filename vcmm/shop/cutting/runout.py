"""Chips of the teeth of a mill that runs out: each tooth cuts the material that the teeth before it left.

The axis of the tool is A beside that of the spindle, towards the most protruding tooth (number 0), so that tooth i runs on a circle larger by

    rho_i = A cos(2 pi i / N),    A the amplitude of tool_runout: what the wall loses

and its chip at phi is the material left by the deepest of the N passes before it, its own of the last turn included:

    h_i(phi) = min over m = 1 .. N of  m c sin(phi) + rho_i - rho_(i-m);    below zero it does not touch

(Kline, DeVor, Int. J. Mach. Tool Des. Res. 23 (1983) 123; Altintas, Manufacturing Automation, 2nd ed. (2012), 2.9). At a wall (sin phi = 0) the tooth that
makes it meets its own previous cut: no chip, as without run-out. The chips of one turn always add up to N c sin(phi). Within a piece of
phi with one m
the chip is that of a feed m c with a constant more, K_c (m c sin(phi) + delta) + K_e, which is the same edge model with K_e + K_c delta.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vcmm.core.laws import Array
from vcmm.program.setup import LinearEdge
from vcmm.shop.cutting.contactmap import Ints

TURN = 2.0 * np.pi
NONE = 1e-12  # mm: of a chip, rounding


class ChipPiece(NamedTuple):
    """A piece of the engagement (low <= phi <= high, rad; empty where high <= low) in which a tooth cuts chips of `chip` sin(phi) mm with
    the coefficients `edges`."""

    chip: Array
    edges: LinearEdge
    low: Array
    high: Array


def radius_more(tooth: int, teeth: Ints, amplitude: Array) -> Array:
    """Return rho (k,) mm of a tooth of each of k tools."""
    return np.asarray(amplitude * np.cos(TURN * tooth / np.maximum(teeth, 1)))


def chip_at(phi: Array, tooth: int, teeth: Ints, chip: Array, amplitude: Array) -> Array:
    """Return h (k,) mm of a tooth at phi (k,); below zero it does not touch."""
    sine, out = np.sin(phi), np.full(len(phi), np.inf)
    for m in range(1, int(np.max(teeth, initial=0)) + 1):
        here = m * chip * sine + _step(tooth, m, teeth, amplitude)
        out = np.where(m <= teeth, np.minimum(out, here), out)
    return out


def chip_pieces(
    tooth: int, teeth: Ints, chip: Array, amplitude: Array, edges: LinearEdge
) -> Iterator[ChipPiece]:
    """Yield the pieces of half a turn of a tooth of each of k tools in which it cuts, without one that begins or ends with the engagement."""
    most = int(np.max(teeth, initial=0))
    feed = np.where(chip > 0.0, chip, np.inf)
    amplitude = np.where(chip > 0.0, amplitude, 0.0)
    for m in range(1, most + 1):
        delta = _step(tooth, m, teeth, amplitude)
        low, high = -delta / (m * feed), np.ones(len(chip))  # in sin(phi): where it touches
        for other in range(1, most + 1):
            if other == m:
                continue
            meet = (delta - _step(tooth, other, teeth, amplitude)) / ((other - m) * feed)
            counts = other <= teeth
            if other > m:
                low = np.where(counts, np.maximum(low, meet), low)
            else:
                high = np.where(counts, np.minimum(high, meet), high)
        is_there = (m <= teeth) & (high > low) & (high > 0.0)
        begins = np.where(low <= NONE, -np.pi / 2, np.arcsin(np.clip(low, 0.0, 1.0)))
        ends = np.arcsin(np.clip(high, 0.0, 1.0))
        more = with_more_chip(edges, np.where(is_there, delta, 0.0))
        for a, b in ((begins, ends), (np.pi - ends, np.pi - begins)):
            yield ChipPiece(m * chip, more, a, np.where(is_there, b, a))


def with_more_chip(edges: LinearEdge, chip: Array) -> LinearEdge:
    """Return the coefficients that hold for chips thicker by `chip` (k,) mm."""
    return replace(
        edges, edge_tangential=edges.edge_tangential + edges.tangential * chip,
        edge_radial=edges.edge_radial + edges.radial * chip, edge_axial=edges.edge_axial + edges.axial * chip,
    )  # fmt: skip


def _step(tooth: int, m: int, teeth: Ints, amplitude: Array) -> Array:
    """Return rho_i - rho_(i-m)."""
    return radius_more(tooth, teeth, amplitude) - radius_more(tooth - m, teeth, amplitude)
