"""The part comes back measured: compared, the difference located, and handed on to diagnose."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import vcmm
from tests.shop.machining import measured_shop
from vcmm.answer.inference.given_points import GivenPoints
from vcmm.core.errors import DataError
from vcmm.face.cli import run as command
from vcmm.files.own.measured_data import read_measured_points
from vcmm.files.own.recording import load_recording
from vcmm.shop.machining.gauge import gauge_plan
from vcmm.shop.machining.measured_part import measured_cut
from vcmm.task.measuring.cut_scenario import SAME_MACHINE, Inspection
from vcmm.task.measuring.plan import Stylus
from vcmm.task.response.observe import baseline

BACKLASH = '[[effects]]\neffect = "backlash"\naxis = "X"\ngap = "6 um"\n'
LARGE_TOOL = '[[effects]]\neffect = "tool_runout"\namplitude = "20 um"\ntool = "1"\n'


def compared(folder, concealed, seed=1):
    points, features = measured_shop.measured(folder, concealed, seed)
    file = measured_shop.csv(folder / "points.csv", points, features)
    return measured_cut(vcmm.load_cut(measured_shop.write(folder)), read_measured_points(file)[0])


def test_a_part_as_predicted_shows_nothing(tmp_path):
    found = compared(tmp_path, "")
    assert found.mismatch == ()
    assert max(abs(c.e_n) for c in found.comparisons) < 1.5
    assert found.scatter == pytest.approx(measured_shop.NOISE, rel=0.25)


def test_backlash_is_located_by_direction(tmp_path):
    (first, *more) = compared(tmp_path, BACKLASH).mismatch
    assert not more
    assert (first.covariate, first.feature, first.line) in {
        ("direction X", "left", 8),
        ("direction X", "right", 10),
    }
    # a gap of 6 um, less what stands where the zero was set; the amount is what was measured less predicted, scatter and all
    amount = float(re.search(r"up to (\d\.\d\d) um (more|less) material", first.text)[1])
    assert 2.5 < amount < 6.5


def test_a_tool_that_is_too_large_is_located_by_the_tool(tmp_path):
    """20 um of radius: both walls 20 um deeper, the width 40 um less; 10 times what u_radius of 2 um allows."""
    found = compared(tmp_path, LARGE_TOOL)
    assert found.mismatch[0].covariate in ("tool", "tool radius")
    width = found.comparisons[0]
    assert (width.name, width.unit) == ("width", "mm")
    assert width.measured - width.prediction == pytest.approx(-0.040, abs=0.012)
    assert width.e_n < -3
    assert width.u == pytest.approx(4.0e-3, rel=0.1)  # twice the 2 um of the radius, little else


@pytest.mark.thorough
def test_the_document_and_the_recording(tmp_path, capsys):
    points, features = measured_shop.measured(tmp_path, BACKLASH, 1)
    file = measured_shop.csv(tmp_path / "points.csv", points, features)
    path = measured_shop.write(tmp_path)
    assert command(["cut", str(path), "--measured", str(file), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert {"name", "measured_mm", "predicted_mm", "u_difference_mm", "E_n"} <= set(document["measured"][0])
    assert {"feature", "covariate", "p", "text"} <= set(document["mismatch"][0])
    recording, machine = load_recording(document["recording"])
    assert recording.kind == "path"
    assert not recording.measuring
    assert recording.m == len(points)
    assert {"force_x_N", "sense_X", "time_s", "feed_mm_min", "cut_length_mm"} - set(
        recording.run.columns
    ) == {"force_x_N"}
    # what is uncertain goes along, and nothing of it is free
    assert recording.nuisance == {"rigid": "run"}
    assert {"tool_radius[1].dr", "work_offset[x].shift", "scatter.value", "scale_factor[X].k"} <= {
        n for n, _ in recording.known
    }
    # what the machine file predicts of the rows, taken off, leaves measured less predicted: the zero was set on this machine
    # the machine file knows nothing of backlash: 3 um on either side of a reversal is left beside its own errors
    rest = recording.value - baseline(recording, machine)
    walls = np.abs(recording.direction[:, 0]) > 0.9
    assert np.ptp(rest[walls & (recording.run.labels["tool"] == "1")]) > 2e-3


@pytest.mark.thorough
def test_machine_coordinates_show_where_the_part_lies(tmp_path):
    """50 um beside its place in X: seen in the machine frame (work offset u = 2 um), not after an alignment."""
    points, features = measured_shop.measured(tmp_path, "", 1)
    scenario = vcmm.load_cut(measured_shop.write(tmp_path))
    zero = np.array([300.0, 250.0, -350.0])
    for shift, names in ((0.0, []), (0.05, ["where the part lies"])):
        file = measured_shop.csv(tmp_path / "machine.csv", points + zero + [shift, 0, 0], features)
        found = measured_cut(scenario, read_measured_points(file)[0], in_machine=True)
        assert [m.covariate for m in found.mismatch] == names


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p, f: (p / 25.4, f), r"taken as inches: name the columns by their unit"),
        (lambda p, f: (p + [300, 250, -350], f), r"fit in the other frame: use --frame machine"),
        (lambda p, f: (p, np.where(f == "bore", "boring", f)), r'points.csv:\d+: the part has no feature "boring"'),
        (lambda p, f: (p[f != "floor"], f[f != "floor"]), r'no points of "floor", which the characteristic "floor" needs'),
        (lambda p, f: (np.where((f == "left")[:, None], p + [0, 70, 0], p), f), r"points.csv:2: .* mm beyond the extent of \"left\""),
    ],
    ids=["unit", "frame", "name", "missing", "elsewhere"],
)  # fmt: skip
def test_points_of_another_part_are_refused_with_their_row(tmp_path, change, words):
    points, features = change(*measured_shop.measured(tmp_path, "", 1))
    file = measured_shop.csv(tmp_path / "points.csv", points, features)
    with pytest.raises(DataError, match=words):
        measured_cut(vcmm.load_cut(measured_shop.write(tmp_path)), read_measured_points(file)[0])


def test_several_parts_are_compared_one_by_one(tmp_path, capsys):
    points, features = measured_shop.measured(tmp_path, "", 1)
    file = measured_shop.csv(tmp_path / "points.csv", points, features)
    lines = file.read_text().splitlines()
    file.write_text("\n".join([f"part,{lines[0]}", f"a,{lines[1]}", *(f"b,{x}" for x in lines[2:])]))
    assert command(["cut", str(measured_shop.write(tmp_path)), "--measured", str(file), "--json"]) == 2
    assert "compare them one by one" in capsys.readouterr().err


@pytest.mark.thorough
def test_measure_of_a_cut_scenario_cuts_first(tmp_path, capsys):
    """One draw of everything, cut and inspected; what is written is read again, and no part is accused of its own uncertainty."""
    file = measured_shop.write(tmp_path)
    still = vcmm.measure(vcmm.load_cut(file))
    width = next(v for v in still.values if v.name == "width")
    assert width.value == pytest.approx(
        vcmm.cut(vcmm.load_cut(file), trials=1000).characteristics[0].value, abs=2e-3
    )
    assert command(["measure", str(file), "--seed", "5", "--out", str(tmp_path / "m")]) == 0
    given = read_measured_points(tmp_path / "m" / "points.csv")[0]
    drawn = vcmm.measure(vcmm.load_cut(file), 5)
    assert given.points == pytest.approx(drawn.points, abs=1e-8)
    assert np.abs(drawn.points - still.points).max() > 1e-4
    found = measured_cut(vcmm.load_cut(file), given, u_point=1e-3)
    assert found.mismatch == ()


@pytest.mark.thorough
def test_a_machine_that_measures_its_own_part_does_not_accuse_itself(tmp_path):
    """Probed on the machine that cut it: of its known errors the reading holds both shares, the recording that of the tool alone."""
    scenario = vcmm.load_cut(measured_shop.write(tmp_path, BACKLASH))
    plan = gauge_plan(scenario.part, scenario.plan)
    styli = {name: Stylus(name, np.array([0.0, 0.0, -100.0]), 0.5) for name in plan.styli}
    same = replace(scenario, inspection=Inspection(SAME_MACHINE), plan=replace(plan, styli=styli))
    points = []
    for one in (scenario, same):
        read = vcmm.measure(one)
        points.append(read.points)
        given = GivenPoints(
            "", read.points, tuple(f"row {i}" for i in range(len(read.points))), read.features
        )
        found = measured_cut(one, given, u_point=0.5e-3)
        assert found.mismatch == ()
        assert found.departure == pytest.approx(0.0, abs=0.1e-3)
    # 20 um/m over 100 mm: the scale that cut the part reads it, so 2 um of the width are missing from the reading, a half on each side
    assert np.abs(points[1] - points[0]).max() > 0.9e-3
