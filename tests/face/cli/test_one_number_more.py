"""One result, one number, in the jobs beside those of test_one_number: measure, audit, nc, compensate, calibrate, compare, field.

Read as there: the document once, then the lines at the head of the page, its tables by their heads, its pictures by `data-chart`,
the terminal by its lines, files by their columns.
"""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import pytest

from tests.face.cli.test_one_number import agree, answers, charts, document, numbers, rows, same, terminal
from vcmm.face.cli import run as command
from vcmm.files.own.library import example

pytestmark = pytest.mark.usefixtures("few_parts")


def new(name: str, folder: Path) -> None:
    assert command(["new", name, "--out", str(folder)]) == 0


def test_measure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "plate.toml"
    file.write_bytes(example("plate").read_bytes())
    words = ["measure", str(file), "--seed", "3"]
    found = document([*words, "--out", str(tmp_path / "out")], capsys)
    shown = terminal(words, capsys).splitlines()
    kept = json.loads((tmp_path / "out" / "measure.json").read_text())
    for c, other in zip(found["characteristics"], kept["characteristics"], strict=True):
        assert c == other
        line = next(s for s in shown if s.strip().startswith(f"{c['name']} "))
        assert any(same(n, c["value_mm"]) for n in numbers(line.split(c["name"])[1]))
    touched = list(csv.DictReader((tmp_path / "out" / "points.csv").open(encoding="utf-8")))
    assert len(touched) == len(found["points"])
    for row, point in zip(touched, found["points"]):
        for axis in "xyz":
            key = f"{axis}_mm"
            if key in row and key in point:
                assert float(row[key]) == pytest.approx(point[key], abs=1e-6)


def test_nc(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new("turned_shaft", tmp_path)
    program = str(tmp_path / "turned_shaft" / "part.nc")
    words = ["nc", program, "--setup", str(tmp_path / "turned_shaft" / "setup.toml")]
    found = document(words, capsys)
    total = found["summary"]
    shown = terminal([*words, "--plot", "--out", str(tmp_path)], capsys)
    page = (tmp_path / "part.html").read_text(encoding="utf-8")
    time, cuts, tip = answers(page)[:3]
    seconds = total["cutting_time_s"] + total["dwell_time_s"]
    assert time["seconds"] == pytest.approx(seconds)
    assert time["moves"] == len(found["moves"])
    assert f"({seconds:.1f} s)" in time["words"]
    assert f"({seconds:.1f} s)" in shown.splitlines()[0]
    for line, key in ((cuts, "extent_cutting_mm"), (tip, "extent_machine_mm")):
        low, high = total[key]
        assert line["box"] == [low, high]
        size = [b - a for a, b in zip(low, high)]
        agree(line["words"].split(" mm ")[0], *size)
    # moves counted by kind in the table of the page and in the document
    for row in rows(page, "move", "number", "path"):
        assert int(row["number"]) == sum(m["type"] == row["move"] for m in found["moves"])


@pytest.mark.thorough
def test_compensate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new("pallet_block", tmp_path)
    target = tmp_path / "new.nc"
    words = ["compensate", str(tmp_path / "pallet_block.toml"), "--out", str(target)]
    found = document([*words, "--plot"], capsys)
    page = target.with_suffix(".html").read_text(encoding="utf-8")
    shown = terminal(words, capsys)
    proof, path = answers(page)
    assert proof["largest_um"] == pytest.approx(found["proof"]["largest_um"])
    assert proof["met"] == found["proof"]["met"] == found["met"]
    assert path["largest_um"] == pytest.approx(found["deviation"]["after"]["max_um"])
    assert path["before_um"] == pytest.approx(found["deviation"]["before"]["max_um"])
    assert f"at most {found['proof']['largest_um']:.2f} µm" in proof["words"]
    assert f"at most {found['proof']['largest_um']:.2f} µm" in shown.splitlines()[0]
    table = {r[""]: r for r in rows(page, "largest", "rms", "at line")}
    for name, key in (("as programmed", "before"), ("compensated program", "after")):
        agree(table[name]["largest"], found["deviation"][key]["max_um"])
        agree(table[name]["rms"], found["deviation"][key]["rms_um"])
        assert int(table[name]["at line"]) == found["deviation"][key]["line"]


@pytest.mark.thorough
def test_calibrate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new("traced_cmm", tmp_path)
    page_file, machine = tmp_path / "report.html", tmp_path / "found.toml"
    words = [
        "calibrate", str(tmp_path / "traced_cmm.toml"), "--machine", str(tmp_path / "traced_cmm" / "machine.toml"), "--out", str(machine),
    ]  # fmt: skip
    found = document([*words, "--report", str(page_file)], capsys)
    page = page_file.read_text(encoding="utf-8")
    identified = {str(f["error"]): f for f in found["identified"]}
    table = {r["name"]: r for r in rows(page, "error", "name", "from ... to")}
    assert set(table) == set(identified)
    for name, f in identified.items():
        ends = [f["value"]] if "value" in f else [f["low"], f["high"]]
        agree(table[name]["from ... to"], *ends)
    lines = answers(page)
    assert next(a for a in lines if "identified" in a)["identified"] == len(identified)
    # A, R, E, M of the head are those of `vcmm test` on the machine file that was written
    figures = {f["name"]: f for f in document(["test", str(machine), "--iso", "230-2"], capsys)["figures"]}
    for line in (a for a in lines if "axis" in a):
        for kind in "AREM":
            f = figures[f"{kind} {line['axis']}"]
            assert line[kind] == pytest.approx(f["value_um"])
            assert f"{kind} = {f['value_um']:.2f} ± {2 * f['u_um']:.2f} µm" in line["words"]
    drawn = {c["series"][0]["name"]: c for c in charts(page, "curve")}
    assert drawn
    for c in charts(page, "curve"):
        assert all(len(s["x"]) == len(s["y"]) for s in c["series"] if isinstance(s["x"], list))


def test_compare_and_field(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new("ballbar", tmp_path)
    recording = str(tmp_path / "ballbar.toml")
    found = document(["compare", recording, "--out", str(tmp_path / "out")], capsys)
    page = next((tmp_path / "out").glob("*.html")).read_text(encoding="utf-8")
    (one,) = found["machines"]
    (line,) = answers(page)
    assert 1e3 * line["rms"] == pytest.approx(one["rms_um"])
    assert 1e3 * line["noise"] == pytest.approx(one["noise_um"])
    (row,) = list(rows(page, "machine file", "rms / µm"))
    assert float(row["rms / µm"]) == pytest.approx(one["rms_um"], rel=5e-4)
    in_order = charts(page, "curve")[0]["series"][0]["y"]
    if isinstance(in_order, list):  # the picture holds the residuals of which the rms was taken
        assert math.sqrt(sum(v * v for v in in_order) / len(in_order)) == pytest.approx(
            one["rms_um"], rel=1e-4
        )
    assert f"rms {one['rms_um']:.3g} µm" in terminal(["compare", recording], capsys).splitlines()[0]

    machine = tmp_path / "mill.toml"
    text = (tmp_path / "ballbar" / "machine.toml").read_text()
    machine.write_text(text + '\n[[effects]]\neffect = "squareness"\npair = "C0Y"\nangle = "20 urad"\n')
    words = ["field", str(machine)]
    mapped = document([*words, "--out", str(tmp_path / "map")], capsys)
    page = (tmp_path / "map" / "field.html").read_text(encoding="utf-8")
    largest = 1e3 * mapped["summary"]["max_mm"]
    assert largest == pytest.approx(20e-6 * 500e3)  # 20 urad over 500 mm of Y are 10 um
    assert answers(page)[0]["largest_um"] == pytest.approx(largest)
    assert f"{largest:.2f} µm" in answers(page)[0]["words"]
    assert f"{largest:.2f} µm" in terminal(words, capsys).splitlines()[0]


@pytest.mark.thorough
def test_audit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "plate.toml"
    file.write_bytes(example("plate").read_bytes())
    words = ["audit", str(file), "--parts", "100"]
    capsys.readouterr()
    assert command([*words, "--json"]) in (0, 1)
    found = json.loads(capsys.readouterr().out)
    names = tuple({f"{c['name']} " for c in found["audit"]})
    shown = [t for t in terminal(words, capsys).splitlines() if t.strip().startswith(names) and "%" in t]
    assert len(shown) == len(found["audit"])
    for c, line in zip(
        found["audit"], shown
    ):  # long words go on in lines of their own; the numbers stand in the first
        given = numbers(line.removeprefix(c["name"]))
        wanted = (100 * c["target"], 100 * c["attained"], c["parts"], 1e3 * c["mean_width_mm"])
        starts = range(len(given) - 3)
        assert any(all(same(n, v) for n, v in zip(given[s : s + 4], wanted)) for s in starts), line
