"""3-D pictures of a machine, a part in it, its touches and their uncertainty; composed of report blocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vcmm.part.part import Feature, frame
from vcmm.show.report.blocks import (
    Ellipsoids,
    Label,
    Lines,
    Points,
    SceneBox,
    SceneMesh,
    cone_mesh,
    cylinder_mesh,
    sphere_mesh,
    torus_mesh,
)

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.core.pose import Pose
    from vcmm.core.run import Array
    from vcmm.part.mesh import Mesh
    from vcmm.part.nominal import NominalPoints
    from vcmm.task.measuring.plan import Stylus, Touches
    from vcmm.task.measuring.task import Task
    from vcmm.task.response.influence import Influence

Item = SceneBox | Ellipsoids | Label | Lines | SceneMesh | Points
STEEL, BORE, GRANITE, PORTAL, RAM = "#9fb4cc", "#c9a46b", "#8d9299", "#c7cdd4", "#a9b3bf"


def volume_items(machine: Machine, stylus: Stylus, at: Array) -> list[Item]:
    """Return the machine around its reach with the tip at `at` (3,), workpiece axes."""
    return machine_items(*reach(machine, stylus.offset), at, stylus)


def machine_items(low: Array, high: Array, at: Array, stylus: Stylus) -> list[Item]:
    """Return a portal over a table: a picture of scale, not of the real build. low, high: reach of the tip."""
    size = high - low
    beam = 0.08 * float(size.max())
    top = high[2] + 0.35 * size[2]
    head = at - stylus.offset
    y = (at[1] - beam / 2, at[1] + beam / 2)
    wide = (low[0] - 1.6 * beam, high[0] + 1.6 * beam)
    table = SceneBox(
        [wide[0], low[1] - beam, low[2] - beam],
        [wide[1], high[1] + beam, low[2] - 1.0],
        GRANITE,
        1.0,
        name="table",
    )
    return [
        table,
        SceneBox(low, high, "#7a8793", 0.0, name="reach of the tip"),
        SceneBox([wide[0], y[0], low[2]], [wide[0] + beam, y[1], top], PORTAL, 0.5),
        SceneBox([wide[1] - beam, y[0], low[2]], [wide[1], y[1], top], PORTAL, 0.5),
        SceneBox([wide[0], y[0], top], [wide[1], y[1], top + beam], PORTAL, 0.5, name="portal"),
        SceneBox(
            [head[0] - 0.3 * beam, at[1] - 0.3 * beam, head[2]],
            [head[0] + 0.3 * beam, at[1] + 0.3 * beam, top + 1.5 * beam],
            RAM,
            0.6,
            name="ram",
        ),
        Lines(np.array([head, at]), "ink", 2.0, name="stylus"),
    ]


def reach(machine: Machine, offset: Array) -> tuple[Array, Array]:
    """Return the corners of the box that the tip can reach with one stylus offset (3,), mm."""
    low, high = np.array(offset, dtype=float), np.array(offset, dtype=float)
    for i, letter in enumerate("XYZ"):
        if letter in machine.axes:
            low[i] += machine.axes[letter].travel[0]
            high[i] += machine.axes[letter].travel[1]
        else:
            high[i] += 1.0
    return low, high


def feature_mesh(feature: Feature) -> SceneMesh | None:
    """Return the nominal surface of a feature, drawing frame; None for points, lines and meshes, and nominal points that go round."""
    if feature.nominal is not None:
        return _through(feature.nominal)
    point, axis = feature.point, feature.axis
    if feature.kind == "plane":
        u, v, _ = frame(feature)
        a, b = feature.extent[0] / 2 * u, feature.extent[1] / 2 * v
        corners = np.array([point - a - b, point + a - b, point + a + b, point - a + b])
        return SceneMesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), STEEL, 0.85)
    if feature.kind in ("cylinder", "circle"):
        length = feature.extent[0] if feature.kind == "cylinder" else 0.05 * feature.sizes[0]
        middle = point + axis * length / 2
        solid = cylinder_mesh(middle, axis, float(feature.sizes[0]), float(length), inside=feature.inside)
        return SceneMesh(*solid, colour=BORE if feature.inside else STEEL, opacity=0.9)
    if feature.kind == "sphere":
        return SceneMesh(*sphere_mesh(point, float(feature.sizes[0])), colour=STEEL, opacity=0.9)
    if feature.kind == "torus":
        return SceneMesh(
            *torus_mesh(point, axis, float(feature.sizes[0]), float(feature.sizes[1])),
            colour=STEEL,
            opacity=0.9,
        )
    if feature.kind == "cone":
        radius, half = feature.sizes
        far = radius + feature.extent[0] * np.tan(half)
        base = point + axis * feature.extent[0]
        return SceneMesh(
            *cone_mesh(base, -axis, float(far), float(feature.extent[0]), top=float(radius)),
            colour=STEEL,
            opacity=0.9,
        )
    return None


def _through(nominal: NominalPoints) -> SceneMesh | None:
    """Return the triangles between nominal points as they lie beside one another seen along their mean normal; None where some turn away."""
    from scipy.spatial import Delaunay, QhullError

    middle = nominal.normals.mean(axis=0)
    if float((nominal.normals @ middle).min()) <= LEAST_COSINE * float(np.linalg.norm(middle)):
        return None
    across = np.linalg.svd(middle[None])[2][1:]
    try:
        faces = Delaunay((nominal.points - nominal.points.mean(axis=0)) @ across.T).simplices
    except QhullError:
        return None  # all on one line
    return SceneMesh(nominal.points, faces, STEEL, 0.85, edges=False, cull=False)


LEAST_COSINE = 0.2  # cosine between a normal and the mean one from which on a surface is drawn: steeper triangles would be slivers
SOURCES = 4  # Inputs that a touch names
MOST_FACES = 20_000  # a larger mesh makes the picture slow; its features are drawn instead


def part_items(features: Sequence[Feature], pose: Pose, mesh: Mesh | None = None) -> list[Item]:
    """Return the part's features, and its mesh if it has one, at the pose."""
    items: list[Item] = []
    if mesh is not None and len(mesh.faces) <= MOST_FACES:
        items.append(SceneMesh(pose.apply(mesh.vertices), mesh.faces, STEEL, 0.6, edges=False))
    for feature in features:
        shape = feature_mesh(feature)
        if shape is not None:
            items.append(
                SceneMesh(pose.apply(np.asarray(shape.vertices)), shape.faces, shape.colour, shape.opacity)
            )
    return items


def touch_items(
    t: Touches, covariances: Array | None = None, hover: Sequence[str] | None = None
) -> list[Item]:
    """Return the touches in the machine, with ellipsoids of their standard uncertainty where covariances (n, 3, 3) are given.

    hover: the text of each touch under the pointer (default: its feature, number and place).
    """
    points = t.pose.apply(t.points)
    names = hover or touch_names(t)
    items: list[Item] = [Points(points, "accent", 2.2, hover=names, name="touches")]
    if covariances is not None:
        items.append(
            Ellipsoids(
                points, covariances, magnification(points, covariances), "c4", names, "uncertainty of a touch"
            )
        )
    return items


def task_in_machine(task: Task) -> list[Item]:
    """Return the part with its touches in the machine, the tip at the last of them."""
    t = task.touches
    last = t.pose.apply(t.points[-1:] + t.tip_radius[-1] * t.normals[-1:])[0]
    stylus = task.plan.styli[task.plan.steps[-1].stylus]
    features = list(task.part.features.values())
    return [
        *volume_items(task.machine, stylus, last), *part_items(features, t.pose, task.part.mesh), *touch_items(t)
    ]  # fmt: skip


def touches_of(task: Task, influences: Sequence[Influence]) -> list[Item]:
    """Return the part alone, every touch with the ellipsoid of its standard uncertainty and its main contributors."""
    t = task.touches
    items = part_items(list(task.part.features.values()), t.pose, task.part.mesh)
    sources = touch_sources(task, influences)
    return [*items, *touch_items(t, touch_covariances(task, influences), sources)]


def touch_names(t: Touches) -> list[str]:
    """Return feature, number and place of every touch."""
    names = [""] * len(t.points)
    for feature, rows in t.rows.items():
        for number, i in enumerate(rows, 1):
            x, y, z = t.points[i]
            names[i] = f"{feature}, point {number}\npart: {x:.3f}, {y:.3f}, {z:.3f} mm"
    return names


def touch_sources(task: Task, influences: Sequence[Influence]) -> list[str]:
    """Return the text of every touch: its name, its standard uncertainty along the normal, and the Inputs with the largest shares."""
    t = task.touches
    normals = t.pose.turn(t.normals)
    parts: dict[str, Array] = {}
    for influence in influences:
        spread = _spread(influence)
        if spread is not None:
            along = np.einsum("ni,nik->nk", normals, spread)
            parts[influence.input.id] = (along**2).sum(axis=1)
    total = np.sum(list(parts.values()), axis=0) if parts else np.zeros(len(normals))
    out = []
    for i, name in enumerate(touch_names(t)):
        largest = sorted(parts, key=lambda key: -parts[key][i])[:SOURCES]
        owners = [
            f"{100 * parts[k][i] / total[i]:.0f} % {k}" for k in largest if total[i] > 0 and parts[k][i] > 0
        ]
        out.append("\n".join([name, f"u along the normal: {1e3 * np.sqrt(total[i]):.3g} µm", *owners]))
    return out


def _spread(influence: Influence) -> Array | None:
    """Return one standard uncertainty of each independent element (n, 3, k) mm; None where it has none."""
    law, factor = influence.input.spread(influence.response.shape[2])
    u = np.asarray(law.u)
    return np.asarray((influence.response @ factor) * u) if np.isfinite(u).all() else None


def magnification(points: Array, covariances: Array) -> float:
    """Return a round factor that makes the largest ellipsoid about a fifteenth of the part."""
    largest = float(np.sqrt(np.linalg.eigvalsh(covariances).max(initial=0.0)))
    size = float(np.ptp(points, axis=0).max(initial=1.0))
    if largest <= 0:
        return 1.0
    return rounded_down(size / 15 / largest)


def rounded_down(factor: float) -> float:
    """Return the largest of 1, 2, 5, 10 ... that is not above a factor."""
    power = 10.0 ** np.floor(np.log10(factor))
    # 1 where the logarithm rounds up: 10^3 of 999.9999999999999
    return float(power * max((m for m in (1, 2, 5) if m * power <= factor), default=1))


def touch_covariances(task: Task, influences: Sequence[Influence]) -> Array:
    """Return the covariance of the indication of each touch from all Inputs (those with a finite variance), as (n, 3, 3) mm^2."""
    total = np.zeros((task.touches.run.n, 3, 3))
    for influence in influences:
        spread = _spread(influence)
        if spread is not None:
            total += np.einsum("nik,njk->nij", spread, spread)
    return total
