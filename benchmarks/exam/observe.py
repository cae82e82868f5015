"""What is observed: the real machine (exact chain) with something concealed, nuisance, and scatter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from benchmarks.exam.design import Design, unit
from benchmarks.exam.kinema import Array, Errors, tip
from benchmarks.exam.machines import Machine


@dataclass(frozen=True, eq=False)
class Hidden:
    """What is concealed. actual: added to an axis's position, sense of the command. six: own error motions added to an
    axis. square rad. place: location of rotary axes. shift (n, 3) of the tip, workpiece axes, actual - nominal.
    reading (n,) indicated - true along the normal. vector (n, 3) the same as a vector."""

    actual: Mapping[str, Array] = field(default_factory=dict)
    six: Mapping[str, Array] = field(default_factory=dict)
    square: Mapping[str, float] = field(default_factory=dict)
    place: Mapping[str, Array] = field(default_factory=dict)
    shift: Array | float = 0.0
    reading: Array | float = 0.0
    vector: Array | None = None


def join(parts: list[Hidden]) -> Hidden:
    """Several effects at once."""
    maps = {}
    for word in ("actual", "six", "square", "place"):
        total: dict[str, Array] = {}
        for part in parts:
            for k, v in getattr(part, word).items():
                total[k] = total.get(k, 0.0) + v
        maps[word] = total
    vectors = [p.vector for p in parts if p.vector is not None]
    shift = sum((np.asarray(p.shift) for p in parts), np.zeros(1))
    reading = sum((np.asarray(p.reading) for p in parts), np.zeros(1))
    return Hidden(**maps, shift=shift, reading=reading, vector=sum(vectors) if vectors else None)


def real_errors(design: Design, machine: Machine, hidden: Hidden, stale: float = 1.0) -> Errors:
    """Tables are entered with the commanded position, as a calibration was."""
    six = {a: machine.real(a, design.q[a], stale) for a in machine.kind.linear}
    for a, more in hidden.six.items():
        six[a] = six.get(a, 0.0) + more
    square = {
        p: machine.square[p] + stale * machine.missed_square[p] + hidden.square.get(p, 0.0)
        for p in machine.square
    }
    return Errors(six, square, hidden.place, hidden.actual)


def tip_motion(design: Design, errors: Errors, shift: Array | float = 0.0) -> Array:
    """actual - nominal (n, 3), workpiece axes."""
    chain = design.machine.chain
    return tip(chain, design.q, design.offset, errors) - tip(chain, design.q, design.offset, Errors()) + shift


def observed(design: Design, motion: Array, hidden: Hidden) -> Array:
    """Observations (n,) or (3n,), mm, from the tip's motion and the readings; exact lengths and sphere contact."""
    if design.normal is None:
        more = hidden.vector if hidden.vector is not None else 0.0
        return (design.sign * motion + more).ravel()
    if design.kind == "length":
        far = design.nominal_tip() - design.hidden["station"]
        out = np.linalg.norm(far + motion, axis=1) - np.linalg.norm(far, axis=1)
        return design.sign * out + hidden.reading
    n = design.normal
    along = (motion * n).sum(axis=1)
    if (
        "ball_radius" in design.hidden
    ):  # the ball is met where its centre distance is R + r, a little past the normal
        across = ((motion - along[:, None] * n) ** 2).sum(axis=1)
        r = design.hidden["ball_radius"]
        along = along + r - np.sqrt(r**2 - across)
    return design.sign * along + hidden.reading


def nuisance_draw(design: Design, rng: np.random.Generator) -> Array:
    """Placement, zero, offset and so on as they happen, mm: exact turns of the artefact, small shifts."""
    n = design.normal if design.normal is not None else None
    out = np.zeros(design.rows if n is not None else (design.rows, 3))
    place = design.nominal_tip()
    for word, label in design.nuisance.items():
        codes = design.codes(label)
        for code in np.unique(codes):
            mine = codes == code
            if word in ("zero", "dead_path", "radius"):
                out[mine] += rng.normal(0, 2e-3 if word != "radius" else 0.5e-3)
                continue
            move = np.tile(rng.normal(0, 3e-3, 3), (int(mine.sum()), 1))
            if word in ("rigid", "alignment"):
                arm = place[mine] - place[mine].mean(axis=0)
                move = move + np.cross(rng.normal(0, 8e-6, 3), arm)
            out[mine] += move if n is None else (move * n[mine]).sum(axis=1)
    return out.ravel()


def nuisance_columns(design: Design) -> Array:
    """The same as linear columns, for the projection in `strength`."""
    place, n = design.nominal_tip(), design.normal
    columns = []
    for word, label in design.nuisance.items():
        codes = design.codes(label)
        for code in np.unique(codes):
            mine = (codes == code).astype(float)
            if word in ("zero", "dead_path", "radius"):
                columns.append(mine)
                continue
            fields = [np.tile(e, (design.rows, 1)) for e in np.eye(3)]
            if word in ("rigid", "alignment"):
                arm = (place - place[mine > 0].mean(axis=0)) / 100.0
                fields += [np.cross(e, arm) for e in np.eye(3)]
            for f in fields:
                f = f * mine[:, None]
                columns.append(f.ravel() if n is None else (f * n).sum(axis=1))
    return np.column_stack(columns) if columns else np.zeros((design.rows, 0))


def directions(design: Design) -> Array:
    """(m, 3) sensitive direction of each observation."""
    return np.tile(np.eye(3), (design.rows, 1)) if design.normal is None else unit(design.normal)
