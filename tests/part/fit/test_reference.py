"""Certified and constructed reference sets to 1e-9 mm and 1e-10 rad; scanned holes with a reported answer."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import data_file
from tests.refdata import KINDS, Array, Recipe, Reference, reference
from vcmm.part.fit import FittedElement, gauss

MM, RAD = 1e-9, 1e-10
CERTIFIED = [f"line{i}" for i in (1, 2, 3)] + [
    f"{kind}{i}" for kind in ("plane", "sphere", "cylinder", "cone", "torus") for i in (1, 2, 3, 4)
]


def differences(fit: FittedElement, want: Reference) -> tuple[float, float]:
    """Worst length (mm) and angle (rad); where a point lies along an axis or in a plane is not compared."""
    away, sizes, angle = fit.point - want.point, fit.sizes - want.sizes, 0.0
    if fit.kind not in ("point", "sphere"):
        angle = float(np.linalg.norm(np.cross(fit.axis, want.axis)))
    if fit.kind == "plane":
        away = away @ want.axis
    if fit.kind in ("line", "cylinder", "cone"):
        height = away @ fit.axis
        away = away - (away @ want.axis) * want.axis
        if fit.kind == "cone":  # both radii at the reference's point
            sizes = sizes - [height * np.tan(fit.sizes[1]), 0.0]
            assert fit.axis @ want.axis > 0
            angle = max(angle, abs(float(sizes[1])))
            sizes = sizes[:1]
    return max(float(np.linalg.norm(away)), float(np.max(np.abs(sizes), initial=0.0))), angle


def assert_same(fit: FittedElement, want: Reference, mm: float = MM, rad: float = RAD) -> None:
    length, angle = differences(fit, want)
    assert length < mm
    assert angle < rad


def read_pair(path: Path, kind: str) -> Reference:
    """NIST syntax: NAME.ds holds n, then the points; NAME.fit one number per line (diameters, full angle)."""
    values = np.array(path.read_text().split(), dtype=float)
    points = values[1:].reshape(int(values[0]), 3)
    fit = np.array(path.with_suffix(".fit").read_text().split(), dtype=float)
    if kind == "sphere":
        return Reference(kind, points, fit[:3], np.zeros(3), fit[3:4] / 2)
    sizes = fit[6:] / 2
    if kind == "cone":  # orthogonal distance to the surface, full apex angle in degrees
        half = np.radians(fit[7] / 2)
        sizes = np.array([fit[6] / np.cos(half), half])
    return Reference(kind, points, fit[:3], fit[3:6] / np.linalg.norm(fit[3:6]), sizes)


def deviations(folder: Path) -> list[tuple[str, int, float, float]]:
    """(set, files, worst length mm, worst angle rad) over all reference sets; printed by tools/validate.py."""
    circles = [("circle", folder / "nist_ls_circle2d" / f"cir2d{i}.ds") for i in range(1, 31)]
    pairs = [*circles, *((name[:-1], folder / "certified_ls" / f"{name}.ds") for name in CERTIFIED)]
    out = []
    for kind in dict.fromkeys(k for k, _ in pairs):
        files = [path for k, path in pairs if k == kind]
        worst = [differences(gauss(kind, w.points), w) for w in (read_pair(path, kind) for path in files)]
        out.append((kind, len(files), max(w[0] for w in worst), max(w[1] for w in worst)))
    return out


@pytest.mark.parametrize("number", range(1, 31))
def test_nist_circles(number: int) -> None:
    want = read_pair(data_file(f"data/fitting/nist_ls_circle2d/cir2d{number}.ds"), "circle")
    assert_same(gauss("circle", want.points), want)
    assert_same(gauss("circle", want.points, fixed_axis=want.axis), want)


@pytest.mark.parametrize("name", CERTIFIED)
def test_certified_sets_without_a_start(name: str) -> None:
    want = read_pair(data_file(f"data/fitting/certified_ls/{name}.ds"), name[:-1])
    assert_same(gauss(want.kind, want.points), want)


@pytest.mark.parametrize("name", CERTIFIED)
def test_certified_sets_from_a_rough_nominal_start(name: str) -> None:
    want = read_pair(data_file(f"data/fitting/certified_ls/{name}.ds"), name[:-1])
    rng = np.random.default_rng(7)
    axis = want.axis + 0.02 * rng.standard_normal(3)
    start = FittedElement(
        want.kind,
        want.point + 0.3 * rng.standard_normal(3),
        axis / np.linalg.norm(axis),
        want.sizes * 1.02,
        np.empty(0),
        np.empty((0, 3)),
    )
    assert_same(gauss(want.kind, want.points, start), want)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    kind=st.sampled_from(KINDS),
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(18, 60),
    size=st.floats(1.0, 200.0),
    form=st.floats(1e-5, 5e-3),
    arc=st.floats(2.6, 2 * np.pi),
    slender=st.floats(0.5, 5.0),
)
def test_null_space_sets(
    kind: str, seed: int, n: int, size: float, form: float, arc: float, slender: float
) -> None:
    recipe = Recipe(n, size, form * size, arc, slender * size)
    want = reference(kind, np.random.default_rng(seed), recipe)
    fit = gauss(kind, want.points)
    assert_same(fit, want)
    assert np.ptp(fit.residuals) < 2.0 * recipe.form


@pytest.mark.parametrize("kind", KINDS)
def test_a_wrong_answer_would_be_noticed(kind: str) -> None:
    want = reference(kind, np.random.default_rng(1))
    moved = want.points.copy()
    moved[3] += [2e-7, -3e-7, 2.5e-7]
    length, angle = differences(gauss(kind, moved), want)
    assert length > MM or angle > RAD


def qif_holes(path: Path) -> list[tuple[Array, float, Array, float]]:
    """Per scanned hole: points (n, 3), probe radius, reported centre and diameter."""
    name = {"q": "http://qifstandards.org/xsd/qif3"}
    root = ElementTree.parse(path).getroot()
    sets = {s.get("id"): s for s in root.iterfind(".//q:MeasuredPointSet", name)}
    holes = []
    for circle in root.iterfind(".//q:CircleFeatureMeasurement", name):
        points = sets[circle.findtext(".//q:WholePointSetId", "", name)]
        text = "".join(points.find("q:Points", name).itertext())  # type: ignore[union-attr]
        holes.append(
            (
                np.array(text.split(), dtype=float).reshape(-1, 3),
                float(points.findtext("q:ProbeRadius", "", name)),
                np.array(circle.findtext("q:Location", "", name).split(), dtype=float),
                float(circle.findtext("q:Diameter", "", name)),
            )
        )
    return holes


def test_scanned_holes_of_a_commercial_software() -> None:
    # probe centres of an inside scan: hole diameter = least-squares diameter + 2 x probe radius
    holes = qif_holes(data_file("data/formats/QIF_PTS_SAMPLE.QIF"))
    assert [len(points) for points, *_ in holes] == [219, 219, 219]
    for points, probe, centre, diameter in holes:
        fit = gauss("circle", points, fixed_axis=np.array([0.0, 0.0, -1.0]))
        assert 2.0 * fit.sizes[0] + 2.0 * probe == pytest.approx(diameter, abs=5e-9)
        assert np.max(np.abs(fit.point - centre)[:2]) < 6e-9
