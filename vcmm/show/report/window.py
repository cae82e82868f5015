"""A scene in a window or as a PNG, by pyvista in a process of its own: VTK without a display can end in a segfault.

    python -m vcmm.show.report.window scene.pickle [picture.png]

The parent writes the items, waits, and reports errors of the child; it does not end with it.
"""

from __future__ import annotations

import importlib.util
import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.errors import Environment
from vcmm.show.report.colormap import bands
from vcmm.show.report.meshes import box_mesh
from vcmm.show.report.palette import hex_of
from vcmm.show.report.scene_items import (
    Arrows,
    Ellipsoids,
    Item,
    Label,
    Lines,
    Points,
    SceneBox,
    SceneMesh,
    face_values,
    line_segments,
    mesh_arrays,
)
from vcmm.show.report.scene_traces import arrow_ends, ellipsoid_arrays

INK = hex_of("ink")
SIZE = (1100, 800)
NEEDS = "install libegl1 and libgl1-mesa-dri (Debian) or mesa-libEGL (Fedora); reports and notebooks do not need them"


def show(items: Sequence[Item], title: str, picture: Path | None = None) -> None:
    """Open a window, or write a PNG. Environment: no display and no --png, or OpenGL that does not work, with the remedy."""
    display = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")) or sys.platform in (
        "win32",
        "darwin",
    )
    if picture is None and not display:
        raise Environment("there is no display for a window; write a picture instead: --png picture.png")
    if importlib.util.find_spec("pyvista") is None:
        raise Environment('windows and their pictures are drawn by pyvista: pip install "vcmm[view]"')
    surroundings = dict(os.environ)
    if not display:
        surroundings["VTK_DEFAULT_OPENGL_WINDOW"] = "vtkEGLRenderWindow"
    with tempfile.TemporaryDirectory(prefix="vcmm-") as folder:
        store = Path(folder) / "scene.pickle"
        store.write_bytes(pickle.dumps((list(items), title)))
        words = [
            sys.executable,
            "-m",
            "vcmm.show.report.window",
            str(store),
            *([str(picture)] if picture else []),
        ]
        done = subprocess.run(words, env=surroundings, capture_output=True, text=True)
    if done.returncode != 0:
        why = (done.stderr.strip().splitlines() or [f"it ended with {done.returncode}"])[-1]
        raise Environment(f"the window of pyvista does not work here ({why}); {NEEDS}")


def _draw_item(plotter: Any, item: Item) -> None:
    import pyvista as pv

    if isinstance(item, SceneBox):
        vertices, faces = box_mesh(item.lo, item.hi)
        mesh = pv.PolyData.from_regular_faces(vertices, faces.astype(int).tolist())
        if item.opacity > 0:
            plotter.add_mesh(mesh, color=hex_of(item.colour), opacity=item.opacity)
        plotter.add_mesh(mesh.extract_feature_edges(), color=hex_of(item.colour), line_width=1)
    elif isinstance(item, SceneMesh):
        _mesh(plotter, item)
    elif isinstance(item, Lines):
        segments = line_segments(item)
        if len(segments):
            plotter.add_lines(segments.reshape(-1, 3), color=hex_of(item.colour), width=item.width)
    elif isinstance(item, Points):
        cloud = np.asarray(item.xyz, float)
        if item.labels:
            plotter.add_point_labels(cloud, list(item.labels), point_color=hex_of(item.colour), shape=None)
        plotter.add_points(
            cloud, color=hex_of(item.colour), point_size=3 * item.size, render_points_as_spheres=True
        )
    elif isinstance(item, Arrows):
        origin, tip = arrow_ends(item)
        plotter.add_arrows(origin, tip - origin, color=hex_of(item.colour))
    elif isinstance(item, Ellipsoids):
        for centre, covariance in zip(*ellipsoid_arrays(item)):
            value, vector = np.linalg.eigh(covariance)
            ball = pv.Sphere(radius=1.0, theta_resolution=16, phi_resolution=12)
            ball.points = centre + item.scale * ball.points @ (vector * np.sqrt(value.clip(0))).T
            plotter.add_mesh(ball, color=hex_of(item.colour), opacity=0.5)
    elif isinstance(item, Label):
        plotter.add_point_labels([np.asarray(item.xyz, float)], [item.text], shape=None, show_points=False)


def _mesh(plotter: Any, item: SceneMesh) -> None:
    import pyvista as pv

    vertices, faces = mesh_arrays(item)
    mesh = pv.PolyData.from_regular_faces(vertices, faces.astype(int).tolist())
    values = face_values(item)
    if values is None:
        plotter.add_mesh(mesh, color=hex_of(item.colour), opacity=item.opacity, show_edges=False)
        return
    scale = bands(values, symmetric=item.symmetric)
    mesh.cell_data[item.unit or "value"] = values
    plotter.add_mesh(
        mesh, scalars=item.unit or "value", cmap=list(scale.colours), clim=(scale.levels[0], scale.levels[-1]),
        n_colors=len(scale.colours), nan_color="lightgrey", opacity=item.opacity, lighting=False,  # colours are those of the bar
        scalar_bar_args={"title": f"{item.unit}\n", "n_labels": len(scale.levels), "color": INK, "vertical": True, "position_x": 0.88, "position_y": 0.3, "height": 0.5, "width": 0.05},
    )  # fmt: skip


def keys_of(items: Sequence[Item]) -> list[list[str]]:
    """Name and colour of every item that has a name, each once."""
    named = [(getattr(i, "name", ""), hex_of(getattr(i, "colour", "muted"))) for i in items]
    return [[name, colour] for name, colour in dict(named).items() if name]


def main(words: Sequence[str]) -> None:
    """Run the child process."""
    import pyvista as pv

    from vcmm.show.report.scene import magnification

    items, title = pickle.loads(Path(words[0]).read_bytes())
    plotter: Any = pv.Plotter(off_screen=len(words) > 1, window_size=list(SIZE), title=title)
    for item in items:
        _draw_item(plotter, item)
    plotter.add_axes()
    plotter.show_bounds(grid="back", location="outer", xtitle="X / mm", ytitle="Y / mm", ztitle="Z / mm", font_size=9, color="dimgrey")  # fmt: skip
    plotter.add_text(
        f"{title}\n{magnification(items)}".strip(), position="upper_left", font_size=10, color=INK
    )
    for row, (name, colour) in enumerate(keys_of(items)):
        at = 0.96 - 0.028 * row
        plotter.add_text("==", position=(0.74, at), viewport=True, font_size=11, font="courier", color=colour)
        plotter.add_text(name, position=(0.775, at), viewport=True, font_size=9, color=INK)
    plotter.camera.enable_parallel_projection()
    plotter.view_vector((0.46, -0.8, 0.37))
    plotter.camera.zoom(1.0)
    if len(words) > 1:
        plotter.screenshot(words[1])
    else:
        plotter.show()


if __name__ == "__main__":
    main(sys.argv[1:])
