"""Nuisance: the columns of every word by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests import build
from tests.task.response.test_observe import X, Y, Z, recording
from vcmm.core.errors import ModelLimit
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.recording import Recording


def nuisance(rec: Recording, **words: str) -> dict[str, list[float]]:
    columns, names = nuisance_columns(replace(rec, nuisance=words), build.machine())
    assert columns.shape == (rec.m, len(names))
    return {name: columns[:, i].tolist() for i, name in enumerate(names)}


def test_rigid_is_shift_and_turn_about_the_centroid():
    """Points at x = 90 and 110 touched along y: a turn w about z through x = 100 moves them by -10 w and +10 w along y;
    about x and y it moves them along z and x or not at all, so these columns are left out.
    """
    found = nuisance(recording([[90, 5, 7], [110, 5, 7]], [Y, Y]), rigid="")
    assert found == {"rigid.shift_y": [1.0, 1.0], "rigid.turn_z": [-10.0, 10.0]}


def test_a_turn_of_the_artefact_is_explained_in_full():
    rng = np.random.default_rng(8)
    d = rng.standard_normal((20, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    rec = recording(rng.uniform(0, 300, (20, 3)), d, pose=["a"] * 10 + ["b"] * 10)
    columns, names = nuisance_columns(replace(rec, nuisance={"rigid": "pose"}), build.machine())
    assert len(names) == 12
    assert names[0] == "rigid[pose=a].shift_x"
    turn, shift = np.array([1e-5, -2e-5, 3e-5]), np.array([0.1, 0.2, -0.3])
    places = np.stack([rec.run.q(a) for a in "XYZ"], axis=1)
    moved = ((np.cross(turn, places - [400.0, 0.0, 0.0]) + shift) * d).sum(axis=1)
    rest = moved - columns @ np.linalg.lstsq(columns, moved, rcond=None)[0]
    assert np.abs(rest).max() < 1e-12


def test_offset_radius_zero_and_centre():
    rec = recording([[0, 0, 0]] * 3, [X, [0.6, 0.0, 0.8], -X], stylus=["s", "t", "s"])
    assert nuisance(rec, offset="stylus") == {
        "offset[stylus=s].shift_x": [1.0, 0.0, -1.0],
        "offset[stylus=t].shift_x": [0.0, 0.6, 0.0],
        "offset[stylus=t].shift_z": [0.0, 0.8, 0.0],
    }
    assert nuisance(rec, radius="stylus") == {
        "radius[stylus=s]": [1.0, 0.0, 1.0],
        "radius[stylus=t]": [0.0, 1.0, 0.0],
    }
    assert nuisance(rec, zero="run") == {"zero": [1.0, 1.0, 1.0]}
    centre = {"centre.shift_x": [1.0, 0.6, -1.0], "centre.shift_z": [0.0, 0.8, 0.0]}
    assert nuisance(rec, centre="") == centre
    assert list(nuisance(rec, station="")) == ["station.shift_x", "station.shift_z"]
    assert nuisance(rec, alignment="") == {
        "alignment.shift_x": [1.0, 0.6, -1.0],
        "alignment.shift_z": [0.0, 0.8, 0.0],
    }


def test_where_a_length_lies_does_not_matter():
    """Shift and turn of an artefact change no length on it; both tips are the same stylus; a fixed end is a centre."""
    places = [[300, 400, 0], [500, 100, 50], [0, 0, 0], [500, 100, -150]]
    rec = recording(places, [[0.6, 0.8, 0.0], Z], "length", second=[2, 3])
    assert nuisance(rec, rigid="", offset="") == {}
    assert nuisance(rec, radius="") == {"radius": [1.0, 1.0]}
    assert nuisance(rec, slope="") == {"slope": [500.0, 200.0]}
    bar = replace(rec, other=np.array([-1, -1]))
    assert nuisance(bar, centre="") == {
        "centre.shift_x": [0.6, 0.0],
        "centre.shift_y": [0.8, 0.0],
        "centre.shift_z": [0.0, 1.0],
    }


def test_an_angle_has_a_turned_artefact_and_a_zero():
    rec = recording([[0, 0, 0], [100, 0, 0]], [Y, Y], "angle")
    assert nuisance(rec, rigid="", offset="", zero="") == {"rigid.turn_y": [1.0, 1.0], "zero": [1.0, 1.0]}


def test_slope_along_the_line_or_over_time():
    """Straightness seen along y of a travel along x: 0, 100, 200 from their centroid; at one place the time counts."""
    rec = recording([[0, 5, 0], [100, 5, 0], [200, 5, 0]], [Y] * 3)
    assert nuisance(rec, slope="")["slope"] == pytest.approx([-100.0, 0.0, 100.0])
    still = recording([[0, 0, 0]] * 2, [Y] * 2, time_s=[0, 60])
    assert nuisance(still, slope="")["slope"] == [-30.0, 30.0]
    with pytest.raises(ModelLimit, match="there is no time_s"):
        nuisance(recording([[0, 0, 0]] * 2, [Y] * 2), slope="")


def test_dead_path():
    """1 K warmer air and 10 hPa more: -0.93e-6 and +2.7e-6 per mm of dead path, from the first row of the instrument."""
    rec = recording([[0, 0, 0]] * 2, [X] * 2, temp_air_C=[20, 21], pressure_hPa=[1000, 1010])
    assert nuisance(rec, dead_path="")["dead_path"] == pytest.approx([0.0, 1.77e-6])
    known = replace(rec, run=rec.run.with_columns({"dead_path_mm": np.full(2, 100.0)}))
    assert nuisance(known, dead_path="")["dead_path"] == pytest.approx([0.0, 1.77e-4])
    paths = recording([[0, 0, 0]] * 2, [X] * 2, dead_path_mm=[100, 200], instrument=["a", "b"])
    assert nuisance(paths, dead_path="instrument") == {
        "dead_path[instrument=a]": [100.0, 0.0],
        "dead_path[instrument=b]": [0.0, 200.0],
    }
    with pytest.raises(ModelLimit, match="dead_path needs dead_path_mm, or"):
        nuisance(recording([[0, 0, 0]], [X]), dead_path="")


def test_a_radius_needs_normals():
    rec = recording([[0, 0, 0]], [X])
    bare = replace(rec, run=replace(rec.run, columns={}))
    with pytest.raises(ModelLimit, match="radius needs the normal"):
        nuisance(bare, radius="")


def test_a_profile_leaves_the_reversal():
    """Three places from both sides: one free value each. A wave of 20 um of the sensor goes, a reversal of 2 um stays."""
    rec = recording([[0, 0, 0], [50, 0, 0], [100, 0, 0], [100, 0, 0], [50, 0, 0], [0.004, 0, 0]], [X] * 6)
    found = nuisance(rec, profile="")
    assert found == {
        "profile.place_1": [1.0, 0, 0, 0, 0, 1.0],  # 4 um apart is one target
        "profile.place_2": [0, 1.0, 0, 0, 1.0, 0],
        "profile.place_3": [0, 0, 1.0, 1.0, 0, 0],
    }
    columns = np.array(list(found.values())).T
    seen = np.array([20.0, -7.0, 11.0, 11.0, -7.0, 20.0]) + np.array([1.0, 1, 1, -1, -1, -1])
    rest = seen - columns @ np.linalg.lstsq(columns, seen, rcond=None)[0]
    assert rest == pytest.approx([1.0, 1, 1, -1, -1, -1])
    with pytest.raises(ModelLimit, match="visited twice"):
        nuisance(recording([[0, 0, 0], [50, 0, 0]], [X, X]), profile="")


def test_more_groups_than_memory_holds_are_refused_beforehand(monkeypatch):
    rec = recording([[k, 0, 0] for k in range(6)], [X] * 6)
    rec = replace(rec, run=replace(rec.run, labels={"pose": np.array(list("abcdef"))}))
    assert len(nuisance(rec, zero="pose")) == 6
    monkeypatch.setattr("vcmm.task.response.nuisance.TABLE", 35)  # 6 values in 6 observations are 36 numbers
    with pytest.raises(ModelLimit, match='zero = "pose" has 6 values in 6 observations'):
        nuisance(rec, zero="pose")
