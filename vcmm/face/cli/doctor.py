"""vcmm doctor: check that everything that vcmm needs is installed, and measure its speed."""

from __future__ import annotations

import contextlib
import io
import os
import platform
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from vcmm import __version__
from vcmm.face.cli import run
from vcmm.face.cli.options import Json
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.show.console.terminal import show_table
from vcmm.show.tables.table import listing

WARMING = (
    "test_piece",
    "turned_shaft",
    "pallet_block",
)  # cuts that together use every kernel of cutting and motion
REQUIRED_PACKAGES = (
    "numpy",
    "scipy",
    "numba",
    "trimesh",
    "pydantic",
    "cyclopts",
    "rich",
    "tomlkit",
)


EXTRA_PACKAGES = (
    ("pyvista", "view", "windows, pictures of vcmm view, places on meshes"),
    ("cadquery-ocp-novtk", "step", "STEP files"),
)


def doctor_command(*, warm: bool = False, json: Json = False, out: Path | None = None) -> int:
    """Check the installation: Python, packages, off-screen rendering, cores. Exit code 3 when something is missing.

    Parameters
    ----------
    warm
        Compile all kernels now (about two minutes), so that no job has to wait for it.
    json
        Print one JSON document.
    out
        Folder for doctor.json, to send with a question.
    """
    return run_job(DoctorJob(warm), Flags(json, out))


Check = list[str]  # what was looked at, what was found, "ok" or what is wrong with it


@dataclass(frozen=True)
class DoctorJob(Job[list[Check], list[Check]]):
    """The installation checked. Loaded: installed packages; the result also holds the trials."""

    warm: bool
    schema = "vcmm.doctor/1"

    def load(self) -> list[Check]:
        python = "ok" if sys.version_info >= (3, 11) else "needs 3.11"
        rows = [["vcmm", __version__, "ok"], ["Python", platform.python_version(), python]]
        rows += [_package(name) for name in REQUIRED_PACKAGES]
        return rows + [_extra(name, extra, what) for name, extra, what in EXTRA_PACKAGES]

    def run(self, loaded: list[Check], report: Progress) -> list[Check]:
        warmed = [_warm_up(report)] if self.warm else []
        return [*loaded, *warmed, _rendering(), _cache(), ["cores", str(os.cpu_count()), "ok"]]

    def record(self, loaded: list[Check], result: list[Check]) -> Record:
        checks = [dict(zip(("what", "found", "state"), row)) for row in result]
        return Record({"checks": checks, "ok": not _missing(result)}, ())

    def texts(self, loaded: list[Check], result: list[Check], content: str, folder: Path) -> dict[str, str]:
        return {"doctor.json": content}

    def exit_code(self, loaded: list[Check], result: list[Check]) -> int:
        return 3 if _missing(result) else 0

    def show(self, loaded: list[Check], result: list[Check]) -> None:
        show_table(listing("installation", ["", "found", "state"], result, words=(0, 1, 2)))


def _missing(rows: list[Check]) -> list[Check]:
    return [row for row in rows if row[2].startswith("missing")]


def _extra(name: str, extra: str, what: str) -> list[str]:
    """Return a package of an extra, which most jobs do without."""
    package = _package(name)
    state = package[2] if package[2] == "ok" else f'not needed but for {what}: pip install "vcmm[{extra}]"'
    return [name, package[1], state]


def _package(name: str) -> list[str]:
    try:
        return [name, version(name), "ok"]
    except PackageNotFoundError:
        return [name, "–", f"missing: pip install {name}"]


def _rendering() -> list[str]:
    """Try rendering in a child process, since without EGL or OSMesa it ends the process."""
    if _package("pyvista")[2] != "ok":
        return ["off-screen OpenGL", "–", "not looked at: pyvista is not installed"]
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


def _warm_up(report: Progress) -> Check:
    """Compile the kernels by small jobs that use them: sampling, fits by extremes, milling, turning, a rotary table."""
    from vcmm.core._compile_kernels import FOLDER, KEPT
    from vcmm.files.own.library import example

    if not KEPT:
        return [
            "kernels compiled",
            "no",
            "nothing can be kept: let NUMBA_CACHE_DIR name a folder that can be written",
        ]
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        extreme = Path(folder) / "plate.toml"
        extreme.write_text(
            example("plate").read_text("utf-8").replace('type = "size"', 'type = "size"\ncriterion = "GX"')
        )
        jobs = [("uncertainty", extreme), *(("cut", example(name)) for name in WARMING)]
        for i, (verb, scenario) in enumerate(jobs):
            report(f"{verb} {scenario.stem}", i / len(jobs))
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                run([verb, str(scenario), "--trials", "50000"])
    kept = len(list(FOLDER.rglob("*.nbi")))
    return ["kernels compiled", f"{kept} in {FOLDER}, {time.perf_counter() - began:.0f} s", "ok"]


def _cache() -> list[str]:
    from vcmm.answer.evaluation.streams import kernel_state

    return ["compiled kernels", *kernel_state()]
