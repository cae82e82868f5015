"""Scatter of a machine tool: large from pass to pass, and small along one pass.

A pass is what one tool cuts between two rapids. Its departure is a Gaussian-correlated process over the way of the tool,
exp(-d^2 / (2 l^2)), one draw per pass: points that a pass cuts side by side have the same departure, however many are
inspected (ISO 230-2 repeatability of positioning approaches anew; a pass approaches once).
"""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array
from vcmm.program.moves import Program
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.sweeps import LINE, Sweep

MOVE, PASS = "number_of_move", "number_of_pass"  # columns of a run of a cut
LENGTH = 20.0  # mm along the pass
CELL = 8  # places per correlation length that are distinguished
LEAST_VARIANCE = 1e-6  # of the variance of a pass that may be left out


def pass_weights(program: Program, sweep: Sweep, row: Ints, share: Array) -> Array:
    """Return the departure of each row of a cut per independent unit draw, (n, r); rows of weight have the length 1.

    row, share (n,): of the sweep.
    """
    number, way = _places(program, sweep, row, share)
    columns = []
    for pass_number in np.unique(number):
        mine = np.flatnonzero(number == pass_number)
        cell, index = np.unique(np.round(way[mine] * CELL / LENGTH), return_inverse=True)
        kernel = np.exp(-((cell[:, None] - cell[None, :]) ** 2) / (2 * CELL**2))
        value, vector = np.linalg.eigh(kernel)
        kept = value > LEAST_VARIANCE * value.sum()
        root = vector[:, kept] * np.sqrt(value[kept])
        root /= np.linalg.norm(root, axis=1, keepdims=True)
        block = np.zeros((len(row), root.shape[1]))
        block[mine] = root[index]
        columns.append(block)
    return np.concatenate(columns, axis=1) if columns else np.zeros((len(row), 0))


def move_and_pass(program: Program, sweep: Sweep, row: Ints) -> tuple[Array, Array]:
    """Return the numbers (n,) of the move that makes each row of a cut, and of its pass."""
    move = sweep.move[row]
    rapid = np.array([move.kind == "rapid" for move in program.moves])
    return move.astype(float), np.cumsum(rapid)[move].astype(float)


def _places(program: Program, sweep: Sweep, row: Ints, share: Array) -> tuple[Ints, Array]:
    """Return the number of the pass of each row and how far along the way of the tool it is, mm."""
    length = _lengths(sweep)
    before = np.concatenate([[0.0], np.cumsum(length)[:-1]])
    rapid = np.array([move.kind == "rapid" for move in program.moves])[sweep.move]
    return np.cumsum(rapid)[row], before[row] + share * length[row]


def _lengths(sweep: Sweep) -> Array:
    """Return lengths of lines, arcs and helices (m,) mm."""
    straight = np.linalg.norm(sweep.end - sweep.start, axis=1)
    arc = np.abs(sweep.turn) * np.linalg.norm(np.nan_to_num(sweep.start - sweep.centre), axis=1)
    return np.where(sweep.kind == LINE, straight, arc)
