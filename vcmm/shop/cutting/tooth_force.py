"""Cutting force at the moment at which an edge makes a point of the wall, instead of the mean of a turn.

A wall keeps the place of the tool at the moments at which its edges touch it. With straight edges that is at phi = 0 (conventional) or
phi = pi (climb), where the chip has no thickness: only the edge forces act. An edge of helix b lags by kappa = tan b / R per mm of height,
so that height z of the wall is made while the edge is at phi_s there and at phi_s - kappa (zeta - z) at height zeta:

    F(z) = sum over teeth j of  int_0^a dF(phi_s - 2 pi j / N - kappa (zeta - z)) dzeta,    where phi lies within start and exit

and every height of the wall has a force of its own. Its mean over a turn is `milling_force`.

Source: Altintas, Manufacturing Automation, 2nd ed. (2012), 2.8 and 4.4 (surface form errors in peripheral milling); Kline, DeVor, Shareef,
J. Eng. Ind. 104 (1982) 272. Frame and angles as in vcmm.shop.cutting.force.

Each tooth of a mill that runs out cuts the material that the teeth before it left.

The axis of the tool is A beside that of the spindle, towards the most protruding tooth (number 0), so that tooth i runs on a circle larger by

    rho_i = A cos(2 pi i / N),    A the amplitude of tool_runout: what the wall loses

and its chip at phi is the material left by the deepest of the N passes before it, its own of the last turn included:

    h_i(phi) = min over m = 1 .. N of  m c sin(phi) + rho_i - rho_(i-m);    below zero it does not touch

(Kline, DeVor, Int. J. Mach. Tool Des. Res. 23 (1983) 123; Altintas, Manufacturing Automation, 2nd ed. (2012), 2.9). At a wall (sin phi = 0) the tooth that
makes it meets its own previous cut: no chip, as without run-out. The chips of one turn always add up to N c sin(phi). Within a piece of
phi with one m the chip is that of a feed m c with a constant more, K_c (m c sin(phi) + delta) + K_e, which is the same edge model with K_e + K_c delta.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from typing import NamedTuple

import numpy as np

from vcmm.core.laws import Array
from vcmm.program.setup import LinearEdge
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.force import edge_force, edge_integral

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


TURN = 2.0 * np.pi
STRAIGHT = 1e-7  # rad of lag over the whole depth, below which an edge is straight
SLACK = 1e-9  # rad


@dataclass(frozen=True, eq=False)
class ToothCuts:
    """Engagement of each of m stretches of a path: start and exit rad, axial depth mm, feed per tooth mm, teeth, lag kappa rad/mm (nan: helix not
    known), edge coefficients, run-out of the tool mm (`vcmm.shop.cutting.tooth_force`; tooth 0 protrudes most)."""

    start: Array
    exit: Array
    axial: Array
    chip: Array
    teeth: Array
    lag: Array
    edges: LinearEdge
    runout: Array = field(default_factory=lambda: np.zeros(1))

    @property
    def runs_out(self) -> bool:
        """Whether any of these tools runs out while it is fed."""
        return bool(np.any((self.runout > 0.0) & (self.chip > 0.0)))

    def take(self, rows: Ints) -> ToothCuts:
        """Return some of the stretches."""
        return ToothCuts(
            start=self.start[rows], exit=self.exit[rows], axial=self.axial[rows], chip=self.chip[rows], teeth=self.teeth[rows],
            lag=self.lag[rows], edges=_edges_of(self.edges, rows), runout=self.runout[rows] if len(self.runout) > 1 else self.runout,
        )  # fmt: skip

    def force(self, angle: Array, height: Array) -> Array:
        """Return the force (m, 3) N of the part on the tool while its edge is at `angle` (m,) rad at `height` (m,) mm over the tip."""
        deep, out = self.axial > 0.0, np.zeros((len(self.axial), 3))
        twist = np.nan_to_num(self.lag) * self.axial
        straight = np.abs(twist) < STRAIGHT
        turns = int(np.ceil(float(np.abs(twist).max(initial=0.0)) / TURN)) + 2
        for tooth in range(int(np.max(self.teeth, initial=0))):
            at = deep & (tooth < self.teeth)
            phi = angle - TURN * tooth / np.maximum(self.teeth, 1)
            at_once = np.remainder(phi - self.start + SLACK, TURN) - SLACK + self.start
            there = at & straight & (at_once <= self.exit + SLACK)
            if there.any():
                out += self._straight(tooth, at_once, there)
            first = (
                phi + np.nan_to_num(self.lag) * height
            )  # angle of the edge at the tip; at the top it lags by the whole twist
            low, high = np.minimum(first, first - twist), np.maximum(first, first - twist)
            for piece in self._pieces(tooth):
                for turn in range(-turns, turns + 1):
                    a, b = (
                        np.maximum(low - turn * TURN, piece.low),
                        np.minimum(high - turn * TURN, piece.high),
                    )
                    cuts = at & ~straight & (b > a)
                    if cuts.any():
                        a, b = np.where(cuts, a, 0.0), np.where(cuts, b, 0.0)
                        per = np.divide(1.0, np.abs(self.lag), out=np.zeros_like(a), where=cuts)
                        along_edge = edge_integral(b, piece.chip, piece.edges) - edge_integral(
                            a, piece.chip, piece.edges
                        )
                        out += np.where(cuts, per, 0.0)[:, None] * along_edge
        return out

    def _straight(self, tooth: int, phi: Array, there: Array) -> Array:
        """Return the force of a straight edge at phi (m,) with all of its depth."""
        depth = np.where(there, self.axial, 0.0)
        if not self.runs_out:
            return depth[:, None] * edge_force(phi, self.chip, self.edges)
        chip = chip_at(phi, tooth, self.teeth, self.chip, self.runout)
        touches = depth * (chip >= -NONE)
        return touches[:, None] * edge_force(
            phi, np.zeros_like(chip), with_more_chip(self.edges, np.maximum(chip, 0.0))
        )

    def _pieces(self, tooth: int) -> list[ChipPiece]:
        """Return the pieces of the engagement in which a tooth cuts."""
        if not self.runs_out:
            return [ChipPiece(self.chip, self.edges, self.start, self.exit)]
        return [
            piece._replace(low=np.maximum(piece.low, self.start), high=np.minimum(piece.high, self.exit))
            for piece in chip_pieces(tooth, self.teeth, self.chip, self.runout, self.edges)
        ]

    def mean(self) -> Array:
        """Return the mean force (m, 3) N of a turn, for any helix: of a mill that runs true `milling_force`."""
        out = np.zeros((len(self.axial), 3))
        for tooth in range(int(np.max(self.teeth, initial=0))):
            per = np.where(tooth < self.teeth, self.axial, 0.0) / TURN
            for piece in self._pieces(tooth):
                low, high = piece.low, np.maximum(piece.high, piece.low)
                along_edge = edge_integral(high, piece.chip, piece.edges) - edge_integral(
                    low, piece.chip, piece.edges
                )
                out += per[:, None] * along_edge
        return out

    def generating(self, angle: Array, height: Array) -> Array:
        """Return the force of the edge that makes the wall at `angle`: it cuts there, so that start or exit, which come from a map of heights, are
        extended to that angle (within TURN / 8 of it). height: of the point of the wall; above the depth of cut that of its top."""
        near = np.remainder(angle, TURN)
        over = np.remainder(near - self.exit, TURN)
        under = np.remainder(self.start - near, TURN)
        inside = np.remainder(near - self.start, TURN) <= self.exit - self.start
        later = ~inside & (over <= under) & (over < TURN / 8)
        sooner = ~inside & ~later & (under < TURN / 8)
        wide = replace(
            self,
            start=np.where(sooner, self.start - under, self.start),
            exit=np.where(later, self.exit + over, self.exit),
        )
        return wide.force(angle, np.clip(height, 0.0, self.axial))


def _edges_of(edges: LinearEdge, rows: Ints) -> LinearEdge:
    """Return the coefficients of some of the stretches, where they have their own."""
    names = [f.name for f in fields(edges) if f.name != "source"]
    of_rows = {n: value[rows] for n in names if np.ndim(value := getattr(edges, n))}
    return replace(edges, **of_rows)
