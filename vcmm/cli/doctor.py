"""vcmm doctor: is everything here that vcmm needs, and how fast is it."""

from __future__ import annotations

import platform
import subprocess
import sys
from typing import Annotated

from cyclopts import Parameter

REQUIRED = ("numpy", "scipy", "numba", "trimesh", "pyvista", "pydantic", "cyclopts", "rich", "tomlkit")


def doctor_command(*, json: Annotated[bool, Parameter(name="--json")] = False) -> int:
    """Check the installation: Python, packages, off-screen rendering, cores. Exit code 3 when something is missing.

    Parameters
    ----------
    json
        Print one JSON document.
    """
    import os

    from vcmm import __version__
    from vcmm.console.documents import document, print_json
    from vcmm.console.terminal import show_table
    from vcmm.tables.table import listing

    rows = [
        ["vcmm", __version__, "ok"],
        ["Python", platform.python_version(), "ok" if sys.version_info >= (3, 11) else "needs 3.11"],
    ]
    rows += [_package(name) for name in REQUIRED]
    rows += [_rendering(), _cache(), ["cores", str(os.cpu_count()), "ok"]]
    missing = [row for row in rows if row[2].startswith("missing")]
    if json:
        body = {"checks": [dict(zip(("what", "found", "state"), row)) for row in rows], "ok": not missing}
        print_json(document("vcmm.doctor/1", body))
    else:
        show_table(listing("installation", ["", "found", "state"], rows, words=(0, 1, 2)))
    return 3 if missing else 0


def _package(name: str) -> list[str]:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return [name, version(name), "ok"]
    except PackageNotFoundError:
        return [name, "–", f"missing: pip install {name}"]


def _rendering() -> list[str]:
    """Rendering without EGL or OSMesa ends the process, so a child process tries it."""
    code = (
        "import os; os.environ.setdefault('VTK_DEFAULT_OPENGL_WINDOW', 'vtkEGLRenderWindow'); import pyvista;"
        "p = pyvista.Plotter(off_screen=True, window_size=(32, 32)); p.add_mesh(pyvista.Sphere()); p.screenshot(return_img=True)"
    )
    try:
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, timeout=60, check=False
        ).returncode
    except subprocess.TimeoutExpired:
        done = 1
    if done == 0:
        return ["off-screen OpenGL", "yes", "ok"]
    hint = "install libegl1 libgl1-mesa-dri (Debian) or mesa-libEGL (Fedora) for pyvista pictures; reports do not need it"
    return ["off-screen OpenGL", "no", hint]


def _cache() -> list[str]:
    from vcmm.evaluation.streams import kernel_state

    return ["compiled kernels", *kernel_state()]
