"""Read the faces of a STEP file by Open CASCADE, in a separate process: a broken file can end it by a fault that Python cannot catch.

Measured: of 12 copies of a sound file with a few entities deleted, exchanged or cut off, 3 ended the process (signal 11).
"""

from __future__ import annotations

import importlib.util
import os
import pickle
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.errors import DataError, Environment
from vcmm.core.run import Array

STEP_READER_MISSING = (
    'STEP files are read by Open CASCADE, which is not installed: pip install "vcmm[step]" (380 MB)'
)
SURFACE_WORDS = {
    "GeomAbs_Plane": "plane", "GeomAbs_Cylinder": "cylinder", "GeomAbs_Cone": "cone", "GeomAbs_Sphere": "sphere",
    "GeomAbs_Torus": "torus",
}  # fmt: skip
SAME_SURFACE_MM = 1e-5  # mm and rad: faces of one surface; modellers keep 1e-6 mm or better
# places tried along each side of a plane whose edges cut the grid; fewest that fix a plane and its form
FINE = 21
LEAST_PLANE_PLACES = 4
LONGEST = 600.0  # s; the public test parts take seconds
CHILD = "import sys; from vcmm.files.foreign.step_faces import write_faces; write_faces(*sys.argv[1:])"


@dataclass(frozen=True, eq=False)
class SurfaceFace:
    """A face: its number in the file, kind, place, frame (rows u, v, axis), sizes in mm and rad, reach (u0, u1, v0, v1).

    sizes: cylinder (radius), cone (radius at the place, half angle), sphere (radius), torus (ring, tube).
    axis of a plane: its outward normal. inside: the material is around it. touches: (n, 2) in u and v, of a plane whose edges cut
    the plain grid.
    """

    number: int
    kind: str
    place: Array
    frame: Array
    sizes: tuple[float, ...]
    reach: tuple[float, float, float, float]
    inside: bool
    touches: Array | None = None

    @property
    def axis(self) -> Array:
        return np.asarray(self.frame[2])


@dataclass(frozen=True, eq=False)
class StepFaces:
    """Faces with a surface that vcmm has, lengths in mm; kinds of all in their order; the number of others by kind."""

    faces: list[SurfaceFace]
    kinds: list[str]
    others: Counter[str]


def read_faces(path: Path) -> StepFaces:
    """Read the faces of a file by a child process. DataError: no shape, a fault of Open CASCADE, too long; Environment: it is missing."""
    if importlib.util.find_spec("OCP") is None:
        raise Environment(STEP_READER_MISSING)
    state = path.stat()
    return _by_child(path, state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=1)
def _by_child(path: Path, _changed: int, _size: int) -> StepFaces:
    """Read as `read_faces` does; the last file is cached, because a part whose drawing contradicts itself is read twice."""
    home = str(Path(__file__).resolve().parents[3])
    around = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, [home, os.environ.get("PYTHONPATH")]))}
    with tempfile.TemporaryDirectory(prefix="vcmm-step-") as folder:
        store = Path(folder) / "faces"
        try:
            done = subprocess.run(
                [sys.executable, "-c", CHILD, str(path), str(store)],
                env=around,
                capture_output=True,
                timeout=LONGEST,
            )
        except subprocess.TimeoutExpired:
            raise DataError(
                f"{path}:1: Open CASCADE was not done after {LONGEST:.0f} s; export the part alone"
            ) from None
        if done.returncode or not store.exists():
            raise DataError(f"{path}:1: {_fault(done.returncode, done.stderr)}")
        faces = pickle.loads(store.read_bytes())  # written by our own child, a moment ago
    if isinstance(faces, str):
        raise DataError(faces)
    assert isinstance(faces, StepFaces)
    return faces


def _fault(code: int, output: bytes) -> str:
    last = (output.decode(errors="replace").strip().splitlines() or [""])[-1]
    why = f"signal {-code}" if code < 0 else last
    return (
        f"Open CASCADE ended by a fault while it read this file ({why}); the file is broken, export it again"
    )


def write_faces(path: str, store: str) -> None:
    """Write, in the child process, the faces, or the message of a DataError, as a pickle."""
    try:
        faces: StepFaces | str = faces_of(Path(path))
    except DataError as error:
        faces = str(error)
    Path(store).write_bytes(pickle.dumps(faces))


def faces_of(path: Path) -> StepFaces:
    """Read the faces of a file, in this process. DataError: no shape."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone or not reader.TransferRoots():
        raise DataError(f"{path}:1: Open CASCADE finds no shape in this file")
    explorer = TopExp_Explorer(reader.OneShape(), TopAbs_FACE)
    faces: list[SurfaceFace] = []
    left, kinds = Counter[str](), []
    while explorer.More():
        shape = TopoDS.Face(explorer.Current())
        surface = BRepAdaptor_Surface(shape)
        kinds.append(surface.GetType().name)
        if kinds[-1] in SURFACE_WORDS:
            face = _face(len(kinds) - 1, kinds[-1], surface, shape.Orientation() == TopAbs_REVERSED)
            faces.append(replace(face, touches=_spread(shape, face.reach)) if face.kind == "plane" else face)
        else:
            left[kinds[-1].removeprefix("GeomAbs_")] += 1
        explorer.Next()
    return StepFaces(faces, kinds, left)


def _face(number: int, name: str, surface: Any, reversed_: bool) -> SurfaceFace:
    kind = SURFACE_WORDS[name]
    shape = getattr(surface, name.removeprefix("GeomAbs_"))()
    position = shape.Position()
    frame = np.array(
        [[d.X(), d.Y(), d.Z()] for d in (position.XDirection(), position.YDirection(), position.Direction())]
    )
    read: dict[str, tuple[str, ...]] = {
        "plane": (), "cylinder": ("Radius",), "cone": ("RefRadius", "SemiAngle"), "sphere": ("Radius",), "torus": ("MajorRadius", "MinorRadius"),
    }  # fmt: skip
    sizes = tuple(float(getattr(shape, n)()) for n in read[kind])
    inwards = reversed_ != (not position.Direct())  # the normal of the surface is that of u x v
    if kind == "plane":
        frame[2] = np.cross(frame[0], frame[1]) * (-1.0 if reversed_ else 1.0)
    p = position.Location()
    reach = (
        surface.FirstUParameter(),
        surface.LastUParameter(),
        surface.FirstVParameter(),
        surface.LastVParameter(),
    )
    place = np.array([p.X(), p.Y(), p.Z()])
    inside = kind != "plane" and inwards
    return SurfaceFace(number, kind, place, frame=frame, sizes=sizes, reach=reach, inside=inside)


def _spread(shape: Any, reach: tuple[float, float, float, float]) -> Array | None:
    """Return nine places (9, 2) within the edges of a plane face, far from each other; None where the plain grid of 3 x 3 is within them."""
    from OCP.gp import gp_Pnt2d
    from OCP.IntTools import IntTools_FClass2d
    from OCP.TopAbs import TopAbs_IN

    inside = IntTools_FClass2d(shape, SAME_SURFACE_MM)
    u0, u1, v0, v1 = reach
    margin = 0.1 * min(u1 - u0, v1 - v0)

    def within(u: float, v: float) -> bool:
        around = ((0, 0), (margin, 0), (-margin, 0), (0, margin), (0, -margin))
        return all(inside.Perform(gp_Pnt2d(u + 0.99 * a, v + 0.99 * b)) == TopAbs_IN for a, b in around)

    plain = [
        (u, v)
        for u in np.linspace(u0 + margin, u1 - margin, 3)
        for v in np.linspace(v0 + margin, v1 - margin, 3)
    ]
    if all(within(*place) for place in plain):
        return None
    free = [(u, v) for u in np.linspace(u0, u1, FINE) for v in np.linspace(v0, v1, FINE) if within(u, v)]
    return _far_apart(np.array(free)) if len(free) >= LEAST_PLANE_PLACES else None


def _far_apart(places: Array) -> Array:
    """Return nine of the places (n, 2), each as far as possible from those before it."""
    chosen = [int(np.argmin(places.sum(axis=1)))]
    nearest = np.full(len(places), np.inf)
    while len(chosen) < min(9, len(places)):
        nearest = np.minimum(nearest, np.linalg.norm(places - places[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(nearest)))
    return places[chosen]
