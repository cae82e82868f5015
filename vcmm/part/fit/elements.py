"""Geometric elements in standard position, and the one Jacobian that fit and sensitivity share.

Every element is evaluated in its own frame (u, v, a): origin at its point, a along its axis. A kernel gives
per point the signed orthogonal distance d, the unit normal of the fitted surface at the foot of the point,
and the partial derivatives of d with respect to the sizes. A small displacement t and rotation w of the
element change d by

    -n . t - (x x n) . w + dd/dsizes . ds,        x = point - element point, in the element frame

(Cox and Forbes; Forbes, Appl. Sci. 12 (2022) 2808). Points and lines have 3 and 2 distance components per
point, all other elements one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Part = Array | float
Triple = tuple[Part, Part, Part]
Row = tuple[Part, Triple, tuple[Part, ...]]  # distance, normal, partials with respect to the sizes
Kernel = Callable[..., list[Row]]

TX, TY, TZ, RX, RY = range(5)  # motions of an element in its own frame; a turn about its axis never counts


@dataclass(frozen=True, eq=False)
class FittedElement:
    """A fitted element, or a batch of them in leading dimensions (written ...).

    kind       "point" "line" "plane" "circle" "sphere" "cylinder" "cone" "torus" "mesh"
    point      (..., 3) mm. Point: mean. Plane and line: foot of the centroid of the data. Circle, sphere,
               torus: centre. Cylinder and cone: the point of the axis nearest the centroid of the data.
    axis       (..., 3) unit. Plane normal, line direction, axis of circle, cylinder, cone, torus; else zeros.
    sizes      (..., s) mm or rad. Circle, sphere, cylinder: [radius]. Cone: [radius at point, half apex
               angle], the radius grows along +axis. Torus: [ring radius, tube radius]. Others: s = 0.
    residuals  (..., n) mm, orthogonal distance, + on the side of increasing radius or of the plane normal.
               Point and line: distance (>= 0). Circle: radial within its plane.
    normals    (..., n, 3) unit direction in which residual i is counted
    also       the same points by other criteria, where asked for (vcmm.part.gps.criteria): {"X": ...}; local sizes LP, LS
               hold half of each of k sizes in `sizes` (..., k)
    unique     (...) of an element by contact: False where others are as good
    points     (..., n, 3) the points themselves, where a characteristic is evaluated on them; of a mesh, which has no element,
               (n, 3) where they lie in the drawing
    moments    (6 + s, 6 + s) of a datum: the normal matrix of its fit (vcmm.part.fit.fixed_orientation), where its points are not kept
    """

    kind: str
    point: Array
    axis: Array
    sizes: Array
    residuals: Array
    normals: Array
    also: Mapping[str, FittedElement] = field(default_factory=dict)
    unique: Mask | None = None
    points: Array | None = None
    moments: Array | None = None


@dataclass(frozen=True)
class Element:
    """Free parameters of an element: motions of its pose, and its sizes (`lengths`: length, or angle)."""

    kind: str
    kernel: Kernel
    pose: tuple[int, ...]
    sizes: tuple[str, ...] = ()
    lengths: tuple[bool, ...] = ()
    rows: int = 1
    slides: bool = False  # the point may lie anywhere along the axis: keep it at the foot of the centroid

    @property
    def has_axis(self) -> bool:
        return self.kind not in ("point", "sphere")


def _point(x: Array, y: Array, z: Array) -> list[Row]:
    return [(x, (1.0, 0.0, 0.0), ()), (y, (0.0, 1.0, 0.0), ()), (z, (0.0, 0.0, 1.0), ())]


def _line(x: Array, y: Array, z: Array) -> list[Row]:
    return [(x, (1.0, 0.0, 0.0), ()), (y, (0.0, 1.0, 0.0), ())]


def _plane(x: Array, y: Array, z: Array) -> list[Row]:
    return [(z, (0.0, 0.0, 1.0), ())]


def _length(*parts: Array) -> Array:
    """Return the length of a vector, never exactly 0: a point on the axis then has the normal 0 and not NaN."""
    return np.maximum(np.sqrt(sum(p * p for p in parts)), 1e-150)


def _cylinder(x: Array, y: Array, z: Array, radius: Array) -> list[Row]:
    rho = _length(x, y)
    return [(rho - radius, (x / rho, y / rho, 0.0), (-1.0,))]


def _sphere(x: Array, y: Array, z: Array, radius: Array) -> list[Row]:
    rho = _length(x, y, z)
    return [(rho - radius, (x / rho, y / rho, z / rho), (-1.0,))]


def _cone(x: Array, y: Array, z: Array, radius: Array, angle: Array) -> list[Row]:
    rho, cos, sin = _length(x, y), np.cos(angle), np.sin(angle)
    across = rho - radius
    normal = (cos * (x / rho), cos * (y / rho), -sin)
    return [(cos * across - sin * z, normal, (-cos, -sin * across - cos * z))]


def _torus(x: Array, y: Array, z: Array, ring: Array, tube: Array) -> list[Row]:
    rho = _length(x, y)
    across = rho - ring
    q = _length(across, z)
    outward = across / q
    return [(q - tube, (outward * (x / rho), outward * (y / rho), z / q), (-outward, -1.0))]


_CROSSWISE = (TX, TY, RX, RY)
ELEMENTS: dict[str, Element] = {
    "point": Element("point", _point, (TX, TY, TZ), rows=3),
    "line": Element("line", _line, _CROSSWISE, rows=2, slides=True),
    "plane": Element("plane", _plane, (TZ, RX, RY)),
    "circle": Element("circle", _cylinder, (TX, TY), ("radius",), (True,), slides=True),
    "sphere": Element("sphere", _sphere, (TX, TY, TZ), ("radius",), (True,)),
    "cylinder": Element("cylinder", _cylinder, _CROSSWISE, ("radius",), (True,), slides=True),
    "cone": Element("cone", _cone, _CROSSWISE, ("radius", "apex angle"), (True, False), slides=True),
    "torus": Element("torus", _torus, (TX, TY, TZ, RX, RY), ("ring radius", "tube radius"), (True, True)),
}
MINIMUM_POINTS: dict[str, int] = {
    "point": 1, "line": 2, "plane": 3, "circle": 3, "sphere": 4, "cylinder": 5, "cone": 6, "torus": 7,
}  # fmt: skip


def free_pose(element: Element, axis_is_fixed: bool) -> tuple[int, ...]:
    """Return the free motions of the element; a fixed axis takes away both tilts."""
    return tuple(j for j in element.pose if not (axis_is_fixed and j in (RX, RY)))


def frames(axis: Array) -> Array:
    """Return rows u, v, a (..., 3, 3) of a right-handed frame about unit axes (..., 3).

    Duff et al., "Building an Orthonormal Basis, Revisited", J. Computer Graphics Techniques 6(1) 2017: no
    branch, so a batch member gets the same frame alone and in company.
    """
    x, y, z = axis[..., 0], axis[..., 1], axis[..., 2]
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    out = np.empty((*axis.shape, 3))
    out[..., 0, 0], out[..., 0, 1], out[..., 0, 2] = 1.0 + sign * x * x * a, sign * b, -sign * x
    out[..., 1, 0], out[..., 1, 1], out[..., 1, 2] = b, sign + y * y * a, -y
    out[..., 2, :] = axis
    return out


def rows_of(element: Element, local: Array, sizes: Array) -> list[Row]:
    """Evaluate the kernel rows of points `local` (B, 3, n) in the element frame, with sizes (B, s)."""
    return element.kernel(local[:, 0], local[:, 1], local[:, 2], *sizes.T[..., None])


def pose_column(motion: int, local: Array, normal: Triple) -> Part:
    """Change of d per unit of one motion: -n for a translation, -(x x n) for a rotation."""
    if motion in (TX, TY, TZ):
        return -normal[motion]
    x, y, z = local[:, 0], local[:, 1], local[:, 2]
    if motion == RX:
        return z * normal[1] - y * normal[2]
    return x * normal[2] - z * normal[0]


def jacobian(
    element: Element, free: tuple[int, ...], local: Array, sizes: Array
) -> tuple[Array, Array, list[Row]]:
    """Return distances d (B, m), the Jacobian (B, p, m) and the kernel rows.

    m = distance components per point x n; p = free motions, then sizes. local (B, 3, n), sizes (B, s).
    """
    batch, n = local.shape[0], local.shape[2]
    rows = rows_of(element, local, sizes)
    d = np.empty((batch, element.rows, n))
    jac = np.empty((batch, len(free) + len(element.sizes), element.rows, n))
    for k, (distance, normal, partials) in enumerate(rows):
        d[:, k] = distance
        for j, motion in enumerate(free):
            jac[:, j, k] = pose_column(motion, local, normal)
        for j, partial in enumerate(partials):
            jac[:, len(free) + j, k] = partial
    m = element.rows * n
    return d.reshape(batch, m), jac.reshape(batch, jac.shape[1], m), rows


def signed_residuals(rows: list[Row], frame: Array, shape: tuple[int, int]) -> tuple[Array, Array]:
    """Return residuals (B, n) and unit normals (B, n, 3) in the outer frame; components become their length."""
    d = np.stack([np.broadcast_to(row[0], shape) for row in rows])
    normal = np.stack([np.stack([np.broadcast_to(c, shape) for c in row[1]], axis=1) for row in rows])
    if len(rows) > 1:  # point and line: along the deviation itself; the first direction where that is 0
        length = np.sqrt(np.sum(d * d, axis=0))
        weight = np.where(length > 0.0, d / np.where(length > 0.0, length, 1.0), 0.0)
        weight[0] = np.where(length > 0.0, weight[0], 1.0)
        d, normal = length[None], np.sum(weight[:, :, None] * normal, axis=0)[None]
    return d[0], np.swapaxes(np.swapaxes(frame, -1, -2) @ normal[0], -1, -2)
