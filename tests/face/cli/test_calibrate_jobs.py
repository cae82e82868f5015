"""vcmm calibrate fit, design ...: the same answers as the flags of old, and only the options that each job has."""

from __future__ import annotations

import inspect
import json
from pathlib import Path

import pytest

from tests.hostile.corpus import DESIGN
from vcmm.face.cli import run
from vcmm.face.cli.calibrate import calibrate_command
from vcmm.face.cli.calibrate_given import JOB_NAMES
from vcmm.face.cli.calibrate_jobs import JOBS
from vcmm.files.own.library import example

TRACED = str(example("traced_cmm"))
WARM = example("traced_cmm").with_suffix("") / "warm_up.toml"


def printed(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, object]:
    capsys.readouterr()
    code = run(["calibrate", *words, "--json"])
    out, err = capsys.readouterr()
    assert code in (0, 1), err
    found: dict[str, object] = json.loads(out)
    return found


def test_a_plan_of_set_ups(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    plan = tmp_path / "design.toml"
    plan.write_text(DESIGN, encoding="utf-8")
    assert printed(capsys, "design", str(plan)) == printed(capsys, "--design", str(plan))


def test_a_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    asked = [TRACED, "--structure", "w b Y X Z t", "--errors", "EXX EYY EZZ"]
    assert printed(capsys, "fit", *asked) == printed(capsys, *asked)


def test_an_option_of_another_job_is_refused(capsys: pytest.CaptureFixture[str]):
    assert run(["calibrate", "design", "plan.toml", "--thermal"]) == 2
    assert "--thermal" in capsys.readouterr().err


def test_help_of_a_job_has_its_own_options_alone(capsys: pytest.CaptureFixture[str]):
    assert run(["calibrate", "thermal", "--help"]) == 0
    out = capsys.readouterr().out
    assert "--sensors" in out
    assert "--interpolation" not in out


@pytest.mark.parametrize(
    "name", [name for name in JOBS if name not in ("program", "face")]
)  # jobs without a flag of old
def test_every_option_is_one_of_the_whole_command(name: str):
    known = inspect.signature(calibrate_command).parameters
    plans = {"plan"}  # the value of --design and --simulate
    own = inspect.signature(JOBS[name]).parameters
    assert set(own) - plans <= set(known)
    assert all(own[p].default == known[p].default for p in set(own) - plans)


def test_a_mistyped_job_is_answered_with_the_closest(capsys: pytest.CaptureFixture[str]):
    assert run(["calibrate", "desing", "plan.toml"]) == 2
    assert tuple(JOBS) == JOB_NAMES
    assert 'Did you mean "design"?' in capsys.readouterr().err


def test_without_a_file_an_example_is_shown(capsys: pytest.CaptureFixture[str]):
    assert run(["calibrate"]) == 2
    assert "vcmm calibrate design plan.toml" in capsys.readouterr().err
