"""One result, one number: every chart, page, terminal table, export and workbench answer of a job holds what its document holds.

The document (JSON) is read once; all else is read as a reader would: numbers out of tables by their heads, out of pictures by
`data-chart`, out of the terminal by columns. A printed number is the right one when it is within half of its last digit.
"""

from __future__ import annotations

import csv
import html as entities
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.face.cli import run as command
from vcmm.face.workbench.bench import Bench
from vcmm.files.own.library import example
from vcmm.show.report.answers import answer_of, in_one_line
from vcmm.show.report.text import micro

pytestmark = pytest.mark.usefixtures("few_parts")
TRIALS = 1000
NUMBER = re.compile(r"[-+−]?\d+(?:\.\d+)?")


def document(words: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    capsys.readouterr()
    assert command([*words, "--json"]) in (0, 1)
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def terminal(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    assert command(words) in (0, 1)
    return capsys.readouterr().out


def charts(page: str, kind: str) -> list[dict[str, Any]]:
    """What the pictures of a page hold, in their order."""
    found = [json.loads(entities.unescape(t)) for t in re.findall(r'data-chart="([^"]*)"', page)]
    return [c for c in found if c["chart"] == kind]


def rows(page: str, *heads: str) -> Iterator[dict[str, str]]:
    """Rows of every table of a page that has these heads: head -> text."""
    for table in re.findall(r"<table.*?</table>", page, re.S):
        lines = [
            re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", line, re.S)
            for line in re.findall(r"<tr.*?</tr>", table, re.S)
        ]
        words = [[entities.unescape(re.sub(r"<[^>]+>", "", cell)).strip() for cell in line] for line in lines]
        if words and set(heads) <= set(words[0]):
            yield from (dict(zip(words[0], line)) for line in words[1:])


def numbers(text: str) -> list[str]:
    return [n.replace("−", "-") for n in NUMBER.findall(text)]


def same(printed: str, value: float) -> bool:
    """Whether a printed number is `value` to within half of its last digit."""
    digits = len(printed.partition(".")[2])
    return abs(float(printed) - value) <= 0.5001 * 10.0**-digits + 1e-9


def agree(text: str, *values: float) -> None:
    """The numbers of a text are these, in order."""
    found = numbers(text)
    assert len(found) == len(values), text
    for printed, value in zip(found, values):
        assert same(printed, value), (text, value)


def in_um(c: dict[str, Any]) -> dict[str, Any]:
    """The one result, um from nominal."""
    assert "value_mm" in c
    low, high = (1e3 * (x - c["nominal_mm"]) for x in c["interval_mm"])
    return {
        "value": 1e3 * (c["value_mm"] - c["nominal_mm"]), "U": 1e3 * c["U_mm"], "low": low, "high": high,
        "bias": 1e3 * c["bias_mm"], "decision": c["decision"], "u": 1e3 * c["u_mm"],
    }  # fmt: skip


def answers(page: str) -> list[dict[str, Any]]:
    """The lines at the head of a page: their data, and their words under "words"."""
    found = re.findall(r'<li data-answer="([^"]*)">(.*?)</li>', page, re.S)
    plain = lambda html: " ".join(entities.unescape(re.sub(r"<[^>]+>", " ", html)).split())  # noqa: E731
    return [json.loads(entities.unescape(data)) | {"words": plain(html)} for data, html in found]


def check_answers(page: str, shown: str, characteristics: list[dict[str, Any]]) -> None:
    """The first lines of page and terminal: value, U (two digits), decision, probability and contributor of the document."""
    lines = {a["name"]: a for a in answers(page) if a["name"] in {c["name"] for c in characteristics}}
    assert len(lines) == len(characteristics)
    for c in characteristics:
        line = lines[c["name"]]
        for key in ("value_mm", "U_mm", "k", "interval_mm", "tolerance_mm", "decision", "p_conform"):
            assert line[key] == c[key], (c["name"], key)
        seen = 1e3 * c["u_mm"] >= 5e-4  # of half a nanometre nobody is the owner
        known = [b for b in c["budget"] if seen and b["share"] > 0.005]
        assert line["contributor"] == (max(known, key=lambda b: b["u_mm"])["input"] if known else None)
        half = 1e3 * c["U_mm"]
        two = f"{half:.{max(0, 1 - int(f'{half:.1e}'.split('e')[1]))}f} µm" if half >= 5e-4 else "0.000 µm"
        (spoken,) = (s for s in shown.splitlines() if s.startswith(f"{c['name']}: "))
        value = numbers(spoken.split(": ", 1)[1])[0]
        scale = 1e3 if c["nominal_mm"] == 0 else 1.0
        for words in (line["words"], spoken):
            assert two in words
            assert value.replace("-", "−") in words or value in words
            assert c["decision"] is None or c["decision"] in words
        assert same(value, scale * c["value_mm"])


def check_pictures(page: str, characteristics: list[dict[str, Any]]) -> None:
    """Decision, distribution and budget of every characteristic, in the order of the document."""
    decided = [c for c in characteristics if c["decision"]]
    for picture, c in zip(charts(page, "decision"), decided, strict=True):
        one = in_um(c)
        assert picture["unit"] == "µm"
        assert picture["value"] == pytest.approx(one["value"], abs=1e-6)
        assert picture["U"] == pytest.approx(one["U"], abs=1e-6)
        assert picture["decision"] == one["decision"]
        # what is drawn is the interval of the document, or value +- U where that is the same to a hundredth of U
        assert picture["interval"] == pytest.approx([one["low"], one["high"]], abs=0.011 * one["U"])
        if c["type"] in ("size", "distance"):
            limits = [1e3 * (x - c["nominal_mm"]) for x in c["tolerance_mm"]]
            assert picture["limits"] == pytest.approx(limits, abs=1e-6)
    known = [c for c in characteristics if any(1e3 * b["u_mm"] > 1e-3 * in_um(c)["U"] for b in c["budget"])]
    for picture, c in zip(charts(page, "bars"), known, strict=True):
        of = {b["input"]: 1e3 * b["u_mm"] for b in c["budget"]}
        assert dict(zip(picture["names"], picture["values"])) == pytest.approx(
            {n: of[n] for n in picture["names"]}
        )
        assert picture["total"] == pytest.approx(in_um(c)["u"])
    check_labels(page, {c["name"]: c for c in characteristics})
    for picture in charts(page, "waterfall"):
        assert any(math.isclose(picture["total"], in_um(c)["u"], rel_tol=1e-6) for c in characteristics)
    values = [in_um(c)["value"] for c in characteristics]
    for picture in charts(page, "distribution"):
        assert any(math.isclose(picture["marks"]["y"], v, abs_tol=1e-6) for v in values)


def check_labels(page: str, of: dict[str, dict[str, Any]]) -> None:
    """The labels on the part: deviation and U with the digits of U, and the decision."""
    (picture,) = charts(page, "callouts")
    assert picture["names"]
    texts, verdicts = (picture[key].split(" | ") for key in ("texts", "verdicts"))
    for name, value, half, text, verdict in zip(
        picture["names"], picture["values"], picture["U"], texts, verdicts, strict=True
    ):
        one = in_um(of[name])
        assert (value, half) == pytest.approx((one["value"], one["U"]), abs=1e-6)
        agree(text, one["value"], *([one["U"]] if one["U"] > 0 else []))
        assert verdict == (one["decision"] or "")


@pytest.mark.thorough
def test_uncertainty(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "plate.toml"
    file.write_bytes(example("plate").read_bytes())
    words = ["uncertainty", str(file), "--trials", str(TRIALS)]
    found = document([*words, "--out", str(tmp_path / "out")], capsys)["characteristics"]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    check_pictures(page, found)
    said = terminal(words, capsys)
    check_answers(page, said, found)
    shown = said.splitlines()
    exported = list(csv.DictReader((tmp_path / "out" / "budget.csv").open(encoding="utf-8")))
    result = vcmm.uncertainty(file, trials=TRIALS)
    table = {r["characteristic"]: r for r in rows(page, "characteristic", "y", "U")}
    assert len(table) == len(found) == 3
    for c in found:
        one, row = in_um(c), table[c["name"]]
        agree(row["y"], c["value_mm"])
        agree(row["U"], one["U"])
        agree(row["bias"], one["bias"])
        agree(row["interval from nominal"], one["low"], one["high"])
        assert row["decision"] == one["decision"]
        line = next(s for s in shown if s.strip().startswith(f"{c['name']} ") and c["decision"] in s)
        agree(
            line.split(c["name"])[1],
            c["nominal_mm"],
            c["value_mm"],
            one["bias"],
            one["U"],
            c["k"],
            one["low"],
            one["high"],
        )
        combined = next(r for r in exported if r["characteristic"] == c["name"] and r["input"] == "combined")
        assert float(combined["u_i_um_or_urad"]) == pytest.approx(one["u"], rel=1e-4)
        assert f"U = {one['U']:.4g};" in combined["what"]
        own = result[c["name"]]
        assert (own.value, own.expanded, own.interval, own.decision.text) == (  # type: ignore[union-attr]
            c["value_mm"], c["U_mm"], tuple(c["interval_mm"]), c["decision"],
        )  # fmt: skip
        assert repr(own) == f"<{c['name']}: {in_one_line(answer_of(own))}>"
    scenario = vcmm.load_scenario(file)
    bench = Bench(scenario.with_(settings=scenario.settings.with_changes(trials=TRIALS)))
    assert bench.settle({})["characteristics"] == json.loads(json.dumps(found))


@pytest.mark.thorough
def test_cut(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    effect = '[[effects]]\neffect = "squareness"\npair = "C0Y"\nangle = "20 urad"\n'
    inputs = '[[inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nu = "5 urad"\n'
    file = shop.write(tmp_path, effect + inputs)
    words = ["cut", str(file), "--trials", str(TRIALS)]
    found = document([*words, "--out", str(tmp_path / "out")], capsys)["characteristics"]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    check_pictures(page, found)
    said = terminal(words, capsys)
    check_answers(page, said, found)
    shown = said.splitlines()
    table = {r["characteristic"]: r for r in rows(page, "characteristic", "deviation", "known errors")}
    assert len(table) == len(found) == 2
    for c in found:
        one, row = in_um(c), table[c["name"]]
        assert c["value_mm"] - c["nominal_mm"] == c["deviation_mm"]
        agree(row["deviation"], one["value"])
        agree(row["known errors"], one["bias"])
        agree(row["U"], one["U"])
        agree(row["interval"], one["low"], one["high"])
        line = next(s for s in shown if s.strip().startswith(f"{c['name']} ") and "[" in s)
        assert same(numbers(line.split(c["name"])[1])[1], one["value"])


@pytest.mark.thorough
def test_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "plate.toml"
    file.write_bytes(example("plate").read_bytes())
    words = ["place", str(file), "--evaluations", "60", "--scan", "40", "--trials", str(TRIALS)]
    found = document([*words, "--out", str(tmp_path / "out")], capsys)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    why = {c["name"]: c for c in found["why"]}
    titled = re.findall(r"<figcaption>([^<:]*): (present|found), U = ([\d.]+) µm", page)
    assert len(titled) == 2 * len(why)
    for place, key, word in (("present", "U_present_mm", "present"), ("objective", "U_best_mm", "found")):
        for c in found[place]["characteristics"]:
            assert c["evaluation"] == "full"
            assert c["U_mm"] == why[c["name"]][key]
            (picture,) = (u for name, of, u in titled if (name, of) == (c["name"], word))
            assert same(picture, 1e3 * c["U_mm"])


@pytest.mark.thorough
def test_evaluate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, values = tmp_path / "plate.toml", tmp_path / "values.csv"
    file.write_bytes(example("plate").read_bytes())
    values.write_text(
        "characteristic,value_mm\nbore diameter,30.004\nbore to front,39.9985\nbore square to top,0.003\n"
    )
    words = ["evaluate", str(file), "--values", str(values), "--trials", str(TRIALS)]
    found = document([*words, "--out", str(tmp_path / "out")], capsys)["characteristics"]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    said = terminal(words, capsys)
    check_answers(page, said, found)
    check_answers((tmp_path / "out" / "sheet.html").read_text(encoding="utf-8"), said, found)
    shown = said.splitlines()
    exported = {
        r["characteristic"]: r
        for r in csv.DictReader((tmp_path / "out" / "values.csv").open(encoding="utf-8"))
    }
    pictures = charts(page, "decision")
    assert len(pictures) == len(found) == 3
    for c, picture in zip(found, pictures):
        one = in_um(c)
        assert picture["value"] == pytest.approx(one["value"], abs=1e-6)
        assert picture["interval"] == pytest.approx([one["low"], one["high"]], abs=0.011 * one["U"])
        assert picture["decision"] == one["decision"]
        line = next(s for s in shown if s.strip().startswith(f"{c['name']} ") and "[" in s)
        measured = numbers(line.split(c["name"])[1])[1]
        assert same(measured, c["measured_mm"])
        agree(re.findall(r"\[.*?\]", line)[0], one["low"], one["high"])
        row = exported[c["name"]]
        assert float(row["true_low"]) == pytest.approx(c["interval_mm"][0], abs=1e-8)
        assert float(row["true_high"]) == pytest.approx(c["interval_mm"][1], abs=1e-8)
        assert row["decision"] == c["decision"]


@pytest.mark.thorough
def test_diagnose(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["new", "bb", "--from", "ballbar", "--out", str(tmp_path)]) == 0
    words = ["diagnose", str(tmp_path / "bb.toml")]
    found = document([*words, "--out", str(tmp_path / "out")], capsys)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    shown = terminal(words, capsys)
    named = [a for a in found["answer"] if not a["doubtful"]]
    first = next(a for a in named if "gap" in a["parameters"])
    assert (first["effect"], first["where"]) == ("backlash", {"axis": "Y"})
    for a in (a for a in named if "gap" in a["parameters"]):
        gap = a["parameters"]["gap"]["value"]
        assert f"{gap:.2f} um" in a["text"]
        assert micro(a["text"].split(";")[0]) in micro(" ".join(shown.split()))
        assert f"{gap:.2f}" in entities.unescape(page)
    (bars,) = (c for c in charts(page, "bars") if c["unit"] == "%")
    # the largest share of the excess is that of the answer, in percent
    assert max(bars["values"]) == pytest.approx(100.0 * max(a["share"] for a in found["answer"]), abs=0.5)
