"""All scans in one fit (vcmm.faces.fit_face): what the reversals of this paper know of slide and spindle, with the priors of this paper.

h = E_ZX - x B0C - x E_BX(x), E_ZX as the straightness reversal found it, E_BX of ROLL's size or as two probes found it; orders of E_ZC and E_BC as
the face reversal found them; the odd part of the half-turn scans
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm import Array, faces, reversals

from .flat import SLOW, FlatScan, face_scan
from .lathe import NM, RADIUS, YAW
from .surveys import MIRROR, PLACED, PLACES, Survey

NODES = np.linspace(-RADIUS, RADIUS, 41)
SHAPE = 10 * NM  # prior of a term of the flat
FREE = 1e-3  # mm or rad: as good as unknown
YAW_LENGTH = 12.0  # mm
SECTORS = 36
PRIOR = faces.FacePrior(RADIUS, SHAPE, SLOW, plane=FREE, sectors=SECTORS)


def joint_fit(
    survey: Survey, scans: Sequence[FlatScan], index: Sequence[float], yaw: bool = False
) -> faces.FaceFit:
    """The flat from all scans; index: rad by which it was turned in each of them. yaw: E_BX was measured too."""
    known = slide_of(survey, yaw), spindle_of(survey), PRIOR, half_turn_of(survey)
    return faces.fit_face([face_scan(s) for s in scans], index, *known)


def half_turn_of(survey: Survey) -> faces.HalfTurn:
    """The odd part at x > 0 that was read, and its u from the scatter of the scans."""
    odd = np.stack([(s.value - s.value[::-1]) / 2 for s in survey.scans])
    first = np.array([s.setup == reversals.NORMAL for s in survey.scans])
    up = MIRROR > 1e-9
    both = (odd[first].mean(axis=0) + odd[~first].mean(axis=0)) / 2
    left = np.concatenate([odd[m] - odd[m].mean(axis=0) for m in (first, ~first)])
    own = (left**2).sum() / (len(odd) - 2) / left.shape[1] / len(odd)
    return faces.HalfTurn(MIRROR[up], both[up], float(np.sqrt(own * faces.memory(left.ravel(), SECTORS))))


def slide_of(survey: Survey, measured: bool) -> faces.SlideKnowledge:
    on = faces.hats(survey.straight.nodes, NODES)
    yaw = YAW**2 * np.exp(-((NODES[:, None] - NODES) ** 2) / (2 * YAW_LENGTH**2))
    value = on @ survey.straight.machine
    if measured:
        value = value - NODES * (faces.hats(PLACES, NODES) @ survey.yaw[0])
        yaw *= (survey.yaw[1] / YAW) ** 2
    # a mirror that lies PLACED beside its old place
    slope = on @ np.gradient(survey.straight.artefact, survey.straight.nodes)
    covariance = (
        on @ survey.straight.covariance @ on.T
        + (PLACED / 2) ** 2 * np.outer(slope, slope)
        + np.outer(NODES, NODES) * (yaw + FREE**2)
        + (0.05 * NM) ** 2 * np.eye(len(NODES))
    )
    return faces.SlideKnowledge(NODES, value, covariance)


def spindle_of(survey: Survey) -> faces.SpindleKnowledge:
    return faces.SpindleKnowledge(*_orders(survey, "EZC", FREE), *_orders(survey, "EBC", FREE / RADIUS))


def _orders(survey: Survey, name: str, free: float) -> tuple[Array, Array]:
    """Cosine and sine of every order, and their variances; free where the face reversal does not identify one."""
    i = survey.spindle.names.index(name)
    value, known = survey.spindle.value[i], survey.spindle.is_identified[i]
    variance = np.where(known, survey.spindle.covariance[:, i, i], free**2)
    return np.stack([value.real, -value.imag], axis=1).ravel(), np.repeat(variance, 2)
