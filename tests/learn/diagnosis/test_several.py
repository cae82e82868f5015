"""Two runs of one axis: the play is common, the scale is each one's own."""

from __future__ import annotations

import json

import numpy as np
import pytest

from vcmm.face.cli import run
from vcmm.files.own.machine import load_machine
from vcmm.learn.diagnosis.several import Size, agreement


def test_sizes_agree_within_their_uncertainty():
    # 0.3^2 / (0.1^2 + 0.05^2 + 0.1^2 + 0.065^2) = 3.368 with one degree of freedom: p = 0.0665
    near = [Size("a", 1.0, 0.1), Size("b", 1.3, 0.1)]
    assert agreement(near) == pytest.approx(0.0665, abs=1e-4)
    assert agreement([Size("a", 1.0, 0.02), Size("b", 0.0, 0.02)]) < 1e-20
    assert agreement([Size("a", 1.0, 0.1), Size("b", None, None)]) == 1.0


ROWS = "X_mm,Y_mm,Z_mm,sense_X,nx,ny,nz,d_um\n"


def written(folder, name: str, scale: float, seed: int):
    noise = np.random.default_rng(seed)
    there = np.arange(0.0, 501.0, 50.0)
    rows = []
    for _ in range(5):
        for sense, places in ((1, there), (-1, there[::-1])):
            rows += [
                f"{q},0,0,{sense},1,0,0,{-1.0 * sense + scale * q + 0.6 * noise.standard_normal():.3f}"
                for q in places
            ]
    (folder / f"{name}.csv").write_text(ROWS + "\n".join(rows) + "\n")
    (folder / f"{name}.toml").write_text(
        f'vcmm = "recording/1"\nname = "{name}"\ndata = "{name}.csv"\nmachine = "machine.toml"\nkind = "displacement"\n'
        'observed = "actual - commanded"\n[nuisance]\nzero = ""\n[noise]\nu = "0.6 um"\n'
    )


@pytest.fixture
def folder(tmp_path):
    axes = "".join(f'[axes.{a}]\ntravel = ["-1 m", "1 m"]\n' for a in "XYZ")
    (tmp_path / "machine.toml").write_text(f'vcmm = "machine/1"\nstructure = "w b Y X Z t"\n{axes}')
    written(tmp_path, "warm", 0.04, 1)
    written(tmp_path, "cold", 0.0, 2)
    return tmp_path


@pytest.mark.thorough
def test_the_command_takes_the_tables_themselves_and_writes_what_is_common(folder, capsys):
    files = [str(folder / "warm.csv"), str(folder / "cold.csv")]
    assert run(["diagnose", *files, "--json", "--out", str(folder / "out")]) == 0
    body = json.loads(capsys.readouterr().out)
    assert [(s["effect"], s["common"]) for s in body["shared"]] == [
        ("backlash", True),
        ("scale_factor", False),
    ]
    gap = body["answer"][0]["parameters"]["gap"]
    assert abs(gap["value"] - 2.0) < 3 * gap["u"] < 0.6
    assert [z["times"] for z in body["shared"][1]["sizes"]] == pytest.approx([1.0, 0.0], abs=0.1)
    alone = {r["recording"]: sorted(a["effect"] for a in r["answer"]) for r in body["recordings"]}
    assert alone == {"warm": ["backlash", "scale_factor"], "cold": ["backlash"]}
    written = folder / "out" / "machine.toml"
    assert run(["compare", *files, "--machine", str(written), "--json"]) == 0
    before, after = (m["rms_um"] for m in json.loads(capsys.readouterr().out)["machines"])
    assert (body["fit"]["rms_before_um"], body["fit"]["rms_after_um"]) == (
        before,
        after,
    )  # of the rows as given
    machine = load_machine(written)
    assert [e.name for e in machine.effects] == ["backlash"]
    assert "What is common" in (folder / "out" / "report.html").read_text()
