"""Errors x features of the circle-diamond-square piece, against numbers made by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from vcmm_twins.test_piece import page, piece, twin

import vcmm
from tests.documented import assert_documented, assert_titled, instead
from vcmm.face.cli import run as command
from vcmm.files.own.library import example, folder
from vcmm.physics.catalogue.lag import ServoLag
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.squareness import Squareness
from vcmm.shop.machining.cut_nets import cut_net, departure
from vcmm.shop.machining.preparation import set_up


@pytest.fixture(scope="module")
def scenario():
    return vcmm.load_cut(example("test_piece"))


@pytest.fixture(scope="module")
def result(scenario):
    return twin.run(scenario)


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        # the cutter's centre runs on a circle of 52 + 10 mm: -c 62 sin cos = -0.31 sin 2a um; sides 152 mm long;
        # widths of the diamond: the centres run 108 + 20 = 128 mm apart, -+c 128 / 2 = 0.64 um
        ("squareness of X and Y", {"oval at 45°": -0.31, "oval at 0°": 0.0, "circle, scan of 1°": 0.62, "square corner": 1.52,
                                   "diamond width NE": -0.64, "diamond width NW": 0.64, "diamond corner": 0.0, "circle diameter": 0.0}),
        # bore at z = -30 to -0, circle at -10 to 0: the cutter stands at -30 and -10, 20 mm x 10 urad apart; coaxiality is twice that
        ("squareness of X and Z", {"bore to circle": 0.40, "square corner": 0.0}),
        # k 62 cos^2: 0.31 (1 + cos 2a); the centres run 160 + 20 mm apart; the diamond's angle opens by k, sides 97.2 mm
        ("scale of X", {"oval at 0°": 0.31, "circle diameter": 0.62, "square length in X": 1.80, "square length in Y": 0.0, "diamond corner": 0.972}),
        ("scale of Y", {"oval at 0°": -0.31, "square length in Y": 1.80, "square length in X": 0.0}),
        # flatness of a parabola over the points of the side, 1 mm in from its ends: 100 um/m2 x (75 mm)^2 = 0.5625 um
        ("straightness EYX", {"side straightness": 0.5625, "side straightness E": 0.0, "square corner": 0.0}),
        ("straightness EXY", {"side straightness E": 0.5625, "side straightness": 0.0}),
        # west is cut after a move to -X, east after one to +X: -0.5 um each; south and north both after +Y
        ("backlash of X", {"square length in X": -1.0, "square length in Y": 0.0}),
        ("backlash of Y", {"square length in Y": 0.0, "square length in X": 0.0}),
        # the pulse reaches its height 0.3 mm after the reversal; of 24 points the nearest behind it is 15 deg - 0.05 rad away:
        # 62 mm (1 - cos 12.1 deg) = 1.38 mm = 4.6 x 0.3 mm, 4.6 exp(1 - 4.6) cos 12.1 deg = 0.12 of it
        ("reversal spike of X", {"circle, scan of 1°": 1.0, "circle roundness": 0.12, "square length in X": 0.0}),
        # 10 mm/s x 0.1 ms = 1 um: clockwise vx = v sin a, so -1 sin a cos a = -0.5 sin 2a
        ("lag of X", {"oval at 45°": -0.5, "oval at 0°": 0.0, "diamond width NE": -1.0, "diamond width NW": 1.0}),
        ("lag of Y", {"oval at 45°": 0.5}),
        ("cutter too large", {"circle diameter": -2.0, "square length in X": -2.0, "diamond width NE": -2.0, "circle roundness": 0.0}),
    ],
)  # fmt: skip
def test_single_errors_by_hand(result, error, expected):
    row = next(i for i, name in enumerate(result.errors) if name.startswith(error))
    for feature, value in expected.items():
        tolerance = 0.04 if "spike" in error else 0.012
        assert result.um[row, result.features.index(feature)] == pytest.approx(value, abs=tolerance), feature


def test_spindle_growth_shows_nowhere(result):
    row = next(i for i, name in enumerate(result.errors) if name.startswith("spindle"))
    assert np.abs(result.um[row]).max() < 1e-6


def test_sizes_add_up(scenario):
    ready = twin.prepared(scenario)
    one, other = Squareness("C0Y", 10e-6), ScaleFactor("X", 10e-6)
    names = [c.name for c in scenario.part.characteristics]
    sizes = [
        names.index(n)
        for n in ("circle diameter", "square length in X", "diamond width NE", "diamond width NW")
    ]
    apart = twin.row(ready, (one,))[0] + twin.row(ready, (other,))[0] - twin.row(ready, ())[0]
    assert twin.row(ready, (one, other))[0][sizes] == pytest.approx(apart[sizes], abs=1e-4)


def test_the_files_of_the_scenario_are_what_the_twin_makes():
    assert (folder() / "test_piece" / "part.nc").read_text() == piece.program()
    assert piece.features() in (folder() / "test_piece.toml").read_text()


def test_harmonics_by_hand():
    angle = np.linspace(0, 2 * np.pi, 361)
    height = 3.0 + 5.0 * np.cos(angle) + 2.0 * np.cos(2 * angle) - 1.5 * np.sin(2 * angle)
    # the shift (cos a) is taken off; 2 cos - 1.5 sin of 2a has the amplitude 2.5, so 5 from peak to valley
    assert twin.harmonics(angle, height) == pytest.approx([5.0, 2.0, -1.5], abs=2e-3)


def test_the_oval_of_a_lag_turns_over_with_the_direction_of_travel(scenario, tmp_path):
    """The circle cut the other way round, by G42 and G3: what the drawing of the errors says in words."""
    cut = piece.program().split("(CIRCLE)")[1].split("(DIAMOND)")[0]
    other = (
        cut.replace("G41", "G42")
        .replace("G2 ", "G3 ")
        .replace("X-25.", "X_")
        .replace("X25.", "X-25.")
        .replace("X_", "X25.")
    )
    file = tmp_path / "part.nc"
    file.write_text(piece.program().replace(cut, other))
    views = []
    for program in (scenario.program, file):
        shop = set_up(replace(scenario, program=program))
        views.append(cut_net(shop, twin.scan(scenario.part.features["circle"])))
    late = replace(scenario.machine, effects=(ServoLag("X", 1e-4),), inputs=())
    there, back = (twin.harmonics(v.net.first, departure(v, late))[2] for v in views)
    # 600 mm/min x 0.1 ms = 1 um; half of it in sin 2a
    assert there == pytest.approx(-0.5e-3, rel=0.01)
    assert back == pytest.approx(0.5e-3, rel=0.01)


def test_documentation_shows_what_the_command_prints(scenario, result):
    assert_documented("test_piece", page.tables(result))
    assert_titled(page, scenario, result)


def test_demo_of_the_test_piece(result, tmp_path, capsys, monkeypatch):
    instead(monkeypatch, twin, "test_piece", result)
    assert command(["demo", "--twin", "test_piece", "--out", str(tmp_path / "out"), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "vcmm.twin/1"
    assert document["twin"] == "test_piece"
    assert len(document["deviation_um"]) == len(document["errors"])
    assert {f["file"].rsplit("/", 1)[-1] for f in document["inputs"]} == {
        "test_piece.toml",
        "part.nc",
        "setup.toml",
    }
    assert json.loads((tmp_path / "out" / "demo.json").read_text()) == document
    assert "Which error shows" in (tmp_path / "out" / "report.html").read_text()
