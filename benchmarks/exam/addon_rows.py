"""Rows of an add-on measurement: a recording taken again at some of its places, with one thing changed as an operator does it.

Everything that follows from the machine's path (sense, distance since the reversal) is walked anew; what cannot be done is
said (NotPossible): a ball bar passes every place at one distance from its reversal only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.exam.design import Design, since_reversal
from benchmarks.exam.design_probe import BODY, _about_stylus
from benchmarks.exam.kinema import Array
from benchmarks.exam.machines import BRIDGE

ROWS = 80
XYZ = "XYZ"


class NotPossible(Exception):
    """This add-on cannot be measured on this design; says why."""


@dataclass(frozen=True, eq=False)
class Part:
    """Rows taken again, in order, and the way points of each (k, 3) up to and including the reading."""

    design: Design
    legs: tuple[Array, ...] = ()


def taken(d: Design, rows: int = ROWS) -> Part:
    """`rows` of the design, evenly through it."""
    pick = np.unique(np.linspace(0, d.rows - 1, min(rows, d.rows)).astype(int))
    part = replace(
        d, q={a: v[pick] for a, v in d.q.items()}, offset=d.offset[pick],
        normal=None if d.normal is None else d.normal[pick], columns={k: v[pick] for k, v in d.columns.items()},
        labels={k: [v[i] for i in pick] for k, v in d.labels.items()}, hidden={k: v[pick] for k, v in d.hidden.items()},
        nodes=None, row_node=None,
    )  # fmt: skip
    if d.nodes is None or d.row_node is None:
        return Part(part)
    first = np.concatenate([[1], d.row_node[:-1] + 2])  # behind the retreat of the row before
    return Part(part, tuple(d.nodes[first[i] : d.row_node[i] + 1] for i in pick))


def place(d: Design) -> Array:
    """Axis positions of X Y Z (n, 3)."""
    return np.column_stack([d.q[a] for a in XYZ])


def _relabelled(d: Design, **labels: str) -> dict[str, list[str]]:
    return {k: [labels.get(k, "{}").format(v) for v in column] for k, column in d.labels.items()}


def faster(part: Part) -> Part:
    """2.5 times the speed; on a curved path 6.25 times the acceleration."""
    d = part.design
    if not any(k.startswith("speed_") and np.any(v) for k, v in d.columns.items()):
        raise NotPossible("the log holds no speed")
    more = {k: 2.5 * v for k, v in d.columns.items() if k.startswith(("speed_", "feed_"))}
    if d.kind == "path":
        more |= {k: 6.25 * v for k, v in d.columns.items() if k.startswith("accel_")}
    return replace(part, design=replace(d, columns={**d.columns, **more}))


def other_side(part: Part) -> Part:
    """Touches: the way to the place in front of the surface is mirrored (a touch itself can only go inwards). Other
    recordings run the other way round, from the other turning point."""
    d = part.design
    if part.legs:
        q, n = place(d), np.asarray(d.normal)
        legs = []
        for leg, here, out in zip(part.legs, q, n):
            away = leg[0] - here
            along = (away @ out) * out
            legs.append(np.vstack([here + along - (away - along), leg[1:]]))
        return replace(part, legs=tuple(legs))
    moved = [a for a in XYZ if f"sense_{a}" in d.columns and np.ptp(d.q[a]) > 0]
    if not moved:
        raise NotPossible("the log holds no sense of approach")
    more = {f"sense_{a}": -d.columns[f"sense_{a}"] for a in moved}
    more |= {k: -d.columns[k] for k in (f"speed_{a}_mm_s" for a in moved) if k in d.columns}
    for a in moved:
        key = f"since_reversal_{a}_mm"
        if key in d.columns:
            whole = 10.0 + np.ptp(d.q[a]) if d.kind == "displacement" else 300.0
            more[key] = np.maximum(whole - d.columns[key], 0.0)
    return replace(part, design=replace(d, columns={**d.columns, **more}))


def after_reversal(part: Part) -> Part:
    """Back off from in front of the surface, then touch: the reversal lies a tenth of the former way before the reading."""
    d = part.design
    if part.legs:
        q, n = place(d), np.asarray(d.normal)
        legs = []
        for leg, here, out in zip(part.legs, q, n):
            far = 0.1 * float((leg[0] - here) @ out)
            legs.append(np.vstack([leg[0], here + 0.3 * far * out, here + far * out, here]))
        return replace(part, legs=tuple(legs))
    if d.kind != "displacement":
        raise NotPossible("a trace passes every place at one distance from its reversal only")
    more = {k: 0.1 * v for k, v in d.columns.items() if k.startswith("since_reversal_")}
    return replace(part, design=replace(d, columns={**d.columns, **more}))


def longer_stylus(part: Part) -> Part:
    d = part.design
    if "stylus_length_mm" not in d.columns or "axis" not in d.hidden:
        raise NotPossible("there is no stylus")
    length = 2.0 * d.columns["stylus_length_mm"]
    offset = d.hidden["axis"] * (BODY + length)[:, None]
    return _moved(
        part,
        place(d) + d.offset - offset,
        offset=offset,
        columns={**d.columns, "stylus_length_mm": length},
        labels=_relabelled(d, stylus="{} long", event="{} long"),
    )


def turned(part: Part) -> Part:
    """The artefact turned by 90 degrees about the vertical through its middle, clamped anew."""
    d = part.design
    if "pose" not in d.labels or d.normal is None:
        raise NotPossible("there is no artefact to turn")
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    tip = place(d) + d.offset
    middle = tip.mean(axis=0)
    normal = d.normal @ turn.T
    columns = dict(d.columns)
    for word in ("speed_{}_mm_s", "accel_{}_mm_s2"):
        three = np.column_stack([d.columns[word.format(a)] for a in XYZ]) @ turn.T
        columns |= {word.format(a): three[:, i] for i, a in enumerate(XYZ)}
    columns["probe_angle_deg"], lateral = _about_stylus(d.hidden["axis"], normal)
    hidden = {**d.hidden, "turns": turn @ d.hidden["turns"], "lateral": lateral, "pose": d.hidden["pose"] + 1}
    legs = tuple(
        (leg + off - middle) @ turn.T + middle - off for leg, off in zip(part.legs, d.offset, strict=True)
    )
    out = replace(part, legs=legs)
    return _moved(
        out,
        (tip - middle) @ turn.T + middle - d.offset,
        normal=normal,
        columns=columns,
        hidden=hidden,
        labels=_relabelled(d, pose="{} turned", clamp="{} turned", event="{} turned"),
        shift_legs=False,
    )


def _moved(part: Part, q: Array, shift_legs: bool = True, **more: object) -> Part:
    """The same rows at other axis positions. Raises NotPossible outside the travels."""
    d = part.design
    axes = {a: q[:, i] for i, a in enumerate(XYZ)}
    travel: Mapping[str, tuple[float, float]] = BRIDGE.travel
    if any(axes[a].min() < travel[a][0] or axes[a].max() > travel[a][1] for a in XYZ):
        raise NotPossible("it would leave the travels")
    by = q - place(d)
    legs = tuple(leg + shift for leg, shift in zip(part.legs, by)) if shift_legs else part.legs
    return Part(replace(d, q={**d.q, **axes}, **more), legs)  # type: ignore[arg-type]


def walked(old: Design, part: Part) -> tuple[Design, Array | None, Array | None]:
    """The new rows with sense and distance as the joint path gives them, and the joint path with the node of each new row."""
    if old.nodes is None or not part.legs:
        return part.design, None, None
    nodes, ends = [old.nodes], []
    count = len(old.nodes)
    normal = np.asarray(part.design.normal)
    for leg, out in zip(part.legs, normal):
        nodes += [leg, leg[-1:] + 4.0 * out]
        ends.append(count + len(leg) - 1)
        count += len(leg) + 1
    path, row_node = np.concatenate(nodes), np.array(ends)
    sense, since = since_reversal(path)
    more = {f"sense_{a}": sense[row_node, i] for i, a in enumerate(XYZ)}
    more |= {f"since_reversal_{a}_mm": since[row_node, i] for i, a in enumerate(XYZ)}
    more |= {f"raw_{a}_mm": part.design.q[a] + 0.0137 * (i + 1) for i, a in enumerate(XYZ)}
    return replace(part.design, columns={**part.design.columns, **more}), path, row_node
