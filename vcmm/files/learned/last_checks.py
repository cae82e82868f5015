"""Compare a check with its forecast: a ball bar over its angle, a laser over its axis, all else reading by reading.

    seen = value - N (nuisance)           forecast = machine file + C theta(state before) - N (nuisance)

both with the nuisance (zero, centre, place of the artefact) fitted to themselves by least squares; the band is that of one reading:
the uncertainty of the state before, in quadrature with the noise of the reading.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vcmm.core.errors import choose_from
from vcmm.core.run import Array
from vcmm.files.own.recording import load_recording
from vcmm.learn.calibration.solve import nuisance_basis
from vcmm.learn.diagnosis.problem import Problem, make_problem
from vcmm.learn.tracking.compress import columns_of
from vcmm.learn.tracking.follow import FollowedMachine
from vcmm.learn.tracking.learn_rates import of_whole_state

if TYPE_CHECKING:
    from vcmm.files.learned.track_result import Track

PLANES = {"XY": (0, 1), "YZ": (1, 2), "ZX": (2, 0)}
CIRCLE_READINGS = 8  # readings of a plane that make a circle
FLAT = 1e-6  # share of a direction out of the plane


@dataclass(frozen=True, eq=False)
class CheckPart:
    """Data of one picture. name: recording, with the plane of a circle; place (n,): rad of a circle, mm of an axis, number of the reading.

    up (n,): 1.0 forwards, -1.0 backwards along the axis, 0.0 no matter. seen, forecast, u (n,) in `unit`; u: of forecast and reading together.
    """

    name: str
    date: str
    axis: str
    circle: bool
    unit: str
    place: Array
    up: Array
    readings: Array
    forecast: Array
    u: Array

    @property
    def inside(self) -> float:
        """Share of the readings within 1.96 u of their forecast."""
        return float((np.abs(self.readings - self.forecast) < 1.96 * self.u).mean())


def check_parts(track: Track, name: str) -> tuple[CheckPart, ...]:
    """Return the parts of a recording by its name, or by its name and a plane ("345_bar.toml YZ"). Raises KeyError with the closest names."""
    number = next((i for i, c in enumerate(track.checks) if name.split(" ")[0] == c.name), None)
    if number is None:
        raise KeyError(
            f'no recording "{name}" was followed.{choose_from(name, [c.name for c in track.checks])}'
        )
    file, followed = track.checks[number].name, track.followed
    recording, _ = load_recording(track.folder / file, followed.tracked.machine, gaps=True)
    problem = make_problem(recording, followed.tracked.machine)
    values_seen, forecast, u = _beside(
        followed, track.states_before(number), problem, followed.recordings[number].noise
    )
    scale, unit = (1e6, "µrad") if recording.kind == "angle" else (1e3, "µm")
    values = (values_seen * scale, forecast * scale, u * scale)
    parts = _circles(problem, (file, track.checks[number].date, unit), values)
    parts = parts or (_along(problem, (file, track.checks[number].date, unit), values),)
    return tuple(p for p in parts if name in (file, p.name)) or parts


def last_checks(track: Track) -> tuple[CheckPart, ...]:
    """Return the last recording of every kind (by its readings): the newest first, three at most."""
    out: list[CheckPart] = []
    kinds: set[tuple[str, bool]] = set()
    for check in reversed(track.checks[-LOOKED:]):
        parts = check_parts(track, check.name)
        kind = (parts[0].axis, parts[0].circle)
        if kind not in kinds:
            kinds.add(kind)
            out += parts
        if len(kinds) == 3:
            break
    return tuple(out)


LOOKED = 8  # recordings, from the last one back


def _beside(
    followed: FollowedMachine, state: tuple[Array, Array], problem: Problem, noise: float
) -> tuple[Array, Array, Array]:
    """Return (seen, forecast, u) (m,) mm or rad, with the nuisance removed from each."""
    mean, factor = state
    shown = of_whole_state(columns_of(followed.tracked, problem), followed.tracked.stated)
    basis = nuisance_basis(problem.nuisance / problem.u[:, None])

    def free(values: Array) -> Array:
        white = (values.T / problem.u).T
        return np.asarray(((white - basis @ (basis.T @ white)).T * problem.u).T)

    value = problem.recording.value
    spread = free(shown @ factor)
    u = np.hypot(np.sqrt((spread**2).sum(axis=1)), noise * problem.u)
    return free(value), free(value - problem.residual + shown @ mean), u


def _circles(
    problem: Problem, words: tuple[str, str, str], values: tuple[Array, Array, Array]
) -> tuple[CheckPart, ...]:
    """Return, for lengths, a picture for each plane in which the bar went round; none where it did not."""
    if problem.recording.kind != "length":
        return ()
    file, date, unit = words
    way, out = problem.recording.direction, []
    plane_of = _planes_of(way)
    for number, (plane, (i, j)) in enumerate(PLANES.items()):
        rows = np.flatnonzero(plane_of == number)
        if len(rows) < CIRCLE_READINGS:
            continue
        angle = np.arctan2(way[rows, j], way[rows, i]) % (2 * np.pi)
        order = np.argsort(angle, kind="stable")
        observed, forecast, u = (v[rows][order] for v in values)
        flat = np.zeros(len(rows))
        out.append(
            CheckPart(
                f"{file} {plane}",
                date,
                plane,
                circle=True,
                unit=unit,
                place=angle[order],
                up=flat,
                readings=observed,
                forecast=forecast,
                u=u,
            )
        )
    return tuple(out)


def _planes_of(way: Array) -> Array:
    """Return the number of the plane in which each reading was made (m,), -1: of none. One along an axis lies in two: it takes that of
    the next reading, else of the one before."""
    flat = np.stack([np.hypot(way[:, i], way[:, j]) > 1 - FLAT for i, j in PLANES.values()], axis=1)
    direction = np.where(flat.sum(axis=1) == 1, flat.argmax(axis=1), -1)
    sure, out = np.flatnonzero(direction >= 0), direction.copy()
    for k in np.flatnonzero(flat.sum(axis=1) > 1):
        at = int(np.searchsorted(sure, k))
        near = [int(direction[sure[n]]) for n in (at, at - 1) if 0 <= n < len(sure)]
        out[k] = next((p for p in near if flat[k, p]), -1)
    return out


def _along(problem: Problem, words: tuple[str, str, str], values: tuple[Array, Array, Array]) -> CheckPart:
    """Return a picture over the one axis that moved, by its sense; else reading by reading."""
    file, date, unit = words
    observed, forecast, u = values
    run, row = problem.recording.run, problem.recording.row
    moved = [a for a, q in run.position.items() if np.ptp(q[row]) > 1e-6]
    if problem.recording.kind == "probe" or len(moved) != 1:
        number = np.arange(1.0, len(row) + 1)
        return CheckPart(
            file,
            date,
            "",
            False,
            unit,
            number,
            up=np.zeros(len(row)),
            readings=observed,
            forecast=forecast,
            u=u,
        )
    place = np.asarray(run.position[moved[0]][row], dtype=float)
    step = np.diff(place, prepend=2 * place[0] - place[min(1, len(place) - 1)])
    up = np.where(step == 0, np.nan, np.sign(step))
    for k in range(len(up)):  # a position that is read again keeps the sense in which it was reached
        up[k] = (up[k - 1] if k else 1.0) if np.isnan(up[k]) else up[k]
    return CheckPart(
        file, date, moved[0], False, unit, place, up=up, readings=observed, forecast=forecast, u=u
    )
