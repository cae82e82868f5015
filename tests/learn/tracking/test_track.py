"""vcmm.track on small folders: numbers by pencil, order, resumption, refusals, the machine of a day, its budget."""

import json
import tomllib

import numpy as np
import pytest

import vcmm
from tests.learn.tracking.small_folder import write_check, write_machine, write_year
from vcmm.core.errors import DataError, UsageError
from vcmm.face.cli import run
from vcmm.files.learned.last_checks import check_parts
from vcmm.learn.tracking.machine_at import machine_on
from vcmm.show.pages.track import track_page
from vcmm.show.tables.answers_runs import track_answers

FILES = ("track.toml", "track.npz", "machine.toml", "machine_state.csv")


def test_one_check_by_pencil(tmp_path):
    machine = write_machine(tmp_path)
    write_check(tmp_path / "checks", "2026-01-05", [0.0, 500.0], [0.0, -3.0])
    found = vcmm.track(machine, tmp_path / "checks", explain=False)
    # -k x 0.5 m = -3 um: k = 6 um/m with u = sqrt(2) / 0.5 = 2.83; before: 0 +- 4.
    # mean (6 / 8) / (1 / 16 + 1 / 8) = 4, variance 1 / (1 / 16 + 1 / 8) = 16 / 3
    k = found.course("scale_factor[X].k")
    assert (k.value[0], k.u[0]) == (pytest.approx(4.0), pytest.approx((16 / 3) ** 0.5))
    assert found.machine.effects[-1].k == pytest.approx(4e-6)
    # half a year later: walk, trend and season of the prior come in, in usual sizes of a scale factor; a = 2 pi 181 / 365.25:
    # walk^2 181 / 365.25 + (trend 181 / 365.25)^2 + season^2 (2 - 2 cos a), for the season is zero on the first day
    usual = vcmm.effects.ScaleFactor.__dataclass_fields__["k"].metadata["typical"].amount
    later = found.machine_on("2026-07-05")
    rate, share = found.followed.rates[0], 181 / 365.25
    grown = rate.walk**2 * share + (rate.trend * share) ** 2
    grown += rate.season**2 * (2 - 2 * np.cos(2 * np.pi * share))
    assert later.u[0] ** 2 == pytest.approx((16 / 3) * 1e-12 + grown * usual**2)
    assert (later.since**2).sum() == pytest.approx(grown * usual**2)
    assert (later.state**2).sum() == pytest.approx((16 / 3) * 1e-12)


@pytest.mark.thorough
def test_at_once_and_one_by_one_are_the_same_bits(tmp_path):
    a, b = tmp_path / "a", tmp_path / "b"
    whole = write_year(a, 9, lambda week: 2.0 + 0.3 * week)
    assert run(["track", str(whole), str(a / "checks"), "--out", str(a / "out"), "--no-explain"]) == 0
    piece = write_machine(b)
    for path in sorted((a / "checks").glob("*.toml")):
        for suffix in (".csv", ".toml"):
            (b / "checks" / f"{path.stem}{suffix}").write_text(path.with_suffix(suffix).read_text())
        assert run(["track", str(piece), str(b / "checks"), "--out", str(b / "out"), "--no-explain"]) == 0
    for name in FILES:
        assert (a / "out" / name).read_bytes() == (b / "out" / name).read_bytes(), name


def test_a_recording_older_than_the_state_is_refused_unless_replayed(tmp_path, capsys):
    machine = write_year(tmp_path, 3, lambda week: 2.0)
    words = ["track", str(machine), str(tmp_path / "checks"), "--no-explain"]
    assert run(words) == 0
    write_check(tmp_path / "checks", "2026-01-06", [0.0, 500.0], [0.0, -1.0])
    capsys.readouterr()
    assert run(words) == 2
    said = capsys.readouterr().err
    assert all(words in said for words in ("laser_2026-01-06.toml", "older than the state", "--replay"))
    assert run([*words, "--replay"]) == 0
    assert 'date = "2026-01-06"' in (tmp_path / "checks-track" / "track.toml").read_text()


def test_what_does_not_fit_the_state_is_refused(tmp_path):
    machine = write_year(tmp_path, 3, lambda week: 2.0)
    ask = {"state": tmp_path / "out", "explain": False}
    vcmm.track(machine, tmp_path / "checks", **ask)
    with pytest.raises(UsageError, match=r"alpha = 0\.05, which holds"):
        vcmm.track(machine, tmp_path / "checks", alpha=0.01, **ask)
    with pytest.raises(UsageError, match="is before the last recording"):
        vcmm.track(machine, tmp_path / "checks", at="2026-01-01", **ask)
    with pytest.raises(UsageError, match="is no date"):
        vcmm.track(machine, tmp_path / "checks", at="soon", **ask)
    rows = tmp_path / "checks" / "laser_2026-01-12.csv"
    kept = rows.read_text()
    rows.write_text(kept.replace(",1\n", ",2\n"))
    with pytest.raises(UsageError, match="was changed since"):
        vcmm.track(machine, tmp_path / "checks", **ask)
    rows.write_text(kept)
    text = machine.read_text()
    machine.write_text(text.replace("4 um/m", "5 um/m"))
    with pytest.raises(DataError, match="another machine file"):
        vcmm.track(machine, tmp_path / "checks", **ask)
    machine.write_text(text)
    kept = (tmp_path / "out" / "track.toml").read_text()
    lines = [line for line in kept.splitlines(keepends=True) if not line.startswith("trend = ")]
    (tmp_path / "out" / "track.toml").write_text("".join(lines))
    with pytest.raises(DataError, match="an earlier version wrote this state"):
        vcmm.track(machine, tmp_path / "checks", **ask)
    (tmp_path / "out" / "track.toml").write_text(kept.replace("shapes = 4\n", ""))
    with pytest.raises(DataError, match="another version wrote this state, with other shapes"):
        vcmm.track(machine, tmp_path / "checks", **ask)
    (tmp_path / "out" / "track.toml").write_text(kept)
    (tmp_path / "out" / "track.npz").write_bytes(b"")
    with pytest.raises(DataError, match="not the file that"):
        vcmm.track(machine, tmp_path / "checks", **ask)


def test_a_state_has_the_keys_that_other_versions_wrote(tmp_path):
    """Renaming a number inside the program made a state unreadable that an earlier version had written."""
    machine = write_year(tmp_path, 3, lambda week: 2.0)
    ask = {"state": tmp_path / "out", "explain": False}
    first = vcmm.track(machine, tmp_path / "checks", **ask)
    written = tomllib.loads((tmp_path / "out" / "track.toml").read_text())["recordings"]
    keys = "name date when rows rank noise outliers chance level predicted unchanged spread change answer"
    assert [list(r["check"]) for r in written] == 3 * [keys.split()]
    again = vcmm.track(machine, tmp_path / "checks", **ask)
    assert [c.rms_unchanged for c in again.checks] == [r["check"]["unchanged"] for r in written]
    assert [c.rms_predicted for c in again.checks] == [c.rms_predicted for c in first.checks]


def test_a_state_among_the_recordings_is_refused(tmp_path):
    machine = write_year(tmp_path, 1, lambda week: 2.0)
    with pytest.raises(UsageError, match="lies among the recordings"):
        vcmm.track(machine, tmp_path / "checks", state=tmp_path / "checks" / "state")


def test_a_recording_without_a_date_and_a_machine_without_errors_are_refused(tmp_path):
    machine = write_machine(tmp_path)
    write_check(tmp_path / "checks", "", [0.0, 500.0], [0.0, -1.0], name="nodate")
    with pytest.raises(UsageError, match=r"nodate\.toml: no date"):
        vcmm.track(machine, tmp_path / "checks")
    text = machine.read_text()
    machine.write_text(text[: text.index("[[effects]]")])
    with pytest.raises(UsageError, match="states no error that could be followed"):
        vcmm.track(machine, tmp_path / "checks")


def test_a_jump_raises_one_alarm_with_its_name_and_date(tmp_path):
    # 60 um/m over 0.5 m = 30 um against a noise of 1 um: seen at once, and followed after it
    machine = write_year(tmp_path, 10, lambda week: 2.0 if week < 6 else 62.0)
    found = vcmm.track(machine, tmp_path / "checks")
    assert [c.date for c in found.alarms] == ["2026-02-16"]
    alarm = found.to_dict()["alarms"][0]
    assert alarm["since"] == "2026-02-09"
    # a machine of one number: whether it stays or goes back no single check can tell, and both are named
    said = {c["name"]: c["probability"] for c in alarm["changed"]}
    assert said == {
        "scale_factor[X].k": pytest.approx(0.5, abs=0.01),
        "everything, for a day or a few": pytest.approx(0.5, abs=0.01),
    }
    assert "scale_factor" in alarm["diagnosis"]
    assert found.course("scale_factor[X].k").value[-1] == pytest.approx(62.0, abs=4.0)


def test_a_day_far_from_the_last_check_is_warned_of(tmp_path):
    machine = write_year(tmp_path, 2, lambda week: 2.0)  # until 2026-01-12
    near = vcmm.track(machine, tmp_path / "checks", at="2026-01-19", explain=False)
    far = vcmm.track(machine, tmp_path / "checks", at="2026-01-20", explain=False)
    assert near.warnings == (
        "on 24 drawn machines with a season and wear the 95 % bands held 0.92 up to 30 days after a check and 0.91 (0.88 to 0.94) after 90 "
        "(docs/track.md)",
    )
    assert "is 8 days after the last check" in far.warnings[0]


def test_a_still_machine_is_not_alarmed(tmp_path):
    machine = write_year(tmp_path, 12, lambda week: 2.0)
    found = vcmm.track(machine, tmp_path / "checks", explain=False)
    assert not found.alarms
    k = found.course("scale_factor[X].k")
    assert abs(k.value[-1] - 2.0) < 3 * k.u[-1] < 3.0


def test_the_files_of_a_day_are_read_as_what_was_found(tmp_path):
    machine = write_year(tmp_path, 5, lambda week: 6.0)
    found = vcmm.track(machine, tmp_path / "checks", at="2026-06-01", explain=False)
    read = vcmm.load_machine(found.write(tmp_path / "out"))
    run_ = vcmm.Run({"X": np.array([0.0, 400.0]), "Y": np.zeros(2), "Z": np.zeros(2)}, np.zeros((2, 3)))
    assert read.tip_error(run_) == pytest.approx(found.machine.tip_error(run_), abs=1e-12)
    ids = [i.id for i in read.inputs]
    assert ids == ["scatter.value", "machine_state", "machine_state by time since calibration"]
    whole = [i.law.covariance[0, 0] for i in read.inputs[1:]]
    assert sum(whole) == pytest.approx(found.dated.u[0] ** 2, rel=1e-6)
    # it may be followed on: what [tracked] states is the state that it starts from
    again = vcmm.track(tmp_path / "out" / "machine.toml", tmp_path / "checks", explain=False)
    assert again.followed.tracked.factor.shape[1] == 2


def test_a_table_is_written_anew_with_its_joint_covariance(tmp_path):
    machine = write_year(tmp_path, 4, lambda week: 6.0)
    text = machine.read_text()
    head = text[: text.index("[[effects]]")]
    (tmp_path / "errors.csv").write_text("X EXX\n0 0\n250 0.001\n500 0.003\n#\nC0Y\n2e-6\n")
    machine.write_text(
        f'{head}[errors]\ntable = "errors.csv"\nuncertainty = {{ translation = "2 um", squareness = "3 urad", correlation_length = "250 mm" }}\n'
    )
    found = vcmm.track(machine, tmp_path / "checks", explain=False)  # until 2026-01-26, its last day
    read = vcmm.load_machine(found.write(tmp_path / "out"))
    line = next(e for e in read.effects if e.where == "EXX")
    ends = np.asarray(line.values)[[0, -1]]
    # 6 um/m x 0.5 m; the last laser alone read 4.96 um by its noise, and with few recordings a scale may have wandered as much
    u = found.course("component_table[EXX].values").u[-1] * 1e-3
    assert float(ends[1] - ends[0]) == pytest.approx(3.0e-3, abs=3 * u)
    assert u < 1.0e-3
    square = next(e for e in read.effects if e.where == "C0Y")
    assert square.angle == pytest.approx(2e-6)  # no laser along X sees it
    state = next(i for i in read.inputs if i.id == "machine_state")
    assert state.widths == (len(line.values), 1)
    dated = machine_on(found.followed, found.dated.when)
    assert np.diag(state.law.covariance)[:-1] == pytest.approx((dated.state**2).sum(axis=1)[:-1], rel=1e-5)
    # the squareness, which nothing saw for the 21 days: 3 urad, and its walk in usual sizes of 10 urad
    rate = dict(zip(found.followed.tracked.groups, found.followed.rates))["squareness[C0Y].angle"]
    share = 21 / 365.25
    grown = (
        rate.walk**2 * share
        + (rate.trend * share) ** 2
        + rate.season**2 * (2 - 2 * np.cos(2 * np.pi * share))
    )
    assert state.law.covariance[-1, -1] == pytest.approx(9e-12 + grown * (10e-6) ** 2, rel=1e-6)


def test_the_budget_has_the_line_of_time_since_calibration(tmp_path):
    machine = write_year(tmp_path, 5, lambda week: 6.0)
    found = vcmm.track(machine, tmp_path / "checks", at="2027-06-01", explain=False)
    found.write(tmp_path / "out")
    (tmp_path / "task.toml").write_text(TASK)
    budget = vcmm.uncertainty(tmp_path / "task.toml")["length"].budget
    line = next(b for b in budget if "time since calibration" in b.input)
    # the centres of the tip (4 mm) are 204 mm apart along X: the part of u(k) that time has brought, times 204 mm
    assert line.u == pytest.approx(204.0 * float(np.sqrt((found.dated.since**2).sum())), rel=1e-6)
    state = next(b for b in budget if b.input == "machine_state")
    assert state.u == pytest.approx(204.0 * float(np.sqrt((found.dated.state**2).sum())), rel=1e-6)


TASK = """vcmm = "scenario/1"
machine = "out/machine.toml"
[part.features]
left = { type = "plane", point = "0 0 0 mm", normal = [-1, 0, 0], size = "40 40 mm" }
right = { type = "plane", point = "200 0 0 mm", normal = [1, 0, 0], size = "40 40 mm" }
[[part.characteristics]]
name = "length"
type = "distance"
between = ["left", "right"]
[pose]
shift = "100 250 250 mm"
[plan]
touch = { speed = "5 mm/s", approach = "3 mm", clearance = "20 mm" }
styli.down = { offset = "0 0 0 mm", tip_diameter = "4 mm" }
[[plan.steps]]
feature = "left"
stylus = "down"
points = { strategy = "grid", n = [2, 2], margin = "5 mm" }
[[plan.steps]]
feature = "right"
stylus = "down"
points = { strategy = "grid", n = [2, 2], margin = "5 mm" }
"""


def test_the_document_and_the_page(tmp_path, capsys):
    machine = write_year(tmp_path, 4, lambda week: 6.0)
    words = ["track", str(machine), str(tmp_path / "checks"), "--out", str(tmp_path / "out"), "--json"]
    assert run(words) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "vcmm.track/1"
    assert {"parameters", "alarms", "forecast", "checks", "machine", "rates"} <= document.keys()
    (only,) = document["parameters"]
    assert (only["input"], only["unit"], len(only["value"])) == ("scale_factor[X].k", "um/m", 4)
    page = (tmp_path / "out" / "report.html").read_text()
    assert all(words in page for words in ("scale_factor[X].k", "forecast"))
    assert "NaN" not in page


def test_the_picture_shows_checks_and_forecast(tmp_path):
    machine = write_year(tmp_path, 4, lambda week: 6.0)
    found = vcmm.track(machine, tmp_path / "checks", explain=False)
    drawn = found.plot("scale_factor[X].k")
    checks, ahead = drawn.get_lines()[:2]
    assert list(checks.get_xdata()) == [0.0, 7.0, 14.0, 21.0]
    assert list(ahead.get_xdata()) == [21.0, 28.0, 51.0, 111.0]
    with pytest.raises(KeyError, match="scale_factor"):
        found.plot("scale_factor[X].kk")


def test_a_check_stands_beside_its_forecast(tmp_path):
    # -k x 0.5 m = -3 um of the second check, read at 0 and at 500 mm; its zero is free: -1.5 and +1.5 um about their mean, as it was read.
    # Forecast by the first alone (k = 4 um/m, pencil of test_one_check_by_pencil): -4 x 0.5 = -2 um: +1 and -1 um; the machine has not moved much in a day
    machine = write_machine(tmp_path)
    for day in (5, 6):
        write_check(tmp_path / "checks", f"2026-01-0{day}", [0.0, 500.0], [0.0, -3.0])
    found = vcmm.track(machine, tmp_path / "checks", explain=False)
    name = found.checks[1].name
    (part,) = check_parts(found, name)
    assert (part.axis, part.circle, part.unit) == ("X", False, "µm")
    assert part.readings == pytest.approx([1.5, -1.5])
    assert part.forecast == pytest.approx([1.0, -1.0], rel=1e-3)
    # u^2 of a half of 0.5 m x k, with var k = 16 / 3 and what a day brings, and 1 um of a reading: (0.25^2 x 16 / 3 + 1) = 1.1547^2
    assert part.u == pytest.approx([1.1547, 1.1547], rel=0.02)
    drawn = found.plot(name)
    assert drawn.get_lines()[1].get_ydata() == pytest.approx([1.5, -1.5])  # both forwards
    assert "Last checks beside their forecast" in track_page(found)
    with pytest.raises(KeyError, match="no recording"):
        check_parts(found, "no.toml")


def test_a_part_is_placed_on_a_machine_that_was_followed(tmp_path, capsys):
    # X alone is uncertain in scale: a length along X has the line of time, 204 mm times what the scale may have gone; turned by a quarter it has none
    machine = write_year(tmp_path, 5, lambda week: 6.0)
    found = vcmm.track(machine, tmp_path / "checks", at="2026-06-01", explain=False)
    found.write(tmp_path / "out")
    (tmp_path / "task.toml").write_text(TASK.replace('offset = "0 0 0 mm"', 'offset = "0 0 -60 mm"'))
    words = ["place", str(tmp_path / "task.toml"), "--evaluations", "200", "--scan", "16", "--trials", "1000"]
    assert run([*words, "--json"]) == 0
    (why,) = json.loads(capsys.readouterr().out)["why"]
    line = next(b for b in why["budget"] if b["input"] == "machine_state by time since calibration")
    assert line["u_present_mm"] == pytest.approx(
        204.0 * float(np.sqrt((found.dated.since**2).sum())), rel=1e-3
    )
    assert line["u_best_mm"] < 0.05 * line["u_present_mm"]


def test_map_and_convenient_pose_are_of_the_pose_that_is_found(tmp_path):
    """A length along X alone: a quarter turn to either side and every place are equally good, and of them the one nearest to the present pose is found. The
    rounded pose beside it is that pose in steps of 50 mm, not another that is as good.
    """
    machine = write_year(tmp_path, 5, lambda week: 6.0)
    vcmm.track(machine, tmp_path / "checks", at="2026-06-01", explain=False).write(tmp_path / "out")
    (tmp_path / "task.toml").write_text(TASK.replace('offset = "0 0 0 mm"', 'offset = "0 0 -60 mm"'))
    found = vcmm.place(tmp_path / "task.toml", evaluations=200, scanned=16, trials=1000, seed=2)
    near = found.region.convenient
    assert near is not None
    assert np.abs(near - found.best.pose)[:2].max() <= 25.0
    assert found.map.x[0] <= found.best.pose[0] <= found.map.x[-1]


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ('vcmm = "recordings/1"', 'vcmm = "recordings/1", but expected a recording file'),
        ("# no first line", 'the first line must be vcmm = "recording/1"'),
    ],
)
def test_a_recording_whose_first_line_is_mistyped_is_not_passed_over(tmp_path, line, told):
    machine = write_year(tmp_path, 2, lambda week: 2.0)
    file = sorted((tmp_path / "checks").glob("*.toml"))[-1]
    file.write_text(file.read_text().replace('vcmm = "recording/1"', line))
    with pytest.raises(DataError, match=told):
        vcmm.track(machine, tmp_path / "checks", explain=False)
    file.write_text('vcmm = "checks/1"\n')  # a file of another kind is none of them
    assert len(vcmm.track(machine, tmp_path / "checks", explain=False).checks) == 1


def test_a_later_day_answers_with_the_numbers_of_that_day(tmp_path):
    machine = write_year(tmp_path, 3, lambda week: 2.0)
    found = vcmm.track(machine, tmp_path / "checks", at="2026-03-01", explain=False)
    line = track_answers(found)[1]
    assert "forecast of 2026-03-01" in line.coverage
    assert line.numbers["value"] == pytest.approx(found.machine.effects[-1].k * 1e6)
    assert line.numbers["U"] == pytest.approx(2e6 * float(found.dated.u[0]))
    last = found.course("scale_factor[X].k").u[-1]
    assert line.numbers["U"] > 2.0 * last
    today = track_answers(vcmm.track(machine, tmp_path / "checks", explain=False))[1]
    assert today.numbers["U"] == 2.0 * last
    assert "forecast" not in today.coverage


@pytest.mark.thorough
def test_a_jump_of_a_stated_squareness_is_no_mistake_of_a_table(tmp_path):
    """C0Y of 20 urad for eleven weeks, then -20: that the table has the wrong sign is what this looks like, but eleven checks were as it says. The
    change is -40 urad; from the first recording on the file itself is asked, whose table may hold a mistake.
    """
    square = '[[effects]]\neffect = "squareness"\npair = "C0Y"\nangle = "20 urad"\n[[inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nu = "2 urad"\n'
    machine = write_machine(tmp_path)
    machine.write_text(machine.read_text() + square)
    q = [(x, y, z) for x in (50.0, 250.0, 450.0) for y in (50.0, 450.0) for z in (50.0, 400.0)]
    rng = np.random.default_rng(5)
    for week in range(12):
        c = -20.0 if week == 11 else 20.0  # urad; the tip errs by -c y along X
        date = str(np.datetime64("2026-01-05") + 7 * week)
        rows = [
            f"{x:g},{y:g},{z:g},{c * y * 1e-3 + e:.4f},{f:.4f},{g:.4f}"
            for (x, y, z), (e, f, g) in zip(q, rng.normal(size=(12, 3)))
        ]
        (tmp_path / "checks" / f"{date}.csv").write_text(
            "X_mm,Y_mm,Z_mm,dx_um,dy_um,dz_um\n" + "\n".join(rows) + "\n"
        )
        (tmp_path / "checks" / f"{date}.toml").write_text(
            f'vcmm = "recording/1"\ndata = "{date}.csv"\nmachine = "../machine.toml"\nkind = "probe"\ndate = "{date}"\n'
        )
    (alarm,) = vcmm.track(machine, tmp_path / "checks").to_dict()["alarms"]
    assert alarm["since"] == "2026-03-16"
    said = alarm["diagnosis"]
    assert said.startswith("explained: squareness C0Y, angle -")
    assert "a collision" in said
    size, u = (float(v) for v in said.partition("angle ")[2].partition(" urad")[0].split(" ± "))
    assert abs(size + 40.0) < 3 * u < 10.0


def test_the_document_is_valid_by_its_schema(tmp_path, capsys):
    """`vcmm schema track` on what `vcmm track` prints, with an alarm and a warning; a key too many, one too few and a text for a number are refused."""
    jsonschema = pytest.importorskip(
        "jsonschema", reason="jsonschema comes with nbformat: pip install vcmm[notebook]"
    )
    machine = write_year(tmp_path, 4, lambda week: 2.0 if week < 3 else 62.0)
    words = [
        "track",
        str(machine),
        str(tmp_path / "checks"),
        "--out",
        str(tmp_path / "out"),
        "--at",
        "2026-03-01",
        "--no-explain",
        "--json",
    ]
    assert run(words) == 1
    document = json.loads(capsys.readouterr().out)
    assert run(["schema", "track"]) == 0
    schema = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator.check_schema(schema)
    known = jsonschema.Draft202012Validator(schema)
    assert [f"{list(e.absolute_path)}: {e.message}" for e in known.iter_errors(document)] == []
    assert document["alarms"]
    assert document["warnings"]
    without = {k: v for k, v in document.items() if k != "alarms"}
    for wrong in (document | {"alarm": []}, without, document | {"alpha": "0.05"}):
        assert len(list(known.iter_errors(wrong))) == 1


def test_a_number_of_which_no_uncertainty_is_stated_is_warned_of(tmp_path):
    machine = write_year(tmp_path, 2, lambda week: 2.0)
    assert not any("exactly right" in w for w in vcmm.track(machine, tmp_path / "checks").warnings)
    text = machine.read_text()
    machine.write_text(text[: text.index("[[inputs]]")])
    said, _ = vcmm.track(machine, tmp_path / "checks").warnings
    assert (
        "states no uncertainty of scale_factor[X].k: taken as exactly right on the day of the first" in said
    )
