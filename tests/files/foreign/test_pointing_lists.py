"""Pointing lists: by hand, and the published mounts as the tests' own converter reads them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import data_file
from tests.recordings.convert import telescope_mount
from vcmm.core.errors import DataError
from vcmm.files.foreign.pointing_lists import direction_of, read_altaz, read_tpoint, refract
from vcmm.files.own.recording import load_recording

MACHINE = """vcmm = "machine/1"
structure = "w b C B t"
[axes.C]
travel = ["-270 deg", "270 deg"]
[axes.B]
travel = ["-270 deg", "270 deg"]
"""
HEAD = "!a list\na mount\n:NODA\n:EQUAT\n+39 00 26 2024 7 14 15.0 1010.0 200 0.9 0.55 0.0065\n"
STAR = "06 00 00.0 -00 30 00.0 06 00 10.0 -00 30 05.0 06 00.0\n"


def load(tmp_path, text: str, name: str = "list.dat", kind: str = "tpoint", more: str = ""):
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / name).write_text(text)
    (tmp_path / "recording.toml").write_text(
        f'vcmm = "recording/1"\ndata = "{name}"\nmachine = "machine.toml"\nkind = "angle"\nformat = "{kind}"\n'
        f'observed = "actual - commanded"\n{more}[noise]\nu = "10 arcsec"\n'
    )
    return load_recording(tmp_path / "recording.toml")[0]


def test_a_star_by_hand(tmp_path):
    found = read_tpoint(_written(tmp_path, HEAD + STAR))
    # hour angle 6 h - 6 h 0 m 10 s = -10 s = -150 arcsec as read; C = -hour angle, B = -declination read
    assert np.degrees(found.first) * 3600 == pytest.approx([150.0])
    assert np.degrees(found.second) * 3600 == pytest.approx([1805.0])
    # the star stands in the meridian at declination -0.5 deg, latitude 39.0072: 50.4928 deg high; lifted by
    # 1.02' / tan(50.4928 + 10.3 / 55.6028 = 50.6780 deg) x 1010 / 1010 x 283 / 288 = 0.8212' = 49.27 arcsec
    declination = np.degrees(np.arcsin(found.directions[0, 2]))
    assert (declination + 0.5) * 3600 == pytest.approx(49.27, abs=0.02)
    assert found.directions[0, 1] == pytest.approx(0.0, abs=1e-12)
    assert found.down == pytest.approx(
        [-np.cos(np.radians(39.00722)), 0.0, -np.sin(np.radians(39.00722))], abs=1e-6
    )
    assert found.lines.tolist() == [6]


def _written(folder, text: str):
    (folder / "list.dat").write_text(text)
    return folder / "list.dat"


@pytest.mark.parametrize(("name", "equinox"), [("cgx-l-data", "date"), ("warp-astron", "J2000")])
def test_published_mounts_are_read_as_they_were_converted(tmp_path, name, equinox):
    source = data_file(f"data/recordings/gem_pointing_rotary_chain/{name}.dat")
    known, _ = load_recording(
        telescope_mount(source, tmp_path / "known", nuisance="", of_date=equinox == "date")
    )
    found = load(tmp_path, source.read_text(), more=f'equinox = "{equinox}"\n')
    assert found.m == known.m > 190
    assert (
        np.abs(found.value - known.value).max() < 2e-8
    )  # the converter precesses without third powers and writes 7 decimals
    assert found.run.column("down_x") == pytest.approx(known.run.column("down_x"), abs=1e-6)


def test_offsets_of_an_altaz_head_by_hand(tmp_path):
    table = "az_deg,alt_deg,d_az_arcsec,d_alt_arcsec,time_s,setup\n90,30,36,-18,0,a\n200,60,0,0,9,a\n"
    found = read_altaz(_written(tmp_path, table))
    assert np.degrees(found.first) == pytest.approx([-90.0, 160.0])
    assert np.degrees(found.second) == pytest.approx([-30.0, -60.0])
    # east is -y; 36 arcsec further round from north to east at 30 degrees, 18 arcsec lower
    assert found.directions[0] == pytest.approx(direction_of(np.radians([90.01]), np.radians([29.995]))[0])
    assert found.directions[0, 1] < -0.8
    recording = load(tmp_path, table, "list.csv", "altaz")
    size = np.abs(recording.value.reshape(2, 2)) * 180 / np.pi * 3600
    assert size[1] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert sorted(size[0]) == pytest.approx([18.0, 36.0 * np.cos(np.radians(30.0))], rel=1e-4)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEAD + STAR + "1 2 3\n", "list.dat:7: expected 14 numbers"),
        (HEAD, "there is no row of 14 numbers"),
        (HEAD.replace(":EQUAT", ":ALTAZ") + STAR, 'give a table with format = "altaz"'),
        ("!a list\n" + STAR, "no line above names latitude"),
        (HEAD.replace("+39", "-80") + STAR.replace("-00 30 00.0 06", "+80 30 00.0 06"), "below the horizon"),
    ],
)
def test_what_no_list_is(tmp_path, text, words):
    with pytest.raises(DataError, match=words.replace("(", r"\(")):
        read_tpoint(_written(tmp_path, text))


def test_a_table_without_its_columns(tmp_path):
    with pytest.raises(DataError, match=r"alt_deg is missing(.|\n)*d_alt_arcsec is missing"):
        read_altaz(_written(tmp_path, "az_deg,d_az_arcsec\n1,2\n"))


def test_air_lifts_less_the_higher_a_star_stands():
    up = refract(np.array([[0.0, 0.0, 1.0]]), np.radians(80.0), 10.0, 1010.0)
    assert np.degrees(np.arccos(up[0, 2])) * 60 == pytest.approx(
        1.02 / np.tan(np.radians(80 + 10.3 / 85.11)), rel=1e-3
    )


@pytest.mark.parametrize("word", ["nan", "1_0", "1e99"])
def test_a_first_star_with_a_bad_number_is_not_taken_for_the_head(tmp_path, word):
    """The line below that of the conditions has 14 words: a star, not a free line."""
    bad = " ".join([word, *STAR.split()[1:]])
    with pytest.raises(DataError, match=f"expected 14 numbers: {word}"):
        read_tpoint(_written(tmp_path, HEAD + bad + "\n" + STAR))
