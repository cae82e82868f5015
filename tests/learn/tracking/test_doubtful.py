"""Parts between a good check and an alarm, and the line "time since calibration" of a part that is cut."""

import json

import numpy as np
import pytest

import vcmm
from tests.learn.tracking.small_folder import write_year
from tests.learn.tracking.test_track import TASK
from vcmm.face.cli import run
from vcmm.learn.tracking.follow import course


def test_parts_of_the_week_of_a_jump_are_doubtful_by_what_pencil_says(tmp_path, capsys):
    # the scale jumps by 60 um/m between 2026-02-09 and 2026-02-16; 204 mm between the tips: indicated - true = -60e-6 x 204 = -12.2 um
    machine = write_year(tmp_path, 10, lambda week: 2.0 if week < 6 else 62.0)
    (tmp_path / "task.toml").write_text(TASK.replace("out/machine.toml", "machine.toml"))
    (tmp_path / "parts.csv").write_text(
        "part,date\na,2026-02-09\nb,2026-02-11\nc,2026-02-16T08:00\nd,2026-02-20\n"
    )
    words = [
        "track",
        str(machine),
        str(tmp_path / "checks"),
        "--out",
        str(tmp_path / "out"),
        "--no-explain",
        "--json",
    ]
    asked = [*words, "--task", str(tmp_path / "task.toml"), "--parts", str(tmp_path / "parts.csv")]
    assert run(asked) == 0
    document = json.loads(capsys.readouterr().out)
    (found,) = document["doubtful"]
    assert (found["since"], found["alarm"]) == ("2026-02-09", "2026-02-16")
    assert [p["part"] for p in found["parts"]] == ["b", "c"]
    (shift,) = found["shifts"]
    assert shift["shift"] == pytest.approx(-12.24e-3, abs=2.5 * shift["u"])
    assert shift["u"] < 2e-3
    # two states of one number: u^2 = 204^2 (P0 + P1)
    track = vcmm.track(machine, tmp_path / "checks", explain=False)
    states = course(track.followed)
    ways = track.followed.ways
    before = track.followed.motion.step(states[5], 7.0)
    p = [(ways @ s.covariance @ ways.T)[0, 0] for s in (before, states[6])]
    assert shift["u"] == pytest.approx(204.0 * np.sqrt(sum(p)), rel=1e-6)
    assert "Doubtful parts" in (tmp_path / "out" / "report.html").read_text()
    assert run([*words, "--parts", str(tmp_path / "parts.csv")]) == 2
    assert "--parts takes --task" in capsys.readouterr().err
    (tmp_path / "parts.csv").write_text("part,date\na,soon\n")
    assert run(asked) == 2
    assert 'parts.csv:2: "soon" is no date' in capsys.readouterr().err


PROGRAM = """%
O1
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-80. Y-60. S3000 M3
G43 H1 Z20.
Z-10.
G1 X-58. F600.
Y60.
X-80.
G0 Z20.
X80.
Z-10.
G1 X58. F600.
Y-60.
X80.
G0 Z50.
M30
%
"""
SETUP = """vcmm = "setup/1"
dialect = "fanuc"
[offsets]
G54 = ["250 mm", "250 mm", "200 mm"]
[tools.1]
length = "100 mm"
diameter = "20 mm"
[stock]
box = ["100 mm", "80 mm", "40 mm"]
"""
CUT = """vcmm = "scenario/1"
machine = "out/machine.toml"
[cut]
program = "part.nc"
setup = "setup.toml"
[part.features]
left = { type = "plane", point = "-48 0 -8 mm", normal = [-1, 0, 0], size = "40 2 mm" }
right = { type = "plane", point = "48 0 -8 mm", normal = [1, 0, 0], size = "40 2 mm" }
[[part.characteristics]]
name = "width"
type = "distance"
between = ["left", "right"]
[job]
trials = 1000
"""


@pytest.mark.thorough
def test_a_part_that_is_cut_has_the_line_of_time_since_calibration(tmp_path):
    machine = write_year(tmp_path, 5, lambda week: 6.0)
    found = vcmm.track(machine, tmp_path / "checks", at="2026-06-01", explain=False)
    found.write(tmp_path / "out")
    for name, text in (("part.nc", PROGRAM), ("setup.toml", SETUP), ("cut.toml", CUT)):
        (tmp_path / name).write_text(text)
    budget = vcmm.cut(tmp_path / "cut.toml")["width"].budget
    line = next(b for b in budget if "time since calibration" in b.input)
    # the axis of the tool stands at -58 and +58 mm for the two walls: 116 mm of a scale
    assert line.u == pytest.approx(116.0 * float(np.sqrt((found.dated.since**2).sum())), rel=1e-6)


def test_evaluated_values_have_the_line_of_time_since_calibration(tmp_path, capsys):
    machine = write_year(tmp_path, 5, lambda week: 6.0)
    found = vcmm.track(machine, tmp_path / "checks", at="2026-06-01", explain=False)
    found.write(tmp_path / "out")
    (tmp_path / "task.toml").write_text(TASK)
    (tmp_path / "values.csv").write_text("characteristic,value_mm\nlength,200.004\n")
    words = ["evaluate", str(tmp_path / "task.toml"), "--values", str(tmp_path / "values.csv"), "--json"]
    assert run(words) == 0
    assert "machine_state by time since calibration" in capsys.readouterr().out


def test_a_program_is_compensated_for_the_machine_of_the_day_and_its_part_keeps_the_line(tmp_path):
    # k of the day times 116 mm (the axis of the tool from -58 to +58 mm) is what the width gains by the correction
    machine = write_year(tmp_path, 5, lambda week: 6.0)
    found = vcmm.track(machine, tmp_path / "checks", at="2026-06-01", explain=False)
    found.write(tmp_path / "out")
    for name, text in (
        ("part.nc", PROGRAM),
        ("cut.toml", CUT),
        ("setup.toml", SETUP + "[control]\ncompensation = []\n"),
    ):
        (tmp_path / name).write_text(text)
    words = [
        "compensate",
        str(tmp_path / "cut.toml"),
        "--out",
        str(tmp_path / "better.nc"),
        "--decimals",
        "5",
    ]
    assert run([*words, "--tolerance", "0.05 um"]) == 0
    before = vcmm.cut(tmp_path / "cut.toml")["width"]
    (tmp_path / "cut.toml").write_text(CUT.replace("part.nc", "better.nc"))
    after = vcmm.cut(tmp_path / "cut.toml")["width"]
    scale = found.machine.effects[-1].k
    assert abs(before.value - after.value) == pytest.approx(116.0 * scale, rel=0.1)
    lines = [next(b for b in r.budget if "time since calibration" in b.input).u for r in (before, after)]
    assert lines[1] == pytest.approx(lines[0], rel=1e-4)  # what nobody knows is not corrected
