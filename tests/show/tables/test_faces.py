"""The document of a scanned face."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.show.tables.faces import face_json


def test_the_odd_part_is_in_micrometres_with_its_u():
    """0.002 mm = 2 um, with u of 0.0005 mm = 0.5 um; cells without readings are null."""
    scan = SimpleNamespace(name="face", spiral=False, x=np.zeros(7))
    found = SimpleNamespace(
        scan=scan, machine="", noise=1e-4, memory=0.0, figures=[], x=np.array([0.0, 1.0]), y=np.array([0.0]),
        height=np.array([[1e-3, np.nan]]), u=np.array([[2e-4, np.nan]]), r=None, profile=None,
        odd=np.array([0.002]), u_odd=np.array([0.0005]),
    )  # fmt: skip
    body = face_json(found)  # type: ignore[arg-type]
    assert body["odd_part"]["height_um"] == pytest.approx([2.0])
    assert body["odd_part"]["u_um"] == pytest.approx([0.5])
    assert (body["readings"], body["noise_um"]) == (7, pytest.approx(0.1))
