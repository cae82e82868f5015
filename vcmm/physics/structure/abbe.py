"""Abbe errors of the stored tables: rotations acting on an arm that was counted twice, or differs from the assumed one.

Both are made from the machine's rotation tables (`from_tables`), copied at their nodes. An arm r is a place in the
axis's own moving frame; a rotation w moves its end by w x r. Own motion of the axis, as the tables are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vcmm.core.declaration import About, ForDiagnosis, Site, Typical, Words
from vcmm.core.effect import Effect, along, argument_grids, argument_letters, at, param, points
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.grid import multilinear
from vcmm.core.run import Array, Run

METRE = 1000.0  # rotations are kept as what they move at the end of an arm of 1 m: 1 um is 1 urad
FINER = 8  # pieces per interval of a spline, which is not straight between its nodes


@dataclass(frozen=True, eq=False)
class _Abbe(Effect):
    per = "map"
    own = True
    about = About(
        cites="Bryan, Precision Engineering 1 (1979) 129: the Abbe principle revisited",
    )
    axis: str = at("X", "axis whose rotation tables act on the arm")
    arguments: tuple[str, ...] = argument_letters()
    grids: tuple[Array, ...] = argument_grids(())
    deviation: Any = points(lambda: np.zeros((0, 3)))

    @property
    def link(self) -> str:
        return self.axis

    def _interpolate(self, run: Run) -> Array:
        """Return the deviation (n, 3) at the rows. Raises ModelLimit outside the table, UsageError without one."""
        deviation = np.asarray(self.deviation, dtype=float)
        if not self.grids or len(deviation) != int(np.prod([len(g) for g in self.grids])):
            raise UsageError(
                f"{self.id} needs the rotation tables of axis {self.axis}: argument_letters, argument_grids, deviation"
            )
        positions = [run.q(a) for a in self.arguments]
        for letter, q, grid in zip(self.arguments, positions, self.grids):
            outside = np.flatnonzero((q < grid[0] - 1e-6) | (q > grid[-1] + 1e-6))
            if len(outside):
                raise ModelLimit(f"{self.id}: {letter} = {q[outside[0]]:.6g} lies outside its table")
        weights, nodes = multilinear(positions, self.grids)
        return np.asarray((weights[:, :, None] * deviation[nodes]).sum(axis=1))


@dataclass(frozen=True, eq=False)
class AbbeCountedTwice(_Abbe):
    """-share (rotation table x arm of the reference line), share = 1: the translation tables hold that part already.

    `deviation` is rotation x arm at the nodes in mm. The arm is where the translations were observed (measured_at).
    """

    name = "abbe_counted_twice"
    diagnosis = ForDiagnosis(
        is_named=False,
        special_case_of=("geometric_change", "abbe_offset"),
    )
    about = replace(
        _Abbe.about,
        words=Words(
            seen="the Abbe arm of {where} is wrong in the table by its full length",
            causes="a table taken at the reference line and corrected once more, or not at all",
            confirm="measure the position of {where} on two lines",
        ),
    )
    share: float = param(
        0.0,
        "%",
        "1 = counted twice in full, -1 = left out",
        show="1",
        typical=Typical(1.0, "a mistake: the coefficient is 1 or -1"),
    )

    @classmethod
    def from_tables(cls, axis: str, effects: Iterable[Effect], arm: Sequence[float]) -> AbbeCountedTwice:
        """Return the effect with share = 1 for the rotation tables of one axis and an arm (3,) mm, such as measured_at."""
        argument_letters, argument_grids, rotations = rotation_tables(axis, effects)
        return cls(
            axis, argument_letters, argument_grids, np.cross(rotations, np.asarray(arm, dtype=float)), 1.0
        )

    def error_motion(self, run: Run) -> Array:
        return along(run, self._interpolate(run), np.full(run.n, -self.share))


def _abbe_offset_make_at(cls: type[AbbeOffset], place: Mapping[str, Any], site: Site) -> AbbeOffset:
    return cls.from_tables(place["axis"], site.effects)


@dataclass(frozen=True, eq=False)
class AbbeOffset(_Abbe):
    """+rotation table x arm: the tip, or the reference line, is off its assumed place by the vector `arm`.

    `deviation` is the rotation (a, b, c) at the nodes, as mm at the end of an arm of 1 m (1 um = 1 urad).
    """

    name = "abbe_offset"
    diagnosis = ForDiagnosis(
        special_case_of=("geometric_change",),
        holds_table_edits=True,
        size_name="arm",
        make_at=_abbe_offset_make_at,
    )
    about = replace(
        _Abbe.about,
        words=Words(
            seen="{where} was measured on another line than stated ({arm})",
            causes="reflector or tool offset entered wrongly",
            confirm="measure {where} on a second, parallel line",
            signed=("arm",),
        ),
    )
    arm: Any = param(
        lambda: np.zeros(3),
        "mm",
        "unknown arm in the axis's moving frame",
        shape="(3,)",
        typical=Typical(50.0, "a reflector or stylus taken for another: 10-200 mm"),
    )

    @classmethod
    def from_tables(cls, axis: str, effects: Iterable[Effect]) -> AbbeOffset:
        """Return the effect with an arm of zero for the rotation tables of one axis."""
        argument_letters, argument_grids, rotations = rotation_tables(axis, effects)
        return cls(axis, argument_letters, argument_grids, rotations * METRE, np.zeros(3))

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        out[:, :3] = np.cross(self._interpolate(run) / METRE, np.asarray(self.arm, dtype=float))
        return out


def rotation_tables(axis: str, effects: Iterable[Effect]) -> tuple[tuple[str, ...], tuple[Array, ...], Array]:
    """Return (argument_letters, argument_grids, rotations (nodes, 3) rad): the stored rotation tables of one axis, summed on common nodes.

    Exact for tables (linear between nodes); splines are sampled 8 times finer. Raises UsageError when there is none.
    """
    stored = [
        e
        for e in effects
        if e.link == axis
        and e.about.table_parameter
        and str(getattr(e, "component", ""))[1:2] in tuple("ABC")
    ]
    if not stored:
        raise UsageError(
            f"axis {axis} has no rotation tables EA{axis}, EB{axis}, EC{axis}; there is no Abbe error"
        )
    grids: dict[str, Array] = {}
    for effect in stored:
        for letter, nodes in _nodes(effect).items():
            grids[letter] = np.union1d(grids.get(letter, nodes), nodes)
    mesh = np.meshgrid(*grids.values(), indexing="ij")
    run = Run({a: m.ravel() for a, m in zip(grids, mesh)}, np.zeros((mesh[0].size, 3)))
    total = np.sum([e.error_motion(run)[:, 3:] for e in stored], axis=0)
    return tuple(grids), tuple(grids.values()), total


def _nodes(effect: Any) -> Mapping[str, Array]:
    """Return the positions of a table over its arguments, or of a spline over its own axis."""
    if hasattr(effect, "grids"):
        return {a: np.asarray(g, dtype=float) for a, g in zip(effect.arguments, effect.grids)}
    coarse = np.asarray(effect.nodes, dtype=float)
    fine = np.linspace(0.0, len(coarse) - 1.0, (len(coarse) - 1) * FINER + 1)
    return {effect.link: np.interp(fine, np.arange(float(len(coarse))), coarse)}
