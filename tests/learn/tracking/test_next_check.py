"""Which check next: U of a task on a day, the day on which a check is due, and the plan, by pencil."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import vcmm
from tests.learn.tracking.small_folder import write_check, write_machine
from tests.learn.tracking.test_track import TASK
from vcmm.core.errors import DataError, UsageError
from vcmm.face.cli import run
from vcmm.files.own.check_list import load_checks
from vcmm.learn.tracking.follow import again
from vcmm.learn.tracking.next_check import ShopCheck, plan_checks
from vcmm.learn.tracking.rates import GroupRates
from vcmm.learn.tracking.task_limits import limits_of
from vcmm.show.tables.track import next_checks

LIST = """vcmm = "checks/1"
[[checks]]
name = "laser"
like = "laser_2026-01-05.toml"
cost = 30
minutes = 60
[[checks]]
name = "two lasers"
like = "laser_2026-01-05.toml"
cost = 70
"""


@pytest.fixture
def followed(tmp_path):
    """0 +- 4 um/m, one laser at 0 and 500 mm: variance 16 / 3 (um/m)^2 (see test_track), and the task of 204 mm."""
    machine = write_machine(tmp_path)
    write_check(tmp_path / "checks", "2026-01-05", [0.0, 500.0], [0.0, -3.0])
    found = vcmm.track(machine, tmp_path / "checks", explain=False)
    (tmp_path / "task.toml").write_text(TASK.replace("out/machine.toml", "machine.toml"))
    return found, vcmm.load_scenario(tmp_path / "task.toml")


def test_u_of_the_task_is_that_of_its_evaluation(followed, tmp_path):
    found, scenario = followed
    (limit,) = limits_of(["length = 3 um"], scenario, found.dated)
    # four touches of 1 um on either plane: rest^2 = 1 / 4 + 1 / 4 um^2, beside the stylus, which is taken as known
    assert limit.rest == pytest.approx(1e-3 * math.sqrt(0.5), rel=1e-3)
    state = found.followed.state
    machine = 204.0 * math.sqrt(16 / 3) * 1e-6
    assert math.sqrt(limit.gain @ state.covariance @ limit.gain) == pytest.approx(machine, rel=1e-6)
    found.write(tmp_path / "out")
    (tmp_path / "now.toml").write_text(TASK)
    whole = vcmm.uncertainty(tmp_path / "now.toml")["length"].u
    assert whole == pytest.approx(math.hypot(limit.rest, machine), rel=1e-3)


def test_a_check_is_due_on_the_day_that_pencil_says(followed):
    found, scenario = followed
    (limit,) = limits_of(["length = 2.5 um"], scenario, found.dated)
    walk = (
        found.followed.rates[0].walk
        * vcmm.effects.ScaleFactor.__dataclass_fields__["k"].metadata["typical"].amount
    )
    alone = again(replace(found.followed, rates=(GroupRates(found.followed.rates[0].walk, 0.0, 0.0),)), ())
    p = 16 / 3 * 1e-12
    # U / 2 = 1.25 um: rest^2 + 204^2 (p + walk^2 d / 365.25) = 1.25^2
    free = ((1.25e-3**2 - limit.rest**2) / 204.0**2 - p) / walk**2 * 365.25
    laser = ShopCheck("laser", "laser_2026-01-05.toml", 30.0, 60.0)
    each, plan = plan_checks(alone, found.dated.when, [laser], (limit,), 400)
    assert each[0].day == math.floor(free) > 3
    # the laser says 1 / 8 (um/m)^-2 again
    after = 1 / (1 / (p + walk**2 * each[0].day / 365.25) + 1 / 8e-12)
    assert each[0].u_after["length"] == pytest.approx(
        2 * math.sqrt(limit.rest**2 + 204.0**2 * after), rel=1e-6
    )
    # the plan repeats it, each on its last day, and no day is above the limit
    assert plan.kept
    variance, day = p, 0
    for one in plan.checks:
        variance += walk**2 * (one.day - day) / 365.25
        assert 2 * math.sqrt(limit.rest**2 + 204.0**2 * variance) <= limit.limit
        assert 2 * math.sqrt(limit.rest**2 + 204.0**2 * (variance + walk**2 / 365.25)) > limit.limit
        variance, day = 1 / (1 / variance + 1 / 8e-12), one.day
    assert (
        2 * math.sqrt(limit.rest**2 + 204.0**2 * (variance + walk**2 * (400 - day) / 365.25)) <= limit.limit
    )
    assert plan.cost == 30.0 * len(plan.checks)
    assert plan.fixed is not None
    assert plan.cost <= plan.fixed[2]


def test_a_limit_that_no_check_keeps_is_said(followed):
    found, scenario = followed
    (limit,) = limits_of(["length = 1.5 um"], scenario, found.dated)  # the rest alone is 1.41 um
    laser = ShopCheck("laser", "laser_2026-01-05.toml", 30.0, 60.0)
    _, plan = plan_checks(found.followed, found.dated.when, [laser], (limit,), 30)
    assert not plan.kept
    assert plan.fixed is None


def test_words_that_do_not_serve(followed, tmp_path):
    found, scenario = followed
    for text, said in (
        ("lenght = 2 um", 'write the name of a characteristic and U, such as "length = 2 um"'),
        ("length = 2 deg", "length"),
        ("length", "write the name"),
        ("length = -2 um", "larger than zero"),
    ):
        with pytest.raises(UsageError, match=said):
            limits_of([text], scenario, found.dated)
    laser = ShopCheck("laser", "laser_2026-02-05.toml", 30.0, 60.0)
    limit = limits_of(["length = 2 um"], scenario, found.dated)
    with pytest.raises(UsageError, match="no recording that was followed"):
        plan_checks(found.followed, found.dated.when, [laser], limit, 30)
    path = tmp_path / "list.toml"
    path.write_text(LIST.replace("two lasers", "laser"))
    with pytest.raises(DataError, match="two checks have the name laser"):
        load_checks(path)
    path.write_text(LIST.replace("cost = 30", "cost = -1"))
    with pytest.raises(DataError, match=r"list\.toml:5"):
        load_checks(path)


def test_from_the_command_line_the_cheaper_of_two_alike_is_first(followed, tmp_path, capsys):
    (tmp_path / "list.toml").write_text(LIST)
    words = [
        "track",
        str(tmp_path / "machine.toml"),
        str(tmp_path / "checks"),
        "--task",
        str(tmp_path / "task.toml"),
    ]
    assert run([*words, "--limit", "length = 2.5 um", "--checks", str(tmp_path / "list.toml"), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert [n["check"] for n in document["next_checks"]] == ["laser", "two lasers"]
    assert document["plan"]["kept"] is True
    assert {c["check"] for c in document["plan"]["checks"]} <= {"laser"}
    assert np.isfinite(document["limits"][0]["u_rest"])
    assert run(words) == 2
    assert "one of them is missing" in capsys.readouterr().err


def test_a_limit_below_what_else_counts_is_said_to_be_beyond_every_check(followed):
    """The rest alone is 2 x 1 um / sqrt(2) = 1.41 um (two faces of four touches of 1 um each): 1.4 um is beyond every check of the machine, 1.5 um is not."""
    found, scenario = followed
    laser = ShopCheck("laser", "laser_2026-01-05.toml", 30.0, 60.0)
    for text, beyond in (("length = 1.4 um", True), ("length = 1.5 um", False)):
        limits = limits_of([text], scenario, found.dated)
        planned = (limits, *plan_checks(found.followed, found.dated.when, [laser], limits, 30))
        caption = next_checks(planned, found).caption
        assert ("U of length is 1.41 µm without any error of the machine" in caption) is beyond


def test_why_no_check_keeps_a_limit_stands_in_answer_and_document(followed, tmp_path, capsys):
    """1.4 um is below the rest (1.41 um); 1.5 um leaves sqrt(1.5^2 - 1.41^2) = 0.5 um for 204 mm of machine: 2.45 um/m (k = 2), less than a laser
    of two readings of 3 um can tell."""
    (tmp_path / "list.toml").write_text(LIST)
    places = [str(tmp_path / "machine.toml"), str(tmp_path / "checks"), "--task", str(tmp_path / "task.toml")]
    for text, is_beyond, why in (
        (
            "1.4 um",
            True,
            "U of length is 1.41 µm without any error of the machine, so no check of it keeps 1.4 µm",
        ),
        ("1.5 um", False, "the best check by itself (laser) leaves U of length at"),
    ):
        words = ["track", *places, "--limit", f"length = {text}", "--checks", str(tmp_path / "list.toml")]
        assert run([*words, "--json"]) == 0
        document = json.loads(capsys.readouterr().out)
        assert document["plan"]["kept"] is False
        assert document["plan"]["because"].startswith(why)
        assert document["limits"][0]["can_be_kept"] is not is_beyond
        assert run(words) == 0
        said = capsys.readouterr().out.split("\n\n")[0]
        assert "Next check: none of the list" in said
        assert why in " ".join(said.split())
