"""The scenario that joins the papers: its files, and what is concealed in them. The whole way runs in notebooks/five_papers.py."""

from __future__ import annotations

import re

import pytest

import vcmm
from tests.documented import DOCS
from vcmm.files.own.design import load_design
from vcmm.files.own.library import companions, example, folder
from vcmm.files.own.machine import load_machine
from vcmm.physics.catalogue.lag import ServoLag


def test_the_shop_knows_no_error_and_the_truth_has_one_that_no_table_holds():
    scenario = vcmm.load_cut(example("five_papers"))
    assert not any(e.about.is_calibrated for e in scenario.machine.effects)
    truth = load_machine(folder() / "five_papers" / "truth.toml")
    (lag,) = (e for e in truth.effects if isinstance(e, ServoLag))
    assert (lag.axis, lag.lag) == ("X", pytest.approx(0.5e-3))
    assert len({e.where for e in truth.effects if e.name == "component_table"}) == 18
    assert {a: x.measured_at for a, x in truth.axes.items()} == {
        a: x.measured_at for a, x in scenario.machine.axes.items()
    }
    setups, bare, _ = load_design(folder() / "five_papers" / "plan.toml")
    assert [c.instrument.name for *_, c in setups] == ["6-D laser"] * 3 + ["LaserTracer"] * 3
    assert bare.effects == ()
    assert {"five_papers/truth.toml", "five_papers/part.nc", "five_papers/known.toml"} <= set(
        companions("five_papers")
    )


def test_feeds_differ_from_feature_to_feature():
    """With one feed a lag looks like a structure that bends."""
    text = (folder() / "five_papers" / "part.nc").read_text()
    assert {"400", "600", "1500"} <= set(re.findall(r"F(\d+)", text))


def test_the_page_shows_the_commands_of_the_notebook():
    notebook = (DOCS.parent / "notebooks" / "five_papers.py").read_text(encoding="utf-8")
    page = (DOCS / "five_papers.md").read_text(encoding="utf-8")
    verbs = re.findall(r'vcmm\(\s*f?[\'"](\w+)', notebook)
    assert verbs == ["calibrate", "calibrate", "place", "compensate", "measure", "cut", "diagnose"]
    assert re.findall(r"\| `vcmm (\w+)", page) == verbs


def test_the_files_of_later_steps_are_the_scenario_with_other_files():
    """placing: without inspection and plan; shop and job: what is cut is the rewritten program, where the part was placed."""
    job = body((folder() / "five_papers.toml").read_text(encoding="utf-8")).replace("five_papers/", "")
    at = {name: job.index(f"[{name}]") for name in ("inspection", "placement", "plan", "environment")}
    plain = job[: at["inspection"]] + job[at["placement"] : at["plan"]] + job[at["environment"] :]
    moved = job.replace('"part.nc"', '"../part-compensated.nc"')
    moved = moved.replace('"setup.toml"', '"../placed/placed-setup.toml"')
    wanted = {
        "placing": plain.replace("known.toml", "mill_known.toml"),
        "shop": moved.replace("known.toml", "truth.toml"),
        "job": moved.replace("known.toml", "mill.toml"),
    }
    for name, text in wanted.items():
        assert body((folder() / "five_papers" / f"{name}.toml").read_text(encoding="utf-8")) == text


def body(text: str) -> str:
    """A scenario without the comment at its head."""
    return text[text.index('vcmm = "scenario/1"') :]
