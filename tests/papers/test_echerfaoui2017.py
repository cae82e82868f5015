"""The twin of Echerfaoui et al. 2017: equations by hand, learning by hand, figures of the page."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest
from vcmm_twins.echerfaoui2017 import page, twin
from vcmm_twins.echerfaoui2017.laser import ARCSEC, OPTIONS, read

from tests.documented import DOCS, assert_documented
from vcmm.face.cli import run as command


@cache
def result():
    return twin.run()


def test_the_synthesis_is_equation_8_with_its_signs_mended():
    """E_x = sum delta_x - y (ez(x) + Sxy) + (z - L)(ey(x) + ey(y)) - L ey(z) - z Sxz, and so on: B0Z = -Sxz, z - L by eq. 4."""
    rng = np.random.default_rng(5)
    cmm = twin.drawn_cmm(rng)
    places = rng.uniform(0.0, 400.0, (20, 3))
    d = {a: np.stack([np.interp(q, twin.NODES, six[:, k]) for k in range(6)], axis=1) for (a, six), q in zip(cmm.curves.items(), places.T)}  # fmt: skip
    x, y, z = (d[a] for a in "XYZ")
    _, py, pz = places.T
    arm, length = pz - twin.LENGTH, twin.LENGTH
    c, b, a = (cmm.square[p] for p in ("C0Y", "B0Z", "A0Z"))
    want = np.stack(
        [
            x[:, 0]
            + y[:, 0]
            + z[:, 0]
            - py * (x[:, 5] + c)
            + arm * (x[:, 4] + y[:, 4])
            - length * z[:, 4]
            + pz * b,
            x[:, 1] + y[:, 1] + z[:, 1] - arm * (x[:, 3] + y[:, 3]) + length * z[:, 3] - pz * a,
            x[:, 2] + y[:, 2] + z[:, 2] + py * x[:, 3],
        ],
        axis=1,
    )
    assert twin.volumetric(twin.machine(cmm.curves, cmm.square), places) == pytest.approx(want, abs=1e-12)


def test_the_laser_stays_within_its_limits():
    rng = np.random.default_rng(1)
    at, none = twin.TARGETS, np.zeros((len(twin.TARGETS), 6))
    many = np.array([read(OPTIONS["precision"], "X", at, none, rng) for _ in range(300)])
    assert np.abs(many[:, -1, 0]).max() == pytest.approx(0.2e-6 * 400.0, rel=0.05)  # 0.2 ppm of 400 mm
    assert np.abs(many[:, :, 3]).max() <= 2 * 0.5 * ARCSEC  # a reading minus that at the start
    assert np.abs(many[:, [0, -1], 1:3]).max() < 1e-12  # straightness has no slope of its own


def test_published_sizes_are_met_by_every_machine():
    cmm = twin.drawn_cmm(np.random.default_rng(3))
    for axis, size in twin.LINEAR.items():
        six = np.abs(cmm.curves[axis]).max(axis=0)
        assert six["XYZ".index(axis)] == pytest.approx(size)
        assert (six[3:] <= 10 * ARCSEC + 1e-12).all()
        assert (six[3:] >= 7 * ARCSEC - 1e-12).all()


@pytest.mark.thorough
def test_a_kelvin_and_the_norm_of_the_diagonal():
    """Scales that are 7, 23 and 12 um long at 400 mm: norm sqrt(49 + 529 + 144) = 26.87 um, along the diagonal 42 / sqrt(3) = 24.25."""
    assert result().thermal == pytest.approx(4.6)  # um: 11.5e-6 x 400 mm
    curves = {a: np.zeros((len(twin.NODES), 6)) for a in "XYZ"}
    for k, (axis, size) in enumerate((("X", 7e-3), ("Y", 23e-3), ("Z", 12e-3))):
        curves[axis][:, k] = size * twin.NODES / twin.TRAVEL
    long = twin.machine(curves, {})
    perfect = twin.machine({a: np.zeros_like(six) for a, six in curves.items()}, {})
    found = twin.diagonal(long, perfect, "none")
    assert (found.norm, found.projection) == pytest.approx((26.870, 24.249), abs=1e-3)
    assert twin.diagonal(long, long, "all").norm_after == pytest.approx(0.0, abs=1e-9)


@pytest.mark.thorough
def test_documentation_shows_what_the_command_prints():
    assert_documented("echerfaoui2017", page.tables(result()))
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    rows = {row.what: row.values for row in page.compared(result())}
    net = rows["what the chosen net leaves of a component"]
    medians = ", ".join(f"{np.median(rows[f'largest error in {a}']):.0f}" for a in "XYZ")
    assert f"{min(net):.1f} to {max(net):.1f} %; medians {medians} µm" in readme


@pytest.mark.thorough
def test_command(tmp_path, capsys):
    assert (
        command(["demo", "--twin", "echerfaoui2017", "--draws", "1", "--out", str(tmp_path), "--json"]) == 0
    )
    found = json.loads(capsys.readouterr().out)
    (one,) = found["machines"]
    assert [r["method"] for r in one["residuals"]] == list(twin.METHODS)
    assert one["residuals"][0]["gain"] == pytest.approx(
        1 - one["residuals"][0]["after"][3] / one["residuals"][0]["before"][3]
    )
    assert (tmp_path / "report.html").is_file()
