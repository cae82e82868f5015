"""All jobs in one server: each gives the figures of the same job by itself, and reads nothing outside what was dropped."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import pytest

from tests.face.workbench.test_confined import OPENED, hostile, secret
from tests.plate import edited
from tests.shop.machining import shop
from vcmm.core.errors import UsageError, VcmmError
from vcmm.face import api
from vcmm.face.workbench.bench import Bench, job_of, run_files
from vcmm.files.own.cut_scenario import load_cut
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario

__all__ = ["secret"]  # the fixture


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    path = edited(tmp_path, ("trials = 20000", "trials = 1000"))
    return Bench(load_scenario(path, knobs=False), path)


def job(bench: Bench, name: str, files: dict[str, bytes], **knobs: float) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        return bench.job(name, files, Path(folder), knobs)


def test_measure_says_the_values_of_the_preview(bench: Bench) -> None:
    found = job(bench, "measure", {}, x=310.0)
    for c in bench.preview({"x": 310.0})["characteristics"]:
        assert any(s.startswith(f"{c['name']}: {c['value']:.5f}") for s in found["said"]), (c, found["said"])


def test_measured_values_are_evaluated(bench: Bench, tmp_path: Path) -> None:
    text = "characteristic,value_mm\nbore diameter,30.008\n"
    (tmp_path / "values.csv").write_text(text)
    (alone,) = api.evaluate(bench.scenario, values=tmp_path / "values.csv")
    found = job(bench, "", {"values.csv": text.encode()})
    assert found["job"] == "evaluate"
    assert repr(alone.characteristics[0].result)[1:-1] in found["said"]
    assert "30.008" in found["said"][0]
    assert found["report"].startswith("<!doctype html>")


@pytest.mark.thorough
def test_a_dropped_scenario_is_cut(bench: Bench, tmp_path: Path) -> None:
    texts = {
        "boss.toml": shop.SCENARIO,
        "mill.toml": shop.MACHINE + '[repeatability]\nu = "1 um"\n',
        "setup.toml": shop.SETUP,
        "part.nc": shop.PROGRAM,
    }
    files = {name: text.encode() for name, text in texts.items()}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    from vcmm.shop.machining.job import cut

    alone = cut(load_cut(tmp_path / "boss.toml"))
    found = job(bench, "", files)
    assert found["job"] == "cut"
    assert [repr(c)[1:-1] for c in alone.characteristics] == found["said"][: len(alone.characteristics)]
    outside = dict(files) | {"boss.toml": files["boss.toml"].replace(b"part.nc", b"/etc/hostname")}
    with pytest.raises(UsageError, match="outside the given files"):
        job(bench, "cut", outside)


@pytest.mark.thorough
def test_a_recording_is_diagnosed_with_its_report(bench: Bench) -> None:
    head = example("ballbar")
    files = {"ballbar.toml": head.read_bytes()}
    for name in ("circles.csv", "machine.toml"):
        files[f"ballbar/{name}"] = (head.parent / "ballbar" / name).read_bytes()
    found = job(bench, "", files)
    assert (found["job"], found["verdict"]) == ("diagnose", "explained")
    assert "Residual of the ball bar" in found["report"]
    with pytest.raises(UsageError, match="identify no error of the machine by itself"):
        job(bench, "calibrate", files)


def test_a_calibration_reads_nothing_outside_either(secret: Path) -> None:
    """Every sixth way of test_confined, where a diagnosis is asked all of them. A machine file is dropped with it; the one named outside is not opened."""
    for name, files in list(hostile(secret, exists=True))[::6]:
        with tempfile.TemporaryDirectory(dir=secret.parent) as folder:
            OPENED.clear()
            said = ""
            try:
                run_files("calibrate", files, Path(folder), None, lambda text, share: None)
            except VcmmError as told:
                said = str(told)
            assert not [o for o in OPENED if str(secret) in o], name
            assert "secret" not in said, name


@pytest.mark.parametrize(
    ("name", "files", "says"),
    [
        ("dance", {}, "no job"),
        ("evaluate", {}, "no job"),
        ("measure", {"a.csv": b""}, "no job"),
        ("", {"a.txt": b""}, "drop one recording"),
        ("cut", {"a.csv": b""}, r"\[cut\]"),
        ("evaluate", {"a.csv": b"", "b.csv": b""}, "one table"),
        ("calibrate", {"r.toml": b'vcmm = "recording/1"'}, "machine file"),
    ],
)
def test_files_and_jobs_that_do_not_go_together(
    bench: Bench, name: str, files: dict[str, bytes], says: str
) -> None:
    with pytest.raises(UsageError, match=says):
        job(bench, name, files)


def test_files_say_for_what_they_are() -> None:
    recording, machine = b'vcmm = "recording/1"', b'vcmm = "machine/1"'
    assert job_of({"a.toml": recording, "m.toml": machine}) == "diagnose"
    assert job_of({"a.toml": recording, "b.toml": recording, "m.toml": machine}) == "calibrate"
    assert job_of({"a.toml": b'vcmm = "scenario/1"\n[cut]\n'}) == "cut"
    assert job_of({"points.csv": b"feature,x_mm"}) == "evaluate"
