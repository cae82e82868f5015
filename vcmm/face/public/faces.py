"""Faces scanned on the machine that made them: scan in, map out, corrected program out.

scan = vcmm.faces.load_face_scan("scan.toml")
found = vcmm.faces.map_face(scan, vcmm.load_machine("lathe.toml"))
better = vcmm.faces.correct_face("face.nc", "setup.toml", found)

Several spirals, with what reversals know of slide and spindle, in one fit: fit_face.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from vcmm.compensation.face import face_errors
from vcmm.compensation.job import compensate, prepare
from vcmm.compensation.result import CompensatedProgram
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.face.programs import setup_and_machine
from vcmm.files.own.face_scan import load_face_scan
from vcmm.learn.calibration.face_fit import (
    FaceFit,
    FacePrior,
    HalfTurn,
    SlideKnowledge,
    SpindleKnowledge,
    fit_face,
    hats,
    memory,
    zernike_terms,
)
from vcmm.learn.calibration.face_knowledge import KnownRise, known_rise
from vcmm.learn.calibration.face_map import FaceFigure, FaceMap, map_face
from vcmm.task.instruments.face_scan import FaceScan

__all__ = [
    "FaceFigure", "FaceFit", "FaceMap", "FacePrior", "FaceScan", "HalfTurn", "KnownRise", "SlideKnowledge", "SpindleKnowledge",
    "correct_face", "fit_face", "hats", "known_rise", "load_face_scan", "map_face", "memory", "zernike_terms",
]  # fmt: skip


def correct_face(
    program: str | Path, setup: str | Path, face: FaceMap, *, lines: tuple[int, int] | None = None,
    dialect: str | None = None, tolerance: float = 1e-3, decimals: int | None = None,
) -> CompensatedProgram:  # fmt: skip
    """Return the program that cut the face, with the excess heights of the map subtracted along Z.

    Parameters
    ----------
    program, setup
        NC program and set-up file (setup/1) with which the face was cut.
    face
        Map of the face.
    lines
        First and last line of the program that cut it; default: every feed move that passes over the scanned area.
    dialect
        How the program is written; default: that of the set-up file, else guessed.
    tolerance
        mm that may be left, beside the rounding of the last decimal.
    decimals
        Decimals of the new numbers.

    Returns
    -------
    CompensatedProgram
        The text, its proof and what was changed.
    """
    given = {"dialect": dialect, "decimals": decimals, "set_here": False}
    work = prepare(program, *setup_and_machine(setup, None), constants=None, **given)  # type: ignore[arg-type]
    machine = replace(work.machine, effects=(), inputs=())
    if work.dialect.lathe != face.scan.spiral:
        what = "spiral of a turned face" if face.scan.spiral else "raster of a milled face"
        raise UsageError(
            f"the scan is a {what}, and {program} is a program of a {'lathe' if work.dialect.lathe else 'mill'}"
        )
    extent = _extent(face)
    moves = work.program.moves
    surface = face_errors(moves, work.setup, face.at, extent=extent, lathe=work.dialect.lathe, lines=lines)
    return compensate(program, work.setup, machine, surface=surface, tolerance=tolerance, **given)  # type: ignore[arg-type]


def _extent(face_map: FaceMap) -> tuple[Array, Array]:
    """Return the lowest and highest x, y of the part that the scan reached, mm."""
    if face_map.scan.spiral:
        far = np.full(2, float(np.abs(face_map.scan.x).max()))
        return -far, far
    places = np.column_stack([face_map.scan.x, face_map.scan.across])
    return places.min(axis=0), places.max(axis=0)
