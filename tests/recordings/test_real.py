"""vcmm diagnose on recordings that other people published, through the command line.

What is asserted is what the makers of the data wrote, or what plain least squares on the same rows gives; the figures
stand in docs/real_recordings.md. Recordings on which vcmm answers something else are listed there too, not tested here.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from conftest import data_file
from convert import gantry_heating, plug_plate, resolver, slit_axis

from vcmm.cli import run

Found = dict[str, Any]


@pytest.fixture
def diagnosed(capsys):
    """vcmm diagnose FILE --json --seed 1, read back."""

    def found(recording: Path) -> Found:
        assert run(["diagnose", str(recording), "--json", "--seed", "1"]) == 0
        read: Found = json.loads(capsys.readouterr().out)
        shown = {k: read[k] for k in ("verdict", "answer", "unknown", "fit", "noise")}
        print(json.dumps(shown, indent=1))  # the figures of docs/real_recordings.md: pytest -s
        return read

    return found


def answer(found: Found, effect: str, **where: str) -> Found:
    """The answer of this name at this place; fails where it was not given."""
    hits = [a for a in found["answer"] if a["effect"] == effect and where.items() <= a["where"].items()]
    assert hits, [(a["effect"], a["where"]) for a in found["answer"]]
    return hits[0]


def value(given: Found, parameter: str) -> float:
    return float(given["parameters"][parameter]["value"])


def names(found: Found) -> set[str]:
    """Every effect that was named or that cannot be told from one that was."""
    return {n for a in found["answer"] for n in (a["effect"], *a["cannot_be_told_from"])}


@pytest.mark.parametrize("axis", [1, 2])
def test_slit_axes_have_a_reversal_error(axis, diagnosed, tmp_path):
    """Makers: reversal error, repeatability. Least squares: scale 20.0 um/m and reversal 2.44 um on axis 2."""
    source = data_file(f"data/recordings/iso230_2_linear_axis/slit_11358_axis{axis}_tidy.csv")
    found = diagnosed(slit_axis(source, tmp_path))
    assert found["verdict"] == "explained"
    reversal = max(found["answer"], key=lambda a: a["share"])
    assert {"backlash", "lost_motion"} & {reversal["effect"], *reversal["cannot_be_told_from"]}
    assert reversal["where"] == {"axis": "X"}
    assert found["fit"]["rms_after_um"] < 0.13  # least squares: 0.09 and 0.12 um with one constant reversal
    for fold in found["fit"]["held_out"]:
        assert fold["rms_after_um"] < 0.2 * fold["rms_before_um"]
    if axis == 2:
        scale = answer(found, "scale_factor", axis="X")
        assert "cosine_error" in scale["cannot_be_told_from"]  # one line of measurement cannot tell
        assert 19.0 < value(scale, "k") < 24.0
        # reversal = up - down = -gap: at 15 mm 15.0002 - 14.9980 = 2.2 um, at 55 mm 55.0013 - 54.9986 = 2.7 um
        gap = reversal["parameters"]["g0" if reversal["effect"] == "lost_motion" else "gap"]["value"]
        assert -2.8 < gap < -2.0


def test_sensor_that_is_worse_than_the_axis_blames_no_part_of_the_axis(diagnosed, tmp_path):
    """Makers: below the accuracy of the laser sensor. The profile is the same both ways, so no reversal may be named."""
    source = data_file("data/recordings/iso230_2_linear_axis/slit_11358_axis2_tidy.csv")
    found = diagnosed(slit_axis(source, tmp_path, column="ild2300_mm", u="1 um"))
    reversal = {"backlash", "lost_motion", "hysteresis", "reversal_spike"}
    assert not reversal & names(found)
    assert all(
        "instrument" in a["remark"] for a in found["answer"]
    )  # a profile of position alone: axis or sensor


def test_resolver_gap_is_a_delay_and_no_backlash(diagnosed, tmp_path):
    """Branches 2.4 deg apart. Rests before and after agree, so it is a delay: 34.0 ms by least squares. Harmonic 2."""
    source = data_file("data/recordings/resolver_cyclic_latency/VoltageDividerSineCosCoils.csv")
    found = diagnosed(resolver(source, tmp_path, every=5))
    delay = answer(found, "servo_lag", axis="C")
    assert 31.0 < value(delay, "1/Kv") < 37.0
    assert not {"backlash", "lost_motion", "hysteresis"} & names(found)
    cyclic = answer(found, "screw_pitch", axis="C")
    assert round(2 * math.pi / value(cyclic, "period")) == 2
    for fold in found["fit"]["held_out"]:
        assert fold["rms_after_um"] < 0.3 * fold["rms_before_um"]


def test_resolver_error_repeats_four_times_a_turn(diagnosed, tmp_path):
    """Makers: a cyclic error from the signal levels. Least squares: harmonic 4, amplitude 8.15 deg."""
    source = data_file("data/recordings/resolver_cyclic_latency/ResolverCiclicError2.csv")
    found = diagnosed(resolver(source, tmp_path, every=5))
    largest = max(found["answer"], key=lambda a: a["share"])
    assert (largest["effect"], largest["where"]) == ("screw_pitch", {"axis": "C"})
    assert round(2 * math.pi / value(largest, "period")) == 4
    assert largest["implausibly_large"]


@pytest.mark.parametrize("name", ["run1_2021-06-13_05-41-53", "run2_2021-06-13_20-04-43"])
def test_gantry_grows_with_the_frame_by_more_than_its_length(name, diagnosed, tmp_path):
    """Makers: Z follows the frame by more than 530 mm x 23.4e-6/K = 12.4 um/K, and something after that is not caught."""
    source = data_file(f"data/recordings/klipper_frame_thermal/{name}.csv")
    found = diagnosed(gantry_heating(source, tmp_path, every=3))
    growth = answer(found, "thermal_drift", direction="z", sensor="frame")
    assert growth["probability"] > 0.9
    slopes = [growth["parameters"][k] for k in ("k", "k_slow") if k in growth["parameters"]]
    assert sum(k["interval95"][0] for k in slopes) > 12.4
    assert found["verdict"] == "partly explained"
    (fold,) = [f for f in found["fit"]["held_out"] if f["fold"] == "temperature"]
    assert fold["rms_after_um"] < 0.5 * fold["rms_before_um"]


def test_plug_plate_is_scaled_and_out_of_square(diagnosed, tmp_path):
    """Makers: scale, X-Y scale difference, squareness. Least squares: scale -34.6e-6, squareness -64 urad.

    Plate, drill and CMM temperatures are not recorded, so their expansion must be reported as not testable.
    """
    source = data_file("data/recordings/sdss_plugplate_cmm/D1597A_redrilled_meas_2011.txt")
    found = diagnosed(plug_plate(source, tmp_path, every=3))
    placed = {(a["effect"], *a["where"].values()) for a in found["answer"]}
    for axis in "XY":
        assert placed & {("scale_factor", axis), ("geometric_change", f"E{axis}{axis}")}, placed
    across = {
        ("squareness", "C0Y"),
        ("squareness", "C0X"),
        ("geometric_change", "EYX"),
        ("geometric_change", "EXY"),
        ("geometric_change", "ECY"),  # a table that turns along its travel takes the place of the shear
        ("geometric_change", "ECX"),
    }
    assert placed & across, placed
    assert {"part_expansion", "scale_expansion"} <= set(found["not_testable"])
    assert found["fit"]["rms_after_um"] < 0.5 * found["fit"]["rms_before_um"]
    assert found["verdict"] == "partly explained"  # a smooth field is left: neighbours correlate 0.5
