"""Cutting force at the moment at which an edge makes a point of the wall, instead of the mean of a turn.

A wall keeps the place of the tool at the moments at which its edges touch it. With straight edges that is at phi = 0 (conventional) or
phi = pi (climb), where the chip has no thickness: only the edge forces act. An edge of helix b lags by kappa = tan b / R per mm of height,
so that height z of the wall is made while the edge is at phi_s there and at phi_s - kappa (zeta - z) at height zeta:

    F(z) = sum over teeth j of  int_0^a dF(phi_s - 2 pi j / N - kappa (zeta - z)) dzeta,    where phi lies within start and exit

and every height of the wall has a force of its own. Its mean over a turn is `milling_force`.

Source: Altintas, Manufacturing Automation, 2nd ed. (2012), 2.8 and 4.4 (surface form errors in peripheral milling); Kline, DeVor, Shareef,
J. Eng. Ind. 104 (1982) 272. Frame and angles as in vcmm.shop.cutting.force.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from vcmm.core.laws import Array
from vcmm.program.setup import LinearEdge
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.force import edge_force, edge_integral
from vcmm.shop.cutting.runout import NONE, ChipPiece, chip_at, chip_pieces, with_more_chip

TURN = 2.0 * np.pi
STRAIGHT = 1e-7  # rad of lag over the whole depth, below which an edge is straight
SLACK = 1e-9  # rad


@dataclass(frozen=True, eq=False)
class ToothCuts:
    """Engagement of each of m stretches of a path: start and exit rad, axial depth mm, feed per tooth mm, teeth, lag kappa rad/mm (nan: helix not
    known), edge coefficients, run-out of the tool mm (`vcmm.shop.cutting.runout`; tooth 0 protrudes most)."""

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
