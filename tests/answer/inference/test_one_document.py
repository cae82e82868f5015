"""What one evaluated document says fits together."""

from __future__ import annotations

import json

import pytest

from tests.plate import PLATE
from vcmm.face.cli import run

FORM = '[[part.characteristics]]\nname = "roundish"\ntype = "cylindricity"\nof = "bore"\nzone = "0.05 mm"\n[pose]\n'


@pytest.mark.thorough
def test_u_k_and_interval_belong_together_and_warnings_are_about_what_was_measured(tmp_path, capsys):
    (tmp_path / "plate.toml").write_text(PLATE.replace("[pose]\n", FORM, 1))
    names = [
        line.split('"')[1] for line in PLATE.split("[part]")[1].splitlines() if line.startswith("name = ")
    ]
    assert run(["measure", str(tmp_path / "plate.toml"), "--json"]) in (0, 1)
    told = {c["name"]: c for c in json.loads(capsys.readouterr().out)["characteristics"]}
    rows = [f"{name},{c['value_mm']}" for name, c in told.items() if name in names or name == "roundish"]
    (tmp_path / "v.csv").write_text("\n".join(["characteristic,value_mm", *rows]) + "\n")
    run(
        [
            "evaluate",
            str(tmp_path / "plate.toml"),
            "--values",
            str(tmp_path / "v.csv"),
            "--trials",
            "2000",
            "--json",
        ]
    )
    found = json.loads(capsys.readouterr().out)
    for c in found["characteristics"]:
        low, high = c["interval_mm"]
        if high is None:  # eight angles hardly meet four lobes: no upper end, no U, nothing claimed
            assert (c["name"], c["U_mm"], c["coverage_shown"], c["decision"]) == (
                "roundish",
                None,
                False,
                "undecided",
            )
            continue
        assert c["U_mm"] == pytest.approx((high - low) / 2)
        assert c["U_mm"] == pytest.approx(c["k"] * c["u_mm"])
    claimed = {c["name"] for c in found["characteristics"] if c["coverage_shown"]}
    assert not [
        w for w in found["warning_texts"] for name in claimed if w.startswith(name) and "not shown" in w
    ]
