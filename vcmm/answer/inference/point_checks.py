"""Check that points belong to the part: labels, unit, frame, tip, extent. Messages say what to do next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.answer.inference.given_points import GivenPoints
from vcmm.core.errors import DataError, choose_from
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.part.extent import EDGE, beyond_extent
from vcmm.part.mesh import closest
from vcmm.part.part import Feature, Part, normal, signed_distance
from vcmm.task.measuring.plan import Ints
from vcmm.task.measuring.scenario import Scenario

# of the tip radius: points that lie this close to one radius off every surface are tip centres
TIP_SHARE = 0.1
MOST_NAMED = 5  # points named in a message, the rest is counted
UNIT_FACTORS = {
    "inches": 25.4,
    "metres": 1000.0,
    "micrometres": 1e-3,
    "mm": 1 / 25.4,  # their columns say inches
}


@dataclass(frozen=True, eq=False)
class OnSurface:
    """Points of one feature on its nominal surface: rows of the file, distance (n,) outwards, foot and normal (n, 3)."""

    feature: Feature
    rows: Ints
    distance: Array
    foot: Array
    normal: Array


def feature_rows(scenario: Scenario, given: GivenPoints) -> dict[str, Ints]:
    """Return the rows of every feature. DataError: labels that match none, a wrong number of rows in plan order, a feature missing."""
    part, plan = scenario.part, scenario.plan
    if given.features is None:
        planned = [s.feature for s in plan.steps for _ in s.points]
        if len(planned) != len(given.points):
            raise DataError(
                f"{given.where[0]}: {_of(given)}{len(given.points)} rows without a column feature, but the plan touches "
                f"{len(planned)} points; add the column feature or give the points in the order of the plan"
            )
        words: Sequence[str] = planned
    else:
        words = given.features
    wrong = [i for i, w in enumerate(words) if w not in part.features]
    if wrong:
        raise DataError(
            [
                f'{given.where[i]}: the part has no feature "{words[i]}".{choose_from(words[i], part.features)}'
                for i in _first_of_each(words, wrong)
            ]
        )
    rows = {
        w: np.array([i for i, o in enumerate(words) if o == w], dtype=np.intp) for w in dict.fromkeys(words)
    }
    _check_complete(scenario, rows, given)
    return rows


def repetition_remarks(given: GivenPoints) -> tuple[str, ...]:
    """Return a remark where rows hold the very same point: a copied row counts as a touch of its own, and U is too small."""
    _, first, same = np.unique(given.points, axis=0, return_index=True, return_inverse=True)
    earlier = first[np.ravel(same)]  # the first row that holds the point of each row
    copies = [i for i, first_row in enumerate(earlier) if first_row != i]
    if not copies:
        return ()
    named = [f"{given.where[i]} as {given.where[earlier[i]]}" for i in copies[:MOST_NAMED]]
    more = f" and {len(copies) - MOST_NAMED} more" if len(copies) > MOST_NAMED else ""
    return (
        f"{', '.join(named)}{more}: the same point to the last digit; each row counts as a touch of its own: remove it where it was copied",
    )


def _first_of_each(words: Sequence[str], rows: Sequence[int]) -> list[int]:
    return [next(i for i in rows if words[i] == w) for w in dict.fromkeys(words[i] for i in rows)]


def _check_complete(scenario: Scenario, rows: Mapping[str, Ints], given: GivenPoints) -> None:
    """Check that every feature that a characteristic or the alignment needs has points."""
    from vcmm.part.gps.characteristics import needs

    reasons = {n: f'the characteristic "{c.name}"' for c in scenario.part.characteristics for n in needs(c)}
    scheme = scenario.plan.alignment
    if scheme:
        for role in (scheme.plane, scheme.line, scheme.origin):
            reasons |= {n: "the alignment" for n in ((role,) if isinstance(role, str) else role) if n}
    missing = [
        f'{given.where[0]}: {_of(given)}no points of "{n}", which {why} needs'
        for n, why in reasons.items()
        if n not in rows
    ]
    if missing:
        raise DataError(missing)


def _of(given: GivenPoints) -> str:
    return f'part "{given.part}": ' if given.part else ""


def surfaces(part: Part, rows: Mapping[str, Ints], points: Array) -> dict[str, OnSurface]:
    """Return where the points (n, 3) of every feature, drawing frame, lie nearest to its nominal surface."""
    out = {}
    for name, at in rows.items():
        feature, p = part.features[name], points[at]
        if feature.kind == "mesh":
            assert part.mesh is not None
            distance, outward = closest(part.mesh, p)
            inner = (
                closest(part.mesh, p + distance[:, None] * outward)[0]
                < closest(part.mesh, p - distance[:, None] * outward)[0]
            )
            distance = np.where(inner, -distance, distance)
        else:
            distance, outward = signed_distance(feature, p), normal(feature, p)
        out[name] = OnSurface(feature, at, distance, p - distance[:, None] * outward, outward)
    return out


def check_points(
    scenario: Scenario, given: GivenPoints, points: Array, placed: Mapping[str, OnSurface], in_machine: bool
) -> None:
    """Raise DataError for points that are not those of this part: too far from its surfaces, tip centres, beyond the extents."""
    reach = scenario.plan.touch.approach
    far = [(p, i) for p in placed.values() for i in np.flatnonzero(np.abs(p.distance) > reach)]
    hint = _tip_hint(scenario, placed)
    if hint and not far:
        raise DataError(f"{given.where[0]}: {hint}")
    if far:
        worst = sorted(far, key=lambda pair: -abs(pair[0].distance[pair[1]]))[:MOST_NAMED]
        hint = (
            hint or _unit_hint(scenario, given, placed) or _frame_hint(scenario, points, placed, in_machine)
        )
        raise DataError(
            [
                f"{given.where[p.rows[i]]}: {abs(p.distance[i]):.4g} mm {'outside' if p.distance[i] > 0 else 'inside'} the nominal "
                f'surface of "{p.feature.name}", more than the approach of {reach:g} mm{_also(len(far), worst, k)}'
                for k, (p, i) in enumerate(worst)
            ]
            + [
                hint
                or "Are these points of another part, or another feature? Correct the labels or the part."
            ]
        )
    if hint:
        raise DataError(f"{given.where[0]}: {hint}")
    _check_normals(given, placed)
    _check_extent(given, placed)


def _also(count: int, named: Sequence[object], k: int) -> str:
    left = count - len(named)
    return f" ({left} more points are)" if left and k == len(named) - 1 else ""


def _unit_hint(scenario: Scenario, given: GivenPoints, placed: Mapping[str, OnSurface]) -> str:
    for word, factor in UNIT_FACTORS.items():
        if _fits(scenario, placed, given.points * factor):
            return (
                f"The points fit when they are taken as {word}: name the columns by their unit (x_mm, x_in, x_m, x_um) or "
                "convert the file."
            )
    return ""


def _frame_hint(scenario: Scenario, points: Array, placed: Mapping[str, OnSurface], in_machine: bool) -> str:
    other: Pose = scenario.pose if in_machine else scenario.pose.inverse()
    if _fits(scenario, placed, other.apply(points)):
        return f"The points fit in the other frame: use --frame {'part' if in_machine else 'machine'}."
    return ""


def _fits(scenario: Scenario, placed: Mapping[str, OnSurface], points: Array) -> bool:
    """Return whether all points (n, 3) would lie within reach of their surfaces."""
    there = surfaces(scenario.part, {n: p.rows for n, p in placed.items()}, points)
    return all(np.abs(p.distance).max() <= scenario.plan.touch.approach for p in there.values())


def _tip_hint(scenario: Scenario, placed: Mapping[str, OnSurface]) -> str:
    """Return a hint on tip centres, which lie one tip radius off every surface, and on points compensated twice, which lie one to the other side."""
    styli = {s.feature: scenario.plan.styli[s.stylus].tip_radius for s in scenario.plan.steps}
    tips = [(float(np.median(p.distance)), styli[n]) for n, p in placed.items() if styli.get(n, 0.0) > 0.0]
    if tips and all(abs(d - r) < TIP_SHARE * r for d, r in tips):
        return (
            f"All points lie one tip radius ({tips[0][1]:g} mm) outside the nominal surfaces: they seem to be tip centres; "
            "give --tip-centres, or compensate them for the tip."
        )
    if tips and all(abs(d + r) < TIP_SHARE * r for d, r in tips):
        return (
            f"All points lie one tip radius ({tips[0][1]:g} mm) inside the nominal surfaces: they seem to be compensated "
            "for the tip already; leave --tip-centres out."
        )
    return ""


def _check_normals(given: GivenPoints, placed: Mapping[str, OnSurface]) -> None:
    """Check that given normals point out of the material, as the nominal ones do."""
    if given.normals is None:
        return
    problems = []
    for p in placed.values():
        size = np.linalg.norm(given.normals[p.rows], axis=1)
        along = (given.normals[p.rows] * p.normal).sum(axis=1)
        for i in np.flatnonzero((np.abs(size - 1.0) > 0.01) | (along < 0.5 * size)):
            what = f"nx ny nz has the length {size[i]:.4g}; give a unit vector"
            if abs(size[i] - 1.0) <= 0.01:
                what = f'nx ny nz is {np.degrees(np.arccos(np.clip(along[i], -1, 1))):.0f} deg off the outward normal of "{p.feature.name}"; normals point out of the material'
            problems.append(f"{given.where[p.rows[i]]}: {what}")
    if problems:
        raise DataError(problems[:MOST_NAMED])


def _check_extent(given: GivenPoints, placed: Mapping[str, OnSurface]) -> None:
    problems = []
    for p in placed.values():
        beyond = beyond_extent(p.feature, p.foot)
        problems += [
            f'{given.where[p.rows[i]]}: {beyond[i]:.4g} mm beyond the extent of "{p.feature.name}"; correct the label, the point or the '
            "size of the feature"
            for i in np.flatnonzero(beyond > EDGE)
        ]
    if problems:
        left = len(problems) - MOST_NAMED
        raise DataError(
            problems[:MOST_NAMED]
            + ([f"and {left} more points lie beyond their features"] if left > 0 else [])
        )
