"""A lathe with driven tools: surfaces of turning tools in the meridian, and of driven ones while axis C rests or turns.

Each point is that of the tool that cuts it deeper. Rows of turning tools come first, then those of driven tools; each point and each
row keeps the axes of its own process: the meridian frame, or workpiece axes (vcmm.shop.machining.turning, .rotary_milling).

Every tool of a turret was set by itself: a turning tool by a trial cut, over a turn of the spindle; a driven one along X and Z with C
at zero. The machine's errors there are subtracted, as in vcmm.shop.machining.turning. Along Y a driven tool is where the machine
holds it: no trial cut sets that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vcmm.core.errors import ModelLimit, VcmmError
from vcmm.core.inputs import Input
from vcmm.core.run import TOOL_AXIS_COLUMNS, Array, Run
from vcmm.part.part import Feature
from vcmm.physics.structure.residual import OVER_VOLUME
from vcmm.shop.cutting.contactmap import Ints, MovedCutters
from vcmm.shop.cutting.envelope import UNCUT, CutSurface
from vcmm.shop.cutting.sweeps import UP, Sweep
from vcmm.shop.machining.maps import Net
from vcmm.shop.machining.maps import net as usual_net
from vcmm.shop.machining.process import ContactRows, CutCandidates, PreparedCut, Process, Words, by_axis
from vcmm.shop.machining.rotary import Bools, commands_to_work
from vcmm.shop.machining.rotary_milling import RotaryMillingProcess
from vcmm.shop.machining.tool_errors import ToolSide
from vcmm.shop.machining.turned_blank import TurnedBlank
from vcmm.shop.machining.turned_faces import about_spindle
from vcmm.shop.machining.turned_surface import TurnedSurface
from vcmm.shop.machining.turning import TurningProcess
from vcmm.task.measuring.settings import Settings

ALONG_ITSELF = {f"led_{d}{c}": float(d == c) for d in "xyz" for c in "xyz"}  # of rows in which nothing is led
AROUND = 1e-7  # sine of the angle by which a normal may look round the spindle; mm from its axis


@dataclass(frozen=True, eq=False)
class LatheSurface(CutSurface):
    """Surface at all n points after turning tools and driven ones; driven (n,): where these cut deeper."""

    by_turning: TurnedSurface
    by_milling: CutSurface
    driven: Bools

    def take(self, rows: Array) -> LatheSurface:
        """Return some of the points."""
        columns = {n: getattr(self, n)[rows] for n in CutSurface.__dataclass_fields__}
        return LatheSurface(
            **columns,
            by_turning=self.by_turning.take(rows),
            by_milling=self.by_milling.take(rows),
            driven=self.driven[rows],
        )


@dataclass(frozen=True, eq=False)
class LatheCutters:
    """The cutters of both; driven (P,) says which kind cuts each point; the arrays of either hold its own points alone."""

    turning: MovedCutters
    driving: MovedCutters
    driven: Bools
    counts: tuple[int, int]

    def entry(self, shift: Array, normal: Array) -> Array:
        """Return where the rays from the points along normal (P, 3) meet cutters moved by shift (..., P, K, 3), (..., P, K)."""
        out = np.full(shift.shape[:-1], np.inf)
        for process, mine, count in zip(
            (self.turning, self.driving), (~self.driven, self.driven), self.counts
        ):
            if mine.any():
                out[..., mine, :count] = process.entry(shift[..., mine, :count, :], normal[mine])
        return out


@dataclass(frozen=True, eq=False)
class LatheProcess(Process):
    """Process of a lathe with driven tools. turning and driving: the two processes; driven: numbers of the driven tools."""

    turning: TurningProcess
    driving: RotaryMillingProcess
    driven: frozenset[int]
    each_tool_set = True

    @property
    def sweep(self) -> Sweep:  # type: ignore[override]
        return _both_sweeps(self.turning.sweep, self.driving.sweep)

    @property
    def _first(self) -> int:
        """Number of the first row of driven tools."""
        return len(self.turning.sweep)

    def surface(self, job: PreparedCut, points: Array, normals: Array, exact: bool) -> LatheSurface:
        turned = self._turn_surface(job, points, normals, exact)
        milled = self.driving.surface(job, points, normals, exact)
        low = [np.where(np.isfinite(surface.s), surface.s, np.inf) for surface in (turned, milled)]
        driven = low[1] < low[0]
        columns = {name: _choose(driven, getattr(turned, name), getattr(milled, name)) for name in _PER_POINT}
        row = _choose(driven, turned.row, np.where(milled.row >= 0, milled.row + self._first, -1), -1)
        return LatheSurface(
            points,
            normals,
            row=row.astype(np.intp),
            **columns,
            by_turning=turned,
            by_milling=milled,
            driven=driven,
        )

    def _turn_surface(self, job: PreparedCut, points: Array, normals: Array, exact: bool) -> TurnedSurface:
        """Return the surface after turning: nothing is cut where a surface looks round the spindle, as no surface of revolution does."""
        arm = points[:, :2] - self.turning.turning.centre
        across = arm[:, 0] * normals[:, 1] - arm[:, 1] * normals[:, 0]
        aside = np.abs(across) > AROUND * np.maximum(np.hypot(*arm.T), AROUND)
        surface = self.turning.surface(job, points, np.where(aside[:, None], UP, normals), exact)
        return replace(
            surface, normals=normals, status=np.where(aside, UNCUT, surface.status), row=np.where(aside[:, None], -1, surface.row),
            contact_s=np.where(aside[:, None], np.nan, surface.contact_s),
        )  # fmt: skip

    def contacts_seen(self, surface: CutSurface) -> tuple[Array, Array]:
        lathe = _lathe(surface)
        (a, n), (b, m) = (
            self.turning.contacts_seen(lathe.by_turning),
            self.driving.contacts_seen(lathe.by_milling),
        )
        return _choose(lathe.driven, a, b), _choose(lathe.driven, n, m)

    def candidates(self, job: PreparedCut, surface: CutSurface) -> CutCandidates:
        lathe = _lathe(surface)
        turned, milled = np.flatnonzero(~lathe.driven), np.flatnonzero(lathe.driven)
        parts = []
        if len(turned):
            parts.append((turned, self.turning.candidates(job, lathe.by_turning.take(turned))))
        if len(milled):
            of_driven = self.driving.candidates(job, lathe.by_milling.take(milled))
            parts.append(
                (
                    milled,
                    replace(of_driven, row=np.where(of_driven.row >= 0, of_driven.row + self._first, -1)),
                )
            )
        count, most = len(lathe.points), max(some.row.shape[1] for _, some in parts)
        out = CutCandidates(
            np.full((count, most), np.inf), np.zeros((count, most, 3)), np.zeros((count, most, 3)),
            np.full((count, most), -1, dtype=np.intp), np.zeros((count, most)),
        )  # fmt: skip
        for mine, some in parts:
            for name in CutCandidates.__annotations__:
                getattr(out, name)[mine, : some.row.shape[1]] = getattr(some, name)
        return out

    def cutters(self, surface: CutSurface, candidates: CutCandidates) -> LatheCutters:
        lathe = _lathe(surface)
        turned, milled = np.flatnonzero(~lathe.driven), np.flatnonzero(lathe.driven)
        first = _some(candidates, turned, 0)
        second = _some(candidates, milled, self._first)
        return LatheCutters(
            self.turning.cutters(lathe.by_turning.take(turned), first),
            self.driving.cutters(lathe.by_milling.take(milled), second),
            lathe.driven,
            (first.row.shape[1], second.row.shape[1]),
        )

    def cusp_lift(self, job: PreparedCut, surface: CutSurface, some: Ints, radius: float) -> Array:
        lathe, out = _lathe(surface), np.zeros(len(some))
        driven = lathe.driven[some]
        if (~driven).any():
            out[~driven] = self.turning.cusp_lift(job, lathe.by_turning, some[~driven], radius)
        if driven.any():
            out[driven] = self.driving.cusp_lift(job, lathe.by_milling, some[driven], radius)
        return out

    def net(self, job: PreparedCut, feature: Feature, across: int) -> Net | None:
        if about_spindle(feature, job.pose, self.turning.turning):
            return self.turning.net(job, feature, across)
        return usual_net(feature, across)

    def states(self, job: PreparedCut, rows: ContactRows) -> tuple[Run, Array]:
        known_error = np.zeros((len(rows.row), 3))
        parts = []
        for process, mine, some in self._split(rows):
            run, off = process.states(job, some)
            known_error[mine] = off
            parts.append((mine, run))
        return _merge_runs(len(rows.row), parts), known_error

    def columns(self, job: PreparedCut, rows: ContactRows) -> dict[str, Array]:
        """Return the columns; of a driven tool the way from its tip to its holder takes the place of that to the centre of a nose."""
        out: dict[str, Array] = {}
        for process, mine, some in self._split(rows):
            columns = process.columns(job, some)
            if process is self.driving:
                columns |= by_axis(
                    "nose_{}", np.column_stack([columns.pop(name) for name in TOOL_AXIS_COLUMNS])
                )
            else:
                columns["across_tool"] = np.ones(len(mine))
            for name, values in columns.items():
                out.setdefault(name, np.zeros(len(rows.row)))[mine] = values
        return out

    def fed_in_part(self, job: PreparedCut) -> Mapping[str, float]:
        milled = self.driving.fed_in_part(job)
        return {**self.turning.fed_in_part(job), **milled}

    def force(self, job: PreparedCut, rows: ContactRows, forces: Array) -> Array:
        """Return the force of turning tools alone."""
        out = np.zeros((len(rows.row), 3))
        for process, mine, some in self._split(rows):
            if process is self.turning:
                out[mine] = process.force(job, some, forces)
        return out

    @property
    def rows_per_zero(self) -> int:  # type: ignore[override]
        return self.turning.rows_per_zero

    def set_at(self, job: PreparedCut, rows: Run) -> Run:
        turned = self.turning.set_at(job, rows)
        still = self._is_driven(rows)
        position = {a: np.where(still, rows.position[a], q) for a, q in turned.position.items()}
        return replace(turned, position=position)

    def tool_side(
        self, job: PreparedCut, run: Run, setting: Ints, known_error: Array, inputs: tuple[Input, ...]
    ) -> ToolSide:
        driven = self._is_driven(run)
        ways = commands_to_work(job.machine, run)
        ways[~driven] = np.eye(3)
        turn = ways @ np.linalg.inv(ways[np.maximum(setting[:, 0], 0)])
        if "led" in run.columns:  # the control turns its zero with the part
            turn[run.columns["led"] > 0.5] = np.eye(3)
        setting = setting.copy()
        setting[driven, 1] = -1  # no trial cut sets the height of a driven tool
        phi = np.where(driven, 0.0, run.position.get("C", np.zeros(run.n)))
        return ToolSide(
            job.machine,
            run,
            setting,
            known_error,
            inputs,
            turn=turn,
            phi=phi,
            rows_per_zero=self.rows_per_zero,
        )

    def blank(self, job: PreparedCut, zero: Array) -> TurnedBlank | None:
        blank = self.turning.blank(job, zero)
        if blank is None:
            return None
        text = "the stock shows what is turned; what driven tools take away is neither drawn nor weighed, and no forces are computed of it"
        return replace(blank, remarks=(*blank.remarks, text))

    def refusal(self, job: PreparedCut) -> VcmmError | None:
        fixed = [e.id for e in job.machine.effects if isinstance(e, OVER_VOLUME)]
        if fixed:
            return ModelLimit(
                f"{', '.join(fixed)}: a field over workpiece axes says nothing of a lathe whose axis C turns; leave it out, or state the errors of "
                "the axes instead"
            )
        return None

    def why_fixed(self, job: PreparedCut) -> str:
        return self.turning.why_fixed(job)

    def engine(self, settings: Settings) -> tuple[Settings, tuple[str, ...]]:
        return self.turning.engine(settings)

    def remarks(self) -> Sequence[str]:
        return self.turning.remarks()

    def remarks_on(self, surface: CutSurface, features: Words) -> Sequence[str]:
        lathe = _lathe(surface)
        some = np.flatnonzero(~lathe.driven)
        return self.turning.remarks_on(lathe.by_turning.take(some), features[some])

    def _is_driven(self, run: Run) -> Bools:
        return np.isin(run.labels["tool"], [str(n) for n in self.driven])

    def _split(self, rows: ContactRows) -> list[tuple[Any, Ints, ContactRows]]:
        """Return (process, which rows, these rows as it numbers them) of either process that has any."""
        lathe, out = _lathe(rows.surface), []
        driven = rows.row >= self._first
        for process, mine, surface, first in (
            (self.turning, np.flatnonzero(~driven), lathe.by_turning, 0),
            (self.driving, np.flatnonzero(driven), lathe.by_milling, self._first),
        ):
            if len(mine):
                some = {n: getattr(rows, n)[mine] for n in ("point", "candidate", "share", "tip", "at")}
                part = ContactRows(surface, rows.contacts, row=rows.row[mine] - first, **some)
                out.append((process, mine, part))
        return out


_PER_POINT = ("status", "contact_s", "t", "normal", "tests")


def _lathe(surface: CutSurface) -> LatheSurface:
    assert isinstance(surface, LatheSurface)
    return surface


def _choose(driven: Bools, turned: Array, milled: Array, none: float = np.nan) -> Array:
    """Choose rows of `milled` where driven, else of `turned`; the shorter one is filled up with `none` along its second axis."""
    if turned.ndim > 1 and turned.shape[1] != milled.shape[1]:
        most = max(turned.shape[1], milled.shape[1])
        turned, milled = (_wide(values, most, none) for values in (turned, milled))
    return np.where(driven.reshape(-1, *(1,) * (turned.ndim - 1)), milled, turned)


def _wide(values: Array, count: int, none: float) -> Array:
    out = np.full((len(values), count, *values.shape[2:]), none)
    out[:, : values.shape[1]] = values
    return out


def _some(candidates: CutCandidates, points: Ints, first: int) -> CutCandidates:
    """Return the candidates of some points, rows numbered from `first` on."""
    columns = {n: getattr(candidates, n)[points] for n in CutCandidates.__annotations__}
    columns["row"] = np.where(columns["row"] >= 0, columns["row"] - first, -1)
    return CutCandidates(**columns)


def _merge_runs(count: int, parts: list[tuple[Ints, Run]]) -> Run:
    """Merge the runs of both processes into one of `count` rows; a column that only one has is zero in the rows of the other."""

    def columns_of_both(read: Callable[[Run], Mapping[str, Array]]) -> dict[str, Array]:
        out: dict[str, Array] = {}
        for mine, run in parts:
            for name, values in read(run).items():
                if name not in out:
                    out[name] = np.full(count, ALONG_ITSELF.get(name, 0.0))
                out[name][mine] = values
        return out

    offset = np.zeros((count, 3))
    labels = {n: np.full(count, "", dtype=object) for n in parts[0][1].labels}
    for mine, run in parts:
        offset[mine] = run.offset
        for name in labels:
            labels[name][mine] = run.labels[name]
    named = {n: values.astype(str) for n, values in labels.items()}
    return Run(columns_of_both(lambda r: r.position), offset, columns_of_both(lambda r: r.columns), named)


def _both_sweeps(first: Sweep, other: Sweep) -> Sweep:
    """Join the rows of both, with tools numbered on."""
    names = ("start", "end", "centre", "normal", "turn", "kind", "move", "axis")
    stacked: dict[str, Any] = {n: np.concatenate([getattr(s, n) for s in (first, other)]) for n in names}
    tool = np.concatenate([first.tool, other.tool + len(first.tools)])
    return Sweep(**stacked, tool=tool, tools=first.tools + other.tools)
