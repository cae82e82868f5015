"""Find the best single shift of each work offset, which a shop can enter by hand, for every dialect that can be read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.compensation.field import PathErrors, field_of, known_errors_of
from vcmm.compensation.loading import MachineOfFile, load_program, machine_of
from vcmm.compensation.proof import (
    best_shifts,
    departure,
    departures,
    end_departures,
    errors_on,
    shift_errors,
    walk,
)
from vcmm.compensation.refusals import check_mark, check_moves, check_state, check_travel
from vcmm.compensation.result import Departure
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.program.interpret import read_for
from vcmm.program.moves import Move
from vcmm.program.setup import Setup


@dataclass(frozen=True, eq=False)
class OffsetOnly:
    """Shifts (3,) mm of the work offsets, machine frame, and the departures without and with them."""

    name: str
    dialect: str
    machine: str
    before: Departure
    offset_only: Departure
    shifts: Mapping[str, Array]
    warnings: tuple[str, ...]


def with_shifts(moves: Sequence[Move], field: PathErrors) -> tuple[Departure, Departure, dict[str, Array]]:
    """Return the departures of the program as it is and with its work offsets shifted by least squares over the cutting path."""
    w = walk(moves)
    error = errors_on(field, w)
    lines = [moves[i].source.line for i in w.move.tolist()]
    shifts = best_shifts(error, w, moves)
    every = np.arange(len(moves))
    both = []
    for off in (error, shift_errors(error, w, moves, shifts)):
        gap = departures(w.tip + off, moves, w.move, w.move)
        gap = np.maximum(gap, end_departures(w.tip + off, w, moves, moves, every, every))
        both.append(departure(gap, w.weight, lines))
    return both[0], both[1], shifts


def best_offsets(
    program: str | Path,
    setup: Setup,
    machine: MachineOfFile | Machine,
    *,
    dialect: str | None = None,
    set_here: bool = True,
    constants: Mapping[str, float] | None = None,
) -> OffsetOnly:
    """Return the best shift of each work offset. Raises as `compensate` does where the position or the control is not known."""
    source, setup, stated, name = load_program(program, setup, machine, dialect)
    check_mark(source)
    notes = check_state(stated, setup)
    machine = machine_of(stated)
    read = read_for("compensate", source.text, name, setup, name=source.name)
    check_moves(read.moves, machine, setup, source.name)
    check_travel(read, machine, False, source.name)
    known_errors = known_errors_of(machine)
    field = field_of(
        known_errors,
        setup,
        read.moves,
        set_here=set_here,
        constants={**setup.constants, **(constants or {})},
        lathe="lathe" in name,
    )
    before, after, shifts = with_shifts(read.moves, field)
    remarks = (*notes, *known_errors.left_out, *(f"{source.name}:{w.line}: {w.text}" for w in read.warnings))
    return OffsetOnly(
        name=source.name,
        dialect=name,
        machine=machine.name,
        before=before,
        offset_only=after,
        shifts=shifts,
        warnings=tuple(dict.fromkeys(remarks)),
    )
