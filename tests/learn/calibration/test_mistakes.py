"""Mistakes that people make with recordings, made on purpose: each is refused or said, none is smoothed away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.calibration.drawn import bare, draw, laser_and_plates, recorded, tracers
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.face.cli import run
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.calibration.checks import check_agreement, remarks_on
from vcmm.learn.calibration.job import calibrate
from vcmm.learn.calibration.model import error_model
from vcmm.learn.calibration.readings import readings
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.task.instruments import find
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.laser import line
from vcmm.task.instruments.laying import simulate_reading

MIDDLE = {"X": 300.0, "Y": 250.0, "Z": -200.0}
TIP = np.array([0.0, 0.0, -100.0])
SIX_X = {"X": (0.0, 600.0)}


@pytest.mark.thorough
def test_one_station_is_too_few():
    rng = np.random.default_rng(3)
    one = recorded(draw(rng), tracers(bare(), step=3)[:1], rng)
    with pytest.raises(UsageError, match="identify no error of the machine by itself") as error:
        calibrate(one, bare())
    alone, *several = str(error.value).splitlines()[1:]
    assert "EZZ" in alone
    assert "no reading depends on them" in alone
    assert "cannot be told apart" in several[0]


@pytest.mark.parametrize(
    ("component", "times", "said"), [("B", 4.848, "arcsec taken"), ("X", 1000.0, "mm taken for um")]
)
def test_values_of_a_larger_unit_are_quieter_than_their_stated_noise(component, times, said):
    """Alone nothing contradicts them; but 0.3 urad or um of noise are read in full units only."""
    rng = np.random.default_rng(3)
    read = recorded(
        draw(rng),
        [
            line(
                bare(),
                "X",
                np.linspace(0, 600, 13),
                MIDDLE,
                TIP,
                component,
                0.3e-6 * (1e3 if component == "X" else 1),
            )
        ],
        rng,
    )[0]
    name = f"E{component}X"
    assert not any(
        "only" in w and "stated noise" in w for w in calibrate([read], bare(), only=[name]).warnings
    )
    small = replace(read, value=read.value / times)
    (warned,) = (w for w in calibrate([small], bare(), only=[name]).warnings if "stated noise" in w)
    assert said in warned


def test_a_mirrored_straightness_is_named():
    """The plate sees the straightness too; the laser's sign of Y is turned round."""
    rng = np.random.default_rng(3)
    design = laser_and_plates(bare())
    read = recorded(draw(rng), [*design[:6], design[18]], rng)
    model = error_model({"X": (0.0, 600.0), "Y": (50.0, 450.0)}, 9)
    parts = [readings(r, bare(), model) for r in read]
    check_agreement(parts, model)
    wrong = [replace(p, value=-p.value) if p.recording.name == "EYX" else p for p in parts]
    with pytest.raises(UsageError, match=r"EYX contradicts the other recordings.*times -1; its sign"):
        check_agreement(wrong, model)


def test_exchanged_direction_labels_stop_a_calibration():
    one = line(bare(), "X", np.linspace(0, 600, 7), MIDDLE, TIP, "X", 1e-4)
    sense = np.repeat([1.0, -1.0], 7)
    good = replace(one, run=one.run.with_columns({"sense_X": sense}))
    assert "BX" in calibrate([good], bare(), only=("EXX", "BX")).posterior.model.names
    bad = replace(one, run=one.run.with_columns({"sense_X": -sense}))
    with pytest.raises(UsageError, match="12 of 12 moves of X go against their direction label"):
        calibrate([bad], bare(), only=("EXX", "BX"))


def test_lines_of_different_travel_are_said():
    """The pitch was read over one half: EBX is not taken from its prior over the other half, and the note says why."""
    rng = np.random.default_rng(3)
    design = [r for r in laser_and_plates(bare())[:6] if r.name != "EBX"]
    design.append(line(bare(), "X", np.linspace(0, 300, 7), MIDDLE, TIP, "B", 0.3e-6))
    found = calibrate(recorded(draw(rng), design, rng), bare())
    assert "EBX" not in found.identified.names
    assert "EBX" in {n for c in found.identified.combinations for n in c.names}
    assert any("EBX reads X from 0 to 300 mm, other recordings from 0 to 600" in w for w in found.warnings)


def test_readings_beyond_the_tables_are_refused():
    known = bare().with_effect(_table())
    one = line(bare(), "X", np.linspace(0, 600, 7), MIDDLE, TIP, "X", 1e-4)
    with pytest.raises(ModelLimit, match="leave out the readings beyond, or calibrate anew"):
        calibrate([one], known)


def _table():
    from vcmm.physics.structure.component import ComponentTable

    q = np.linspace(0.0, 400.0, 5)
    return ComponentTable("EXX", ("X",), (q,), 1e-5 * q)


def test_clocks_that_disagree_read_like_a_lost_motion():
    """Read at 20 mm/s with 50 us between the clocks: 1 um later in either sense, so that the senses differ by 2 um."""
    one = line(bare(), "X", np.linspace(0, 600, 7), MIDDLE, TIP, "X", 1e-6)
    sense = np.repeat([1.0, -1.0], 7)
    run_ = one.run.with_columns({"sense_X": sense, "speed_X_mm_s": 20.0 * sense})
    late = replace(one, run=run_, value=20.0 * sense * 50e-6)
    found = calibrate([late], bare(), only=("EXX", "BX"))
    assert np.abs(found.band("BX")[1]) * 1e3 == pytest.approx(2.0, abs=0.05)
    (said,) = [w for w in found.warnings if "clocks" in w]
    assert "moved at 20 mm/s" in said
    assert "differ by 2 um" in said
    assert "disagree by 0.05 ms" in said
    assert remarks_on([replace(late, run=one.run)]) == []


def test_a_log_that_ends_before_the_readings_is_refused(tmp_path, capsys):
    """The logger's clock stands an hour before the instrument's: its log has nothing to say of these rows."""
    one = line(bare(), "X", np.linspace(0, 600, 4), MIDDLE, TIP, "X", 1e-4)
    timed = replace(one, run=one.run.with_columns({"time_s": 3600.0 + 10.0 * np.arange(8)}))
    save_recording(timed, tmp_path / "laser.toml", "unused.toml")
    (tmp_path / "air.csv").write_text("time_s,temp_air_C\n0,20.0\n60,20.1\n120,20.2\n")
    path = tmp_path / "laser.toml"
    path.write_text(path.read_text() + '[[series]]\ndata = "air.csv"\n')
    assert run(["calibrate", str(path), "--structure", "w b Y X Z t", "--errors", "EXX"]) == 2
    assert "the log of temp_air_C ends at 120 s" in capsys.readouterr().err


def test_claimed_compensation_without_its_sensor_is_refused(tmp_path, capsys):
    one = line(bare(), "X", np.linspace(0, 600, 4), MIDDLE, TIP, "X", 1e-4)
    save_recording(one, tmp_path / "laser.toml", "unused.toml")
    path = tmp_path / "laser.toml"
    path.write_text(path.read_text() + '[instrument]\nname = "laser linear"\ncompensated = ["material"]\n')
    assert run(["calibrate", str(path), "--structure", "w b Y X Z t", "--errors", "EXX"]) == 2
    assert "compensation of material is claimed, but the data have no temp_part_C" in capsys.readouterr().err


def test_arcsec_taken_for_urad_is_named():
    """Alone a wrong unit of an angle cannot be told; beside readings that see the same turn it is refused."""
    machine = bare().with_effect(ComponentPolynomial("EBX", np.array([0.0, 20e-6, 60e-6])))
    rng = np.random.default_rng(0)
    upper, lower = (
        simulate_reading(
            replace(line(bare(), "X", np.linspace(0, 600, 13), MIDDLE, np.array([0, 0, z]), "X", 1e-4), name=f"at {z}"),
            machine, rng,
        )
        for z in (-50.0, -350.0)
    )  # fmt: skip
    angle = simulate_reading(
        line(bare(), "X", np.linspace(0, 600, 13), MIDDLE, TIP, "B", 0.2e-6), machine, rng
    )
    seconds = replace(angle, value=angle.value / 4.848)
    with pytest.raises(UsageError, match="arcsec taken for urad"):
        calibrate([upper, lower, seconds], bare(), only=("EXX", "EBX"))
    # a gain known to 20 % only does not take it up: 1 / 4.848 is 4 u of it
    loose = InstrumentCertificate.of(find("laser angle"), {"gain": "20 %"})
    with pytest.raises(UsageError, match="arcsec taken for urad"):
        calibrate([upper, lower, seconds], bare(), {seconds.name: loose}, only=("EXX", "EBX"))


def test_a_reversal_is_no_clock():
    """At rest (no speed column) the same difference of the senses is a lost motion, without a note about clocks."""
    one = line(bare(), "X", np.linspace(0, 600, 7), MIDDLE, TIP, "X", 1e-6)
    sense = np.repeat([1.0, -1.0], 7)
    still = replace(one, run=one.run.with_columns({"sense_X": sense}))
    read = simulate_reading(still, bare().with_effect(Backlash("X", 2e-3)), np.random.default_rng(0))
    found = calibrate([read], bare(), only=("EXX", "BX"))
    assert found.band("BX")[1] * 1e3 == pytest.approx(2.0, abs=0.05)
    assert not any("clocks" in w for w in found.warnings)
